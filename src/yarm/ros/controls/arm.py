"""A manipulator with a sander, of the controls server: CALIBRATION, ON, OFF, CLEANUP."""

from __future__ import annotations

from typing import Callable, Optional

import rospy
from sensor_msgs.msg import Joy
from std_msgs.msg import Int8

from yarm.control.actions import ArmAction, SearchSpace
from yarm.control.base.controller import Outcome
from yarm.control.sander.client import SWITCHES, SanderClient
from yarm.control.sander.states import Button, SanderReport, SanderState
from yarm.geometry import GridSpec
from yarm.geometry.kinds import ObjectKind
from yarm.msg import KeepOff, MoveRobotFeedback, MoveRobotGoal, RegisteredObject, SanderStatus, StepAck
from yarm.robots.hc10 import area_text, parse_area
from yarm.ros.common import names
from yarm.ros.common.acks import step_ack
from yarm.ros.common.checks import Doorkeeper, keep_off_fault, present_s, sander_fault
from yarm.ros.common.clock import SAME_TICK_S
from yarm.ros.common.stations import load_station
from yarm.ros.controls.params import ControlsServerParams
from yarm.ros.controls.robots import End, Outbox, RobotUnit, SeedPose

JOY_AXES = 4


class ArmUnit(RobotUnit):
    """Presses the buttons of one arm's sander."""

    kind = ObjectKind.MANIPULATOR

    def __init__(
        self,
        name: str,
        params: ControlsServerParams,
        registered: Callable[[str], Optional[RegisteredObject]],
        wake: Callable[[], None],
    ) -> None:
        """Advertise and subscribe (arguments as of ``MobileUnit``)."""
        del registered
        self._name = name
        self._params = params
        self._wake = wake
        self._area = area_text(load_station(name).moved_area(GridSpec(), parse_area(params.manipulator_area)))
        self._client = SanderClient(params.manipulator_timeout_s)
        self._action: Optional[ArmAction] = None
        self._report: Optional[SanderReport] = None
        self._report_s = -1.0
        self._last_tick_s: Optional[float] = None
        self._outbox = Outbox()
        self._joy = self._outbox.publisher(names.sander_joy(name), Joy)
        self._switch = self._outbox.publisher(names.motion_start_stop(name), Int8)
        self._keep_off = self._outbox.publisher(names.sander_keep_off(name), KeepOff)
        self._kept_off = self._news = KeepOff()
        self._ack = (
            rospy.Publisher(names.sander_command_ack(name), StepAck, queue_size=10, latch=True) if params.sync else None
        )
        self._door = Doorkeeper(names.sander_status(name))
        self._status = rospy.Subscriber(
            names.sander_status(name), SanderStatus, self._on_status, queue_size=20, tcp_nodelay=True
        )

    def refusal(self, goal: MoveRobotGoal) -> str:
        """Anything but the four actions is refused by name, and so are places that are none."""
        return SanderClient.refusal(goal.action, self._report) or keep_off_fault(goal.keep_off)

    def start(self, goal: MoveRobotGoal) -> None:
        """Pursue one of the four actions."""
        self._action = ArmAction(goal.action)
        if self._action in SWITCHES:
            self._news = goal.keep_off
        self._client.start(self._action)

    def cancel(self, reason: str) -> None:
        """Hold the arm where it is, unless only a switch was being thrown."""
        if self._action in (ArmAction.CALIBRATE, ArmAction.CLEANUP):
            rospy.loginfo("%s: %s given up (%s), arm held", self._name, self._action.value, reason)
            self._press(Button.HOLD)
        self._action = None

    def tick(self, pose: SeedPose, now_s: float) -> Optional[End]:
        """Press what is needed next."""
        self._last_tick_s = now_s
        if self._action is None:
            return None
        if self._keep_off.get_num_connections() == 0:
            self._kept_off = KeepOff()  # the sander that comes knows of nothing
        elif self._news != self._kept_off:
            self._kept_off = self._news
            self._outbox.send(self._keep_off, self._news)
        request = self._client.step(self._report, now_s)
        if request.press is not None:
            self._press(request.press)
        if request.switch is not None:
            self._outbox.send(self._switch, Int8(int(request.switch)))
        if request.outcome is Outcome.ACTIVE:
            return None
        action, self._action = self._action, None
        if action is ArmAction.CALIBRATE and request.outcome is Outcome.SUCCEEDED:
            return Outcome.SUCCEEDED, SearchSpace.SWITCH.answer(self._area)
        return request.outcome, request.reason

    def hold(self) -> None:
        """The sander does not depend on the seeds."""

    def feedback(self, feedback: MoveRobotFeedback) -> None:
        """An arm's seed velocity is not measured here."""

    def ready(self, stamp_s: float) -> bool:
        """The sander's answer to the tick before is here."""
        unheard = self._report is None or self._last_tick_s is None
        return unheard or self._report_s >= (self._last_tick_s or 0.0) - SAME_TICK_S

    def acknowledge(self, stamp_s: float) -> None:
        """Tell the sander how many messages it must have had before it works on this tick."""
        if self._ack is not None:
            self._ack.publish(step_ack(rospy.Time.from_sec(stamp_s), self._outbox.sent))

    def reset(self) -> None:
        """Forget goal, report and counts."""
        self._action, self._report, self._report_s = None, None, -1.0
        self._last_tick_s = None
        self._kept_off = self._news = KeepOff()
        self._outbox.sent = 0

    def close(self) -> None:
        """Withdraw all topics."""
        self._status.unregister()
        self._outbox.close()
        if self._ack is not None:
            self._ack.unregister()

    def _press(self, button: Button) -> None:
        """Press and let go."""
        for pressed in (1, 0):
            joy = Joy(axes=[0.0] * JOY_AXES, buttons=[pressed * int(b is button) for b in Button])
            joy.header.stamp = rospy.Time.now()
            self._outbox.send(self._joy, joy)

    def _on_status(self, message: SanderStatus) -> None:
        if self._door.refuses(message, sander_fault(message, present_s(self._params.sync))):
            return
        self._report = SanderReport(
            state=SanderState(message.state),
            enabled=message.enabled,
            moving=message.moving,
            lifted=message.lifted,
            progress=message.progress,
            reason=message.reason,
            presses=message.presses,
            switches=message.switches,
        )
        self._report_s = message.header.stamp.to_sec()
        self._wake()
