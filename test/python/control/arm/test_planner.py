"""Collision model, moves between configurations, and their timing."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from python.control.arm_samples import arm, planner
from yarm.control.arm.collision import ArmCollision
from yarm.control.arm.errors import ArmError
from yarm.control.arm.model import ArmKinematics, JointLimits, tool_pose
from yarm.control.arm.motion import along_path, through_corners
from yarm.control.arm.planner import ArmPlanner
from yarm.robots.hc10 import Box, station_boxes

READY = np.array([-0.19, 0.92, 1.51, 0.0, -0.58, 0.19])
UP = np.array([0.0, 0.0, 1.0])
LIMITS = arm().limits
WALL = Box("wall", (0.1, 0.1, 1.0), (-0.45, 0.4, 1.4))


def at(x: float, y: float, z: float) -> np.ndarray:
    q = ArmKinematics(arm()).solve(tool_pose(np.array([x, y, z]), UP, 0.0), READY)
    assert q is not None
    return q


def test_storage_is_clear_of_everything():
    clearance = planner().collision.clearance(arm().storage, 0.3)
    assert clearance.distance_m > 0.02
    assert "base_link and link_2_l" in clearance.between


def test_sanding_touches_only_what_it_may():
    collision = planner().collision
    on_part = at(-0.25, 0.0, 0.731)
    assert not collision.free(on_part, 0.01)
    assert collision.free(on_part, 0.01, sanding=True)
    assert not collision.free(at(-0.25, 0.45, 0.705), 0.01, sanding=True)


def test_clearance_names_the_pair():
    assert collision_words(at(-0.25, 0.0, 0.731)) == "sander and part"


def collision_words(q: np.ndarray) -> str:
    return planner().collision.clearance(q, 0.05).between


@pytest.fixture(scope="module")
def walled() -> ArmPlanner:
    return ArmPlanner(ArmCollision(arm(), (*station_boxes(), WALL)), LIMITS, 0.02, 1)


def test_a_move_round_a_wall_is_found_and_free(walled):
    start, goal = at(-0.3, 0.0, 1.1), turned(at(-0.3, 0.0, 1.1), 1.5)
    assert not walled.straight_is_free(start, goal)
    corners = walled.plan(start, goal, 30.0)
    assert len(corners) > 2
    assert corners[0] == pytest.approx(start) and corners[-1] == pytest.approx(goal)
    for a, b in zip(corners[:-1], corners[1:]):
        assert walled.straight_is_free(a, b)


def test_a_time_limit_counts_by_the_clock_that_was_given():
    start, goal = at(-0.3, 0.0, 1.1), turned(at(-0.3, 0.0, 1.1), 1.5)
    surroundings = ArmCollision(arm(), (*station_boxes(), WALL))
    standing = ArmPlanner(surroundings, LIMITS, 0.02, 1, clock=lambda: 5.0)
    assert len(standing.plan(start, goal, 0.001)) > 2
    leaping = ArmPlanner(surroundings, LIMITS, 0.02, 1, clock=itertools.count(0, 100).__next__)
    with pytest.raises(ArmError, match=r"no path found in 200 of 30 s from \("):
        leaping.plan(start, goal, 30.0)


def turned(q: np.ndarray, angle_rad: float) -> np.ndarray:
    return q + np.array([angle_rad, 0.0, 0.0, 0.0, 0.0, 0.0])


SEEDED = """
import numpy as np
from python.control.arm.test_planner import WALL, at, turned
from python.control.arm_samples import arm
from yarm.control.arm.collision import ArmCollision
from yarm.robots.hc10 import station_boxes
from yarm.control.arm.planner import ArmPlanner
planner = ArmPlanner(ArmCollision(arm(), (*station_boxes(), WALL)), arm().limits, 0.02, 1)
start = at(-0.3, 0.0, 1.1)
for angle in (1.5, 1.8):
    print(planner.plan(start, turned(start, angle), 60.0).tolist())
"""


def test_the_same_seed_gives_the_same_paths_in_every_process():
    root = Path(__file__).resolve().parents[4]
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join([str(root / "src"), str(root / "test")]))
    outputs = [
        subprocess.run(
            [sys.executable, "-c", SEEDED], env=environment, capture_output=True, text=True, timeout=120, check=True
        ).stdout
        for _ in range(2)
    ]
    assert outputs[0].count("[[") == 2
    assert outputs[0] == outputs[1]


def test_an_end_that_touches_is_refused_with_pair_and_distance(walled):
    with pytest.raises(ArmError, match=r"goal .* deg: sander and part are -?0\.\d+ m apart"):
        walled.plan(arm().storage, at(-0.25, 0.0, 0.731), 5.0)


@pytest.mark.parametrize(("name", "value"), [("lower", 9.0), ("upper", -9.0), ("upper", np.nan), ("speed", 0.0)])
def test_limits_that_no_angle_keeps_are_refused_with_the_joint(name, value):
    given = {"lower": LIMITS.lower.copy(), "upper": LIMITS.upper.copy(), "speed": LIMITS.speed.copy()}
    given[name][2] = value
    with pytest.raises(ArmError, match=r"joint 3: limits .* rad at .* rad/s; the lower one must be under"):
        JointLimits(**given)


def test_an_end_beyond_the_limits_is_refused(walled):
    with pytest.raises(ArmError, match="out of the joints' limits"):
        walled.plan(arm().storage, np.full(6, 3.5), 5.0)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.1, 0.9))
def test_free_moves_keep_speed_limits_and_the_straight_line(seed, share):
    rng = np.random.default_rng(seed)
    corners = rng.uniform(LIMITS.lower, LIMITS.upper, (3, 6))
    motion = through_corners(corners, LIMITS, share, 2.0)
    speeds = np.abs(np.diff(motion.positions, axis=0)) / np.diff(motion.times_s)[:, None]
    assert np.all(speeds <= share * LIMITS.speed * 1.001)
    assert motion.positions[0] == pytest.approx(corners[0])
    assert motion.positions[-1] == pytest.approx(corners[-1], abs=1e-6)
    for q in motion.positions:
        assert min(off_line(q, a, b) for a, b in zip(corners[:-1], corners[1:])) < 1e-6


def off_line(q: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
    share = np.clip(np.dot(q - a, b - a) / np.dot(b - a, b - a), 0.0, 1.0)
    return float(np.linalg.norm(q - a - share * (b - a)))


def line(length_m: float = 0.5):
    arc = np.linspace(0.0, length_m, 51)
    kinematics, q, joints = ArmKinematics(arm()), READY, []
    for y in arc:
        q = kinematics.solve(tool_pose(np.array([-0.25, -0.25 + y, 0.74]), UP, 0.0), q)
        joints.append(q)
    return np.array(joints), arc


def test_a_timed_path_keeps_the_tips_speed_from_rest_to_rest():
    joints, arc = line()
    motion = along_path(joints, arc, 0.1, 0.5, LIMITS)
    speeds = np.diff(motion.arc_m) / np.diff(motion.times_s)
    assert speeds.max() <= 0.1 * 1.01
    assert speeds.max() > 0.099
    assert speeds[0] < 0.05 and speeds[-1] < 0.05
    assert motion.positions[-1] == pytest.approx(joints[-1], abs=1e-6)


def test_timing_one_point_is_refused():
    with pytest.raises(ArmError, match="1 point"):
        along_path(READY[None, :], np.zeros(1), 0.1, 0.5, LIMITS)


@given(st.floats(0.0, 5.0), st.floats(0.05, 0.5))
@settings(max_examples=30, deadline=None)
def test_braking_stays_on_the_path_and_covers_half_the_way(from_s, stop_s):
    motion = along_path(*line(), 0.1, 0.5, LIMITS)
    braked = motion.braked(from_s, stop_s)
    assert braked.duration_s == pytest.approx(stop_s)
    assert np.all(np.diff(braked.arc_m) >= -1e-12)
    assert braked.arc_m[0] == pytest.approx(motion.arc_at(from_s))
    assert braked.arc_m[-1] - braked.arc_m[0] <= 0.1 * stop_s / 2.0 + 1e-3
    last = np.max(np.abs(np.diff(braked.positions[-2:], axis=0))) / (braked.times_s[-1] - braked.times_s[-2])
    assert last < 0.1


def test_the_nearest_time_of_a_measured_pose_is_found():
    motion = along_path(*line(), 0.1, 0.5, LIMITS)
    assert motion.nearest_time(motion.at(2.0), 1.5, 2.2) == pytest.approx(2.0, abs=0.03)
