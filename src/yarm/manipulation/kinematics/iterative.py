"""Inverse kinematics by iteration, for poses that have no exact answer and beside the closed form.

Damped least squares: Y. Nakamura, H. Hanafusa, "Inverse kinematic solutions with singularity robustness for robot
manipulator control", Journal of Dynamic Systems, Measurement, and Control 108, 1986; the damping follows the residual
as in K. Levenberg, 1944.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

import numpy as np

from yarm.geometry import FloatArray
from yarm.manipulation.kinematics.forward import checked_joints, checked_pose, forward, jacobian, pose_error
from yarm.robots.youbot import LOWER_RAD, N_JOINTS, UPPER_RAD, Joints, random_joints

LENGTH_M = 0.3
"""A radian counts as much as this length: the arm's reach, about."""
ITERATIONS = 200
RESTARTS = 20
TOLERANCE = 1e-10
"""Steps of the joints, rad, under which it has come to rest."""
CONVERGED = 1e-6
"""Residual, m and rad, under which a pose counts as reached."""


@dataclass(frozen=True)
class IterativeAnswer:
    """Where an iteration ended.

    Attributes:
        q: joints, rad.
        converged: both residuals are under ``CONVERGED``, or what was asked for.
        iterations: of all starts together.
        position_m: residual of the position.
        rotation_rad: residual of the rotation.
    """

    q: Joints
    converged: bool
    iterations: int
    position_m: float
    rotation_rad: float


def damped_least_squares(
    pose: FloatArray, start: FloatArray, restarts: int = 0, seed: int = 0, rotation_weight: float = 1.0
) -> IterativeAnswer:
    """The configuration within the limits whose pose is nearest, as far as descent from the starts finds it.

    Args:
        pose: (4, 4), metres, arm's frame.
        start: (5,), rad, of the first descent.
        restarts: further descents, from random configurations, until one converges.
        seed: of those.
        rotation_weight: 0 leaves the rotation free.

    Raises:
        KinematicsError: not a pose, or not a configuration.
    """
    wanted, first = checked_pose(pose), checked_joints(start)
    starts = [first, *random_joints(np.random.default_rng(seed), restarts)]
    best: Optional[IterativeAnswer] = None
    iterations = 0
    for origin in starts:
        found = _descend(wanted, origin, rotation_weight)
        iterations += found.iterations
        if best is None or _cost(found, rotation_weight) < _cost(best, rotation_weight):
            best = found
        if best.converged:
            break
    assert best is not None
    return IterativeAnswer(best.q, best.converged, iterations, best.position_m, best.rotation_rad)


def _descend(pose: FloatArray, start: FloatArray, rotation_weight: float) -> IterativeAnswer:
    weights = np.array([1.0, 1.0, 1.0] + [LENGTH_M * rotation_weight] * 3)
    low, high = np.array(LOWER_RAD), np.array(UPPER_RAD)
    q = np.clip(start, low, high)
    residual = weights * pose_error(forward(q), pose)
    damping = 1e-3
    count = 0
    while count < ITERATIONS and damping < 1e6:
        count += 1
        matrix = weights[:, None] * jacobian(q)
        # A joint at its stop that is drawn farther is left out, so that the others make the best of it.
        gradient = matrix.T @ residual
        held = ((q <= low) & (gradient < 0.0)) | ((q >= high) & (gradient > 0.0))
        matrix[:, held] = 0.0
        step = np.linalg.solve(matrix.T @ matrix + damping * np.eye(N_JOINTS), matrix.T @ residual)
        trial = np.clip(q + step, low, high)
        tried = weights * pose_error(forward(trial), pose)
        if float(tried @ tried) < float(residual @ residual):
            moved = float(np.max(np.abs(trial - q)))
            q, residual, damping = trial, tried, max(damping * 0.2, 1e-15)
            if moved < TOLERANCE:
                break
        elif float(np.max(np.abs(step))) < TOLERANCE:
            break
        else:
            damping *= 4.0
    error = pose_error(forward(q), pose)
    position, rotation = float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))
    joints: Joints = tuple(float(v) for v in q)  # type: ignore[assignment]
    return IterativeAnswer(
        joints, position < CONVERGED and rotation * rotation_weight < CONVERGED, count, position, rotation
    )


def _cost(answer: IterativeAnswer, rotation_weight: float) -> float:
    return float(np.hypot(answer.position_m, LENGTH_M * rotation_weight * answer.rotation_rad))
