"""Depth noise of a Kinect-like camera."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from yarm.geometry.depth_noise import kinect_sigma

FloatImage = npt.NDArray[np.float32]

POOL_SIZE = 1 << 21
GRAZING_RAD = math.radians(60.0)
STEEPEST_RAD = math.radians(85.0)


def axial_sigma(depth_m: FloatImage, incidence_cos: FloatImage) -> FloatImage:
    """Standard deviation, metres, of the depth of a surface.

    That of ``kinect_sigma``, and for surfaces seen at more than 60 deg from their normal (theta, taken as at most 85
    deg, where the formula still means something) + 0.0001 / sqrt(z) theta^2 / (pi/2 - theta)^2, as measured there.

    Args:
        depth_m: depth along the optical axis z, metres, any shape.
        incidence_cos: cosine of the angle between the ray and the surface's normal, same shape.
    """
    sigma = kinect_sigma(depth_m)
    theta = np.minimum(np.arccos(np.minimum(np.abs(incidence_cos), 1.0)), STEEPEST_RAD)
    grazing = 0.0001 / np.sqrt(np.maximum(depth_m, 0.1)) * theta**2 / (0.5 * math.pi - theta) ** 2
    result: FloatImage = (sigma + np.where(theta > GRAZING_RAD, grazing, 0.0)).astype(np.float32)
    return result


class NormalPool:
    """Standard normal numbers from one seeded pool, read from a seeded random place for each image.

    Drawing 100 000 numbers afresh for each image costs about a millisecond; a slice of the pool costs nothing. Two
    images share numbers only where their slices overlap, shifted to other pixels.
    """

    def __init__(self, seed: int) -> None:
        """Fill the pool."""
        generator = np.random.Generator(np.random.Philox(seed))
        self._pool: FloatImage = generator.standard_normal(POOL_SIZE, dtype=np.float32)
        self._seed = seed

    def take(self, n: int, camera: int, frame: int) -> FloatImage:
        """N numbers for one image of one camera; the same for the same seed, camera and frame."""
        word = _mixed((self._seed << 40) ^ (camera << 32) ^ frame)
        start = word % (POOL_SIZE - n)
        return self._pool[start : start + n]


def _mixed(word: int) -> int:
    """A 64-bit hash: SplitMix64's finaliser (G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014)."""
    mask = (1 << 64) - 1
    word = (word + 0x9E3779B97F4A7C15) & mask
    word = ((word ^ (word >> 30)) * 0xBF58476D1CE4E5B9) & mask
    word = ((word ^ (word >> 27)) * 0x94D049BB133111EB) & mask
    return word ^ (word >> 31)
