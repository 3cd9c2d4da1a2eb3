"""The goals robots are working on: who was sent what, and how it ended."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum
from typing import Dict, List, Optional, Tuple

from yarm.commander.events import NOTHING, CancelGoal, GoalDone, KeepOff, SendGoal, Target
from yarm.geometry import wrap_angle
from yarm.planning.model.types import Waypoint
from yarm.robots.ankurbot import ARM_REACH_M


class Purpose(Enum):
    """Why a goal was sent."""

    STEP = "step"
    HAND = "hand"
    CALIBRATION = "calibration"
    SWITCH = "switch"
    CLEANUP = "cleanup"


@dataclass(frozen=True)
class ActiveGoal:
    """A goal that has not ended.

    Attributes:
        robot: who works on it.
        serial: its number, unique for the life of the process.
        purpose: why it was sent.
        action: the MoveRobot action.
        target: where to; None for goals without a pose.
        start: where a step begins; None for whatever was not checked from there.
        sent_s: when it was sent.
        cancelled_s: when it was cancelled; None when it was not.
        why: why it was cancelled.
        replans: it was cancelled to be planned again at once.
        best: least distance measure to the target so far (see ``remaining``).
        best_s: when it last became less.
    """

    robot: str
    serial: int
    purpose: Purpose
    action: str
    target: Optional[Target]
    sent_s: float
    start: Optional[Waypoint] = None
    cancelled_s: Optional[float] = None
    why: str = ""
    replans: bool = False
    best: float = math.inf
    best_s: float = 0.0


PROGRESS_M = 0.02
"""A robot has moved when its distance measure has fallen by this, metres."""


def remaining(target: Target, x: float, y: float, yaw_rad: float) -> float:
    """How far a robot is from its target: metres to go plus the way its body's centre still has to turn."""
    turn = abs(wrap_angle(target.yaw_rad - yaw_rad))
    return math.hypot(target.x - x, target.y - y) + ARM_REACH_M * turn


class GoalBook:
    """One active goal a robot; newer goals replace older ones."""

    def __init__(self) -> None:
        """No goals yet."""
        self.active: Dict[str, ActiveGoal] = {}
        self._serial = 0

    def send(
        self,
        robot: str,
        purpose: Purpose,
        action: str,
        now_s: float,
        target: Optional[Target] = None,
        start: Optional[Waypoint] = None,
        via: Tuple[Target, ...] = (),
        why: str = "",
        keep_off: KeepOff = NOTHING,
    ) -> SendGoal:
        """Note a new goal, to a target by other poses, and why; it replaces the robot's active one."""
        self._serial += 1
        self.active[robot] = ActiveGoal(robot, self._serial, purpose, action, target, now_s, start, best_s=now_s)
        return SendGoal(robot, self._serial, action, target, via, purpose.value, why, keep_off)

    def cancel(self, robot: str, now_s: float, why: str, replans: bool = False) -> List[CancelGoal]:
        """Cancel a robot's goal; nothing when it has none or it was cancelled already.

        Args:
            robot: whose goal.
            now_s: simulated time.
            why: the reason, for people.
            replans: whether the robot is planned for again at once.
        """
        goal = self.active.get(robot)
        if goal is None or goal.cancelled_s is not None:
            return []
        self.active[robot] = replace(goal, cancelled_s=now_s, why=why, replans=replans)
        return [CancelGoal(robot, goal.serial, why)]

    def end(self, event: GoalDone) -> Optional[ActiveGoal]:
        """Note that a goal has ended; None when it is not the robot's active one."""
        goal = self.active.get(event.robot)
        if goal is None or goal.serial != event.serial:
            return None
        return self.active.pop(event.robot)

    def drop(self, robot: str) -> Optional[ActiveGoal]:
        """Forget a robot's goal without waiting for its end."""
        return self.active.pop(robot, None)

    def of(self, *purposes: Purpose) -> List[ActiveGoal]:
        """Active goals sent for one of the purposes."""
        return [goal for goal in self.active.values() if goal.purpose in purposes]

    def note_progress(self, robot: str, x: float, y: float, yaw_rad: float, now_s: float) -> None:
        """Remember how near a robot has come to its target."""
        goal = self.active.get(robot)
        if goal is None or goal.target is None:
            return
        left = remaining(goal.target, x, y, yaw_rad)
        if left < goal.best - PROGRESS_M:
            self.active[robot] = replace(goal, best=left, best_s=now_s)

    def overdue(self, now_s: float, cancel_timeout_s: float) -> List[ActiveGoal]:
        """Goals that were cancelled too long ago without an end."""
        return [
            goal
            for goal in self.active.values()
            if goal.cancelled_s is not None and now_s - goal.cancelled_s > cancel_timeout_s
        ]
