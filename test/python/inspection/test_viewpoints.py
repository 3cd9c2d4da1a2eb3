"""Where the report looks from: the practice world's viewpoints for an exact disc, and the rules for neighbours."""

from __future__ import annotations

import dataclasses
import math
from typing import Dict, Sequence, Tuple

import pytest

from yarm.geometry import Pose2
from yarm.geometry.pinhole import BoxSize
from yarm.inspection.boxes import Box
from yarm.inspection.inputs import read_boxes
from yarm.inspection.viewpoints import ANGLES_DEG, angles_beside, candidates, first_reachable, viewpoint
from yarm.resources import resource

RADIUS_M = 0.20
WALLS = ((-2.36, 3.64), (-4.83, 1.17))


def boxes(depth_m: float) -> Tuple[Box, ...]:
    found = read_boxes(resource("scenes", "inspection", "practice_boxes.yaml"))
    return tuple(dataclasses.replace(box, size=BoxSize(0.5, depth_m, 0.4)) for box in found)


def fits(pose: Pose2, others: Sequence[Box]) -> bool:
    (west, east), (south, north) = WALLS
    inside = west + RADIUS_M <= pose.x <= east - RADIUS_M and south + RADIUS_M <= pose.y <= north - RADIUS_M
    return inside and all(box.distance(pose.x, pose.y) >= RADIUS_M for box in others)


@pytest.mark.parametrize(
    "depth_m, turned", [(0.16, {5: -30.0, 10: 30.0}), (0.32, {2: 30.0, 5: -30.0, 9: -30.0, 10: 30.0})]
)
def test_viewpoints_of_the_practice_world(depth_m: float, turned: Dict[int, float]) -> None:
    all_boxes = boxes(depth_m)
    for box in all_boxes:
        found = first_reachable(box, lambda pose: fits(pose, all_boxes))
        assert found is not None and (found.distance_m, found.angle_deg) == (0.5, turned.get(box.number, 0.0))


def test_a_viewpoint_faces_the_box() -> None:
    box = Box(1, Pose2(1.0, 1.0, math.pi / 2))
    view = viewpoint(box, 0.5, 30.0)
    assert view.pose.distance(box.pose) == pytest.approx(0.5)
    ahead = view.pose.compose(Pose2(0.5, 0.0))
    assert ahead.distance(box.pose) < 1e-9


def test_distances_first_then_angles() -> None:
    order = [(view.distance_m, view.angle_deg) for view in candidates(Box(1, Pose2(0.0, 0.0)))]
    assert order[:6] == [(0.5, 0), (0.5, 30), (0.5, -30), (0.5, 60), (0.5, -60), (0.6, 0)]
    assert [distance for distance, _ in order[::5]] == [0.5, 0.6, 0.7, 0.8, 0.4, 0.3, 0.2]


def test_a_box_that_cannot_be_reached_has_none() -> None:
    assert first_reachable(Box(1, Pose2(0.0, 0.0)), lambda pose: False) is None


@pytest.mark.parametrize(
    "x, y, order",
    [
        (0.5, 0.75, (0, -30, -60, 30, 60)),
        (0.5, -0.75, (0, 30, 60, -30, -60)),
        (1.1, 0.0, (30, -30, 60, -60)),
        (5.0, 5.0, ANGLES_DEG),
    ],
)
def test_neighbours_send_to_the_other_side(x: float, y: float, order: Tuple[int, ...]) -> None:
    box, other = Box(1, Pose2(0.0, 0.0)), Box(2, Pose2(x, y))
    assert angles_beside(box, [other], lambda px, py: 10.0) == order


def test_in_a_narrow_space_there_is_no_frontal_point() -> None:
    assert 0 not in angles_beside(Box(1, Pose2(0.0, 0.0)), [], lambda x, y: 0.2)
