"""Carries out the orders of a round, pass by pass: goals for the navigation, turns in place, looks at boxes; pure.

A drive is held, not failed, while the robot may not move for want of a sensor: its time stands still, and its goal is
given again when the sensor is back.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional

from yarm.geometry import Pose2, wrap_angle
from yarm.inspection.model import ClearCostmaps, Drive, Look, Order, Outcome, Reading, Spin, Stand
from yarm.inspection.readers import PictureRead, Reader, Shot
from yarm.inspection.senses import Senses

LOST_S = 2.0
"""A drive without a place has failed after so long."""
SETTLE_S = 1.0
"""After a turn the localisation gets so long to answer."""
SLOWEST_TURN = 3.0
SPARE_S = 10.0
"""A turn has failed after so many times its time and this."""
CLEARING_S = 1.0
"""What forgetting costmaps is given."""
STANDS_MPS, STANDS_RADPS, STANDS_S = 0.02, 0.03, 0.2
"""A robot that has been slower than this for so long stands."""
PICTURE_WAIT_S = 5.0
"""A look without a picture that can be used has failed after so long."""


@dataclass(frozen=True)
class Action:
    """What is done at a pass, and how the order stands after it.

    Attributes:
        outcome: of the order.
        reason: why it failed, or why nothing was read.
        reading: of the box looked at, once the look has ended.
        goal: to be given to the navigation now.
        cancel: the navigation's goal is taken back now.
        clear: the costmaps are cleared now.
        turn_radps: the base is to turn this fast; None for no command.
        read: the picture looked at.
    """

    outcome: Outcome = Outcome.BUSY
    reason: str = ""
    reading: Optional[Reading] = None
    goal: Optional[Pose2] = None
    cancel: bool = False
    clear: bool = False
    turn_radps: Optional[float] = None
    read: Optional[PictureRead] = None


class Executor:
    """Carries out one order at a time."""

    def __init__(self, reader: Reader) -> None:
        """No order yet."""
        self._reader = reader
        self._order: Order = Stand()
        self._goal: Optional[Pose2] = None
        self._driving = False
        self._turning = False
        self.again(0.0)

    def take(self, order: Order, now_s: float) -> None:
        """A new order; the one that stands already is gone on with."""
        if order is self._order:
            return
        self._order = order
        self.again(now_s)

    def again(self, now_s: float) -> None:
        """Begin the order from its start."""
        self._began_s, self._before_s, self._held_s = now_s, now_s, 0.0
        self._lost_s = self._stood_s = self._looking_s = self._done_s = math.inf
        self._turned_rad = 0.0
        self._odometry_yaw: Optional[float] = None
        self._images, self._trouble, self._image_s = 0, "", -math.inf
        self._fresh = True

    def step(self, seen: Senses, hold: str = "", jump: str = "") -> Action:
        """One pass of the order.

        Args:
            seen: everything known.
            hold: why the robot may not move now; empty when it may.
            jump: what has jumped at this pass; empty when nothing has.
        """
        order = self._order
        if isinstance(order, Drive):
            action = self._drive(order, seen, hold, jump)
        elif isinstance(order, Spin):
            action = self._spin(order, seen, hold)
        elif isinstance(order, Look):
            action = self._look(order, seen, jump)
        else:
            action = self._wait(order, seen)
        self._before_s = seen.now_s
        return action

    def stop(self) -> Action:
        """Whatever is going on ends; the robot stands."""
        self._order = Stand()
        return Action(cancel=self._release(), turn_radps=self._halt())

    def _release(self) -> bool:
        """Whether a goal has to be taken back."""
        had, self._driving = self._driving, False
        return had

    def _halt(self) -> Optional[float]:
        """The command that ends a turn; None when there was none."""
        had, self._turning = self._turning, False
        return 0.0 if had else None

    def _drive(self, order: Drive, seen: Senses, hold: str, jump: str) -> Action:
        if hold:
            self._held_s += seen.now_s - self._before_s
            return Action(reason=hold, cancel=self._release(), turn_radps=self._halt())
        if not seen.localised or seen.pose is None:
            return self._lost(seen)
        self._lost_s = math.inf
        if not self._driving or jump:
            self._driving, self._goal = True, order.goal
            return Action(reason=jump, goal=order.goal, turn_radps=self._halt())
        outcome, reason = seen.goal
        if outcome != Outcome.BUSY:
            self._driving = False
        elif seen.now_s - self._began_s - self._held_s > order.limit_s:
            late = f"not there after {order.limit_s:.0f} s"
            return Action(Outcome.FAILED, late, cancel=self._release())
        return Action(outcome, reason)

    def _lost(self, seen: Senses) -> Action:
        """A drive does not go on without a place, and fails soon."""
        self._lost_s = min(self._lost_s, seen.now_s)
        failed = seen.now_s - self._lost_s >= LOST_S
        why = f"the place is not known: {seen.place_fault or 'nobody says where the robot is'}"
        outcome = Outcome.FAILED if failed else Outcome.BUSY
        return Action(outcome, why, cancel=self._release(), turn_radps=self._halt())

    def _spin(self, order: Spin, seen: Senses, hold: str) -> Action:
        cancel = self._release()
        if math.isfinite(self._done_s):
            settled = seen.now_s - self._done_s >= SETTLE_S
            return Action(Outcome.DONE if settled else Outcome.BUSY, turn_radps=self._halt())
        if hold or seen.odometry is None:
            self._held_s += seen.now_s - self._before_s
            return Action(reason=hold, cancel=cancel, turn_radps=self._halt())
        yaw = seen.odometry.pose.yaw_rad
        if self._odometry_yaw is not None:
            self._turned_rad += wrap_angle(yaw - self._odometry_yaw)
        self._odometry_yaw = yaw
        if abs(self._turned_rad) >= abs(order.angle_rad):
            self._done_s = seen.now_s
            return Action(turn_radps=self._halt())
        limit_s = SLOWEST_TURN * abs(order.angle_rad) / order.rate_radps + SPARE_S
        if seen.now_s - self._began_s - self._held_s > limit_s:
            turned = f"turned {abs(self._turned_rad):.1f} of {abs(order.angle_rad):.1f} rad in {limit_s:.0f} s"
            return Action(Outcome.FAILED, f"{turned}; does something hold the robot?", turn_radps=self._halt())
        self._turning = True
        return Action(cancel=cancel, turn_radps=math.copysign(order.rate_radps, order.angle_rad))

    def _look(self, order: Look, seen: Senses, jump: str) -> Action:
        cancel, halt = self._release(), self._halt()
        if jump:
            return Action(Outcome.FAILED, jump, self._reader.reading(order.box))
        if not self._stands(seen) or not seen.localised or seen.pose is None:
            self._trouble = self._trouble or "the robot does not stand, or its place is not known"
            return self._looked_long(order, seen, cancel, halt)
        picture = seen.picture
        if picture is None or picture.stamp_s < self._stood_s:
            self._trouble = f"camera: {seen.camera}" if seen.camera else self._trouble
            return self._looked_long(order, seen, cancel, halt)
        if seen.now_s - self._image_s < order.pause_s:
            return self._looked_long(order, seen, cancel, halt)
        self._image_s = seen.now_s
        read = self._reader.read(order.box, Shot(picture.grey, seen.pose, seen.scan, self._goal))
        self._looking_s = min(self._looking_s, seen.now_s)
        self._images, self._trouble = self._images + 1, read.trouble
        if read.final or self._images >= order.images:
            reading = self._reader.reading(order.box)
            return Action(Outcome.DONE, self._trouble, reading, cancel=cancel, turn_radps=halt, read=read)
        action = self._looked_long(order, seen, cancel, halt)
        return Action(action.outcome, action.reason, action.reading, cancel=cancel, turn_radps=halt, read=read)

    def _looked_long(self, order: Look, seen: Senses, cancel: bool, halt: Optional[float]) -> Action:
        """The look ends when its time is over, or no picture that can be used comes."""
        late = seen.now_s - self._looking_s >= order.limit_s
        blind = not math.isfinite(self._looking_s) and seen.now_s - self._began_s >= PICTURE_WAIT_S
        if not (late or blind):
            return Action(cancel=cancel, turn_radps=halt)
        if blind:
            self._reader.missed(order.box, order.images)
        trouble = self._trouble or (f"no picture in {PICTURE_WAIT_S:g} s" if blind else "")
        return Action(Outcome.DONE, trouble, self._reader.reading(order.box), cancel=cancel, turn_radps=halt)

    def _stands(self, seen: Senses) -> bool:
        odometry = seen.odometry
        moves = odometry is None or abs(odometry.v_mps) > STANDS_MPS or abs(odometry.w_radps) > STANDS_RADPS
        self._stood_s = math.inf if moves else min(self._stood_s, seen.now_s)
        return seen.now_s - self._stood_s >= STANDS_S - 1e-6

    def _wait(self, order: Order, seen: Senses) -> Action:
        first, self._fresh = self._fresh, False
        clear = first and isinstance(order, ClearCostmaps)
        waited = not isinstance(order, ClearCostmaps) or seen.now_s - self._began_s >= CLEARING_S
        outcome = Outcome.DONE if waited else Outcome.BUSY
        return Action(outcome, cancel=self._release(), turn_radps=self._halt(), clear=clear)
