"""From a drive command and the casters' angles to the speed of each wheel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from yarm.geometry import FloatArray
from yarm.robots.ankurbot import CASTER_XY_M

CASTERS_M = np.array(CASTER_XY_M)
PARALLEL_LIMIT = 0.002
"""Least curvature of the wheels' headings, 1, for a turning centre to exist (a centre nearer than about 7 m)."""


@dataclass(frozen=True, eq=False)
class WheelSpeeds:
    """Speed of each wheel along its heading (4,), m/s, and whether a yaw rate found a centre to turn about."""

    speeds_mps: FloatArray
    has_centre: bool


def turning_centre(angles_rad: FloatArray) -> FloatArray:
    """The point (2,), metres, base_link, that the wheels' axes meet in (least squares); NaN when they are parallel."""
    headings = np.stack([np.cos(angles_rad), np.sin(angles_rad)], axis=-1)
    normal = headings.T @ headings
    if float(np.linalg.eigvalsh(normal)[0]) < PARALLEL_LIMIT:
        return np.full(2, np.nan)
    along = np.sum(headings * CASTERS_M, axis=-1)
    centre: FloatArray = np.linalg.solve(normal, headings.T @ along)
    return centre


def wheel_speeds(angles_rad: FloatArray, drive_mps: float, yaw_rate_rps: float) -> WheelSpeeds:
    """Wheel speeds for a drive speed along the wheels' headings plus a yaw rate about their common centre.

    Args:
        angles_rad: measured caster angles (4,), rad, 0 along the arm.
        drive_mps: speed along the wheels' heading, m/s.
        yaw_rate_rps: yaw rate about the centre that the angles define, rad/s; without a centre it is left out.
    """
    speeds = np.full(4, float(drive_mps))
    if yaw_rate_rps == 0.0:
        return WheelSpeeds(speeds, True)
    centre = turning_centre(angles_rad)
    if np.isnan(centre[0]):
        return WheelSpeeds(speeds, False)
    arm = CASTERS_M - centre
    speeds += yaw_rate_rps * (arm[:, 0] * np.sin(angles_rad) - arm[:, 1] * np.cos(angles_rad))
    return WheelSpeeds(speeds, True)
