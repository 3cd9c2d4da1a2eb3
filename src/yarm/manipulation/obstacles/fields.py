"""Artificial potential fields for the arm: pulled by its hand, pushed away from obstacles all along its links.

O. Khatib, "Real-time obstacle avoidance for manipulators and mobile robots", International Journal of Robotics
Research 5, 1986. Straight attraction has local minima, in which the arm stops for good. The better field pulls along a
navigation function: the length of the shortest way of the hand round the obstacles, a wave over a grid (J. Barraquand,
J.-C. Latombe, "Robot motion planning: a distributed representation approach", International Journal of Robotics
Research 10, 1991). It has no minimum for the hand but its goal; the links behind it can still be caught.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Callable, List, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from yarm.geometry import FloatArray, IntArray
from yarm.manipulation.kinematics.forward import checked_joints, forward
from yarm.manipulation.motion.checkpoints import Obstacle
from yarm.manipulation.obstacles.distance import nearest_obstacle
from yarm.manipulation.obstacles.waves import GridWaves
from yarm.robots.youbot import (
    FOREARM_M,
    HAND_M,
    LOWER_RAD,
    SHOULDER_AHEAD_M,
    SHOULDER_HEIGHT_M,
    UPPER_ARM_M,
    UPPER_RAD,
    WRIST_ASIDE_M,
)

LINK_RADIUS_M = 0.05
HAND_RADIUS_M = 0.035
INFLUENCE_M = 0.04
"""Obstacles farther than this from a link do not push."""
PUSH = 1.6e-5
PULL = 1.0
STEP_RAD = 0.02
MOST_STEPS = 1500
PATIENCE = 150
"""Steps without progress after which it counts as stuck."""
PROGRESS_M = 2e-3
ARRIVED_M = 0.02
CELL_M = 0.03
REACH_M = 0.52
Pull = Callable[[FloatArray], Tuple[FloatArray, float]]
"""From the hand's position (3,) the direction (3,) it is pulled in, and the way left, metres."""


class FieldStatus(Enum):
    """How a descent ended."""

    ARRIVED = "arrived"
    STUCK = "stuck"


@dataclass(frozen=True, eq=False)
class FieldWay:
    """A descent of the field.

    Attributes:
        status: whether the hand came within ``ARRIVED_M`` of its goal.
        joints: (m, 5), rad, step by step.
        left_m: distance of the hand from its goal at the end.
        reason: where and why it stopped; empty when it arrived.
    """

    status: FieldStatus
    joints: FloatArray
    left_m: float
    reason: str = ""


def straight_pull(goal: FloatArray) -> Pull:
    """Attraction straight to a goal (3,), metres."""

    def pull(hand: FloatArray) -> Tuple[FloatArray, float]:
        way = goal - hand
        length = float(np.linalg.norm(way))
        return way / max(length, 1e-12), length

    return pull


class NavigationField:
    """Length of the shortest way of the hand to a goal round the obstacles, on a grid about the arm."""

    def __init__(self, obstacles: Sequence[Obstacle], cell_m: float = CELL_M) -> None:
        """Find the free cells.

        Args:
            obstacles: inflated by the hand's radius.
            cell_m: size of a cell.
        """
        n = math.ceil(REACH_M / cell_m)
        self._cell = cell_m
        self._lower = np.array([-n * cell_m, -n * cell_m, 0.0])
        self._shape = (2 * n + 1, 2 * n + 1, math.ceil((REACH_M + SHOULDER_HEIGHT_M) / cell_m) + 1)
        self._centres = self._lower + cell_m * np.stack(
            np.meshgrid(*(np.arange(size) for size in self._shape), indexing="ij"), axis=-1
        )
        flat = self._centres.reshape(-1, 3)
        distance, _ = nearest_obstacle(obstacles, flat)
        # The column of the arm's own base is no place for its hand.
        shaft = (np.hypot(flat[:, 0], flat[:, 1]) < 0.06) & (flat[:, 2] < SHOULDER_HEIGHT_M + UPPER_ARM_M)
        reach = np.linalg.norm(flat - (0.0, 0.0, SHOULDER_HEIGHT_M), axis=1) < REACH_M
        free = (distance > HAND_RADIUS_M) & reach & ~shaft
        self._waves = GridWaves(free.reshape(self._shape), cell_m)

    def pull(self, goal: FloatArray) -> Pull:
        """Attraction to a goal (3,), metres, along the shortest way from cell to cell."""
        ways = self.ways(goal)

        def pull(hand: FloatArray) -> Tuple[FloatArray, float]:
            straight = goal - hand
            if float(np.linalg.norm(straight)) < 2.0 * self._cell:
                return straight / max(float(np.linalg.norm(straight)), 1e-12), float(np.linalg.norm(straight))
            cell = self._cell_of(hand)
            low = np.maximum(cell - 2, 0)
            high = np.minimum(cell + 3, self._shape)
            near = tuple(slice(a, b) for a, b in zip(low, high))
            around = ways[near]
            # The best cell in sight, the way to it counted: smoother than the next cell alone.
            cost = around + np.linalg.norm(self._centres[near] - hand, axis=-1)
            best = np.unravel_index(int(np.argmin(cost)), cost.shape)
            way = self._centres[near][best] - hand
            return way / max(float(np.linalg.norm(way)), 1e-12), float(cost[best])

        return pull

    def ways(self, goal: FloatArray) -> FloatArray:
        """Length (gx, gy, gz) of the shortest way from each cell to a goal, metres; inf where there is none."""
        return self._waves.ways(self._cell_of(goal))

    def _cell_of(self, point: FloatArray) -> IntArray:
        cell = np.rint((point - self._lower) / self._cell).astype(np.int64)
        return np.asarray(np.clip(cell, 0, np.array(self._shape) - 1))


def descend(start: npt.ArrayLike, goal: FloatArray, pull: Pull, obstacles: Sequence[Obstacle]) -> FieldWay:
    """Follow the field from a configuration until the hand arrives or no longer gets on.

    Args:
        start: joints (5,), rad.
        goal: (3,), metres, arm's frame, where the hand shall be.
        pull: how it is drawn there.
        obstacles: what pushes.
    """
    q = checked_joints(start).copy()
    low, high = np.array(LOWER_RAD), np.array(UPPER_RAD)
    path = [q.copy()]
    best, since = math.inf, 0
    for _ in range(MOST_STEPS):
        points, jacobians, radii = control_points(q)
        hand = points[-1]
        left = float(np.linalg.norm(goal - hand))
        if left < ARRIVED_M:
            return FieldWay(FieldStatus.ARRIVED, np.array(path), left)
        direction, length = pull(hand)
        since = 0 if length < best - PROGRESS_M else since + 1
        best = min(best, length)
        if since > PATIENCE:
            break
        torque = PULL * jacobians[-1].T @ direction
        distance, away = nearest_obstacle(obstacles, points)
        gap = np.maximum(distance - radii, 1e-3)
        for point in np.flatnonzero(gap < INFLUENCE_M):
            force = PUSH * (1.0 / gap[point] - 1.0 / INFLUENCE_M) / gap[point] ** 2
            torque = torque + min(force, 10.0) * jacobians[point].T @ away[point]
        size = float(np.max(np.abs(torque)))
        if size < 1e-6:
            break
        q = np.clip(q + torque * (STEP_RAD / max(size, 0.2)), low, high)
        path.append(q.copy())
    where = ", ".join(f"{v:.2f}" for v in forward(q)[:3, 3])
    left = float(np.linalg.norm(goal - forward(q)[:3, 3]))
    return FieldWay(
        FieldStatus.STUCK,
        np.array(path),
        left,
        f"a local minimum holds the hand at ({where}), {left:.3f} m from its goal",
    )


def control_points(q: FloatArray) -> Tuple[FloatArray, FloatArray, FloatArray]:
    """Points (n, 3) along the links, the hand the last, their Jacobians (n, 3, 5) and the links' radii (n,) there."""
    q1, q2, q3, q4 = (float(v) for v in q[:4])
    angles = (q2, q2 + q3, q2 + q3 + q4)
    joints = [np.array([SHOULDER_AHEAD_M, SHOULDER_HEIGHT_M])]
    for length, angle in zip((UPPER_ARM_M, FOREARM_M), angles[:2]):
        joints.append(joints[-1] + length * np.array([math.sin(angle), math.cos(angle)]))
    places: List[Tuple[int, FloatArray]] = []
    for link, (length, shares) in enumerate(((UPPER_ARM_M, (0.5, 1.0)), (FOREARM_M, (0.5, 1.0)), (HAND_M, (0.5, 1.0)))):
        direction = np.array([math.sin(angles[link]), math.cos(angles[link])])
        aside = WRIST_ASIDE_M * np.array([direction[1], -direction[0]]) if link == 2 else np.zeros(2)
        places += [(link, joints[link] + share * length * direction + aside) for share in shares]
    c1, s1 = math.cos(q1), math.sin(q1)
    points, jacobians = np.empty((len(places), 3)), np.zeros((len(places), 3, 5))
    for index, (link, (out, up)) in enumerate(places):
        points[index] = c1 * out, s1 * out, up
        jacobians[index, :, 0] = -s1 * out, c1 * out, 0.0
        for joint in range(link + 1):
            ahead, above = out - joints[joint][0], up - joints[joint][1]
            jacobians[index, :, joint + 1] = c1 * above, s1 * above, -ahead
    radii = np.full(len(places), LINK_RADIUS_M)
    radii[-1] = HAND_RADIUS_M
    return points, jacobians, radii
