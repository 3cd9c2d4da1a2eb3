#!/usr/bin/env python3
"""What a hand costs in planning: the same errands of two robots, bare, loaded, and loaded with eighth turns.

    source tools/env.sh && python3 bench/planning_hands.py

On the map of ``2m1ma_bin`` (``test/data/planning/loaded_robots_at_a_bin.npz``) both robots start at random places and
headings, and one goes to a random place, step by step, re-planned at each as by the Commander. All kinds of robot get
the same errands, one kind right after the other; each is held against the first on the errands that both can do. Prints
how many errands each can do; processor times in ms, over those that all can do, of the first plan of an errand, of the
plans of the steps after it, and of all plans of an errand together; and how many times as long as the first each takes.
A row a plan goes to ``bench/data/planning_hands.csv``; an errand that cannot be done has one row without a plan.
"""

from __future__ import annotations

import argparse
import math
import time
from functools import partial
from pathlib import Path
from typing import Dict, List, Optional, Tuple

import numpy as np
import raw_rows

from yarm.geometry import BoolArray, GridSpec
from yarm.planning.fleet.yarm_planner import YarmPlanner
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import Goal, GoalKind, PlanRequest, PlanStatus, Robot, Waypoint, without_robots
from yarm.robots.ankurbot import ANKURBOT_BEAMS, ANKURBOT_DISCS, HAND_BEAMS, HAND_DISCS
from yarm.robots.shapes import PieceShape, RobotShape

MAP = Path(__file__).parents[1] / "test" / "data" / "planning" / "loaded_robots_at_a_bin.npz"
SPEC = GridSpec()
BARE = RobotShape(ANKURBOT_DISCS, ANKURBOT_BEAMS)
LOADED = RobotShape(HAND_DISCS, HAND_BEAMS).with_load(PieceShape(math.hypot(0.075, 0.03), 0.04))
"""The robot with a hand and a piece of debris under it."""
STEPS = 30

KINDS: Dict[str, Tuple[RobotShape, Tuple[float, ...]]] = {
    "bare, quarter turns": (BARE, (0.0, 90.0, -90.0)),
    "loaded hand, quarter turns": (LOADED, (0.0, 90.0, -90.0)),
    "loaded hand, eighth turns": (LOADED, (0.0, 90.0, -90.0, 45.0, -45.0)),
}

Errand = Tuple[Dict[str, Waypoint], Tuple[int, int]]


def errands(count: int, seed: int) -> List[Errand]:
    """Where the robots start, and where the first one goes; headings 90 degrees apart, as in a mission."""
    rng = np.random.default_rng(seed)

    def place() -> Waypoint:
        return Waypoint(tuple(rng.integers(2, 48, size=2).tolist()), float(0.3 + 0.5 * math.pi * rng.integers(4)))

    return [({"one": place(), "other": place()}, place().column) for _ in range(count)]


def request(occupied: BoolArray, shape: RobotShape, at: Dict[str, Waypoint], goal: Tuple[int, int]) -> PlanRequest:
    """What the Commander would ask."""
    mask_at = partial(shape.mask, SPEC)
    robots = tuple(Robot(n, w.column, w.yaw_rad, mask_at(w.yaw_rad), mask_at=mask_at) for n, w in at.items())
    wanted = Goal("place", GoalKind.TARGET, goal)
    return PlanRequest(SPEC, without_robots(SPEC, occupied, robots), robots, {"place": wanted}, {"one": "place"})


def carried_out(occupied: BoolArray, planner: YarmPlanner, shape: RobotShape, errand: Errand) -> Optional[List[float]]:
    """Processor time of each plan of an errand, ms; None when it cannot be done."""
    at, goal = dict(errand[0]), errand[1]
    rng, taken = np.random.default_rng(0), []
    for _ in range(STEPS):
        ask = request(occupied, shape, at, goal)
        began = time.thread_time()
        plan = planner.plan(ask, rng)
        taken.append(1e3 * (time.thread_time() - began))
        if plan.status is not PlanStatus.SOLVED:
            return None
        at.update({name: entry.step for name, entry in plan.robots.items() if entry.step is not None})
        if at["one"].column == goal:
            return taken
    return None


def rows_of(kind: str, taken: List[Optional[List[float]]]) -> List[Dict[str, object]]:
    """A row a plan of each errand; one without a plan for an errand that could not be done."""
    rows: List[Dict[str, object]] = []
    for errand, way in enumerate(taken):
        plans = [("", "")] if way is None else [(step, round(ms, 3)) for step, ms in enumerate(way)]
        rows += [{"robots": kind, "errand": errand, "plan": step, "ms": ms} for step, ms in plans]
    return rows


def lines(taken: Dict[str, List[Optional[List[float]]]]) -> List[str]:
    """The table's lines of the plans' times, by kind and errand; times are of the errands that all kinds can do."""
    done = [i for i in range(len(taken[next(iter(KINDS))])) if all(taken[kind][i] is not None for kind in KINDS)]
    found = []
    for kind in KINDS:
        ways = [way for way in (taken[kind][i] for i in done) if way is not None]
        first, after = [way[0] for way in ways], [ms for way in ways for ms in way[1:]]
        cells = [f"{np.percentile(ms, q):.1f}" for ms in (first, after, [sum(w) for w in ways]) for q in (50, 95)]
        found.append(f"| {kind} | {sum(way is not None for way in taken[kind])} | " + " | ".join(cells) + " |")
    return found


def main() -> None:
    """Measure, print the table and keep the rows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--errands", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    data = np.load(MAP)
    occupied = np.unpackbits(data["occupied"])[: math.prod(SPEC.shape)].reshape(SPEC.shape).astype(bool)
    asked = errands(options.errands, options.seed)
    planners = {kind: YarmPlanner(PlannerParams(turns_deg=turns)) for kind, (_, turns) in KINDS.items()}
    taken: Dict[str, List[Optional[List[float]]]] = {kind: [] for kind in KINDS}
    for errand in asked:
        for kind, (shape, _) in KINDS.items():
            taken[kind].append(carried_out(occupied, planners[kind], shape, errand))
    raw_rows.save(raw_rows.DATA / "planning_hands.csv", [row for kind in KINDS for row in rows_of(kind, taken[kind])])
    print(f"seed {options.seed}, {len(asked)} errands; processor time of a plan, ms")
    print(
        "| robots | errands done | first of an errand, p50 | p95 | steps after, p50 | p95 | errand in all, p50 | p95 |"
    )
    print("|---|---|---|---|---|---|---|---|")
    print("\n".join(lines(taken)))
    bare, *others = KINDS
    for kind in others:
        pairs = [(one, two) for one, two in zip(taken[bare], taken[kind]) if one is not None and two is not None]
        costs = [
            np.array([[way[0] for way in pair] for pair in pairs]),
            np.array([[*map(sum, pair)] for pair in pairs]),
        ]
        medians = [np.median(times[:, 1] / times[:, 0]) for times in costs]
        means = [times[:, 1].mean() / times[:, 0].mean() for times in costs]
        print(
            f"{kind} over {bare}, {len(pairs)} errands: first plan {medians[0]:.2f} (median of the ratios), "
            f"{means[0]:.2f} (ratio of the means); errand in all {medians[1]:.2f}, {means[1]:.2f}"
        )


if __name__ == "__main__":
    main()
