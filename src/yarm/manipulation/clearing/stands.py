"""Base pose and arm motion chosen together.

Stands come from the reachability map, the nearest and easiest first; one is taken when the arm finds its way there too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Generic, List, Sequence, Tuple, TypeVar

import numpy as np

from yarm.geometry import BoolArray, FloatArray, Pose2
from yarm.manipulation.clearing.arm_work import WorkError
from yarm.manipulation.clearing.floor_space import HEADINGS, Ways
from yarm.manipulation.clearing.reachability import ReachMap

EASE_M = 1.0
"""An arm at the end of its reach costs as much as a way so much longer than one that is at ease."""
TRIED = 30
"""Stands that the arm is asked about."""
APART_M = 0.10
"""They lie so far apart, or have another heading."""
Plan = TypeVar("Plan")


@dataclass(frozen=True, eq=False)
class Stand(Generic[Plan]):
    """Where the base stands, its way there, what the arm does there, and the cost it was chosen by."""

    pose: Pose2
    way: Tuple[Pose2, ...]
    arm: Plan
    cost: float


def choose_stand(
    ways: Ways,
    targets: FloatArray,
    reach: ReachMap,
    plan: Callable[[Pose2], Plan],
    free: Callable[[FloatArray], BoolArray],
) -> Stand[Plan]:
    """The cheapest stand from which the arm does its work.

    Args:
        ways: from where the base is.
        targets: (n, 2) where the cup may go, metres, world.
        reach: the map of their height.
        plan: the arm's motions from a stand; raises WorkError where there are none.
        free: which poses (n, 3) the base may have, (n,).

    Raises:
        WorkError: there is none.
    """
    poses, ease = candidates(targets, reach)
    open_to = free(poses)
    if not open_to.any():
        raise WorkError(f"none of {len(poses)} stands is free")
    poses, ease = poses[open_to], ease[open_to]
    cost = ways.lengths_to(poses) + EASE_M * (1.0 - ease)
    if not np.isfinite(cost).any():
        raise WorkError(f"none of {len(poses)} free stands can be gone to")
    faults: List[str] = []
    for index in _spread(poses, cost):
        pose = Pose2(*poses[index].tolist())
        way = ways.to(pose)
        if not way:
            faults.append("no way leads to it")
            continue
        try:
            return Stand(pose, way, plan(pose), float(cost[index]))
        except WorkError as error:
            faults.append(str(error))
    raise WorkError(f"none of {len(faults)} stands will do: {faults[0]}")


def candidates(targets: FloatArray, reach: ReachMap) -> Tuple[FloatArray, FloatArray]:
    """Poses (m, 3) of the base from which one of the targets (n, 2) is reached, and how easily (m,)."""
    points, ease = reach.reached()
    found = []
    for heading in 2.0 * math.pi * np.arange(HEADINGS) / HEADINGS:
        c, s = math.cos(heading), math.sin(heading)
        offsets = points @ np.array(((c, s), (-s, c)))
        for target in np.atleast_2d(targets):
            found.append(
                np.column_stack([target - offsets, np.full(len(points), math.remainder(heading, 2 * math.pi))])
            )
    return np.concatenate(found), np.tile(ease, len(found))


def _spread(poses: FloatArray, cost: FloatArray) -> Sequence[int]:
    """The cheapest, each apart from those before it."""
    chosen: List[int] = []
    left = np.where(np.isfinite(cost), cost, np.inf)
    while len(chosen) < TRIED:
        index = int(np.argmin(left))
        if not math.isfinite(left[index]):
            break
        chosen.append(index)
        near = np.hypot(*(poses[:, :2] - poses[index, :2]).T) < APART_M
        left = np.where(near & (np.abs(poses[:, 2] - poses[index, 2]) < 1e-6), np.inf, left)
    return chosen
