"""Node ``velocity_gate``: stands between the multiplexer and the base; see ``yarm.exploration.deadline``.

It answers every command with one of its own, and says zero again and again while none comes: a dead explorer, or a dead
multiplexer, means zero, and a dead gate leaves the base without commands, which stops it too.

It serves ``safety/stop``, as the safety monitor does in a cell: a person stops the robot until it is released, and
``safety/status`` says so.
"""

from __future__ import annotations

import math
import threading
from typing import Mapping, Tuple, Type, Union

import rospy
from geometry_msgs.msg import Twist
from rosgraph_msgs.msg import Clock

from yarm.exploration.deadline import COMMAND_AGE_S, Gate, Lease, Passed
from yarm.exploration.model import LOOP_S, Command
from yarm.msg import ExplorerStatus, InspectionStatus, SafetyStatus, StepAck
from yarm.robots.turtlebot import TYPE
from yarm.ros.common import names
from yarm.ros.common.acks import step_ack
from yarm.ros.common.checks import Doorkeeper
from yarm.ros.common.clock import ClockWatch
from yarm.ros.common.params import load_params
from yarm.ros.common.start import init_node
from yarm.ros.exploration.params import GateParams
from yarm.ros.safety.stop import StopService

SILENT_S = COMMAND_AGE_S + LOOP_S
"""When no command has come for so long the gate speaks by itself, every pass of the explorer's loop, s."""
STATUS_S = 0.5
"""Simulated time between two words about a person's stop, s; at once when it begins or ends."""


NEVER_S = 1e9
"""A deadline that never comes."""
Said = Union[ExplorerStatus, InspectionStatus]
STATUS: Mapping[str, Tuple[str, Type[Said]]] = {
    names.EXPLORER_NODE: (names.explorer("status"), ExplorerStatus),
    names.INSPECTOR_NODE: (names.inspector("status"), InspectionStatus),
}
"""Whose word counts as a lease: topic and message."""


def lease_of(message: Said) -> Lease:
    """What a status grants; the inspector's, that the robot may move as long as the node lives."""
    stamp_s = message.header.stamp.to_sec()
    if isinstance(message, InspectionStatus):
        return Lease(stamp_s, 0.0, NEVER_S, True)
    return Lease(stamp_s, message.started.to_sec(), message.deadline.to_sec(), message.moving)


class VelocityGate:
    """Ties the gate to topics. Every callback takes the lock."""

    def __init__(self, params: GateParams) -> None:
        """Listen and advertise; all work is done in callbacks."""
        self._sync = params.sync
        self._lock = threading.Lock()
        self._gate = Gate(params.lease)
        self._reason = ""
        self._begin()
        topic, kind = STATUS[params.lease]
        self._door = Doorkeeper(topic)
        self._base = rospy.Publisher(names.BASE_VELOCITY, Twist, queue_size=10, tcp_nodelay=True)
        self._ack = rospy.Publisher(names.STEP_ACK, StepAck, queue_size=100, tcp_nodelay=True)
        self._status = rospy.Publisher(names.SAFETY_STATUS, SafetyStatus, queue_size=10, latch=True)
        with self._lock:  # nobody's call is answered before the gate knows of it
            self._stop = StopService(self._on_stop)
            self._gate.stop(self._stop.reason)
        self._input = rospy.Subscriber("~input", Twist, self._on_command, queue_size=10, tcp_nodelay=True)
        self._clock = ClockWatch()
        self._clock.on_reset(self._on_clock_reset)
        self._leases = rospy.Subscriber(topic, kind, self._on_status, queue_size=10, tcp_nodelay=True)
        self._ticks = rospy.Subscriber("/clock", Clock, self._on_clock, queue_size=100, tcp_nodelay=True)

    def _begin(self) -> None:
        """Nothing was wanted yet, and nothing said."""
        self._now_s, self._sent_s = 0.0, 0.0
        self._own, self._asked = 0, False
        self._said_s = -math.inf

    def _on_status(self, message: Said) -> None:
        lease = lease_of(message)
        with self._lock:
            self._now_s = max(self._now_s, rospy.get_time())
            taken = self._gate.hear(lease, self._now_s)
        self._door.refuses(message, "" if taken else f"its stamp {lease.stamp_s:.2f} s lies in the future")

    def _on_command(self, message: Twist) -> None:
        with self._lock:
            self._now_s, self._asked = max(self._now_s, rospy.get_time()), True
            self._gate.want(Command(message.linear.x, message.angular.z), self._now_s)
            self._send(self._gate.step(self._now_s))

    def _on_clock(self, message: Clock) -> None:
        with self._lock:
            self._now_s = message.clock.to_sec()
            passed = self._gate.step(self._now_s)
            since_s = self._now_s - self._sent_s
            if since_s >= SILENT_S or (passed.reason and passed.reason != self._reason):
                self._speak(passed)
            if self._now_s - self._said_s >= STATUS_S:
                self._tell_stop()
            if self._sync:
                self._acknowledge(message.clock)

    def _on_stop(self) -> None:
        """A person has stopped the robot or released it: the base hears of a stop at once."""
        with self._lock:
            self._gate.stop(self._stop.reason)
            self._now_s = max(self._now_s, rospy.get_time())
            if self._stop.reason:
                self._speak(self._gate.step(self._now_s))
            self._tell_stop()

    def _tell_stop(self) -> None:
        reason = self._stop.reason
        message = SafetyStatus(robots=[TYPE], clearance_m=[math.inf], nearest=[""], stopped=[bool(reason)])
        message.header.stamp, message.header.frame_id = rospy.Time.from_sec(self._now_s), names.MAP_FRAME
        message.reason, message.latched = reason, bool(reason)
        self._said_s = self._now_s
        self._status.publish(message)

    def _speak(self, passed: Passed) -> None:
        """Say unasked what the gate lets through; in lock-step not before the first command, the base stands till then.

        A word said while the base connects may be lost, or heard without being counted. The base would wait for one
        command too many, or too few, ever after.
        """
        if self._asked or not self._sync:
            self._own += 1
            self._send(passed)

    def _acknowledge(self, stamp: rospy.Time) -> None:
        """Lock-step: this tick is done, as soon as the node is connected on all sides; what it said unasked counts."""
        connected = (self._base, self._input, self._leases)
        if all(side.get_num_connections() for side in connected):
            self._ack.publish(step_ack(stamp, self._own))

    def _send(self, passed: Passed) -> None:
        if passed.reason != self._reason:
            self._reason = passed.reason
            rospy.loginfo("gate at %.1f s: %s", self._now_s, passed.reason or "lets commands through")
        message = Twist()
        message.linear.x, message.angular.z = passed.command.v_mps, passed.command.w_radps
        self._sent_s = self._now_s
        self._base.publish(message)

    def _on_clock_reset(self) -> None:
        with self._lock:
            self._gate.reset()
            self._begin()


def main() -> None:
    """Run the node until it is shut down."""
    init_node(names.GATE_NODE)
    VelocityGate(load_params(GateParams))
    rospy.spin()
