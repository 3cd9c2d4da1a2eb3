"""Low obstacles in depth images that are drawn from plain geometry: a floor, a wall and bricks."""

from __future__ import annotations

from typing import Sequence, Tuple

import numpy as np
import pytest

from yarm.navigation.low_obstacles import low_obstacles
from yarm.robots import turtlebot

ROWS, COLUMNS = turtlebot.CAMERA_HEIGHT_PX, turtlebot.CAMERA_WIDTH_PX
Brick = Tuple[float, float, float, float]
"""Distance of the front face from the camera, left end, right end (y), height; metres."""


def image(bricks: Sequence[Brick] = (), wall_m: float = 4.0, noise: float = 0.0, tilt_rad: float = 0.0) -> np.ndarray:
    """Depth image of a floor, a wall straight ahead, and the front faces and tops of bricks 0.1 m deep."""
    slope = (np.arange(ROWS) + 0.5 - ROWS / 2) / turtlebot.CAMERA_FOCAL_PX + np.tan(tilt_rad)
    aside = -(np.arange(COLUMNS) + 0.5 - COLUMNS / 2) / turtlebot.CAMERA_FOCAL_PX
    with np.errstate(divide="ignore"):
        floor = np.where(slope > 0.0, turtlebot.CAMERA_Z_M / slope, np.inf)
    depth = np.minimum(floor, wall_m)[:, None].repeat(COLUMNS, axis=1)
    for front, left, right, height in bricks:
        top = np.where(slope > 0.0, (turtlebot.CAMERA_Z_M - height) / np.maximum(slope, 1e-9), np.inf)
        seen = np.where((top >= front) & (top <= front + 0.1), top, np.where(top < front, front, np.inf))
        y = aside[None, :] * seen[:, None]
        depth = np.where((y <= left) & (y >= right), np.minimum(depth, seen[:, None]), depth)
    rng = np.random.default_rng(8)
    depth = depth + noise * depth**2 * rng.standard_normal(depth.shape)
    depth[turtlebot.HIDDEN_ROWS_FROM :] = 0.2
    depth[depth < 0.45] = np.nan
    return depth.astype(np.float32)


@pytest.mark.parametrize("noise", [0.0, 0.0015])
def test_a_bare_floor_and_a_wall_are_no_low_obstacles(noise: float) -> None:
    assert len(low_obstacles(image(noise=noise))) == 0
    assert len(low_obstacles(image(wall_m=1.0, noise=noise))) == 0


def test_a_braking_robot_sees_no_obstacles_in_the_floor() -> None:
    assert len(low_obstacles(image(tilt_rad=0.005, noise=0.0015))) == 0


@pytest.mark.parametrize(("front", "height"), [(0.8, 0.10), (1.2, 0.05), (1.8, 0.08), (2.2, 0.20)])
def test_bricks_are_found_where_they_stand(front: float, height: float) -> None:
    points = low_obstacles(image([(front, 0.25, -0.05, height)], noise=0.0015))
    assert len(points) >= 3
    assert np.all((points[:, 0] > front - 0.087 - 0.05) & (points[:, 0] < front - 0.087 + 0.15))
    assert np.all((points[:, 1] > -0.05 + 0.0135 - 0.04) & (points[:, 1] < 0.25 + 0.0135 + 0.04))
    assert points[:, 1].max() - points[:, 1].min() > 0.2


def test_a_brick_of_a_tenth_is_seen_from_0_65_on() -> None:
    assert len(low_obstacles(image([(0.66, 0.1, -0.1, 0.10)]))) > 0
    assert len(low_obstacles(image([(0.55, 0.1, -0.1, 0.10)]))) == 0, "its top lies in the hidden rows"


def test_the_hidden_rows_and_stray_pixels_count_nothing() -> None:
    picture = image()
    picture[300:302, 100:300] = np.nan
    picture[350, 200] = 0.9
    picture[408:] = 0.6
    assert len(low_obstacles(picture)) == 0


def test_an_image_without_a_floor_is_refused() -> None:
    with pytest.raises(ValueError, match="10 rows"):
        low_obstacles(np.zeros((10, 10), np.float32))
