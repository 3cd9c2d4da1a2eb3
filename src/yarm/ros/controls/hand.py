"""A mobile robot's hand for the controls server: its topics and services, and the work it does."""

from __future__ import annotations

import math
import threading
from typing import Callable, Dict, List, Optional, Tuple

import rospy
from std_msgs.msg import Bool, Float64
from std_srvs.srv import Empty

from yarm.control.actions import MobileAction
from yarm.control.base.controller import Outcome
from yarm.control.hand import HandCommand, HandParams, HandReading, HandWork
from yarm.msg import GripperState
from yarm.ros.common import names
from yarm.ros.common.clock import SAME_TICK_S
from yarm.ros.controls.robots import End, Outbox

SWITCH_LIMIT_S = 2.0
"""Longest wall time for suction to be switched, s."""


class Hand:
    """One hand. Its services are called between two ticks, so that in lock-step the world stands still meanwhile."""

    def __init__(
        self, robot: str, params: HandParams, outbox: Outbox, wake: Callable[[], None], sync: bool = False
    ) -> None:
        """Advertise and subscribe.

        Args:
            robot: whose hand.
            params: how it works.
            outbox: of the robot.
            wake: called when something a tick may wait for has come.
            sync: in lock-step: it waits for the hand's word of each tick.
        """
        self._work = HandWork(params)
        self._outbox, self._wake = outbox, wake
        self._lift = outbox.publisher(names.lift_command(robot), Float64)
        self._switches: Dict[bool, rospy.ServiceProxy] = {
            on: rospy.ServiceProxy(names.gripper(robot, "on" if on else "off"), Empty) for on in (True, False)
        }
        self._grasping: Optional[bool] = None
        self._reading = (0.0, 0.0)
        self._said_s = -math.inf if sync else math.inf
        topic, kind, heard = ("state", GripperState, self._on_state) if sync else ("grasping", Bool, self._on_grasping)
        self._subscriber = rospy.Subscriber(names.gripper(robot, topic), kind, heard, queue_size=10, tcp_nodelay=True)

    @property
    def active(self) -> bool:
        """Whether it picks or drops."""
        return self._work.active

    @property
    def known(self) -> bool:
        """Whether it has said what it holds, and a lift's commands are heard."""
        return self._grasping is not None and self._lift.get_num_connections() > 0

    @property
    def stage(self) -> str:
        """What it does, for people."""
        return str(self._work.stage.value)

    @property
    def lift_m(self) -> float:
        """How far down it is, metres."""
        return self._reading[0]

    def ready(self, stamp_s: float) -> bool:
        """Whether it has said what it holds at a tick; without lock-step always."""
        return self._said_s >= stamp_s - SAME_TICK_S

    def note_joint(self, lift_m: float, speed_mps: float) -> None:
        """Take in the lift's joint: metres down, m/s down."""
        self._reading = (lift_m, speed_mps)

    def start(self, action: MobileAction, now_s: float) -> Optional[End]:
        """Begin a PICK or a DROP; the end when it cannot be."""
        return self._apply(self._work.start(action, self._read(), now_s))

    def tick(self, now_s: float) -> Optional[End]:
        """One step of the work; its end when it has come."""
        return self._apply(self._work.step(self._read(), now_s))

    def before_driving(self, now_s: float) -> Tuple[bool, Optional[End]]:
        """Whether the base may drive on, the hand being drawn up; when not, it is drawn up, and the end if it stays."""
        command = self._work.before_driving(self._read(), now_s)
        return (True, None) if command is None else (False, self._apply(command))

    def stop(self) -> None:
        """Give the work up and draw the hand up; nothing when it is at rest."""
        active, command = self._work.active, self._work.stop()
        if active:
            self._apply(command)

    def reset(self) -> None:
        """Simulated time went backwards: forget the work."""
        self._work.stop()

    def close(self) -> None:
        """Hear no more."""
        self._subscriber.unregister()

    def _read(self) -> HandReading:
        return HandReading(*self._reading, bool(self._grasping))

    def _on_grasping(self, message: Bool) -> None:
        self._grasping = bool(message.data)
        self._wake()

    def _on_state(self, message: GripperState) -> None:
        self._grasping = bool(message.grasping)
        self._said_s = message.header.stamp.to_sec()
        self._wake()

    def _apply(self, command: HandCommand) -> Optional[End]:
        if command.suction is not None:
            fault = self._switch(command.suction)
            if fault:
                self._outbox.send(self._lift, Float64(self._work.stop().lift_m))
                return Outcome.ABORTED, fault
        if command.lift_m is not None:
            self._outbox.send(self._lift, Float64(command.lift_m))
        return None if command.outcome is Outcome.ACTIVE else (command.outcome, command.reason)

    def _switch(self, on: bool) -> str:
        """Switch suction; why it was not switched, empty when it was."""
        proxy = self._switches[on]
        faults: List[str] = []

        def call() -> None:
            try:
                proxy()
            except rospy.ServiceException as error:
                faults.append(f"{proxy.resolved_name}: {error}")

        thread = threading.Thread(target=call, daemon=True)
        thread.start()
        thread.join(SWITCH_LIMIT_S)
        if thread.is_alive():
            return f"{proxy.resolved_name} has not answered within {SWITCH_LIMIT_S:g} s"
        return "; ".join(faults)
