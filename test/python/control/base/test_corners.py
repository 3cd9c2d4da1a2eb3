"""Ways with corners on the kinematic model: driven round within the distance promised, never slower than stopping."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Sequence, Tuple

import pytest

from yarm.control.base.controller import BaseController, BaseGoal, Outcome
from yarm.control.base.corners import corners_ahead, speed_for
from yarm.control.base.model import BaseModel
from yarm.control.base.params import BaseParams
from yarm.control.base.speed_profile import passing_speed, stopping_speed
from yarm.geometry.poses import Pose2
from yarm.planning.verification.checker import ROUNDED_M

DT_S = 1.0 / 60.0
PARAMS = BaseParams()
OFF_M = PARAMS.corner_m + 0.015
"""From the lines: the arc, and what the base is off it."""


@dataclass(frozen=True)
class Driven:
    """How a way was driven."""

    time_s: float
    off_m: float
    slowest_mps: float
    left_m: float


def points(corner_deg: float, leg_m: float, yaw: float = 0.7) -> List[Pose2]:
    """Two legs with a corner between them."""
    turn = math.radians(corner_deg)
    end = Pose2(leg_m * (1.0 + math.cos(turn)), leg_m * math.sin(turn), yaw)
    return [Pose2(0.0, 0.0, yaw), Pose2(leg_m, 0.0, yaw), end]


def drive(way: Sequence[Pose2], goals: Sequence[Tuple[float, BaseGoal]]) -> Driven:
    """Drive from the way's first pose; each goal is given once the end effector's x is so far."""
    model, controller, left = BaseModel(way[0]), BaseController(PARAMS), list(goals)
    off, slowest, outcome = 0.0, math.inf, Outcome.ACTIVE
    while model.stamp_s < 60.0 and (left or outcome is Outcome.ACTIVE):
        if left and (model.pose.x >= left[0][0] or outcome is not Outcome.ACTIVE):
            controller.start(left.pop(0)[1])
        command = controller.step(model.pose, model.casters, model.stamp_s)
        outcome = command.outcome
        model.step(command, DT_S)
        off = max(off, min(distance(model.pose, a, b) for a, b in zip(way, way[1:])))
        if model.pose.x > 0.3 and model.pose.distance(way[-1]) > 0.5:
            slowest = min(slowest, math.hypot(*model.velocity()[:2]))
    assert outcome is Outcome.SUCCEEDED
    return Driven(model.stamp_s, off, slowest, model.pose.distance(way[-1]))


def distance(pose: Pose2, a: Pose2, b: Pose2) -> float:
    """From a pose to the straight way between two others."""
    dx, dy = b.x - a.x, b.y - a.y
    share = max(0.0, min(1.0, ((pose.x - a.x) * dx + (pose.y - a.y) * dy) / (dx * dx + dy * dy)))
    return math.hypot(pose.x - a.x - share * dx, pose.y - a.y - share * dy)


@pytest.mark.parametrize("yaw", [0.7, -2.0])
@pytest.mark.parametrize("leg_m", [0.3, 1.0])
@pytest.mark.parametrize("corner_deg", [0, 10, -20, 30, -45, 60, 75, 90, -150])
def test_a_corner_is_passed_within_the_distance_and_no_later_than_with_a_stop(corner_deg, leg_m, yaw):
    way = points(corner_deg, leg_m, yaw)
    round_it = drive(way, [(-1.0, BaseGoal(way[2], via=(way[1],)))])
    stopping = drive(way, [(-1.0, BaseGoal(way[1])), (math.inf, BaseGoal(way[2]))])
    assert round_it.off_m <= OFF_M
    assert round_it.left_m <= PARAMS.position_tolerance_m
    assert round_it.time_s <= stopping.time_s
    if abs(corner_deg) <= 45:
        assert round_it.time_s <= stopping.time_s - 0.5
        assert round_it.slowest_mps > 0.3 or leg_m < 1.0


def test_at_a_sharp_corner_the_base_stops():
    way = points(90, 1.0)
    assert drive(way, [(-1.0, BaseGoal(way[2], via=(way[1],)))]).slowest_mps < 0.02


def test_a_goal_that_leads_on_takes_over_without_a_stop_and_another_one_does_not():
    way = points(20, 1.0)
    onward = drive(way, [(-1.0, BaseGoal(way[1])), (0.4, BaseGoal(way[2], via=(way[1],)))])
    assert onward.slowest_mps > 0.6
    assert onward.off_m <= OFF_M
    late = drive(way, [(-1.0, BaseGoal(way[1])), (math.inf, BaseGoal(way[2], via=(way[1],)))])
    assert late.slowest_mps < 0.02
    assert late.left_m <= PARAMS.position_tolerance_m


def test_only_a_goal_by_the_end_of_the_straight_way_being_driven_continues_it():
    way = points(20, 1.0)
    model, controller = BaseModel(way[0]), BaseController(PARAMS)
    onward = BaseGoal(way[2], via=(way[1],))
    assert not controller.continues(onward)
    controller.start(BaseGoal(way[1]))
    assert not controller.continues(onward), "it may have to turn first"
    while model.pose.x < 0.4:
        model.step(controller.step(model.pose, model.casters, model.stamp_s), DT_S)
    assert controller.continues(onward)
    assert not controller.continues(BaseGoal(way[2]))
    assert not controller.continues(BaseGoal(Pose2(way[2].x, way[2].y, 1.7), via=(way[1],)))
    controller.pause()
    assert controller.continues(onward), "held for a moment it still drives there"
    controller.stop("")
    assert not controller.continues(onward)


def test_the_speed_to_pass_a_corner_with_is_the_one_to_stop_with_at_its_least():
    assert passing_speed(0.7, 0.0, 1.5, 0.1) == stopping_speed(0.7, 1.5, 0.1)
    assert passing_speed(0.0, 0.4, 1.5, 0.1) == 0.4
    speed = passing_speed(0.5, 0.4, 1.5, 0.0)
    assert speed**2 - 0.4**2 == pytest.approx(2.0 * 1.5 * 0.5)


def test_no_leg_is_left_earlier_than_the_checker_takes_it_to_be():
    for corner_deg in range(1, 60):
        for leg_m in (0.1, 0.5, 3.0):
            first = corners_ahead(leg_m, 0.0, points(corner_deg, leg_m), PARAMS)[0]
            assert first.speed_mps > 0.0
            assert first.before_m <= min(ROUNDED_M, leg_m / 2.0) + 1e-9, corner_deg


def test_casters_are_not_turned_beyond_their_stops_and_every_corner_ahead_is_braked_for():
    way = points(30, 1.0)
    assert len(corners_ahead(1.0, 0.0, way, PARAMS)) == 2
    assert len(corners_ahead(1.0, math.pi - 0.7, way, PARAMS)) == 1
    near = [Pose2(0.0, 0.0), Pose2(1.0, 0.0), Pose2(1.3, 0.0), Pose2(1.45, 0.2)]
    corners = corners_ahead(0.2, 0.0, near, PARAMS)
    assert [round(c.left_m, 2) for c in corners] == [0.2, 0.5, 0.75]
    assert speed_for(corners, PARAMS) < speed_for(corners[:1], PARAMS)
