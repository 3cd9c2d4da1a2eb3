"""Is a camera still where it is said to be? The newest seconds of its points tell, set by set."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Deque, Sequence, Tuple

import numpy as np
from scipy.spatial.transform import Rotation

from yarm.calibration.extrinsics import Refined, refine
from yarm.geometry import FloatArray
from yarm.geometry.depth_noise import kinect_sigma
from yarm.geometry.solids import Solid

TRIMS_M = (0.2, 0.12, 0.08, 0.05, 0.05)
"""A camera that was in its place a moment ago is not far from it, metres."""


@dataclass(frozen=True)
class WatchLimits:
    """When a camera counts as off.

    Attributes:
        window_s: points of so long count.
        named_m: a shift of this or more is named.
        named_rad: and a turn of this.
        significance: in deviations, that the difference must have.
        least_clouds: nothing is said of fewer.
    """

    window_s: float = 8.0
    named_m: float = 0.007
    named_rad: float = math.radians(0.3)
    significance: float = 3.0
    least_clouds: int = 3


@dataclass(frozen=True)
class Word:
    """What is said of a camera.

    Attributes:
        known: whether anything can be said.
        off: whether it is not where it is said to be.
        text: a sentence: the correction, or why nothing is known.
        refined: the fit.
    """

    known: bool
    off: bool
    text: str
    refined: Refined


class ExtrinsicsWatch:
    """One camera's newest points on known static surfaces. Not thread-safe."""

    def __init__(self, limits: WatchLimits) -> None:
        """Nothing seen yet."""
        self._limits = limits
        self._clouds: Deque[Tuple[float, FloatArray]] = deque()
        self._told: FloatArray = np.eye(4)

    def see(self, stamp_s: float, points: FloatArray, told: FloatArray) -> None:
        """Take points (n, 3) of a cloud, optical frame, metres; another pose that is told begins afresh."""
        if not np.allclose(told, self._told, atol=1e-6) or (self._clouds and stamp_s < self._clouds[-1][0]):
            self._clouds.clear()
            self._told = told.copy()
        self._clouds.append((stamp_s, points))
        while stamp_s - self._clouds[0][0] > self._limits.window_s:
            self._clouds.popleft()

    def judge(self, static: Sequence[Solid], movers: Sequence[Solid]) -> Word:
        """Whether it is where it is told to be; ``movers`` as they are now, for points near them are left out."""
        limits, count = self._limits, len(self._clouds)
        if count < limits.least_clouds:
            nothing = Refined(False, f"{count} clouds, {limits.least_clouds} are needed", self._told)
            return Word(False, False, nothing.reason, nothing)
        points = np.concatenate([cloud for _, cloud in self._clouds])
        refined = refine(points, kinect_sigma(points[:, 2]), self._told, static, movers, trims=TRIMS_M)
        if not refined.ok:
            return Word(False, False, refined.reason, refined)
        large = refined.moved_m >= limits.named_m or refined.turned_rad >= limits.named_rad
        off = large and refined.significance >= limits.significance
        return Word(True, off, correction(refined, self._told), refined)


def correction(refined: Refined, told: FloatArray) -> str:
    """How far a camera is off, and where it is: metres, quaternion x, y, z, w."""
    xyz = " ".join(f"{v:.4f}" for v in refined.pose[:3, 3])
    quaternion = " ".join(f"{v:.5f}" for v in Rotation.from_matrix(refined.pose[:3, :3]).as_quat())
    shift = " ".join(f"{1000.0 * v:+.0f}" for v in refined.pose[:3, 3] - told[:3, 3])
    turned = f"{math.degrees(refined.turned_rad):.2f} deg"
    return (
        f"{1000.0 * refined.moved_m:.0f} mm ({shift} along world x, y, z) and {turned} "
        f"from where it is told to be, {refined.significance:.0f} deviations; it fits at {xyz}, quaternion {quaternion}"
    )
