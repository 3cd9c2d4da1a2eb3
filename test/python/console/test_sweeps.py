"""The outline of a move holds all that the robot passes over, and no more than a convex one must."""

from __future__ import annotations

import math

import numpy as np
import pytest

from yarm.console.picture import BodyDrawing
from yarm.console.sweeps import footprint, outlines
from yarm.geometry import quaternion_from_rpy
from yarm.geometry.solids import Shape, Solid

REACH_M = 0.8


def robot():
    """A round body behind a thin arm, its tip the seed."""
    arm = np.eye(4)
    arm[0, 3] = REACH_M / 2.0
    return BodyDrawing(
        "r",
        "Mobile",
        "dynamic",
        "r/ee",
        [
            ("r/base_link", Solid(Shape.CYLINDER, (0.25, 0.5), np.eye(4))),
            ("r/base_link", Solid(Shape.BOX, (REACH_M, 0.08, 0.08), arm)),
        ],
    )


def poses_at(x, y, yaw):
    turn = tuple(quaternion_from_rpy(0.0, 0.0, yaw))
    base = (x - REACH_M * math.cos(yaw), y - REACH_M * math.sin(yaw))
    return {"r/ee": (x, y, 0.8, *turn), "r/base_link": (*base, 0.0, *turn)}


def body_points(x, y, yaw):
    """Points on the edge of the robot seen from above."""
    base = np.array([x - REACH_M * math.cos(yaw), y - REACH_M * math.sin(yaw)])
    angles = np.linspace(-math.pi, math.pi, 73)
    across = 0.04 * np.array([-math.sin(yaw), math.cos(yaw)])
    tip = np.array([x, y])
    return np.concatenate(
        [base + 0.25 * np.column_stack([np.cos(angles), np.sin(angles)]), [tip + across, tip - across]]
    )


def outside_m(outline, points):
    """How far the points farthest out lie beside a closed convex line that goes round counter-clockwise."""
    edges = np.diff(outline[:, :2], axis=0)
    normals = np.column_stack([edges[:, 1], -edges[:, 0]]) / np.linalg.norm(edges, axis=1)[:, None]
    return float(((points[:, None] - outline[:-1, :2]) * normals).sum(axis=2).max(axis=1).max())


def passed_over(start, end, pivot_back_m):
    """Points on the robot's edge, finely along its way: a turn about what lies so far behind the tip, then straight."""
    x, y, yaw = start
    centre = np.array([x - pivot_back_m * math.cos(yaw), y - pivot_back_m * math.sin(yaw)])
    turned = []
    for heading in np.linspace(yaw, end[2], 400):
        tip = centre + pivot_back_m * np.array([math.cos(heading), math.sin(heading)])
        turned.append(body_points(*tip, heading))
    tip = centre + pivot_back_m * np.array([math.cos(end[2]), math.sin(end[2])])
    straight = [body_points(*(tip + share * (np.array(end[:2]) - tip)), end[2]) for share in np.linspace(0.0, 1.0, 50)]
    return np.concatenate([*turned, *straight])


@pytest.mark.parametrize("about_body", [False, True])
@pytest.mark.parametrize("end", [(1.5, -0.4, 0.3), (0.2, 1.0, 0.3 + math.pi / 2.0), (0.0, 0.1, 0.3 - math.pi / 4.0)])
def test_an_outline_is_around_all_that_a_move_sweeps(end, about_body):
    start = (0.2, 0.1, 0.3)
    poses = poses_at(*start)
    pivot = poses["r/base_link" if about_body else "r/ee"]
    (outline,) = outlines(robot(), poses, poses["r/ee"], [end], pivot)
    swept = passed_over(start, end, REACH_M if about_body else 0.0)
    assert np.array_equal(outline[0], outline[-1])
    assert outside_m(outline, swept) < 0.002
    apart = np.linalg.norm(outline[:, None, :2] - swept, axis=2).min(axis=1)
    assert apart.max() < 0.25 * (1.0 / math.cos(math.pi / 16.0) - 1.0) + 0.02, "a round body's corners lie outside"


def test_a_move_by_way_of_others_has_an_outline_for_each_part():
    poses = poses_at(0.0, 0.0, 0.0)
    lines = outlines(robot(), poses, poses["r/ee"], [(1.0, 0.0, 0.0), (1.0, 1.0, 0.0)], poses["r/ee"])
    assert len(lines) == 2
    assert lines[1][:, 1].max() == pytest.approx(1.25, abs=0.01)


def test_a_robot_without_solids_or_with_a_frame_unheard_of_has_no_outline():
    poses = poses_at(0.0, 0.0, 0.0)
    assert footprint(BodyDrawing("r", "Mobile", "dynamic", "r/ee"), poses) is None
    del poses["r/base_link"]
    assert footprint(robot(), poses) is None
    assert outlines(robot(), poses, (0.0,) * 6 + (1.0,), [(1.0, 0.0, 0.0)], (0.0,) * 7) == []
