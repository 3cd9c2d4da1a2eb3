"""Where a round began, better than odometry can tell after a whole turn: its first scan laid on the known map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import binary_dilation, distance_transform_edt, map_coordinates
from scipy.optimize import least_squares

from yarm.geometry import FloatArray, Pose2
from yarm.geometry.scans import Scan
from yarm.navigation.grid_map import GridMap
from yarm.robots.turtlebot import SCAN_BIAS_PER_M

GUESS_M, GUESS_RAD = 0.05, 0.10
"""Deviation of the guess: what odometry loses in a turn."""
SURFACE_M, FAR_M = 0.03, 0.30
"""Deviation of a point from the map's surface; a point farther than the second belongs to something else."""
EVERY = 4
LEAST_POINTS = 20


def fitted(guess: Pose2, scan: Scan, grid: GridMap) -> Pose2:
    """The pose near a guess, map frame, from which a scan fits the map best; the guess if it shows too little."""
    lengthened = scan.ranges + SCAN_BIAS_PER_M * scan.ranges**2
    points = replace(scan, ranges=lengthened).points()[::EVERY]
    if len(points) < LEAST_POINTS:
        return guess
    field = _to_surfaces(grid)

    def residuals(move: FloatArray) -> FloatArray:
        pose = Pose2(guess.x + move[0], guess.y + move[1], guess.yaw_rad + move[2])
        placed = grid.origin.inverse().moved(pose.moved(points)) / grid.resolution_m - 0.5
        away = map_coordinates(field, [placed[:, 1], placed[:, 0]], order=1, mode="nearest")
        prior = move / (GUESS_M, GUESS_M, GUESS_RAD)
        found: FloatArray = np.concatenate([np.minimum(away, FAR_M) / SURFACE_M, prior])
        return found

    move = least_squares(residuals, np.zeros(3), loss="soft_l1", diff_step=1e-3, x_scale=(0.01, 0.01, 0.01)).x
    return Pose2(guess.x + float(move[0]), guess.y + float(move[1]), guess.yaw_rad + float(move[2]))


def _to_surfaces(grid: GridMap) -> FloatArray:
    """(rows, columns) distance from each cell's centre to the nearest occupied one beside a free one, metres.

    Behind a surface it grows again, so that a body's depth is nothing for points to lie in.
    """
    surfaces = grid.occupied & binary_dilation(grid.free)
    if not surfaces.any():
        return np.full(surfaces.shape, FAR_M)
    distance: FloatArray = distance_transform_edt(~surfaces, sampling=grid.resolution_m)
    return distance
