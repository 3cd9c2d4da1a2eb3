#!/usr/bin/env python3
"""Is the change that ``why`` names enough, and is no smaller one? Random scenes in which a robot has no way.

    python3 bench/why.py [--scenes 200] [--csv bench/data/why.csv]

Every answer is held against the complete search of ``yarm.planning.scenes.oracle``, which shares no code with it: the
change named is made and must give a way, and every smaller single change is made and must give none. A box whose
removal gives no way is not moved about: wherever it stands, more is taken than with it gone.

What favours whom: the oracle tests turned cells exactly, the planner rounds them outwards; so it may find a way with
turns of 45 degrees where none is named. Those are counted apart.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, List, Sequence, Tuple

import numpy as np

from yarm.planning.fleet.problem import FINER_TURNS_DEG
from yarm.planning.model.params import PlannerParams
from yarm.planning.scenes.infeasible import InfeasibleMaker, moved_boxes
from yarm.planning.scenes.instances import CELL_GRID
from yarm.planning.scenes.oracle import Node, Shape, Space
from yarm.planning.scenes.scene import Box, PlanScene, SceneRobot, Stand
from yarm.planning.why.causes import MOVE_LIMIT_CELLS, Circumstances, why
from yarm.planning.why.changes import Change, ChangeKind, Crossing
from yarm.robots.ankurbot import ankurbot_mask

Row = Dict[str, object]
ROBOT = SceneRobot("ankurbot_1", Stand((25, 25), 0.0), ankurbot_mask(CELL_GRID, 0.0).cells)


@dataclass(frozen=True)
class Judge:
    """Whether the robot of a scene has a way with some changes made, by the complete search."""

    scene: PlanScene
    shape: Shape
    finer: Shape

    def reached(self, changes: Sequence[Change]) -> bool:
        """A way is there."""
        occupied = PlanScene(self.scene.spec, self._boxes(changes), (), {}).occupied()
        kinds = {change.kind for change in changes}
        shape = self.finer if ChangeKind.TURNS in kinds else self.shape
        space = Space(shape, occupied, ChangeKind.MARGIN not in kinds)
        start = self.scene.robots[0].start
        lengths = space.lengths(Node(shape.heading(start.yaw_rad), *start.column))
        return bool(np.isfinite(lengths[self.scene.goals["goal"].column]))

    def _boxes(self, changes: Sequence[Change]) -> Tuple[Box, ...]:
        boxes, gone = self.scene.boxes, set()
        for change in changes:
            if change.kind is ChangeKind.MOVE:
                boxes = moved_boxes(boxes, _box(change), *change.offset)
            elif change.kind is ChangeKind.REMOVE:
                gone.add(_box(change))
        return tuple(box for i, box in enumerate(boxes) if i not in gone)


def _box(change: Change) -> int:
    return int(change.thing.removeprefix("boxes[").removesuffix("]"))


def smaller_changes(scene: PlanScene, judge: Judge, best: Sequence[Change]) -> List[Change]:
    """Single changes smaller than the one named that give a way all the same, turns apart."""
    crossing = Crossing(scene.request(), ROBOT.name, scene.goals["goal"], PlannerParams())
    tried: List[Change] = [Change(ChangeKind.MARGIN)]
    for name in crossing.things:
        removal = Change(ChangeKind.REMOVE, name)
        tried.append(removal)
        if judge.reached([removal]):
            tried += crossing.moves(name, MOVE_LIMIT_CELLS)
    if len(best) == 1:
        tried = [change for change in tried if change.size < best[0].size]
    return [change for change in sorted(tried, key=lambda change: change.size) if judge.reached([change])]


def row_of(seed: int, maker: InfeasibleMaker, shapes: Tuple[Shape, Shape]) -> Row:
    """One scene asked about, and the answer judged."""
    scene = maker.make(seed)
    judge = Judge(scene, *shapes)
    started = time.process_time()
    cause = why("goal", Circumstances(scene.request())).causes[0]
    asked_s = time.process_time() - started
    best = cause.changes
    turns = Change(ChangeKind.TURNS)
    without_turns = not best or len(best) > 1 or best[0].size > turns.size
    return {
        "seed": seed,
        "boxes": len(scene.boxes),
        "changes": len(best),
        "named": " and ".join(str(change) for change in best),
        "gives_a_way": bool(best) and judge.reached(best),
        "smaller": " / ".join(str(change) for change in smaller_changes(scene, judge, best)),
        "exact_turns_would_do": without_turns and judge.reached([turns]),
        "seconds": round(asked_s, 3),
    }


def main() -> int:
    """Ask, judge, write and print; 1 when an answer is wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=200)
    parser.add_argument("--csv", type=Path, default=Path("bench/data/why.csv"))
    options = parser.parse_args()
    maker = InfeasibleMaker(CELL_GRID, ROBOT)
    turns = PlannerParams.turns_deg
    finer = (*turns, *(sign * angle for angle in FINER_TURNS_DEG for sign in (1.0, -1.0)))
    shapes = Shape(ROBOT, CELL_GRID, turns), Shape(ROBOT, CELL_GRID, finer)
    rows = [row_of(seed, maker, shapes) for seed in range(options.scenes)]
    with options.csv.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    wrong = [row for row in rows if not row["gives_a_way"] or row["smaller"]]
    counts = [sum(row["changes"] == n for row in rows) for n in (1, 2)]
    seconds = np.percentile([float(str(row["seconds"])) for row in rows], [50, 99, 100])
    print(f"{len(rows)} scenes: one change {counts[0]}, two {counts[1]}, more {len(rows) - sum(counts)}")
    print(f"answers that give no way, or are not the smallest: {len(wrong)} {[row['seed'] for row in wrong]}")
    exact = sum(bool(row["exact_turns_would_do"]) for row in rows)
    print(f"ways by turns of 45 degrees that only the exact test finds: {exact}")
    print("CPU seconds an answer, p50 / p99 / most: " + " / ".join(f"{value:.2f}" for value in seconds))
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
