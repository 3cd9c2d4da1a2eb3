"""The safety monitor's geometry and its verdicts, without ROS."""

from __future__ import annotations

import math

import numpy as np
import pytest

from yarm.commander.clearance import (
    Body,
    Foresight,
    Motion,
    coasting,
    distance,
    placed,
    room_ahead,
    signed_distance,
    surface_points,
)
from yarm.commander.monitor import Monitor, Seen, bodies_for, own_goals
from yarm.commander.safety_params import SafetyParams
from yarm.commander.shapes import Solid
from yarm.geometry import Pose2

EVERYWHERE = (np.full(3, -np.inf), np.full(3, np.inf))


def at(x=0.0, y=0.0, z=0.0):
    matrix = np.eye(4)
    matrix[:3, 3] = (x, y, z)
    return matrix


ROBOT = surface_points(
    [Solid("cylinder", (0.45, 0.35), at(-1.3, 0.0, -0.565)), Solid("box", (1.3, 0.08, 0.08), at(-0.65, 0.0, 0.0))], 0.08
)
WALL = Body("table", (Solid("box", (1.0, 4.0, 1.0), at(1.5, 0.0, 0.5)),))
HEIGHT = 0.89


@pytest.mark.parametrize(
    ("solid", "point", "expected"),
    [
        (Solid("box", (2.0, 2.0, 2.0), at()), (2.0, 0.0, 0.0), 1.0),
        (Solid("box", (2.0, 2.0, 2.0), at()), (0.0, 0.0, 0.75), -0.25),
        (Solid("sphere", (0.5,), at(1.0)), (1.0, 2.0, 0.0), 1.5),
        (Solid("cylinder", (2.0, 0.5), at()), (1.5, 0.0, 0.0), 1.0),
        (Solid("cylinder", (2.0, 0.5), at()), (0.0, 0.0, 1.25), 0.25),
        (Solid("cylinder", (2.0, 0.5), at()), (3.5, 0.0, 5.0), 5.0),
    ],
)
def test_signed_distances(solid, point, expected):
    assert signed_distance(np.array([point]), solid)[0] == pytest.approx(expected)


def test_surface_points_lie_on_the_surface_and_leave_no_gap():
    for solid in (
        Solid("cylinder", (0.45, 0.35), at()),
        Solid("box", (1.3, 0.1, 0.1), at()),
        Solid("sphere", (0.3,), at()),
    ):
        points = surface_points([solid], 0.08)
        assert np.abs(signed_distance(points, solid)).max() < 1e-9
        probes = np.random.default_rng(1).normal(size=(200, 3))
        probes *= 2.0 / np.linalg.norm(probes, axis=1)[:, None]
        gap = np.array([np.linalg.norm(points - probe, axis=1).min() for probe in probes])
        assert np.all(gap - signed_distance(probes, solid) < 0.02)


def test_boxes_of_the_map_count_as_bodies():
    body = Body("unknown_1", (), np.array([[1.0, -0.1, 0.8, 1.1, 0.1, 0.9]]))
    assert distance(np.array([[0.5, 0.0, 0.85]]), body, *EVERYWHERE) == pytest.approx(0.5)


def test_a_robot_is_placed_at_its_end_effector():
    points = placed(np.array([[-1.3, 0.0, -0.5]]), Pose2(1.0, 2.0, math.pi / 2), HEIGHT)
    assert points[0] == pytest.approx([1.0, 0.7, 0.39])


def test_coasting_ends_at_the_target():
    sight = Foresight()
    fast = Motion(vx=1.0)
    free = coasting(Pose2(0.0, 0.0), fast, None, sight)
    assert max(p.x for p in free) == pytest.approx(sight.latency_s + 1.0 / (2 * sight.deceleration_mps2))
    bound = coasting(Pose2(0.0, 0.0), fast, Pose2(0.1, 0.0), sight)
    assert max(p.x for p in bound) <= 0.11 + 1e-9
    assert coasting(Pose2(0.0, 0.0), Motion(), None, sight) == []


def test_room_ahead_counts_the_motion_not_the_place():
    pose = Pose2(0.98, 0.0)
    limit = 0.03
    near = room_ahead(ROBOT, pose, HEIGHT, [Pose2(0.99, 0.0)], [WALL], limit)
    assert near.closing and near.nearest == "table"
    away = room_ahead(ROBOT, pose, HEIGHT, [Pose2(0.9, 0.0)], [WALL], limit)
    assert not away.closing
    along = room_ahead(ROBOT, Pose2(0.9, 0.0), HEIGHT, [Pose2(0.9, 0.3)], [WALL], limit)
    assert not along.closing
    assert along.distance_m == pytest.approx(0.1, abs=0.01)


def drive(monitor, poses, target, bodies, goal_id="g"):
    verdicts = []
    for i, x in enumerate(poses):
        seen = {"r": Seen(Pose2(x, 0.0), HEIGHT, ROBOT, target, goal_id)}
        verdicts.append(monitor.look(i / 30.0, seen, {"r": bodies})["r"])
    return verdicts


def test_a_robot_sent_at_the_table_is_stopped_before_it():
    monitor = Monitor(SafetyParams())
    poses = np.arange(0.0, 1.2, 1.0 / 30.0)
    verdicts = drive(monitor, poses, Pose2(1.5, 0.0), [WALL])
    first = next(i for i, v in enumerate(verdicts) if v.held)
    assert verdicts[first].stop_now
    assert 1.0 - poses[first] >= 1.0 / (2 * 1.5)
    assert "r on its step to (1.50, 0.00, 0 deg) would come within" in verdicts[first].reason
    assert "of table" in verdicts[first].reason


def test_a_good_step_beside_the_table_is_left_alone():
    monitor = Monitor(SafetyParams())
    poses = np.concatenate([np.arange(0.0, 0.94, 1.0 / 30.0), np.full(10, 0.94)])
    assert not any(v.held for v in drive(monitor, poses, Pose2(0.94, 0.0), [WALL]))


def test_a_step_that_begins_into_the_table_never_begins():
    verdicts = drive(Monitor(SafetyParams()), [0.97], Pose2(1.5, 0.0), [WALL])
    assert verdicts[0].stop_now


def test_a_held_robot_is_released_when_it_stands_and_may_leave():
    monitor = Monitor(SafetyParams(hold_s=0.2))
    assert drive(monitor, [0.97], Pose2(1.5, 0.0), [WALL])[0].held
    seen = {"r": Seen(Pose2(0.97, 0.0), HEIGHT, ROBOT, None, "")}
    assert monitor.look(0.1, seen, {"r": [WALL]})["r"].held
    assert not monitor.look(0.5, seen, {"r": [WALL]})["r"].held
    leaving = {"r": Seen(Pose2(0.96, 0.0), HEIGHT, ROBOT, Pose2(0.0, 0.0), "g2")}
    assert not monitor.look(0.6, leaving, {"r": [WALL]})["r"].held


def test_own_goals_may_be_touched_others_not():
    debris = Body("debris_1", (Solid("box", (0.1, 0.1, 0.04), at()),))
    allowed = own_goals([("r", "debris_1"), ("s", "debris_2")])
    assert bodies_for("r", [debris, WALL], allowed["r"]) == [WALL]
    assert bodies_for("s", [debris, WALL], allowed["s"]) == [debris, WALL]
