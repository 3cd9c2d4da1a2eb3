"""At which headings the robots of a fleet can stand on their targets at the same time."""

from __future__ import annotations

import math
from itertools import islice, product
from typing import Dict, List, Sequence, Tuple

from yarm.planning.cspace.robot_space import Pose, poses_touch
from yarm.planning.fleet.fleet import Fleet
from yarm.planning.roadmap.search import Target, path_cost

Targets = Dict[int, Target]
"""Target by robot."""

MEASURED = 4
"""Combinations whose ways are measured, to try the shortest first."""
COMBINATIONS = 4096
"""Combinations of headings looked at, at most."""

_BESIDE = 6.0
"""Cells: more than a margin and what turned cells, rounded outwards, add on both sides."""


def target_choices(fleet: Fleet, robots: Sequence[int]) -> List[Targets]:
    """Targets for some robots, certain headings chosen where it matters, the most promising choice first.

    When the robots, each on the way it would take alone, end apart from each other, the first choice leaves the
    headings open. The others are the combinations of headings at which all are apart, those with little turning first;
    a robot whose target is apart from all others' at every heading keeps it open.
    """
    open_targets: Targets = {}
    for i in robots:
        target = fleet.targets[i]
        assert target is not None
        open_targets[i] = target
    close = [(i, j) for i in robots for j in robots if i != j and _is_close(fleet, open_targets, i, j)]
    stands = {i: _stands(fleet, i, open_targets[i]) for i, _ in close}
    touching = {i for i, j in close if _may_touch(fleet, i, stands[i], j, stands[j])}
    concerned = [i for i in robots if i in touching]
    if not concerned:
        return [open_targets]
    ends = {i: path[-1] for i in robots for path in [fleet.alone(i)] if path is not None}
    choices = [open_targets] if _apart(fleet, ends) else []
    ranked = sorted(
        islice(product(*(stands[i] for i in concerned)), COMBINATIONS), key=lambda c: _turning(fleet, concerned, c)
    )
    fitting = [dict(zip(concerned, c)) for c in ranked if _apart(fleet, dict(zip(concerned, c)))]
    closed = [{**open_targets, **{i: Target(p[:2], p[2]) for i, p in poses.items()}} for poses in fitting]
    closed[:MEASURED] = sorted(closed[:MEASURED], key=lambda targets: _length(fleet, targets))
    return [*choices, *closed] or [open_targets]


def _is_close(fleet: Fleet, targets: Targets, i: int, j: int) -> bool:
    """Whether two targets are so close that robots on them may touch at some heading."""
    reach = fleet.spaces[i].shape0.reach + fleet.spaces[j].shape0.reach
    return math.dist(targets[i].column, targets[j].column) <= reach + _BESIDE


def _stands(fleet: Fleet, i: int, target: Target) -> List[Pose]:
    view = fleet.view(i, fleet.starts, range(len(fleet.spaces)))
    headings = range(len(view.space.headings)) if target.heading is None else [target.heading]
    poses: List[Pose] = [(target.column[0], target.column[1], h) for h in headings]
    return [pose for pose in poses if view.stands(pose)]


def _may_touch(fleet: Fleet, i: int, mine: Sequence[Pose], j: int, theirs: Sequence[Pose]) -> bool:
    return any(poses_touch(fleet.spaces[i], a, fleet.spaces[j], b) for a in mine for b in theirs)


def _apart(fleet: Fleet, poses: Dict[int, Pose]) -> bool:
    robots = list(poses)
    return not any(
        poses_touch(fleet.spaces[i], poses[i], fleet.spaces[j], poses[j])
        for k, i in enumerate(robots)
        for j in robots[:k]
    )


def _length(fleet: Fleet, targets: Targets) -> float:
    """Sum of the ways the robots would take alone."""
    total = 0.0
    for i, target in targets.items():
        path = fleet.alone(i, target)
        total += math.inf if path is None else path_cost(fleet.view(i, fleet.starts), path)
    return total


def _turning(fleet: Fleet, robots: Sequence[int], poses: Tuple[Pose, ...]) -> float:
    """Cost of turning from the present headings, where the way a robot would take alone does not end so anyway."""
    cost = 0.0
    for i, pose in zip(robots, poses):
        alone = fleet.alone(i)
        if alone is None or alone[-1] != pose:
            cost += 1.0 + fleet.spaces[i].move_cost((*pose[:2], fleet.starts[i][2]), pose)
    return cost
