"""What stands on the floor below the height of the scan, from a depth image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from yarm.geometry import FloatArray, Pose2
from yarm.robots import turtlebot

DepthArray = npt.NDArray[np.float32]


@dataclass(frozen=True)
class LowSettings:
    """How low obstacles are found; the camera looks level along its +x.

    Attributes:
        focal_px: of the camera.
        camera_z_m: height of the camera above the floor.
        camera: pose of the camera on the robot's base.
        hidden_rows_from: this row and those below show the robot itself.
        low_m: least height of an obstacle close by.
        low_slope: what is added to low_m for each metre of distance: a robot that brakes tilts the camera.
        high_m: greatest height; what is higher the scan sees.
        far_m: farther than this is not judged.
        apart_m: an obstacle stands at least this far in front of what the scan's rows show.
        stride_px: every so many columns and rows are looked at.
        cell_m: points are counted in squares of this side.
        least_points: squares with fewer are noise.
    """

    focal_px: float = turtlebot.CAMERA_FOCAL_PX
    camera_z_m: float = turtlebot.CAMERA_Z_M
    camera: Pose2 = turtlebot.DEPTH_CAMERA
    hidden_rows_from: int = turtlebot.HIDDEN_ROWS_FROM
    low_m: float = 0.03
    low_slope: float = 0.008
    high_m: float = 0.30
    far_m: float = 2.5
    apart_m: float = 0.12
    stride_px: int = 4
    cell_m: float = 0.05
    least_points: int = 3


SETTINGS = LowSettings()
MIDDLE_ROWS = 5
"""Rows on each side of the image's middle that make up the scan."""


def low_obstacles(depth: DepthArray, settings: LowSettings = SETTINGS) -> FloatArray:
    """(n, 2) places of low obstacles in the robot's base frame, metres; about 1 ms for 640 x 480.

    Args:
        depth: (rows, columns) distance along the camera's axis, metres; NaN or <= 0 where nothing valid was seen.
        settings: how.

    Raises:
        ValueError: the image has no rows below its middle.
    """
    rows, columns = depth.shape
    middle = rows // 2
    if rows < 4 * MIDDLE_ROWS or settings.hidden_rows_from <= middle:
        raise ValueError(f"depth image of {rows} rows, hidden from row {settings.hidden_rows_from}: no floor in view")
    u = np.arange(settings.stride_px // 2, columns, settings.stride_px)
    v = np.arange(middle + MIDDLE_ROWS, min(rows, settings.hidden_rows_from), settings.stride_px)
    z = depth[v[0] : v[-1] + 1 : settings.stride_px, u[0] :: settings.stride_px].astype(float)
    slope = (v + 0.5 - rows / 2.0)[:, None] / settings.focal_px
    with np.errstate(invalid="ignore"):
        height = settings.camera_z_m - slope * z
        good = (z > 0.0) & (z < settings.far_m) & (height <= settings.high_m)
        good &= height >= settings.low_m + settings.low_slope * z
        good &= ~(z > _behind(depth, u, middle) - settings.apart_m)
    row, column = np.nonzero(good)
    ahead = z[row, column]
    aside = -(u[column] + 0.5 - columns / 2.0) / settings.focal_px * ahead
    return settings.camera.moved(_squares(np.stack([ahead, aside], axis=1), settings))


def _behind(depth: DepthArray, u: npt.NDArray[np.int64], middle: int) -> FloatArray:
    """(columns,) the nearest thing that the scan's rows show; inf where they show nothing."""
    window = depth[middle - MIDDLE_ROWS : middle + MIDDLE_ROWS, :][:, u].astype(float)
    window[~(window > 0.0)] = np.inf
    nearest: FloatArray = window.min(axis=0)
    return nearest


def _squares(points: FloatArray, settings: LowSettings) -> FloatArray:
    """The mean of the points in each square that holds enough of them."""
    if len(points) == 0:
        return points
    keys = np.floor(points / settings.cell_m).astype(np.int64)
    flat = (keys[:, 0] << 20) + keys[:, 1]
    _, which, counts = np.unique(flat, return_inverse=True, return_counts=True)
    means = np.stack([np.bincount(which, points[:, i]) / counts for i in range(2)], axis=1)
    kept: FloatArray = means[counts >= settings.least_points]
    return kept
