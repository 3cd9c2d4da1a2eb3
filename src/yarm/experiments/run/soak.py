"""A soak: missions repeated in one cell with debris at random, and what must hold at its end."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Optional, Sequence, Tuple

import numpy as np

from yarm.experiments.run.record import NodeUsage

PART_X_M = (-0.38, -0.10)
PART_Y_M = (-0.22, 0.22)
DROP_Z_M = 0.755
APART_M = 0.30
TRIES = 200
RECORDER = "run_experiment"
"""It keeps every pose for the results, so it must grow."""


@dataclass(frozen=True)
class Drop:
    """Debris to be dropped onto the part: its name, place, metres, world, heading, rad, and when, s from now."""

    name: str
    x_m: float
    y_m: float
    yaw_rad: float
    after_s: float


@dataclass(frozen=True)
class MissionRow:
    """One mission of a soak.

    Attributes:
        index: its number.
        start_s: simulated time it began, s since the soak began.
        end_s: simulated time it ended.
        debris: names of its debris, separated by blanks.
        reached: how many of them were reached.
        refused: how many were refused with a reason.
        failures: pairs of bodies that have touched and may not, so far.
        memory_mb: resident memory of all nodes, MB.
    """

    index: int
    start_s: float
    end_s: float
    debris: str
    reached: int
    refused: int
    failures: int
    memory_mb: float


def drops(mission: int, rng: np.random.Generator) -> Tuple[Drop, ...]:
    """One or two debris at random, at least ``APART_M`` apart; the second falls up to 6 s later."""
    count = int(rng.integers(1, 3))
    found: List[Drop] = []
    for _ in range(TRIES):
        x, y = float(rng.uniform(*PART_X_M)), float(rng.uniform(*PART_Y_M))
        if all(math.hypot(x - d.x_m, y - d.y_m) >= APART_M for d in found):
            after_s = float(rng.uniform(0.0, 6.0)) if found else 0.0
            yaw = float(rng.uniform(-math.pi, math.pi))
            found.append(Drop(f"debris_{mission:04d}_{len(found) + 1}", x, y, yaw, after_s))
        if len(found) == count:
            break
    return tuple(found)


def judge_soak(
    usage: Sequence[NodeUsage], lost: Sequence[str], rows: Sequence[MissionRow], memory_limit_mb: float
) -> Tuple[str, ...]:
    """What is wrong with a soak besides what is wrong with its missions.

    Memory is judged from half-way on: caches are filled by then, so what still grows would go on growing.
    """
    faults = [f"{node} has ended or was started again" for node in lost]
    for node in usage:
        grown = node.memory_end_mb - node.memory_middle_mb
        if grown > memory_limit_mb and node.node != RECORDER:
            faults.append(
                f"{node.node} has grown by {grown:.0f} MB in the second half of the soak "
                f"(limit {memory_limit_mb:.0f} MB)"
            )
    if not rows:
        faults.append("no mission was run")
    return tuple(faults)


def soak_line(rows: Sequence[MissionRow]) -> str:
    """One line on a soak."""
    last: Optional[MissionRow] = rows[-1] if rows else None
    if last is None:
        return "soak: no mission"
    return (
        f"soak: {len(rows)} missions in {last.end_s:.0f} s; {sum(r.reached for r in rows)} debris reached, "
        f"{sum(r.refused for r in rows)} refused, {last.failures} failure contacts"
    )
