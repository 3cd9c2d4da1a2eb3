"""Boxes on the floor: their face, corners, distances and overlaps."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from yarm.geometry import Pose2
from yarm.geometry.pinhole import BoxSize
from yarm.inspection.boxes import Box, extent_of, outside, overlap
from yarm.inspection.inputs import read_boxes
from yarm.navigation.grid_map import GridMap
from yarm.resources import resource

TURNED = Box(1, Pose2(1.0, 2.0, math.pi / 2), BoxSize(0.5, 0.2, 0.4))


def test_the_tag_is_on_the_side_that_the_yaw_points_to() -> None:
    assert TURNED.face.distance(Pose2(1.0, 2.1)) < 1e-9 and TURNED.face.yaw_rad == pytest.approx(math.pi / 2)


def test_corners_are_half_a_width_and_half_a_depth_away() -> None:
    assert TURNED.corners() == pytest.approx(TURNED.corners().round(9))
    assert sorted(map(tuple, TURNED.corners().round(6))) == [(0.75, 1.9), (0.75, 2.1), (1.25, 1.9), (1.25, 2.1)]


@pytest.mark.parametrize("x, y, gap", [(1.0, 2.0, 0.0), (1.25, 2.05, 0.0), (1.55, 2.5, 0.5), (1.0, 1.0, 0.9)])
def test_distance(x: float, y: float, gap: float) -> None:
    assert TURNED.distance(x, y) == pytest.approx(gap if (x, y) != (1.55, 2.5) else math.hypot(0.3, 0.4))


@pytest.mark.parametrize("depth, deep", [(0.32, 0.10), (0.16, 0.025)])
def test_boxes_9_and_10_of_the_practice_world_overlap(depth: float, deep: float) -> None:
    boxes = read_boxes(resource("scenes", "inspection", "practice_boxes.yaml"))
    nine, ten = (Box(box.number, box.pose, BoxSize(0.5, depth, 0.4)) for box in boxes if box.number in (9, 10))
    assert overlap(nine, ten) == pytest.approx(deep, abs=0.012)
    assert overlap(nine, Box(11, nine.pose.compose(Pose2(0.0, 0.51)))) == 0.0


def test_the_shipped_file_is_there() -> None:
    assert Path(resource("scenes", "inspection", "practice_boxes.yaml")).is_file()


def test_a_box_is_outside_a_map_by_its_centre_also_of_one_that_is_turned() -> None:
    grid = GridMap(np.zeros((40, 60), np.int8), 0.05, Pose2(1.0, 1.0, math.pi / 2))
    there, beyond = Box(1, Pose2(0.0, 2.0)), Box(2, Pose2(2.0, 2.0))
    assert outside([there, beyond], grid) == [beyond]
    assert extent_of(grid) == "3 x 2 m from (1, 1) on"
