"""Robots that stand in the way step aside, and push on those that stand in theirs.

The push of R. Luna, K. E. Bekris, "Push and Swap: fast cooperative path-finding with completeness guarantees", IJCAI
2011. Whoever is pushed has the rank of the one it makes way for and may push anybody below, as in priority inheritance
(K. Okumura, M. Machida, X. Defago, Y. Tamura, "Priority inheritance with backtracking for iterative multi-agent path
finding", Artificial Intelligence 310, 2022); here a robot has a whole path to a place that is clear, not one cell.
"""

from __future__ import annotations

from typing import Dict, FrozenSet, Iterable, List, Optional, Tuple

import numpy as np

from yarm.planning.cspace.cell_sets import CellSet, ColumnSet, bits_of, dilated, union
from yarm.planning.cspace.robot_space import View
from yarm.planning.fleet.fleet import Fleet, Progress, free_path
from yarm.planning.roadmap.search import Flooding, Path, Target, merged, shortened


def push_through(
    fleet: Fleet, state: Progress, i: int, target: Target, rng: Optional[np.random.Generator] = None
) -> bool:
    """Let a robot go to its target after those in its way have stepped aside.

    Args:
        fleet: spaces.
        state: where everybody stands; extended when it works.
        i: the robot.
        target: where it goes.
        rng: robots step aside to a random place instead of the nearest; None for the nearest.

    Returns:
        whether it worked.
    """
    everybody = range(len(fleet.spaces))
    path = fleet.path(fleet.view(i, state.poses, everybody), state.poses[i], target)
    if path is None:
        return False
    trial = state.copy()
    keep_free = _grown_sweep(fleet, i, path)
    others = [j for j in everybody if j != i]
    if not _all_step_aside(fleet, trial, others, keep_free, frozenset({i}), rng):
        return False
    if not free_path(fleet.view(i, trial.poses), path):
        return False
    trial.go(i, path)
    state.poses, state.moves = trial.poses, trial.moves
    return True


def stroll(fleet: Fleet, state: Progress, i: int, rng: np.random.Generator) -> None:
    """Move a robot to a random place that it can reach between the others."""
    view = fleet.view(i, state.poses)
    way = fleet.flooding(view, state.poses[i]).wander(lambda reached: _random_pose(reached, rng))
    if way is not None and len(way) > 1:
        state.go(i, shortened(view, merged(way)))


def _all_step_aside(
    fleet: Fleet,
    state: Progress,
    robots: Iterable[int],
    keep_free: CellSet,
    above: FrozenSet[int],
    rng: Optional[np.random.Generator],
) -> bool:
    return all(
        _stands_clear(fleet, state, j, keep_free) or _step_aside(fleet, state, j, keep_free, above, rng) for j in robots
    )


def _stands_clear(fleet: Fleet, state: Progress, j: int, keep_free: CellSet) -> bool:
    x, y, h = state.poses[j]
    return not any(a & b for a, b in zip(fleet.spaces[j].shape(h).at((x, y)), keep_free))


def _step_aside(
    fleet: Fleet,
    state: Progress,
    j: int,
    keep_free: CellSet,
    above: FrozenSet[int],
    rng: Optional[np.random.Generator],
) -> bool:
    """Move a robot to a place clear of ``keep_free``, pushing others, but those above it, on when needed."""
    view = fleet.view(j, state.poses)
    path = _way_clear_of(view, fleet.flooding(view, state.poses[j]), keep_free, rng)
    if path is not None:
        state.go(j, path)
        return True
    below = [k for k in range(len(fleet.spaces)) if k != j and k not in above]
    if not below:
        return False
    without = fleet.view(j, state.poses, below)
    path = _way_clear_of(without, fleet.flooding(without, state.poses[j]), keep_free, rng)
    if path is None:
        return False
    free_too = union(keep_free, _grown_sweep(fleet, j, path))
    if not _all_step_aside(fleet, state, below, free_too, above | {j}, rng):
        return False
    if not free_path(fleet.view(j, state.poses), path):
        return False
    state.go(j, path)
    return True


def _way_clear_of(
    view: View, flooding: Flooding, keep_free: CellSet, rng: Optional[np.random.Generator]
) -> Optional[Path]:
    """Way to the nearest, or a random, pose where the robot overlaps nothing of ``keep_free``."""
    space = view.space
    column_sets: Dict[int, ColumnSet] = {}

    def clear(h: int) -> ColumnSet:
        if h not in column_sets:
            column_sets[h] = space.layout.field & ~space.shape(h).blocked_by(keep_free)
        return column_sets[h]

    if rng is None:
        way = flooding.way(clear)
    else:
        choice = rng
        way = flooding.wander(lambda reached: _random_pose({h: b & clear(h) for h, b in reached.items()}, choice))
    return None if way is None else shortened(view, merged(way))


def _random_pose(reached: Dict[int, ColumnSet], rng: np.random.Generator) -> Optional[Tuple[int, int]]:
    """Heading and bit of a pose, every pose as likely; None when there is none."""
    counts: List[int] = [bin(column_set).count("1") for column_set in reached.values()]
    if not sum(counts):
        return None
    index = int(rng.integers(sum(counts)))
    for (h, column_set), count in zip(reached.items(), counts):
        if index < count:
            return h, bits_of(column_set)[index]
        index -= count
    return None


def _grown_sweep(fleet: Fleet, i: int, path: Path) -> CellSet:
    return dilated(fleet.swept(i, path), fleet.spaces[i].layout.stride)
