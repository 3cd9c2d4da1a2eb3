"""The KUKA youBot's arm: measures and limits, as in urdf/manipulation/youbot.urdf.xacro (a test compares).

Joint angles are *mechanical*: all zero is the candle, every link upright. ``urdf_angles`` and ``mechanical_angles`` go
to the driver's reading of the same joints (zero at one stop) and back.

The arm's frame: origin on axis 1, 0.145 m below joint 2; x ahead, z up. The coursework's ``base_link`` is this frame.
"""

from __future__ import annotations

import math
from typing import Tuple, Union

import numpy as np
import numpy.typing as npt

from yarm.geometry import FloatArray

N_JOINTS = 5
NAME = "youbot"
Joints = Tuple[float, float, float, float, float]
"""Mechanical angles of joints 1 to 5, rad."""
JOINT_NAMES = tuple(f"arm_joint_{number}" for number in range(1, N_JOINTS + 1))

SHOULDER_HEIGHT_M = 0.145
"""Joint 2 over the arm's frame."""
SHOULDER_AHEAD_M = 0.033
"""Joint 2 ahead of axis 1."""
UPPER_ARM_M = 0.155
"""Joint 2 to joint 3."""
FOREARM_M = 0.135
"""Joint 3 to joint 4."""
WRIST_ASIDE_M = -0.002
"""Axis 5 ahead of joint 4 when the hand points up."""
HAND_M = 0.185
"""Joint 4 to the end effector, along axis 5."""

LOWER_RAD: Joints = (
    math.radians(-168),
    math.radians(-65),
    math.radians(-150),
    math.radians(-102.5),
    math.radians(-167.5),
)
"""Lower limits: the narrower of the driver's and the coursework's, joint by joint."""
UPPER_RAD: Joints = (math.radians(169), math.radians(90), math.radians(146), math.radians(102.5), math.radians(167.5))
"""Upper limits, likewise."""
SPEED_RADPS = 1.5708
"""Greatest speed of every joint."""
ACCELERATION_RADPS2 = 3.0
"""Acceleration that motions keep to; the maker names none."""
JERK_RADPS3 = 30.0
"""Jerk that motions keep to; the maker names none."""

ARM_ON_BASE_XYZ_M = (0.167, 0.0, 0.0975)
"""The arm's frame over the floor under the base's middle, x ahead."""

_SIGNS = np.array([-1.0, 1.0, 1.0, 1.0, 1.0])
_CANDLE = np.radians([170.0, 65.0, -146.0, 102.5, 167.5])


def urdf_angles(q: npt.ArrayLike) -> FloatArray:
    """Driver's readings (..., 5), rad, of mechanical angles (..., 5), rad."""
    readings: FloatArray = _CANDLE + _SIGNS * np.asarray(q, dtype=float)
    return readings


def mechanical_angles(readings: npt.ArrayLike) -> FloatArray:
    """Mechanical angles (..., 5), rad, of the driver's readings (..., 5), rad."""
    angles: FloatArray = _SIGNS * (np.asarray(readings, dtype=float) - _CANDLE)
    return angles


def urdf_rates(rates: npt.ArrayLike) -> FloatArray:
    """Speeds or accelerations (..., 5) of the driver's readings, from those of the mechanical angles."""
    turned: FloatArray = _SIGNS * np.asarray(rates, dtype=float)
    return turned


def within_limits(q: npt.ArrayLike, tolerance_rad: Union[float, FloatArray] = 1e-9) -> npt.NDArray[np.bool_]:
    """Which of the configurations (..., 5), rad, keep every limit; (...)."""
    angles = np.asarray(q, dtype=float)
    inside = (angles >= np.array(LOWER_RAD) - tolerance_rad) & (angles <= np.array(UPPER_RAD) + tolerance_rad)
    return np.asarray(np.all(inside, axis=-1))


def random_joints(rng: np.random.Generator, n: int) -> FloatArray:
    """Configurations (n, 5), rad, uniform within the limits."""
    drawn: FloatArray = rng.uniform(LOWER_RAD, UPPER_RAD, (n, N_JOINTS))
    return drawn
