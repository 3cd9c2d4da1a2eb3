"""Runs of a fork in full physics: the cell as a scene file, and the whole system on it in lock-step."""

from __future__ import annotations

import contextlib
import math
import signal
import subprocess
import tempfile
import threading
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Sequence, Set, Tuple, Union

import numpy as np
import yaml

from yarm.experiments.run.missions import experiment_command
from yarm.experiments.study.kinematic import FIXTURES
from yarm.experiments.study.runner import TrialKind
from yarm.experiments.what_if.cell import TUCKED, Cell, Placed, WhatIfError, cell_of
from yarm.experiments.what_if.trial import ROBOTS, WhatIfResult, WhatIfSpec, drawn, params_of, share_of
from yarm.geometry import STRAY, Pose2
from yarm.geometry.kinds import ObjectKind
from yarm.robots.ankurbot import ARM_REACH_M
from yarm.robots.hc10 import STATION_FIXTURES, Station
from yarm.sim.scenes.events import Event, Trigger
from yarm.sim.scenes.scene import Scene, SceneError, load_scene, scene_from
from yarm.sim.scenes.scene_file import scene_text
from yarm.sim.scenes.specs import ArmSpec, FixtureSpec, RobotSpec, ThingSpec

OPTIONS: Mapping[str, str] = {
    "planner": "--planner",
    "particles": "--particles",
    "turns_deg": "--turns",
    "execution": "--execution",
    "hidden": "--hidden",
    "removal": "--removal",
}
"""Settings that a run in physics knows, and run_experiment's options for them."""
FLAGS: Mapping[str, str] = {"sand_elsewhere": "--sand-elsewhere"}
"""Those that are true or false."""
CHECKED = "check_steps"
"""A run in physics sends only what the checker passes."""
LEAST_PRIORITY = "19"
DROP_M = 0.005
"""Debris is put down from so high, metres."""


class Runs:
    """The runs of this process that go on now; after an interrupt none is begun any more. Thread-safe."""

    def __init__(self) -> None:
        """None yet."""
        self.going: Set[subprocess.Popen[bytes]] = set()
        self._interrupted = False
        self._lock = threading.Lock()

    def allow(self) -> None:
        """Runs may be begun again."""
        with self._lock:
            self._interrupted = False

    def interrupt(self) -> None:
        """End all of them, as Ctrl-C does."""
        with self._lock:
            self._interrupted = True
            for run in self.going:
                run.send_signal(signal.SIGINT)

    def to_the_end(self, call: Sequence[str]) -> Tuple[int, str]:
        """Exit code and last words of a run, which ends by itself when this thread does.

        Raises:
            RuntimeError: there was an interrupt.
        """
        with self._lock:
            if self._interrupted:
                raise RuntimeError("interrupted before it began")
            run = subprocess.Popen(
                ["setpriv", "--pdeathsig", "INT", *call],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
            )
            self.going.add(run)
        try:
            said = run.communicate()[1].decode(errors="replace")
        finally:
            with self._lock:
                self.going.discard(run)
        return run.returncode, said


RUNS = Runs()


def physics() -> TrialKind[WhatIfSpec, WhatIfResult]:
    """Runs in full physics; one keeps two cores busy."""
    return TrialKind(run_physics, WhatIfResult.from_json)


@contextlib.contextmanager
def runs_at_once(count: int) -> Iterator[Executor]:
    """So many runs in physics beside each other; an exception inside, as by Ctrl-C, ends them."""
    pool = ThreadPoolExecutor(count)
    RUNS.allow()
    try:
        yield pool
    except BaseException:
        RUNS.interrupt()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def check_physics(specs: Sequence[WhatIfSpec]) -> None:
    """Whether full physics can be asked.

    Raises:
        WhatIfError: a setting is none of run_experiment's, or the cell cannot be written as a scene.
    """
    for spec in {spec.name: spec for spec in reversed(specs)}.values():
        unknown = {name for name, _ in spec.settings} - {*OPTIONS, *FLAGS, ROBOTS}
        if unknown:
            known = ", ".join((*OPTIONS, *FLAGS, ROBOTS))
            raise WhatIfError(f"--physics: {', '.join(sorted(unknown))}: settings are {known}")
        checked = dict(spec.cell.settings).get(CHECKED, "true")
        if checked != "true":
            raise WhatIfError(f"--physics: the cell has {CHECKED} = {checked!r}: runs in physics have 'true'")
        _case_of(spec)


def run_physics(spec: WhatIfSpec) -> WhatIfResult:
    """One run of the whole system, in lock-step, at the least priority."""
    with tempfile.TemporaryDirectory(prefix="yarm-what-if-") as folder:
        case = [spec.cell.scene]
        written = _case_of(spec)
        if written:
            file = Path(folder) / "forked.yaml"
            file.write_text(written)
            case = [str(file), "--nominal"]
        call = [*experiment_command(), "--case", *case, *_options(spec), "--nice", LEAST_PRIORITY]
        done, said = RUNS.to_the_end([*call, "--results", folder])
        found = sorted(Path(folder).glob("*/*/summary.yaml"))
        if not found:
            raise RuntimeError(f"run_experiment left no results (exit code {done}): {said[-500:]}")
        summary: Dict[str, Any] = yaml.safe_load(found[0].read_text())
    declared = [goal["declared_s"] for goal in summary["goals"].values() if goal["declared_s"] is not None]
    lengths = [(pause["end_s"] or summary["sim_s"]) - pause["start_s"] for pause in summary["pauses"]]
    gaps = [robot["min_clearance_m"] for robot in summary["robots"].values() if robot["min_clearance_m"] is not None]
    return WhatIfResult(
        spec,
        bool(summary["success"]),
        float(max(declared, default=0.0)) if summary["success"] else math.nan,
        len(lengths),
        float(sum(lengths)),
        float(min(gaps, default=math.inf)),
        int(summary["steps"]["refused"]),
        tuple(summary["faults"]),
    )


def _options(spec: WhatIfSpec) -> List[str]:
    """Options of run_experiment: the cell's own settings, those that are asked for over them."""
    removal = params_of(spec.cell, spec.settings, in_physics=True).removal
    given = {**dict(spec.cell.settings), **dict(spec.settings), "removal": removal}
    words = []
    for name, value in given.items():
        if name in OPTIONS:
            loaded = yaml.safe_load(value)
            text = ",".join(f"{angle:g}" for angle in loaded) if isinstance(loaded, list) else str(value)
            words.append(f"{OPTIONS[name]}={text}")
    words += [flag for name, flag in FLAGS.items() if yaml.safe_load(str(given.get(name, False)))]
    words += ["--seed", str(spec.seed), "--raster", f"{_share(spec):.3f}", "--limit", str(spec.limit_s)]
    return [*words, "--mode", _state(spec).lower()]


def _share(spec: WhatIfSpec) -> float:
    """Share of the raster that is done when the mission begins, 0 to 1."""
    at_work = any(arm.kind != TUCKED for arm in spec.cell.arms)
    return share_of(spec.cell, _rng(spec)) if at_work and not spec.cell.scene else 0.0


def _state(spec: WhatIfSpec) -> str:
    return "BOUNDED" if spec.bounded else "BOUNDLESS"


def _rng(spec: WhatIfSpec) -> np.random.Generator:
    return np.random.default_rng([spec.seed, 7])


def _case_of(spec: WhatIfSpec) -> str:
    """The scene file of a run; nothing where the scene it was asked for runs as it is.

    Raises:
        WhatIfError: the cell is no scene.
    """
    count = int(dict(spec.settings).get(ROBOTS, 0))
    try:
        if spec.cell.scene and not count:
            return ""
        if spec.cell.scene:
            scene = with_robots(load_scene(spec.cell.scene, spec.seed), count)
        else:
            cell = drawn(spec.cell, spec.seed, _rng(spec))
            scene = scene_of_cell(cell.with_robots(count) if count else cell, spec.seed)
            scene = debris_from(scene, _state(spec)) if _share(spec) > 0.0 else scene
        text = scene_text(scene)
        scene_from(yaml.safe_load(text), spec.cell.source)
    except (SceneError, ValueError) as error:
        raise WhatIfError(f"--physics: {error}") from error
    return text


def with_robots(scene: Scene, count: int) -> Scene:
    """A scene, as it is laid out, with so many robots; events that wait for any of its robots wait for any of these.

    Raises:
        WhatIfError: there is no room, or the number is out of range.
    """
    placed = cell_of(scene, scene.name, in_physics=True).with_robots(count).robots
    first = {robot.name: robot for robot in scene.robots}
    robots = tuple(first.get(robot.name) or _robot(robot) for robot in placed)
    left, names = {robot.name for robot in robots}, tuple(robot.name for robot in robots)

    def among(event: Event) -> Event:
        asked = tuple(name for name in event.when.robots if name in left)
        anybody = set(event.when.robots) == set(first) or not asked
        return (
            replace(event, when=replace(event.when, robots=names if anybody else asked)) if event.when.robots else event
        )

    gone = set(first) - left
    events = tuple(among(event) for event in scene.events if not {event.when.holding, event.vacuum} & gone)
    return replace(scene, robots=robots, events=events, vary=None)


def scene_of_cell(cell: Cell, seed: int) -> Scene:
    """A forked cell as a scene: what is bolted to no manipulator's station and is no bin becomes boxes."""
    kinds = {fixture.kind for fixture in cell.fixtures}
    scene = Scene(
        "forked",
        seed,
        cell.source,
        tuple(kind for kind in STATION_FIXTURES if kind in kinds),
        tuple(_robot(robot) for robot in cell.robots),
        tuple(ArmSpec(arm.name, "hc10", arm.kind == TUCKED, _station(arm)) for arm in cell.arms),
        tuple(FixtureSpec(fixture.name, fixture.kind, _station(fixture)) for fixture in cell.bins),
    )
    there = {(fixture.type, _rounded(fixture.station)) for fixture in scene.placed_fixtures}
    things = [_goal(goal) for goal in cell.goals]
    things += [_box(thing) for thing in cell.obstacles]
    things += [
        box for fixture in cell.fixtures if (fixture.kind, _rounded(fixture)) not in there for box in _boxes(fixture)
    ]
    return replace(scene, things=tuple(things))


def _rounded(placed: Union[Placed, Station]) -> Tuple[float, float]:
    """A place to the millimetre."""
    return round(placed.x, 3), round(placed.y, 3)


def debris_from(scene: Scene, state: str) -> Scene:
    """A scene whose debris is there from this state of the Commander on: before, it would keep the sander waiting."""
    debris = scene.things_of(ObjectKind.DEBRIS)
    events = tuple(Event(f"{piece.name} is there", Trigger(state=state), spawn=piece) for piece in debris)
    return replace(scene, things=tuple(t for t in scene.things if t not in debris), events=(*scene.events, *events))


def _robot(robot: Placed) -> RobotSpec:
    body = Pose2(robot.x, robot.y, robot.yaw_rad).compose(Pose2(-ARM_REACH_M, 0.0))
    return RobotSpec(robot.name, "ankurbot", body.x, body.y, robot.yaw_rad)


def _station(placed: Placed) -> Station:
    return Station(placed.x, placed.y, placed.yaw_rad, placed.size)


def _goal(goal: Placed) -> ThingSpec:
    z = goal.z + (DROP_M if goal.kind == ObjectKind.DEBRIS else 0.0)
    return ThingSpec(goal.name, goal.kind, goal.x, goal.y, z, goal.yaw_rad, registered=not goal.name.startswith(STRAY))


def _box(thing: Placed) -> ThingSpec:
    size = (thing.size[0], thing.size[1], thing.size[2])
    return ThingSpec(thing.name, ObjectKind.OBSTACLE, thing.x, thing.y, thing.z, thing.yaw_rad, size)


def _boxes(fixture: Placed) -> List[ThingSpec]:
    """A table or stand that no manipulator is bolted to."""
    boxes = []
    for number, solid in enumerate(FIXTURES[fixture.kind]):
        placed = solid.at(Pose2(fixture.x, fixture.y, fixture.yaw_rad))
        (low, high), (x, y) = placed.z, placed.half
        size = (2.0 * x, 2.0 * y, high - low)
        centre = placed.centre
        place = (centre.x, centre.y, 0.5 * (low + high), centre.yaw_rad)
        boxes.append(ThingSpec(f"{fixture.name}_box_{number + 1}", ObjectKind.OBSTACLE, *place, size))
    return boxes
