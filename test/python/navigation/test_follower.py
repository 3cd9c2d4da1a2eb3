"""The follower drives an ideal robot along paths."""

from __future__ import annotations

import math
from typing import List, Optional, Tuple

import numpy as np
import pytest

from python.navigation.map_samples import cluttered
from yarm.geometry import Pose2, wrap_angle
from yarm.navigation.costs import Room
from yarm.navigation.follower import Drive, FollowSettings, PathFollower, room_ahead
from yarm.navigation.planner import Field

TICK_S = 0.1


def drive(
    follower: PathFollower, pose: Pose2, field: Optional[Field] = None, ahead_m: float = 9.0, ticks: int = 2000
) -> Tuple[List[Pose2], List[Drive]]:
    """Steps an ideal robot until it arrives; fails when it does not."""
    poses, drives = [pose], []
    for _ in range(ticks):
        given = follower.step(pose, ahead_m, None if field is None else field.sees)
        drives.append(given)
        if given.arrived:
            return poses, drives
        middle = pose.yaw_rad + 0.5 * given.w_radps * TICK_S
        pose = Pose2(
            pose.x + given.v_mps * TICK_S * math.cos(middle),
            pose.y + given.v_mps * TICK_S * math.sin(middle),
            wrap_angle(pose.yaw_rad + given.w_radps * TICK_S),
        )
        poses.append(pose)
    pytest.fail(f"not arrived after {ticks} ticks: {pose}")


def test_it_reaches_the_end_and_the_heading_and_stands() -> None:
    follower = PathFollower()
    follower.follow(np.array([[0.0, 0.0], [1.5, 0.0], [1.5, 1.0]]), math.pi)
    poses, drives = drive(follower, Pose2(0.0, 0.0, 0.0))
    assert math.hypot(poses[-1].x - 1.5, poses[-1].y - 1.0) < 0.06
    assert abs(wrap_angle(poses[-1].yaw_rad - math.pi)) < 0.07
    assert drives[-1].v_mps == 0.0 and drives[-1].w_radps == 0.0
    assert follower.step(poses[-1], 9.0) == Drive()


def test_speeds_keep_the_rules_and_change_smoothly() -> None:
    follower = PathFollower()
    settings = FollowSettings()
    follower.follow(np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0]]))
    _, drives = drive(follower, Pose2(0.0, 0.0, 2.0))
    v, w = np.array([d.v_mps for d in drives[:-1]]), np.array([d.w_radps for d in drives[:-1]])
    assert 0.29 < v.max() <= 0.3 + 1e-9 and v.min() >= 0.0
    assert np.abs(w).max() <= settings.turn_radps + 1e-9
    assert np.diff(v).max() <= 0.06 + 1e-9 and np.diff(v).min() >= -0.15 - 1e-9
    assert np.abs(np.diff(w)).max() <= 0.4 + 1e-9


def test_it_is_slow_near_what_is_ahead_and_below_a_cap() -> None:
    follower = PathFollower()
    follower.follow(np.array([[0.0, 0.0], [2.0, 0.0]]))
    _, drives = drive(follower, Pose2(0.0, 0.0), ahead_m=0.69)
    assert max(d.v_mps for d in drives) == pytest.approx(0.15)
    follower.follow(np.array([[0.0, 0.0], [2.0, 0.0]]))
    assert max(follower.step(Pose2(0.0, 0.0), 9.0, cap_mps=0.08).v_mps for _ in range(20)) == pytest.approx(0.08)


def test_it_is_as_quick_as_the_speeds_allow() -> None:
    follower = PathFollower()
    follower.follow(np.array([[0.0, 0.0], [3.0, 0.0]]))
    _, drives = drive(follower, Pose2(0.0, 0.0, math.pi / 2))
    assert len(drives) * TICK_S < math.pi / 2 / 1.0 + 3.0 / 0.3 + 2.5


@pytest.mark.parametrize("seed", range(4))
def test_the_body_stays_clear_along_planned_ways(seed: int) -> None:
    room = cluttered(seed)
    rng = np.random.default_rng(seed)
    free = np.argwhere(room.free)
    start = room.centre_of(*free[rng.integers(len(free))])
    field = Field(room, Pose2(*start))
    reached = np.argwhere(np.isfinite(field.cost))
    for row, column in reached[rng.integers(len(reached), size=3)] if len(reached) else []:
        follower = PathFollower()
        follower.follow(field.path_to((int(row), int(column))))
        poses, _ = drive(follower, Pose2(start[0], start[1], 1.0), field)
        gaps = Room(room, 0.3).distances(np.array([[p.x, p.y] for p in poses]))
        assert gaps.min() >= min(0.176, float(gaps[0]))


def test_the_strip_ahead() -> None:
    points = np.array([[0.5, 0.3], [0.8, -0.1], [-0.2, 0.0]])
    assert room_ahead(points, 0.2) == pytest.approx(0.8)
    assert room_ahead(points, 0.31) == pytest.approx(0.5)
    assert room_ahead(np.zeros((0, 2)), 0.2) == 10.0 and room_ahead(points[2:], 0.2) == 10.0


def test_no_path_is_refused() -> None:
    with pytest.raises(ValueError, match="empty"):
        PathFollower().follow(np.zeros((0, 2)))
