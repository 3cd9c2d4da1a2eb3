"""Command line: plan a scene, or step it to the end.

    rosrun yarm plan_scene SCENE.yaml --planner yarm --steps --json
    python3 -m yarm.planning scenes/planning/two_robots.yaml --plot out.png
    rosrun yarm plan_scene scenes/planning/walled_in.yaml --why
    rosrun yarm plan_scene scenes/planning/head_on.yaml --steps --waits

Exit code 0 solved, 2 infeasible, 3 timeout, 4 bad input (a wrong option or scene, an invalid start or goal).
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from typing import Any, Dict, List, Mapping, NoReturn, Optional, Sequence, TextIO

import numpy as np

from yarm.params import ParamError, build
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import FleetPlan, PlanStatus
from yarm.planning.registry import PLANNER_NAMES, PlannerUnavailableError, make_planner
from yarm.planning.roadmap.particles import threshold_particles
from yarm.planning.scenes.assignment import assign_goals
from yarm.planning.scenes.releasing import ReleasedRun, release_to_end, waits
from yarm.planning.scenes.scene import PlanScene
from yarm.planning.scenes.scene_file import SceneError, load_scene
from yarm.planning.scenes.stepping import SteppedRun, step_to_end
from yarm.planning.why.causes import Circumstances, why

EXIT_CODES = {
    PlanStatus.SOLVED: 0,
    PlanStatus.INFEASIBLE: 2,
    PlanStatus.TIMEOUT: 3,
    PlanStatus.INVALID_START: 4,
    PlanStatus.INVALID_GOAL: 4,
}
BAD_INPUT = 4


class _UsageError(ValueError):
    """The command line is wrong."""


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise _UsageError(message)


def main(argv: Optional[Sequence[str]] = None, out: Optional[TextIO] = None, err: Optional[TextIO] = None) -> int:
    """Run the command; gives the exit code.

    Args:
        argv: arguments without the program's name; those of the process unless given.
        out: where results go; standard output unless given.
        err: where faults go; standard error unless given.
    """
    stdout, stderr = out or sys.stdout, err or sys.stderr
    try:
        options = _parser().parse_args(argv)
        scene = load_scene(options.scene)
        params = _params(options, scene)
        if options.seed < 0:
            raise _UsageError(f"--seed = {options.seed}: expected a whole number >= 0")
        report, plan, run = _solve(scene, options, params)
        if options.plot is not None:
            _plot(options.plot, scene, plan, run)
    except (_UsageError, SceneError, ParamError, PlannerUnavailableError, OSError) as error:
        stderr.write(f"plan_scene: {error}\n")
        return BAD_INPUT
    stdout.write(json.dumps(report, indent=2) + "\n" if options.json else _text(report))
    return EXIT_CODES[PlanStatus(report["status"])]


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="plan_scene", description="Plan a scene, or step it to the end as the Commander would.")
    parser.add_argument("scene", type=Path, help="planning scene, YAML")
    planners = f"{', '.join(PLANNER_NAMES)}, or module:Class of your own; default: %(default)s"
    parser.add_argument("--planner", default="yarm", help=planners)
    parser.add_argument("--particles", help=f"particles of a search at most; default: {PlannerParams.particles}")
    parser.add_argument(
        "--threshold",
        help="in place of --particles: the threshold t of the publication (5): gx gy gz / (30 t) particles",
    )
    parser.add_argument("--turns", help="turns about the end effector, degrees, for instance 0,90,-90")
    parser.add_argument("--seed", type=int, default=0, help="seed of the random generator; default: %(default)s")
    parser.add_argument(
        "--steps", action="store_true", help="step the fleet to the end, planning again before each step"
    )
    parser.add_argument(
        "--why", action="store_true", help="say of every goal that is not reached what would change that"
    )
    parser.add_argument(
        "--waits", action="store_true", help="say which moves of the joint plan wait for which, and carry it out so"
    )
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--plot", type=Path, metavar="OUT.png", help="draw particles, graph, obstacles and paths")
    return parser


def _params(options: argparse.Namespace, scene: PlanScene) -> PlannerParams:
    values: Dict[str, Any] = {}
    if options.particles is not None and options.threshold is not None:
        raise _UsageError("--particles and --threshold: expected one of them, both say how many particles")
    if options.threshold is not None:
        values["particles"] = _threshold_particles(options.threshold, scene)
    if options.particles is not None:
        values["particles"] = _number(options.particles, int)
    if options.turns is not None:
        values["turns_deg"] = tuple(_number(part, float) for part in options.turns.split(","))
    return build(PlannerParams, values, "options")


def _threshold_particles(text: str, scene: PlanScene) -> int:
    try:
        return threshold_particles(scene.spec.shape, float(text))
    except ValueError as error:
        raise _UsageError(f"--threshold = {text}: {error}") from error


def _number(text: str, kind: Any) -> Any:
    try:
        return kind(text)
    except ValueError:
        return text


def _solve(scene: PlanScene, options: argparse.Namespace, params: PlannerParams) -> Any:
    try:
        planner = make_planner(options.planner, params)
    except KeyError as error:
        raise _UsageError(f"--planner: {error.args[0]}") from error
    rng = np.random.default_rng(options.seed)
    assignment = assign_goals(scene, params)
    run: Optional[SteppedRun] = None
    if options.steps:
        run = step_to_end(scene, planner, rng, assignment.assignments)
    plan = run.first if run is not None else planner.plan(scene.request(assignments=assignment.assignments), rng)
    report = _report(scene, plan)
    if run is not None:
        report.update(_run_report(run))
    if assignment.unserved:
        report["unserved"] = dict(assignment.unserved)
        if report["status"] == PlanStatus.SOLVED.value:
            report["status"] = PlanStatus.INFEASIBLE.value
            report["reason"] = "; ".join(assignment.unserved.values())
    if options.waits:
        report.update(_released(release_to_end(scene, planner, rng, assignment.assignments)))
    if options.why:
        request = scene.request(assignments=assignment.assignments)
        report["why"] = _answers(Circumstances(request, plan, params), assignment.unserved)
    return report, plan, run


def _answers(circumstances: Circumstances, unserved: Mapping[str, str]) -> Dict[str, Any]:
    """Why, for every goal that nobody serves, whose robot has no plan, or whose robot waits at first."""
    robots = circumstances.plan.robots if circumstances.plan is not None else {}
    stuck = {entry.goal for entry in robots.values() if entry.status is not PlanStatus.SOLVED or entry.step is None}
    answers = {}
    for goal in sorted({*unserved, *stuck} & set(circumstances.request.goals)):
        causes = why(goal, circumstances).causes
        answers[goal] = [
            {"text": cause.text, "kind": cause.kind, "changes": [str(change) for change in cause.changes]}
            for cause in causes
        ]
    return answers


def _report(scene: PlanScene, plan: Optional[FleetPlan]) -> Dict[str, Any]:
    if plan is None:
        return {"status": PlanStatus.SOLVED.value, "reason": "", "robots": {}, "planning_ms": 0.0, "particles": 0}
    robots: Dict[str, Any] = {}
    for name, entry in plan.robots.items():
        robots[name] = {
            "goal": entry.goal,
            "status": entry.status.value,
            "reason": entry.reason,
            "path": [
                {"cell": [int(v) for v in w.column], "yaw_deg": round(math.degrees(w.yaw_rad), 3)} for w in entry.path
            ],
            "length_cells": round(entry.length_cells, 3),
            "planning_ms": round(entry.planning_ms, 3),
        }
    status = {"status": plan.status.value, "reason": plan.reason, "scene": scene.name}
    return {**status, "robots": robots, "planning_ms": round(plan.planning_ms, 3), "particles": plan.particles}


def _run_report(run: SteppedRun) -> Dict[str, Any]:
    return {
        "status": run.status.value,
        "reason": run.reason,
        "steps": run.steps,
        "sum_of_costs": round(run.sum_of_costs, 3),
        "makespan": round(run.makespan, 3),
        "min_clearance_cells": run.min_clearance_cells,
        "replans": run.replans,
        "refused_steps": run.refused,
        "ms_p50": round(run.percentile_ms(50.0), 3),
        "ms_p99": round(run.percentile_ms(99.0), 3),
    }


def _released(run: ReleasedRun) -> Dict[str, Any]:
    """Who waits for whom in the first plan, and how long it takes when nobody waits for more than that."""
    moves = []
    for move, behind in waits(run.first) if run.first is not None else []:
        label = f"{move.robot} {tuple(map(int, move.start.column))} to {tuple(map(int, move.end.column))}"
        moves.append({"move": label, "after": list(behind)})
    times = {"released_status": run.status.value, "released_time": round(run.time, 3), "released_moves": len(run.made)}
    return {"waits": moves, **times, "released_refused": len(run.refusals)}


def _text(report: Dict[str, Any]) -> str:
    lines = [f"{report['status']}{': ' + report['reason'] if report['reason'] else ''}"]
    for name, entry in report["robots"].items():
        cells = " ".join(f"({w['cell'][0]}, {w['cell'][1]}) {w['yaw_deg']:g} deg" for w in entry["path"])
        lines.append(f"  {name} -> {entry['goal'] or 'aside'}: {entry['status']} {entry['reason']}{cells}")
    numbers: List[str] = []
    for key in (
        "planning_ms",
        "particles",
        "steps",
        "sum_of_costs",
        "makespan",
        "min_clearance_cells",
        "replans",
        "refused_steps",
    ):
        if key in report:
            numbers.append(f"{key} {report[key]}")
    for key in ("ms_p50", "ms_p99"):
        if key in report:
            numbers.append(f"{key} {report[key]}")
    for key in ("released_status", "released_time", "released_moves", "released_refused"):
        if key in report:
            numbers.append(f"{key} {report[key]}")
    for entry in report.get("waits", []):
        lines.append(f"  {entry['move']}: " + (f"after {', '.join(entry['after'])}" if entry["after"] else "at once"))
    for goal, causes in report.get("why", {}).items():
        lines += [f"  why {goal}: {cause['text']}" for cause in causes]
    return "\n".join([*lines, "  " + ", ".join(numbers)]) + "\n"


def _plot(path: Path, scene: PlanScene, plan: Optional[FleetPlan], run: Optional[SteppedRun]) -> None:
    from yarm.planning.tools.plot import draw_scene  # matplotlib is slow to import and only needed here  # noqa: PLC0415

    draw_scene(scene, plan, path, None if run is None else run.trails)
