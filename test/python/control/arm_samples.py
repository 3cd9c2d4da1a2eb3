"""The shipped arm and a made-up scan of its part, for the sander's tests."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from yarm.control.arm.model import ArmDescription, load_arm
from yarm.control.sander.params import SanderParams
from yarm.control.sander.planner import SanderPlanner

PART_LOWER, PART_UPPER, PART_TOP_M = (-0.45, -0.30), (-0.05, 0.30), 0.73
TOOL_RADIUS_M = 0.06


@lru_cache(maxsize=None)
def arm() -> ArmDescription:
    """The shipped HC10."""
    return load_arm()


@lru_cache(maxsize=None)
def planner(spacing_m: float = 0.04) -> SanderPlanner:
    """One planner for all tests of a process; few passes make short runs."""
    return SanderPlanner(arm(), SanderParams(spacing_m=spacing_m))


def scan(noise_m: float = 0.0015, curvature: float = 0.0, debris: bool = True, n: int = 60000) -> np.ndarray:
    """Points (n, 3) of table, part (bent along y by the curvature, 1/m) and debris, metres, world."""
    rng = np.random.default_rng(0)
    xy = rng.uniform((-0.45, -0.6), (0.1, 0.6), (n, 2))
    on_part = (np.abs(xy[:, 0] + 0.25) < 0.20) & (np.abs(xy[:, 1]) < 0.30)
    z = np.where(on_part, PART_TOP_M + 0.5 * curvature * xy[:, 1] ** 2, 0.70)
    if debris:
        z[(np.abs(xy[:, 0] + 0.2) < 0.075) & (np.abs(xy[:, 1]) < 0.03)] = PART_TOP_M + 0.04
    return np.column_stack([xy, z + rng.normal(0.0, noise_m, n)])
