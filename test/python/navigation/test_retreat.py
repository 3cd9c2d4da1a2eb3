"""Backing off along the way a robot came: how far, how near to that way, and when it ends."""

from __future__ import annotations

import math
from typing import List

import numpy as np
import pytest

from yarm.geometry import Pose2
from yarm.navigation.retreat import JUMP_M, RETREAT_M, RETREAT_S, STEP_M, Retreat, Trail

DT_S = 0.1


def moved(pose: Pose2, v_mps: float, w_radps: float) -> Pose2:
    """After a command of DT_S."""
    yaw = pose.yaw_rad + 0.5 * w_radps * DT_S
    return Pose2(
        pose.x + v_mps * DT_S * math.cos(yaw), pose.y + v_mps * DT_S * math.sin(yaw), pose.yaw_rad + w_radps * DT_S
    )


def driven(v_mps: float, w_radps: float, seconds: float) -> List[Pose2]:
    """Where a robot has been that began at the origin."""
    poses = [Pose2(0.0, 0.0)]
    for _ in range(round(seconds / DT_S)):
        poses.append(moved(poses[-1], v_mps, w_radps))
    return poses


def trail_of(poses: List[Pose2]) -> Trail:
    trail = Trail()
    for pose in poses:
        trail.note(pose)
    return trail


def retreated(way: np.ndarray, pose: Pose2) -> List[Pose2]:
    """Where the robot goes."""
    retreat, poses, now_s = Retreat(way, 0.0), [pose], 0.0
    while now_s <= RETREAT_S + 1.0:
        drive = retreat.step(poses[-1], now_s)
        if drive is None:
            return poses
        poses.append(moved(poses[-1], drive.v_mps, drive.w_radps))
        now_s += DT_S
    raise AssertionError(f"no end; {poses[-1]}")


@pytest.mark.parametrize("w_radps", [0.0, 0.4, -0.7])
def test_it_goes_back_over_where_it_was(w_radps: float) -> None:
    came = driven(0.2, w_radps, 6.0)
    poses = retreated(trail_of(came).back(), came[-1])
    places = np.array([(pose.x, pose.y) for pose in came])
    off = [float(np.hypot(places[:, 0] - pose.x, places[:, 1] - pose.y).min()) for pose in poses]
    assert max(off) < 0.03
    way_m = sum(a.distance(b) for a, b in zip(poses, poses[1:]))
    assert way_m == pytest.approx(RETREAT_M, abs=2 * STEP_M)


def test_turned_round_meanwhile_it_drives_forwards() -> None:
    came = driven(0.2, 0.0, 4.0)
    here = Pose2(came[-1].x, came[-1].y, math.pi)
    poses = retreated(trail_of(came).back(), here)
    assert poses[-1].x == pytest.approx(here.x - RETREAT_M, abs=2 * STEP_M)
    assert abs(math.remainder(poses[-1].yaw_rad - math.pi, 2.0 * math.pi)) < 0.1


def test_a_place_that_jumped_was_not_driven_to() -> None:
    trail = trail_of(driven(0.2, 0.0, 4.0))
    trail.note(Pose2(0.8, JUMP_M + 0.01))
    assert len(trail.back()) == 1


def test_what_was_driven_back_over_is_not_driven_back_over_again() -> None:
    trail = trail_of(driven(0.2, 0.0, 6.0))
    first = trail.back()
    trail.cut(len(first))
    assert trail.back()[0, 0] < first[-1, 0]


def test_a_robot_that_does_not_get_on_gives_up() -> None:
    retreat = Retreat(np.array([[1.0, 0.0]]), 0.0)
    assert retreat.step(Pose2(0.0, 0.0), RETREAT_S) is not None
    assert retreat.step(Pose2(0.0, 0.0), RETREAT_S + 0.1) is None


def test_without_a_way_it_ends_at_once() -> None:
    assert len(Trail().back()) == 0 and Retreat(Trail().back(), 0.0).step(Pose2(0.0, 0.0), 0.0) is None
