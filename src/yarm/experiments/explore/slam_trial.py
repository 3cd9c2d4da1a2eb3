"""One trial with SLAM: an arena, a controller and a seed, in physics or in the kinematic world."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, replace
from typing import Any, ContextManager, Dict, List, Mapping, Sequence, Tuple

import numpy as np

from yarm.experiments.explore.judge import Judge, Watcher
from yarm.experiments.explore.measures import Measures, measure
from yarm.experiments.explore.record import ExploreRecord, PathRow
from yarm.experiments.explore.runner import explore
from yarm.experiments.explore.slam_run import MAP_S, SlamExplorer
from yarm.experiments.explore.trial import curve_of, judge_of, measures_of
from yarm.experiments.study.runner import TrialKind, fingerprint
from yarm.experiments.study.sources import files_of
from yarm.exploration.model import Controller
from yarm.exploration.params import ExploreParams
from yarm.exploration.registry import CONTROLLERS, make_controller
from yarm.exploration.report.controller import ReportController
from yarm.exploration.report.params import FAST
from yarm.geometry import wrap_angle
from yarm.navigation import slam_native
from yarm.navigation.low_obstacles import low_obstacles
from yarm.resources import resource
from yarm.sim.engine.physics_world import PhysicsWorld
from yarm.sim.kinematic.world import KinematicWorld
from yarm.sim.room_robot import RoomRobot
from yarm.sim.scenes.arena import Arena
from yarm.sim.sensors import rays_native

TRIAL = __name__
PHYSICS, KINEMATIC = "physics", "kinematic"
WORLDS = (PHYSICS, KINEMATIC)


@dataclass(frozen=True)
class SlamSpec:
    """What a trial is made of; equal specs give equal results but for the processor times.

    Attributes:
        arena: name.
        controller: name in the registry.
        seed: of the controller's draws and of all noise.
        world: one of WORLDS.
        fast: `report` at 0.3 and 0.15 m/s in place of 0.2 and 0.1.
        map_s: between two maps.
        time_limit_s: the robot stands from here on.
    """

    arena: str
    controller: str
    seed: int
    world: str = PHYSICS
    fast: bool = False
    map_s: float = MAP_S
    time_limit_s: float = 900.0

    @property
    def key(self) -> str:
        """Unique name, good for a file."""
        fast = "-fast" if self.fast else ""
        limit = "" if self.time_limit_s == 900.0 else f"-{self.time_limit_s:g}s"
        maps = "" if self.map_s == MAP_S else f"-maps{self.map_s:g}s"
        return f"{self.world}-{self.arena}-{self.controller}{fast}-{self.seed:04d}{maps}{limit}"


@dataclass(frozen=True)
class SlamResult:
    """What a trial came to.

    Attributes:
        spec: what it was made of.
        measures: of the run.
        end_s: when it ended.
        done: by the controller itself.
        reason: its last words.
        curve: share every 10 s.
        heading_rmse_rad: of where the robot believed to look.
        worst_pose_m: greatest error of where it believed to be.
        slam_core: share of a core that mapping took, of the simulated time.
        keyframes: scans that the map maker kept.
        unmatched: matches that were due and failed.
    """

    spec: SlamSpec
    measures: Measures
    end_s: float
    done: bool
    reason: str
    curve: Tuple[float, ...]
    heading_rmse_rad: float
    worst_pose_m: float
    slam_core: float
    keyframes: int
    unmatched: int

    def to_json(self) -> Dict[str, Any]:
        """Plain values."""
        return dataclasses.asdict(self)

    @staticmethod
    def from_json(values: Mapping[str, Any]) -> SlamResult:
        """From plain values, as read back.

        Raises:
            TypeError: fields are missing or unknown.
            KeyError: the same.
        """
        plain = dict(values)
        plain["spec"] = SlamSpec(**plain["spec"])
        plain["measures"] = measures_of(plain["measures"])
        plain["curve"] = tuple(plain["curve"])
        return SlamResult(**plain)


def run_slam_trial(spec: SlamSpec) -> SlamResult:
    """Run one trial."""
    judge = judge_of(spec.arena)
    record, explorer = run_slam_record(spec, judge)
    return SlamResult(
        spec=spec,
        measures=measure(record, judge),
        end_s=record.end_s,
        done=record.done,
        reason=record.reason,
        curve=curve_of(record.coverage, spec.time_limit_s),
        heading_rmse_rad=heading_rmse_rad(record.path),
        worst_pose_m=max(math.hypot(row.true_x - row.x, row.true_y - row.y) for row in record.path),
        slam_core=explorer.slam_cpu_s / record.path[-1].t_s,
        keyframes=explorer.counts.keyframes,
        unmatched=explorer.counts.unmatched,
    )


def run_slam_record(spec: SlamSpec, judge: Judge) -> Tuple[ExploreRecord, SlamExplorer]:
    """The whole record of a trial, and who explored."""
    params = ExploreParams(controller=spec.controller, time_limit_s=spec.time_limit_s)
    with make_world(spec.world, judge.arena, spec.seed) as world:
        explorer = SlamExplorer(world, params, lambda: controller_of(spec, params), spec.map_s)
        watcher = Watcher(judge, explorer.world_from_map)
        record = explore(world, explorer, explorer, spec.seed, params, watcher, spec.world)
    return replace(record, first_seen=watcher.first_seen), explorer


def make_world(name: str, arena: Arena, seed: int) -> ContextManager[RoomRobot]:
    """A world by name.

    Raises:
        ValueError: there is none of that name.
    """
    if name == PHYSICS:
        return PhysicsWorld(arena, seed, low_obstacles)
    if name == KINEMATIC:
        return KinematicWorld(arena, seed)
    raise ValueError(f"world {name!r} is not known; known: {', '.join(WORLDS)}")


def controller_of(spec: SlamSpec, params: ExploreParams) -> Controller:
    """The controller of a trial.

    Raises:
        ValueError: no such controller, or one that has no fast profile.
    """
    if not spec.fast:
        return make_controller(params, spec.seed)
    if spec.controller != "report":
        raise ValueError(f"{spec.controller} has no fast profile; only report has")
    return ReportController(params, spec.seed, FAST)


def heading_rmse_rad(rows: Sequence[PathRow]) -> float:
    """Of where the robot believed to look."""
    errors = [wrap_angle(row.yaw - row.true_yaw) for row in rows]
    return math.sqrt(float(np.mean(np.square(errors))))


def code_of(spec: SlamSpec) -> str:
    """Digest of what a trial depends on, as of the trials without SLAM, and of the libraries it has loaded."""
    own = CONTROLLERS[spec.controller].__module__
    others = {make.__module__ for make in CONTROLLERS.values()} - {own, ReportController.__module__}
    libraries: List[Any] = [slam_native.library_path(), rays_native.library_path()]
    data = [resource("scenes", "exploration"), resource("urdf", "exploration")]
    return fingerprint([*files_of([TRIAL, own], others), *data, *(path for path in libraries if path is not None)])


SLAM_TRIALS: TrialKind[SlamSpec, SlamResult] = TrialKind(run_slam_trial, SlamResult.from_json, code_of)
