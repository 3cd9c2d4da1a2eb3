"""Node ``hc10_state_machine``: joystick and switch in, joint trajectories out (see ``yarm.control.sander.machine``).

Event-driven: each reading of the arm's joints is one tick, worked on by one thread; planning runs on another, but in
lock-step on the spot.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from typing import Deque, List, Optional, Sequence, Tuple

import numpy as np
import rospy
from geometry_msgs.msg import Point
from sensor_msgs.msg import JointState, Joy
from std_msgs.msg import Float32, Int8
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from visualization_msgs.msg import Marker

from yarm.control.arm.model import ArmKinematics, load_arm
from yarm.control.arm.motion import ArmMotion
from yarm.control.sander.machine import ArmInputs, SanderMachine
from yarm.control.sander.planner import RasterPlan, SanderPlanner
from yarm.control.sander.progress import KeepOff
from yarm.control.sander.states import Button, SanderReport, SanderState
from yarm.control.sander.steps import DoneJob
from yarm.geometry import FloatArray, Pose2, transform_points
from yarm.msg import KeepOff as KeepOffMessage
from yarm.msg import SanderStatus, StepAck
from yarm.robots.hc10 import Station
from yarm.ros.common import names
from yarm.ros.common.acks import step_ack
from yarm.ros.common.checks import Doorkeeper, ack_fault, joints_fault, keep_off_fault, present_s
from yarm.ros.common.clock import JUMP_BACK_S, SAME_TICK_S, ClockWatch
from yarm.ros.common.params import load_params
from yarm.ros.common.start import init_node
from yarm.ros.common.stations import load_station
from yarm.ros.common.watchers import Watchers
from yarm.ros.controls.robots import Outbox
from yarm.ros.sander.memory import SanderBook
from yarm.ros.sander.params import SanderNodeParams
from yarm.ros.sander.scan import ScanCollector
from yarm.safety.pulse import Pulse

WATCH_PERIOD_S = 0.5
SILENCE_S = 3.0
PROGRESS_PERIOD_S = 0.1
Axes = Tuple[float, float, float, float]


class SanderNode:
    """Ties topics to the machine. Only the newest joints count, except in lock-step, where no tick may be left out."""

    def __init__(self, params: SanderNodeParams) -> None:
        """Subscribe and advertise; work begins with ``spin``."""
        self._params = params
        self._station = load_station(params.arm)
        self._world = Pose2(self._station.x, self._station.y, self._station.yaw_rad).inverse()
        arm = load_arm(self._station.folded)
        self._joint_names = [joint.name for joint in arm.model.moving_joints]
        self._condition = threading.Condition()
        self._woken = False
        self._joints: Deque[JointState] = deque(maxlen=None if params.sync else 1)
        self._presses: List[Button] = []
        self._switches: List[bool] = []
        self._keep_off: Optional[KeepOff] = None
        self._axes: Optional[Axes] = None
        self._buttons: Sequence[int] = (0,) * len(Button)
        self._received = 0
        self._ack_after: Optional[StepAck] = None
        self._heard_s = self._driven_s = time.monotonic()
        self._last_s = -np.inf
        self._was_scanning = False
        self._reported: Tuple[Optional[SanderReport], float] = (None, -np.inf)
        self._progress_s = -np.inf
        self._plan_shown: Optional[RasterPlan] = None
        self._scan = ScanCollector(params, ArmKinematics(arm), self._wake, lambda: present_s(params.sync))
        workers = ThreadPoolExecutor(max_workers=1)
        run_job = DoneJob if params.sync else workers.submit
        self._machine = SanderMachine(SanderPlanner(arm, params), params, run_job, self._scan.points)
        self._book = SanderBook(rospy.get_name().rsplit("/", 1)[-1])
        if self._book.taken_up is not None:
            self._machine.take_up(*self._book.taken_up)
            rospy.logwarn("%s: taken up after its sander's death: %s", params.arm, self._machine.state.words)
        self._advertise()
        self._subscribe()

    def spin(self) -> None:
        """Work until the node is shut down."""
        pulse = Pulse()
        while not rospy.is_shutdown():
            pulse.beat()
            with self._condition:
                self._condition.wait_for(lambda: self._woken, timeout=WATCH_PERIOD_S)
                self._woken = False
                waiting = list(self._joints)
            if time.monotonic() - self._heard_s > SILENCE_S:
                topic = names.joint_states(self._params.arm)
                rospy.logwarn_throttle(10.0, f"nothing on {topic} for {SILENCE_S:g} s: is the arm's driver up?")
            for joints in waiting:
                if not self._ready(joints.header.stamp.to_sec()):
                    break
                with self._condition:
                    if self._joints and self._joints[0] is joints:
                        self._joints.popleft()
                self._tick(joints)

    def _advertise(self) -> None:
        arm = self._params.arm
        self._outbox = Outbox()
        self._path = self._outbox.publisher(names.joint_path_command(arm), JointTrajectory)
        self._state = rospy.Publisher(names.sander_state(arm), Int8, queue_size=10, latch=True)
        self._status = rospy.Publisher(names.sander_status(arm), SanderStatus, queue_size=20, tcp_nodelay=True)
        self._marker = rospy.Publisher(names.sander_raster(arm), Marker, queue_size=1, latch=True)
        self._progress = rospy.Publisher(names.sander_progress(arm), Float32, queue_size=10)
        self._ack = rospy.Publisher(names.STEP_ACK, StepAck, queue_size=100, tcp_nodelay=True)
        self._state.publish(Int8(int(self._machine.state)))

    def _subscribe(self) -> None:
        arm = self._params.arm
        self._joints_door = Doorkeeper(names.joint_states(arm))
        self._ack_door = Doorkeeper(names.sander_command_ack(arm))
        self._keep_off_door = Doorkeeper(names.sander_keep_off(arm))
        self._watchers = Watchers(self._params, self._params.sync)
        self._clock = ClockWatch()
        self._clock.on_reset(self._wake)
        self._subscribers = [
            rospy.Subscriber(names.joint_states(arm), JointState, self._on_joints, queue_size=5, tcp_nodelay=True),
            rospy.Subscriber(names.sander_joy(arm), Joy, self._on_joy, queue_size=50, tcp_nodelay=True),
            rospy.Subscriber(names.motion_start_stop(arm), Int8, self._on_switch, queue_size=50, tcp_nodelay=True),
            rospy.Subscriber(
                names.sander_keep_off(arm), KeepOffMessage, self._on_keep_off, queue_size=50, tcp_nodelay=True
            ),
        ]
        if self._params.sync and self._params.sync_after:
            ack = names.sander_command_ack(arm)
            self._subscribers.append(rospy.Subscriber(ack, StepAck, self._on_ack, queue_size=50, tcp_nodelay=True))

    # Callbacks: store and wake.

    def _wake(self) -> None:
        with self._condition:
            self._woken = True
            self._condition.notify()

    def _on_joints(self, message: JointState) -> None:
        stamp_s = message.header.stamp.to_sec()
        fault = joints_fault(message, present_s(self._params.sync))
        if stamp_s < self._last_s - JUMP_BACK_S <= rospy.get_time():
            fault = f"its stamp {stamp_s:.3f} s is older than that of the newest reading, {self._last_s:.3f} s"
        if self._joints_door.refuses(message, fault):
            return
        with self._condition:
            self._joints.append(message)
            self._heard_s = time.monotonic()
        self._wake()

    def _on_joy(self, message: Joy) -> None:
        buttons = tuple(message.buttons) + (0,) * len(Button)
        axes = tuple(message.axes) + (0.0,) * 4
        with self._condition:
            self._presses += [b for b in Button if buttons[b] and not self._buttons[b]]
            self._buttons = buttons
            self._axes = (axes[0], axes[1], axes[2], axes[3])
            self._received += 1
        self._wake()

    def _on_switch(self, message: Int8) -> None:
        with self._condition:
            self._switches.append(message.data != 0)
            self._received += 1
        self._wake()

    def _on_keep_off(self, message: KeepOffMessage) -> None:
        refused = self._keep_off_door.refuses(message, keep_off_fault(message))
        places = np.array([(point.x, point.y) for point in message.points]).reshape(-1, 2)
        with self._condition:
            if not refused:
                self._keep_off = KeepOff(self._world.moved(places), message.distance)
            self._received += 1
        self._wake()

    def _on_ack(self, message: StepAck) -> None:
        if not self._ack_door.refuses(message, ack_fault(message)):
            self._ack_after = message
            self._wake()

    # The tick.

    def _ready(self, stamp_s: float) -> bool:
        """The arm's driver listens; in lock-step, the controls server has done the tick and what it sent has come."""
        if not self._params.sync:
            return self._driver_listens()
        if not self._scan.complete(stamp_s):
            return False
        if not self._params.sync_after:
            return True
        ack = self._ack_after
        return (
            ack is not None and self._done(ack.header.stamp.to_sec(), stamp_s) and self._received >= ack.commands_sent
        )

    def _done(self, done_s: float, stamp_s: float) -> bool:
        """Whether the controls server, done with one tick, s, is with this one, the next that has come here.

        What comes, comes in order: one between the last and this has been lost here, as ticks may be before lock-step
        begins. It waits for the answer to that and will not do this one before it.
        """
        return done_s >= stamp_s - SAME_TICK_S or done_s > self._last_s + SAME_TICK_S

    def _driver_listens(self) -> bool:
        """A motion sent to nobody would be believed under way: until somebody listens nothing is decided or said.

        What was under way before comes to rest then: the next reading is one after a pause.
        """
        now_s = time.monotonic()
        if self._outbox.connected:
            self._driven_s = now_s
        elif now_s - self._driven_s > SILENCE_S:
            topic = names.joint_path_command(self._params.arm)
            rospy.logwarn_throttle(10.0, f"nobody listens to {topic} for {SILENCE_S:g} s: is the arm's driver up?")
        return self._outbox.connected

    def _tick(self, joints: JointState) -> None:
        stamp_s = joints.header.stamp.to_sec()
        if stamp_s < self._last_s - JUMP_BACK_S:
            self._start_afresh()
        self._last_s = stamp_s
        q = self._ordered(joints)
        if q is None:
            return
        with self._condition:
            presses, self._presses = self._presses, []
            switches, self._switches = self._switches, []
            axes, self._axes = self._axes, None
            keep_off, self._keep_off = self._keep_off, None
        objection = self._watchers.objection(stamp_s)
        for motion in self._machine.step(ArmInputs(q, stamp_s, presses, axes, switches, objection, keep_off)):
            self._outbox.send(self._path, self._trajectory(motion, joints.header.stamp))
        self._book.note(self._machine.memory, self._machine.plan)
        scanning = self._machine.scanning
        self._scan.step(stamp_s, q, scanning, scanning and not self._was_scanning)
        self._was_scanning = scanning
        self._scan.listen(scanning or (self._params.sync and self._machine.state is SanderState.SCANNING))
        self._report(joints.header.stamp)
        if self._params.sync:
            self._ack.publish(step_ack(joints.header.stamp, self._outbox.sent))

    def _ordered(self, joints: JointState) -> Optional[FloatArray]:
        angles = dict(zip(joints.name, joints.position))
        missing = [name for name in self._joint_names if name not in angles]
        if missing:
            rospy.logerr_throttle(10.0, f"{names.joint_states(self._params.arm)} lacks {', '.join(missing)}")
            return None
        return np.array([angles[name] for name in self._joint_names])

    def _start_afresh(self) -> None:
        """Simulated time went backwards: the arm is in storage again."""
        rospy.logwarn("simulated time went backwards: the sander starts in storage again")
        self._machine.reset()
        self._scan.reset()
        self._watchers.reset()
        with self._condition:
            self._presses, self._switches, self._axes = [], [], None
            self._keep_off = KeepOff(np.zeros((0, 2)), 0.0)
            self._received = 0
            self._ack_after = None
        self._outbox.sent = 0
        self._reported, self._progress_s = (None, -np.inf), -np.inf

    def _trajectory(self, motion: ArmMotion, stamp: rospy.Time) -> JointTrajectory:
        message = JointTrajectory(joint_names=self._joint_names)
        message.header.stamp = stamp
        first = 1 if len(motion.times_s) > 1 else 0
        message.points = [
            JointTrajectoryPoint(positions=q.tolist(), time_from_start=rospy.Duration.from_sec(float(time)))
            for time, q in zip(motion.times_s[first:], motion.positions[first:])
        ]
        return message

    # Reports.

    def _report(self, stamp: rospy.Time) -> None:
        report, now_s = self._machine.report, stamp.to_sec()
        last, last_s = self._reported
        changed = last is None or _essence(last) != _essence(report)
        if changed or self._params.sync or now_s - last_s >= 1.0 / self._params.status_hz:
            self._reported = (report, now_s)
            self._status.publish(_status(report, stamp))
        if last is None or last.state is not report.state:
            self._state.publish(Int8(int(report.state)))
            rospy.loginfo("%s: state %d, %s", self._params.arm, report.state, report.state.words)
        if report.reason and (last is None or last.reason != report.reason):
            rospy.logwarn("%s: %s", self._params.arm, report.reason)
        if report.state is SanderState.SCAN_TO_PATH and now_s - self._progress_s >= PROGRESS_PERIOD_S:
            self._progress_s = now_s
            self._progress.publish(Float32(report.progress))
        if self._machine.plan is not self._plan_shown:
            self._plan_shown = self._machine.plan
            self._marker.publish(_marker(self._plan_shown, self._station, stamp))


def _essence(report: SanderReport) -> Tuple[object, ...]:
    """What is told at once when it changes; the progress is not."""
    return (
        report.state,
        report.enabled,
        report.moving,
        report.lifted,
        report.reason,
        report.presses,
        report.switches,
    )


def _status(report: SanderReport, stamp: rospy.Time) -> SanderStatus:
    message = SanderStatus(
        state=int(report.state),
        state_name=report.state.words,
        enabled=report.enabled,
        moving=report.moving,
        lifted=report.lifted,
        progress=report.progress,
        reason=report.reason,
        presses=report.presses,
        switches=report.switches,
    )
    message.header.stamp = stamp
    return message


def _marker(plan: Optional[RasterPlan], station: Station, stamp: rospy.Time) -> Marker:
    """The passes as a line; without a plan the line is deleted."""
    marker = Marker(ns="raster", id=0, type=Marker.LINE_STRIP, action=Marker.ADD)
    marker.header.frame_id, marker.header.stamp = names.WORLD_FRAME, stamp
    marker.pose.orientation.w = 1.0
    marker.scale.x = 0.006
    marker.color.r, marker.color.g, marker.color.b, marker.color.a = 1.0, 0.6, 0.0, 1.0
    if plan is None:
        marker.action = Marker.DELETE
    else:
        marker.points = [Point(*p) for p in transform_points(station.pose, plan.raster.polyline).tolist()]
    return marker


def main() -> None:
    """Run the node until it is shut down."""
    init_node("hc10_state_machine")
    SanderNode(load_params(SanderNodeParams)).spin()
