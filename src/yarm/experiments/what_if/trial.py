"""One run of an alternative: the cell forked, noise and debris drawn by its seed, one mission to its end."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from typing import Any, Dict, Mapping, Tuple

import numpy as np
import yaml

from yarm.commander.params import CommanderParams, Removal
from yarm.commander.states import State
from yarm.experiments.study.runner import TrialKind
from yarm.experiments.what_if.cell import Cell, Placed, Settings, WhatIfError, cell_of_case
from yarm.experiments.what_if.world import Fork
from yarm.params import ParamError, build
from yarm.planning.model.params import PlannerParams
from yarm.planning.registry import PlannerUnavailableError, make_planner
from yarm.records import plain, read
from yarm.robots.turns import FINER_TURNS_DEG

ROBOTS = "robots"
"""The one setting that is no parameter of the Commander: how many robots."""
START_M, START_RAD, PIECE_M = 0.02, 0.02, 0.02
"""Standard deviations of where robots start, and where debris lies, about where it was, metres and rad."""
NOT_HERE = {
    "hidden": "the kinematic world has no cameras",
    "replanning": "a fork plans again at every waypoint",
    "sync": "a fork has no simulator to wait for",
    "sand_elsewhere": "a fork plays the raster back",
    "seed": "each run has its own: say --seed",
}
"""Parameters of the Commander that mean nothing in a fork, and why."""


@dataclass(frozen=True)
class WhatIfSpec:
    """What a run is made of; equal specs give equal results.

    Attributes:
        cell: what is forked.
        name: of the alternative.
        settings: names and values, as texts, over the cell's own.
        seed: of layout, noise, place in the raster and planner.
        bounded: mode of the Commander.
        limit_s: simulated time the mission may take, s.
    """

    cell: Cell
    name: str
    settings: Settings
    seed: int
    bounded: bool = False
    limit_s: float = 300.0

    @property
    def key(self) -> str:
        """Unique name, good for a file."""
        return f"{re.sub('[^a-zA-Z0-9=.]+', '_', self.name)}-{self.seed:04d}"


@dataclass(frozen=True)
class WhatIfResult:
    """What came of it.

    Attributes:
        spec: what was run.
        cleared: the mission succeeded.
        clear_s: simulated time until the last goal was done, s; NaN when it did not clear.
        pauses: of all manipulators; one that is paused at the fork counts.
        paused_s: time they were paused, s.
        least_m: least distance of a robot to anything it must not touch, metres.
        refusals: planning steps that the checker had something against.
        reasons: why it did not clear, and what the checker had against steps.
    """

    spec: WhatIfSpec
    cleared: bool
    clear_s: float
    pauses: int
    paused_s: float
    least_m: float
    refusals: int
    reasons: Tuple[str, ...] = ()

    def to_json(self) -> Dict[str, Any]:
        """Plain values."""
        values: Dict[str, Any] = plain(self)
        return values

    @staticmethod
    def from_json(values: Mapping[str, Any]) -> WhatIfResult:
        """From plain values, as read back.

        Raises:
            RecordError: they are no result.
        """
        return read(WhatIfResult, values)


def kinematic() -> TrialKind[WhatIfSpec, WhatIfResult]:
    """Runs in the kinematic world."""
    return TrialKind(run_fork, WhatIfResult.from_json)


def run_fork(spec: WhatIfSpec) -> WhatIfResult:
    """Run one; a pure function of its spec."""
    rng = np.random.default_rng([spec.seed, 7])
    cell, params = drawn(spec.cell, spec.seed, rng), params_of(spec.cell, spec.settings, spec.seed)
    count = dict(spec.settings).get(ROBOTS)
    cell = cell.with_robots(int(count)) if count else cell
    share = share_of(cell, rng)
    fork = Fork(cell, params, share, rng)
    fault = fork.run(State.BOUNDED if spec.bounded else State.BOUNDLESS, spec.limit_s)
    reasons = ([fault] if fault else []) + [f"checker: {reason}" for reason in fork.reasons]
    return WhatIfResult(
        spec,
        not fault,
        fork.done_s if not fault else math.nan,
        sum(arm.pauses for arm in fork.arms),
        sum(arm.paused_s for arm in fork.arms),
        fork.least_m,
        fork.refusals,
        tuple(reasons),
    )


def share_of(cell: Cell, rng: np.random.Generator) -> float:
    """Share of the raster that is done at the fork, 0 to 1; drawn where nobody knows."""
    return cell.share if cell.share >= 0.0 else float(rng.uniform(0.0, 0.9))


def drawn(cell: Cell, seed: int, rng: np.random.Generator) -> Cell:
    """The cell of one run: a scene as the seed lays it out, anything else with starts and debris moved a little."""
    if cell.scene:
        return replace(cell_of_case(cell.scene, seed), settings=cell.settings)
    robots = tuple(_moved(robot, rng, START_M, START_RAD) for robot in cell.robots)
    goals = tuple(_moved(goal, rng, PIECE_M, 0.0) if goal.kind == "Debris" else goal for goal in cell.goals)
    return replace(cell, robots=robots, goals=goals)


def _moved(thing: Placed, rng: np.random.Generator, by_m: float, by_rad: float) -> Placed:
    dx, dy, turn = rng.normal(0.0, 1.0, 3).tolist()
    return replace(thing, x=thing.x + by_m * dx, y=thing.y + by_m * dy, yaw_rad=thing.yaw_rad + by_rad * turn)


def params_of(cell: Cell, settings: Settings, seed: int = 1, in_physics: bool = False) -> CommanderParams:
    """The Commander's parameters of an alternative; ``in_physics`` those of a cell that has cameras.

    Raises:
        WhatIfError: a setting is unknown or out of range, or its planner is not there; all faults at once.
    """
    values: Dict[str, Any] = {"removal": (Removal.BIN if cell.bins else Removal.DELETE).value}
    missing = () if in_physics else NOT_HERE
    own = [(name, value) for name, value in cell.settings if name not in missing]
    given = {n: yaml.safe_load(value) for n, value in (*own, *settings) if n != ROBOTS}
    values.update(given)
    if values["removal"] == Removal.BIN.value and "turns_deg" not in given:
        values["turns_deg"] = (*PlannerParams.turns_deg, *FINER_TURNS_DEG)
    faults = [f"{name}: {NOT_HERE[name]}" for name in missing if name in given]
    if values["removal"] == Removal.BIN.value and not cell.bins:
        faults.append("removal = 'bin': the cell has no bins")
    try:
        params = build(CommanderParams, {**values, "seed": seed}, "what if")
        make_planner(params.planner, params.planner_params)
    except (ParamError, PlannerUnavailableError) as error:
        faults.append(str(error))
    count = dict(settings).get(ROBOTS, "1")
    if not count.isdigit():
        faults.append(f"robots = {count!r}: must be a whole number")
    if faults:
        raise WhatIfError("; ".join(faults))
    return params
