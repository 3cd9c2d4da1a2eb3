"""Where the arm loses a direction: the least singular value of its Jacobian, and which of the two causes it is.

The arm is singular exactly when the elbow is straight (sin q3 = 0), or when the wrist point is on axis 1 *and* the tool
is vertical. The determinant of a computed Jacobian is never exactly 0, and its size means nothing by itself; the least
singular value with lengths measured in the arm's reach does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np
import numpy.typing as npt

from yarm.manipulation.kinematics.forward import checked_joints, jacobian
from yarm.manipulation.kinematics.iterative import LENGTH_M
from yarm.robots.youbot import FOREARM_M, SHOULDER_AHEAD_M, UPPER_ARM_M, WRIST_ASIDE_M

MARGIN = 0.03
"""Least singular value below which a configuration counts as singular; there the elbow is 10 degrees from straight."""


class SingularityKind(Enum):
    """What makes a configuration singular."""

    NONE = "none"
    ELBOW = "elbow straight"
    WRIST_OVER_AXIS = "wrist over axis 1, tool vertical"


@dataclass(frozen=True)
class Singularity:
    """How near a configuration is to one where a direction is lost.

    Attributes:
        kind: the cause, ``NONE`` at or above the margin.
        sigma_min: least singular value of the Jacobian with lengths in units of ``LENGTH_M``.
        elbow: |sin q3|, 0 when the elbow is straight.
        wrist: distance of the wrist point from axis 1 (in ``LENGTH_M``) and sine of the tool's tilt, as one length.
    """

    kind: SingularityKind
    sigma_min: float
    elbow: float
    wrist: float


def singularity(q: npt.ArrayLike, margin: float = MARGIN) -> Singularity:
    """How singular a configuration (5,), rad, is.

    Raises:
        KinematicsError: not five finite numbers.
    """
    _, q2, q3, q4, _ = checked_joints(q)
    matrix = jacobian(q)
    matrix[:3] /= LENGTH_M
    sigma = float(np.linalg.svd(matrix, compute_uv=False)[-1])
    tilt = q2 + q3 + q4
    out = WRIST_ASIDE_M * math.cos(tilt) + FOREARM_M * math.sin(q2 + q3) + UPPER_ARM_M * math.sin(q2) + SHOULDER_AHEAD_M
    elbow, wrist = abs(math.sin(q3)), math.hypot(out / LENGTH_M, math.sin(tilt))
    kind = SingularityKind.NONE
    if sigma < margin:
        kind = SingularityKind.ELBOW if elbow <= wrist else SingularityKind.WRIST_OVER_AXIS
    return Singularity(kind, sigma, elbow, wrist)
