"""What a mission in a random cell came to, held against the ground truth and against what ``cell_check`` says."""

from __future__ import annotations

import csv
import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple

import yaml

from yarm.commander.activity import Ending
from yarm.commander.events import TaskState
from yarm.experiments.run.cases import CELL_PREFIX, expected_goals
from yarm.geometry.kinds import ContactKind
from yarm.sim.scenes.random_cell import KINDS, PERSON
from yarm.sim.scenes.scene import Scene

STOOD_M = 0.01
"""A robot whose end effector moved less than this in the STOOD_S before a contact stood."""
STOOD_S = 0.25
REFUSED = (TaskState.UNREACHABLE, TaskState.FAILED)


@dataclass(frozen=True)
class CellSpec:
    """One random cell."""

    kind: str
    seed: int

    @property
    def key(self) -> str:
        """Unique name, good for a file."""
        return f"{CELL_PREFIX}{self.kind}-{self.seed:04d}"


@dataclass(frozen=True)
class CellResult:
    """What became of one cell.

    Attributes:
        spec: which cell.
        faults: everything that is wrong, one sentence each; none for a success.
        reached: goals that were reached.
        refused: goals that were refused, where ``cell_check`` finds no way to them either.
        walked_into: robots that stood still when the person who stops for nothing walked into them.
        odd: goals that were reached though ``cell_check`` finds no way to them.
        robots: mobile robots in the cell.
        sim_s: simulated length of the mission, s.
    """

    spec: CellSpec
    faults: Tuple[str, ...]
    reached: Tuple[str, ...] = ()
    refused: Tuple[str, ...] = ()
    walked_into: Tuple[str, ...] = ()
    odd: Tuple[str, ...] = ()
    robots: int = 0
    sim_s: float = 0.0

    @property
    def success(self) -> bool:
        """Nothing is wrong."""
        return not self.faults

    def to_json(self) -> Dict[str, Any]:
        """Plain values."""
        return asdict(self)

    @staticmethod
    def from_json(values: Mapping[str, Any]) -> CellResult:
        """The inverse; raises TypeError, ValueError or KeyError for anything else."""
        spec = CellSpec(str(values["spec"]["kind"]), int(values["spec"]["seed"]))
        lists = {name: tuple(values[name]) for name in ("faults", "reached", "refused", "walked_into", "odd")}
        return CellResult(spec, robots=int(values["robots"]), sim_s=float(values["sim_s"]), **lists)


def kind_of(seed: int) -> str:
    """The kind a seed stands for where none is asked for: all kinds in turn."""
    return KINDS[seed % len(KINDS)]


def read_cell(scene: Scene, folder: Path, unreachable: Mapping[str, str]) -> CellResult:
    """Judge the results in a folder.

    Args:
        scene: the cell that was run.
        folder: with summary.yaml and path.csv.
        unreachable: why ``cell_check`` finds no way to goals, by name.
    """
    spec = CellSpec(scene.name[len(CELL_PREFIX) :], scene.seed)
    try:
        summary: Mapping[str, Any] = yaml.safe_load((folder / "summary.yaml").read_text())
        with (folder / "path.csv").open(newline="") as stream:
            path = list(csv.DictReader(stream))
    except FileNotFoundError as error:
        return CellResult(spec, (f"no results: {Path(str(error.filename)).name} was not written",))
    return judge_cell(scene, summary, path, unreachable)


def judge_cell(
    scene: Scene, summary: Mapping[str, Any], path: Sequence[Mapping[str, str]], unreachable: Mapping[str, str]
) -> CellResult:
    """Judge a summary and the rows of the paths driven; arguments as for ``read_cell``."""
    goals: Mapping[str, Mapping[str, Any]] = summary["goals"]
    expected = sorted(expected_goals(scene))
    reached = tuple(name for name in expected if goals.get(name, {}).get("reached"))
    given_up = [name for name in expected if _given_up(goals.get(name, {}))]
    faults = _faults_of_goals(goals, expected, reached, unreachable)
    standing, touched = _contacts(summary["contacts"], path, [robot.name for robot in scene.robots])
    ended_well = summary["outcome"] == Ending.SUCCEEDED or (summary["outcome"] == Ending.FAILED and given_up)
    if not ended_well:
        faults.append(f"the mission ended {summary['outcome'] or 'never'!r}: {summary['reason'] or 'no reason'}")
    return CellResult(
        CellSpec(scene.name[len(CELL_PREFIX) :], scene.seed),
        (*faults, *touched),
        reached,
        tuple(name for name in given_up if name in unreachable),
        standing,
        tuple(name for name in reached if name in unreachable),
        len(scene.robots),
        float(summary["sim_s"] or 0.0),
    )


def _given_up(goal: Mapping[str, Any]) -> bool:
    return goal.get("declared_s") is None and goal.get("status") in REFUSED and bool(goal.get("reason"))


def _faults_of_goals(
    goals: Mapping[str, Mapping[str, Any]],
    expected: Iterable[str],
    reached: Sequence[str],
    unreachable: Mapping[str, str],
) -> List[str]:
    faults = []
    for name in expected:
        goal: Optional[Mapping[str, Any]] = goals.get(name)
        if name in reached or (goal is not None and _given_up(goal) and name in unreachable):
            continue
        if goal is None:
            faults.append(f"{name} was never seen by the Commander")
        elif goal["declared_s"] is not None:
            faults.append(f"{name} was declared reached while {goal['robot']} stood {goal['distance_m']:.2f} m away")
        elif _given_up(goal):
            faults.append(f"{name} was refused, and cell_check finds a way: {goal['reason']}")
        else:
            faults.append(f"{name} was not reached ({goal['status'] or 'no status'}): {goal['reason'] or 'no reason'}")
    return faults


def _contacts(
    contacts: Sequence[Mapping[str, Any]], path: Sequence[Mapping[str, str]], robots: Sequence[str]
) -> Tuple[Tuple[str, ...], List[str]]:
    """Robots that stood when the person walked into them, and a sentence on every other contact that may not be."""
    standing, faults = [], []
    for tally in (tally for tally in contacts if tally["kind"] == ContactKind.FAILURE):
        a, b = tally["pair"]
        hit = next((name for name in (a, b) if name in robots), "")
        if PERSON in (a, b) and hit and _stood(path, hit, float(tally["first_s"])):
            standing.append(hit)
        else:
            (one, other), depth_mm = tally["links"], 1000.0 * tally["depth_m"]
            faults.append(f"{a} ({one}) touched {b} ({other}) at {tally['first_s']:.1f} s, {depth_mm:.1f} mm deep")
    return tuple(standing), faults


def _stood(path: Sequence[Mapping[str, str]], robot: str, until_s: float) -> bool:
    """Whether a robot's end effector kept its place just before a moment."""
    rows = [r for r in path if r["robot"] == robot and until_s - STOOD_S <= float(r["time_s"]) <= until_s]
    places = [(float(row["x_m"]), float(row["y_m"])) for row in rows]
    return len(places) > 1 and max(math.dist(places[0], place) for place in places) < STOOD_M


def cell_line(result: CellResult) -> str:
    """One line on a cell."""
    parts = [f"{result.robots} robots, {len(result.reached)} goals reached in {result.sim_s:.0f} s"]
    if result.refused:
        parts.append(f"refused as cell_check expects: {', '.join(result.refused)}")
    if result.walked_into:
        parts.append(f"walked into while they stood: {', '.join(result.walked_into)}")
    if result.odd:
        parts.append(f"reached against cell_check: {', '.join(result.odd)}")
    verdict = "success" if result.success else "FAILED: " + "; ".join(result.faults)
    return f"{result.spec.key}: {verdict} ({'; '.join(parts)})"
