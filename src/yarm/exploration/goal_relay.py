"""Explores through a navigation: what the controller wants to drive becomes goals, and only the rest commands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from yarm.exploration.model import Command
from yarm.exploration.session import MOVING, SessionStep
from yarm.geometry import Pose2

SAME_M = 0.01
SAME_RAD = 0.02
"""A goal that differs by less is the same."""


@dataclass(frozen=True)
class Order:
    """What a pass asks for.

    Attributes:
        goal: drive there, map frame, in place of any goal before; None: no new goal.
        cancel: take back the goal that the navigation has.
        command: drive so, past the navigation; None: leave the base to it.
    """

    goal: Optional[Pose2] = None
    cancel: bool = False
    command: Optional[Command] = None


class GoalRelay:
    """Keeps in mind which goal the navigation has; pure, one pass of a session after the other.

    The controller goes on following the way that it has planned: that tells it when it has arrived, and when the robot
    stands though it should drive, as it does when the navigation has given a goal up.
    """

    def __init__(self) -> None:
        """The navigation has no goal."""
        self._goal: Optional[Pose2] = None

    def step(self, step: SessionStep) -> Order:
        """What to send after a pass. Backing off, and turns that lead to no goal, are commands."""
        wanted = self._wanted(step)
        if wanted is None:
            had, self._goal = self._goal is not None, None
            drives = step.state in MOVING and (step.command.v_mps != 0.0 or step.command.w_radps != 0.0)
            return Order(cancel=had, command=step.command if drives else None)
        if self._goal is not None and _same(self._goal, wanted):
            return Order()
        self._goal = wanted
        return Order(goal=wanted)

    def _wanted(self, step: SessionStep) -> Optional[Pose2]:
        """The pose to drive to now; None while the robot stands or backs off."""
        if step.state not in MOVING or step.behaviour == "hold" or step.command.v_mps < 0.0:
            return None
        return step.intent.goal


def _same(a: Pose2, b: Pose2) -> bool:
    turn = Pose2(0.0, 0.0, a.yaw_rad).inverse().compose(Pose2(0.0, 0.0, b.yaw_rad)).yaw_rad
    return a.distance(b) < SAME_M and abs(turn) < SAME_RAD
