"""One trial of the exploration study: an arena, a controller and a seed in the kinematic world."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Dict, Mapping, Sequence, Tuple

from yarm.experiments.explore.judge import Judge, WallError, Watcher
from yarm.experiments.explore.measures import Measures, Obstacles, measure
from yarm.experiments.explore.record import CoverageRow, ExploreRecord, PathRow
from yarm.experiments.explore.runner import run_kinematic
from yarm.exploration.model import Controller
from yarm.exploration.params import ExploreParams
from yarm.exploration.registry import make_controller
from yarm.exploration.report.controller import ReportController
from yarm.exploration.report.params import ReportParams
from yarm.exploration.report.printed import PrintedController
from yarm.geometry import Pose2
from yarm.sim.scenes.arena_maker import find_arena

CURVE_STEP_S = 10.0
PARTS: Mapping[str, Any] = {
    "tall": Obstacles,
    "low": Obstacles,
    "wall": WallError,
    "wall_fitted": WallError,
    "fit": Pose2,
}
"""Fields of Measures that are dataclasses of their own."""
FREED_M = 0.30
"""A robot this far from its start has come away from what it stood against."""


@dataclass(frozen=True)
class ExploreSpec:
    """What a trial is made of; equal specs give equal results but for the processor times.

    Attributes:
        arena: name.
        controller: name in the registry.
        seed: of the controller's draws and of all noise.
        without: a behaviour of `report` that is switched off, or faults of `report_printed` that are mended, with "+"
            between them; empty for none.
        time_limit_s: the robot stands from here on.
    """

    arena: str
    controller: str
    seed: int
    without: str = ""
    time_limit_s: float = 900.0

    @property
    def variant(self) -> str:
        """The controller, and what it goes without."""
        return f"{self.controller} without {self.without}" if self.without else self.controller

    @property
    def key(self) -> str:
        """Unique name, good for a file."""
        limit = "" if self.time_limit_s == 900.0 else f"-{self.time_limit_s:g}s"
        return f"{self.arena}-{self.variant.replace(' ', '_')}-{self.seed:04d}{limit}"


@dataclass(frozen=True)
class ExploreResult:
    """What a trial came to.

    Attributes:
        spec: what it was made of.
        measures: of the run.
        end_s: when it ended.
        done: by the controller itself.
        reason: its last words.
        curve: share every CURVE_STEP_S from 0 to the time limit; the last one stays after an early end.
        freed_s: when the robot was FREED_M from its start; inf for never.
    """

    spec: ExploreSpec
    measures: Measures
    end_s: float
    done: bool
    reason: str
    curve: Tuple[float, ...]
    freed_s: float

    def to_json(self) -> Dict[str, Any]:
        """Plain values."""
        return dataclasses.asdict(self)

    @staticmethod
    def from_json(values: Mapping[str, Any]) -> ExploreResult:
        """From plain values, as read back.

        Raises:
            TypeError: fields are missing or unknown.
            KeyError: the same.
        """
        plain = dict(values)
        plain["spec"] = ExploreSpec(**plain["spec"])
        plain["measures"] = measures_of(plain["measures"])
        plain["curve"] = tuple(plain["curve"])
        return ExploreResult(**plain)


def measures_of(values: Mapping[str, Any]) -> Measures:
    """Measures from plain values, as read back.

    Raises:
        TypeError: fields are missing or unknown.
        KeyError: the same.
    """
    measures = dict(values)
    for name, cls in PARTS.items():
        measures[name] = cls(**measures[name])
    measures["times"] = tuple(measures["times"])
    return Measures(**measures)


def run_trial(spec: ExploreSpec) -> ExploreResult:
    """Run one trial."""
    judge = judge_of(spec.arena)
    record = run_record(spec, judge)
    return ExploreResult(
        spec=spec,
        measures=measure(record, judge),
        end_s=record.end_s,
        done=record.done,
        reason=record.reason,
        curve=curve_of(record.coverage, spec.time_limit_s),
        freed_s=freed_s(record.path),
    )


def run_record(spec: ExploreSpec, judge: Judge) -> ExploreRecord:
    """The whole record of a trial."""
    params = params_of(spec)
    watcher = Watcher(judge)
    record = run_kinematic(judge.arena, controller_of(spec, params), spec.seed, params, watcher)
    return replace(record, first_seen=watcher.first_seen)


def params_of(spec: ExploreSpec) -> ExploreParams:
    """What the controller of a trial is made with."""
    return ExploreParams(controller=spec.controller, time_limit_s=spec.time_limit_s)


def parameters_of(spec: ExploreSpec) -> Dict[str, Any]:
    """Everything that can be set in a trial, by the names of its parts."""
    parts = {"explorer": dataclasses.asdict(params_of(spec))}
    if spec.controller == "report":
        parts["explorer_report"] = dataclasses.asdict(ReportParams(off=(spec.without,) if spec.without else ()))
    return parts


def controller_of(spec: ExploreSpec, params: ExploreParams) -> Controller:
    """The controller of a trial.

    Raises:
        ValueError: no such controller, or one that has nothing to go without.
    """
    if not spec.without:
        return make_controller(params, spec.seed)
    if spec.controller == "report_printed":
        return PrintedController(params, spec.seed, spec.without.split("+"))
    if spec.controller != "report":
        raise ValueError(f"{spec.controller} has nothing to go without, so not {spec.without!r}; only the reports have")
    return ReportController(params, spec.seed, ReportParams(off=(spec.without,)))


@lru_cache(maxsize=4)
def judge_of(arena: str) -> Judge:
    """The judge of an arena by name."""
    return Judge(find_arena(arena))


def curve_of(coverage: Sequence[CoverageRow], limit_s: float) -> Tuple[float, ...]:
    """Share every CURVE_STEP_S: the newest known then."""
    shares = []
    last, rows = 0.0, list(coverage)
    for i in range(int(limit_s / CURVE_STEP_S) + 1):
        while rows and rows[0].t_s <= i * CURVE_STEP_S + 1e-6:
            last = rows.pop(0).share
        shares.append(round(last, 5))
    return tuple(shares)


def freed_s(path: Sequence[PathRow]) -> float:
    """When the robot was away from its start for the first time, by the truth."""
    for row in path:
        if math.hypot(row.true_x - path[0].true_x, row.true_y - path[0].true_y) > FREED_M:
            return row.t_s
    return math.inf
