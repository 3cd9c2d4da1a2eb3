"""A floor as cells, and a round base on it: through checkpoints by a potential field, or by shortest ways."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from yarm.geometry import BoolArray, FloatArray
from yarm.manipulation.motion.checkpoints import Obstacle
from yarm.manipulation.obstacles.distance import nearest_obstacle
from yarm.manipulation.obstacles.waves import GridWaves

STEP_M = 0.02
INFLUENCE_M = 0.4
PUSH = 0.02
MOST_STEPS = 3000
PATIENCE = 200
ARRIVED_M = 0.05
PROGRESS_M = 0.005


@dataclass(frozen=True, eq=False)
class Floor:
    """Square cells of a floor.

    Attributes:
        lower: (2,) corner, metres.
        cell_m: size of a cell.
        free: (gx, gy), where the base's centre may be.
    """

    lower: FloatArray
    cell_m: float
    free: BoolArray

    def centre(self, cells: npt.ArrayLike) -> FloatArray:
        """Centres (n, 2) of cells (n, 2), metres."""
        return np.asarray(self.lower + self.cell_m * (np.asarray(cells) + 0.5))

    def cell(self, point: FloatArray) -> Tuple[int, int]:
        """The cell of a point (2,), metres; it may lie outside."""
        x, y = np.floor((np.asarray(point) - self.lower) / self.cell_m).astype(int).tolist()
        return x, y


@dataclass(frozen=True, eq=False)
class BaseWay:
    """A way of the base's centre (n, 2), metres; how many checkpoints it reached, and why no more."""

    points: FloatArray
    reached: int
    reason: str = ""


def lay_floor(half_m: float, cell_m: float, obstacles: Sequence[Obstacle], radius_m: float) -> Floor:
    """The floor from -half to half along both axes, obstacles inflated by the base's radius.

    Args:
        half_m: half its side.
        cell_m: size of a cell.
        obstacles: solids that stand on it; their heights do not matter.
        radius_m: of the base.
    """
    n = round(2.0 * half_m / cell_m)
    lower = np.full(2, -half_m)
    centres = np.indices((n, n)).reshape(2, -1).T * cell_m + lower + 0.5 * cell_m
    inside = np.all(np.abs(centres) <= half_m - radius_m + 1e-9, axis=1)
    free = inside & (_distance(obstacles, centres)[0] > radius_m)
    return Floor(lower, cell_m, free.reshape(n, n))


def field_way(
    start: FloatArray, checkpoints: Sequence[FloatArray], obstacles: Sequence[Obstacle], radius_m: float
) -> BaseWay:
    """Down a potential field, each checkpoint attracting when the one before is reached, obstacles repelling.

    Args:
        start: (2,), metres.
        checkpoints: (2,) each, metres, in order.
        obstacles: on the floor.
        radius_m: of the base.
    """
    here, points = np.asarray(start, dtype=float), [np.asarray(start, dtype=float)]
    for number, goal in enumerate(checkpoints):
        best, since = math.inf, 0
        for _ in range(MOST_STEPS):
            way = goal - here
            left = float(np.linalg.norm(way))
            if left < ARRIVED_M:
                break
            since = 0 if left < best - PROGRESS_M else since + 1
            best = min(best, left)
            if since > PATIENCE:
                where = f"({here[0]:.2f}, {here[1]:.2f})"
                reason = f"a local minimum at {where} holds it {left:.2f} m from checkpoint {number + 1}"
                return BaseWay(np.array(points), number, reason)
            force = way / left
            distance, away = _distance(obstacles, here[None])
            gap = max(float(distance[0]) - radius_m, 0.01)
            if gap < INFLUENCE_M:
                force = force + PUSH * (1.0 / gap - 1.0 / INFLUENCE_M) / gap * away[0]
            here = here + STEP_M * force / max(float(np.linalg.norm(force)), 1.0)
            points.append(here)
        else:
            reason = f"{MOST_STEPS} steps did not bring it to checkpoint {number + 1}"
            return BaseWay(np.array(points), number, reason)
    return BaseWay(np.array(points), len(checkpoints))


def planned_way(start: FloatArray, checkpoints: Sequence[FloatArray], floor: Floor) -> BaseWay:
    """Shortest ways over the floor's free cells from one checkpoint to the next."""
    waves = GridWaves(floor.free, floor.cell_m)
    here = tuple(waves.nearest_free(floor.cell(start)))
    points: List[FloatArray] = [np.asarray(start, dtype=float)]
    for number, goal in enumerate(checkpoints):
        cell = floor.cell(goal)
        if not (min(cell) >= 0 and max(cell) < min(floor.free.shape)) or not floor.free[cell]:
            return BaseWay(np.array(points), number, f"checkpoint {number + 1} is not on the free floor")
        path = waves.path(here, cell)
        if not len(path):
            return BaseWay(np.array(points), number, f"no way leads to checkpoint {number + 1}")
        points += list(floor.centre(path))
        here = cell
    return BaseWay(np.array(points), len(checkpoints))


def _distance(obstacles: Sequence[Obstacle], points: FloatArray) -> Tuple[FloatArray, FloatArray]:
    """Distance (n,) of points (n, 2) to the nearest obstacle's outline, and directions (n, 2) away from it."""
    least, away = np.full(len(points), np.inf), np.zeros((len(points), 2))
    for obstacle in obstacles:
        # At the height of the solid's own middle the nearest point is on its outline.
        level = np.column_stack([points, np.full(len(points), obstacle.solid.pose[2, 3])])
        distance, direction = nearest_obstacle([obstacle], level)
        inside_flat = np.hypot(direction[:, 0], direction[:, 1]) < 0.5
        direction[inside_flat, 0] = 1.0
        closer = distance < least
        least[closer], away[closer] = distance[closer], direction[closer, :2]
    return least, away
