"""Nearer boxes are drawn after those they cover, held against rays."""

from __future__ import annotations

from typing import List, Tuple

import numpy as np
import pytest

from yarm.geometry import Pose2
from yarm.geometry.pinhole import BoxSize, footprint
from yarm.sim.sensors.draw_order import far_to_near

Boxes = List[Tuple[Pose2, BoxSize]]


def reach(outline: np.ndarray, eye: np.ndarray, direction: np.ndarray) -> float:
    """How far a ray goes before it meets an outline; infinite if it never does."""
    nearest = np.inf
    for a, b in zip(outline, np.roll(outline, -1, axis=0)):
        matrix = np.column_stack([direction, a - b])
        if abs(np.linalg.det(matrix)) > 1e-12:
            along, part = np.linalg.solve(matrix, a - eye)
            if along > 0 and 0 <= part <= 1:
                nearest = min(nearest, along)
    return nearest


def test_a_long_box_behind_a_small_one_is_drawn_first_though_its_near_end_is_nearer() -> None:
    long, small = (Pose2(2.0, 0.0, 0.5), BoxSize(4.0, 0.1, 0.4)), (Pose2(1.6, 1.1, 0.0), BoxSize(0.2, 0.1, 0.4))
    order = far_to_near([long, small], (0.0, 0.0))
    outlines = [footprint(*box) for box in (long, small)]
    direction = np.array([1.6, 1.1])
    distances = [reach(outline, np.zeros(2), direction) for outline in outlines]
    nearer = int(np.argmin(distances))
    assert order[-1] == nearer


@pytest.mark.parametrize("seed", range(25))
def test_the_last_box_drawn_along_any_ray_is_the_nearest(seed: int) -> None:
    rng = np.random.default_rng(seed)
    boxes: Boxes = []
    while len(boxes) < 8:
        box = (Pose2(*rng.uniform(-2, 2, 2), rng.uniform(-3, 3)), BoxSize(rng.uniform(0.2, 0.9), 0.16, 0.4))
        if all(np.hypot(box[0].x - o.x, box[0].y - o.y) > 0.5 * (box[1].width + s.width) + 0.2 for o, s in boxes):
            boxes.append(box)
    eye = np.array([3.0 * np.cos(seed), 3.0 * np.sin(seed)])
    order = far_to_near(boxes, (float(eye[0]), float(eye[1])))
    assert sorted(order) == list(range(8))
    outlines = [footprint(*box) for box in boxes]
    for angle in np.linspace(0.0, 2.0 * np.pi, 180):
        distances = [reach(outlines[i], eye, np.array([np.cos(angle), np.sin(angle)])) for i in order]
        met = [d for d in distances if np.isfinite(d)]
        assert not met or met[-1] == min(met), (seed, angle)


def test_boxes_that_overlap_are_drawn_by_the_distance_of_their_middles() -> None:
    size = BoxSize()
    assert far_to_near([(Pose2(1.0, 0.0), size), (Pose2(1.05, 0.0, 1.5), size)], (0.0, 0.0)) == [1, 0]
    assert far_to_near([], (0.0, 0.0)) == []
