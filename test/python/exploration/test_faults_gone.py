"""Faults of the printed program that ours has not, where no other test sets the two side by side."""

from __future__ import annotations

import math
from typing import List

import pytest

from python.navigation.map_samples import drawn
from support.report_rig import Rig, scan
from yarm.exploration.model import Step
from yarm.exploration.params import ExploreParams
from yarm.exploration.report.printed import PrintedController
from yarm.exploration.yarm import YarmController
from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap
from yarm.robots.turtlebot import Bumper

AHEAD = drawn("#######\n#.....?\n#.....?\n#######", scale=20)
"""Known ground that ends to the east."""
ASIDE = drawn("#?##\n#..#\n#..#\n####", scale=20)
"""Known ground that ends to the north."""


def ours(room: GridMap, pose: Pose2) -> Rig:
    rig = Rig(YarmController(ExploreParams(), 1))
    rig.map, rig.pose = room, pose
    return rig


def printed() -> Rig:
    rig = Rig(PrintedController(ExploreParams(), 1))
    rig.run(1.2, scan(2.0))
    return rig


def turned(steps: List[Step]) -> float:
    """Sum of what was turned, radians, + = left."""
    return sum(0.1 * step.command.w_radps for step in steps)


@pytest.mark.parametrize("ahead", [7.0, math.nan])
def test_open_space_does_not_stop_it(ahead: float) -> None:
    theirs, rig = printed(), ours(AHEAD, Pose2(2.0, 2.0))
    theirs.step(scan(ahead))
    assert theirs.step(scan(ahead)).behaviour == "selection"
    rig.run(4.0, scan(ahead))
    assert rig.pose.x > 2.3 and abs(rig.pose.y - 2.0) < 0.3


def test_at_a_junction_it_turns_to_where_there_is_more_to_see() -> None:
    theirs, rig = printed(), ours(ASIDE, Pose2(1.5, 1.5))
    seen = scan(3.0, left=4.0, right=1.0)
    assert theirs.step(seen).command.w_radps == 0.0
    assert turned(rig.run(2.0, seen)) > 0.5


def test_a_bump_is_heard_in_a_turn_and_backing_off_ends() -> None:
    rig, seen = ours(ASIDE, Pose2(1.5, 1.5)), scan(3.0)
    assert turned(rig.run(0.5, seen)) > 0.0
    assert rig.step(seen, (Bumper.LEFT, True)).behaviour == "back off"
    rig.step(seen, (Bumper.LEFT, False))
    backing = [step.behaviour == "back off" for step in rig.run(5.0, seen)]
    assert backing[0] and not any(backing[20:])
