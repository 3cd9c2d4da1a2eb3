"""One trial of the study: one robot, one target, a planner with or without re-planning, in the kinematic world."""

from __future__ import annotations

import dataclasses
import math
import time
from dataclasses import dataclass, field, replace
from typing import Any, Dict, List, Mapping, Optional, Tuple

import numpy as np

from yarm.commander.params import CommanderParams
from yarm.control.base.controller import Outcome
from yarm.experiments.study.arm_track import arm_of
from yarm.experiments.study.clearance import flat_distance
from yarm.experiments.study.kinematic import TICK_S, KinematicRobot, KinematicWorld
from yarm.geometry import GridSpec
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import FleetPlan, FleetPlanner, PlanRequest, RobotPlan, Waypoint
from yarm.planning.registry import make_planner
from yarm.planning.verification.checker import check_step
from yarm.robots.ankurbot import EE_HEIGHT_M
from yarm.sim.scenes.scene import load_scene

THINK_S = 0.1
"""Simulated time a robot stands between two waypoints while the map is looked at and the plan is made."""
WAIT_S = 0.5
PATIENCE_S = 60.0
"""A robot that was sent nothing, or got nowhere, for so long is stuck."""
LIMIT_S = 300.0
ORIGINAL_PAUSE_CELLS = 2.0
"""The publication pauses the manipulator when its tip is nearer than this to the end effector."""


@dataclass(frozen=True)
class TrialSpec:
    """What a trial is made of; equal specs give equal results.

    Attributes:
        scene: name of the scene.
        planner: "original" or "yarm".
        replanning: plan again at every waypoint; else the first path is followed to its end, unchecked.
        particles: number of particles.
        margin_cells: what `original` keeps from what stands in the map, cells; `yarm` always keeps one.
        seed: of the planner, and of the place in its raster the manipulator starts from.
    """

    scene: str
    planner: str
    replanning: bool
    particles: int
    margin_cells: int
    seed: int

    @property
    def key(self) -> str:
        """Unique name, good for a file."""
        asked = "replanning" if self.replanning else "once"
        return f"{self.scene}-{self.planner}{self.margin_cells}-{asked}-{self.particles:04d}-{self.seed:04d}"


@dataclass(frozen=True)
class TrialResult:
    """What came out.

    Attributes:
        spec: what was run.
        solved: the end effector stood on its goal at the end.
        declared: arrival was declared.
        declared_m: distance of the end effector from the goal's column then, metres; NaN when never.
        stuck: it ended neither on its goal nor with a declared arrival.
        hits_stationary: things that do not move that were touched.
        hits_moving: moving things that were touched.
        free_end_touches: motions that touched something although their end pose was free when they were sent.
        first_path: waypoints of the first path, the start counted as in the publication; 0 for none.
        sent: columns sent, in order.
        planning_ms: processor time of each planning step, which a busy machine does not lengthen.
        path_m: way of the end effector, metres.
        time_s: simulated time, s.
        least_m: least distance to anything, metres.
        reason: why it ended.
    """

    spec: TrialSpec
    solved: bool
    declared: bool
    declared_m: float
    stuck: bool
    hits_stationary: Tuple[str, ...]
    hits_moving: Tuple[str, ...]
    free_end_touches: int
    first_path: int
    sent: Tuple[Tuple[int, int], ...]
    planning_ms: Tuple[float, ...]
    path_m: float
    time_s: float
    least_m: float
    reason: str

    @property
    def clean(self) -> bool:
        """Solved without touching anything."""
        return self.solved and not self.hits_stationary and not self.hits_moving

    @property
    def declared_elsewhere(self) -> bool:
        """Arrival was declared while the robot was not there."""
        return self.declared and not self.solved

    def to_json(self) -> Dict[str, Any]:
        """Plain values."""
        return dataclasses.asdict(self)

    @staticmethod
    def from_json(values: Mapping[str, Any]) -> TrialResult:
        """From plain values, as read back.

        Raises:
            TypeError: fields are missing or unknown.
        """
        plain = dict(values)
        plain["spec"] = TrialSpec(**plain.get("spec", {}))
        for name in ("hits_stationary", "hits_moving", "planning_ms"):
            plain[name] = tuple(plain.get(name, ()))
        plain["sent"] = tuple((int(x), int(y)) for x, y in plain.get("sent", ()))
        return TrialResult(**plain)


def run_trial(spec: TrialSpec) -> TrialResult:
    """Run one trial; a pure function of its spec but for the planning times it reports."""
    params = PlannerParams(particles=spec.particles, original_margin_cells=spec.margin_cells)
    return Trial(spec, _world(spec), make_planner(spec.planner, params)).run()


def raster_share(seed: int) -> float:
    """Share of its raster the manipulator has done when the trial of a seed begins, 0 to 1."""
    return float(np.random.default_rng([seed, 1]).uniform())


def _world(spec: TrialSpec) -> KinematicWorld:
    scene = load_scene(spec.scene)
    arm = arm_of(raster_share(spec.seed)) if scene.working_arms else None
    return KinematicWorld(scene, GridSpec(), arm)


@dataclass
class Trial:
    """One trial under way."""

    spec: TrialSpec
    world: KinematicWorld
    planner: FleetPlanner
    stationary: List[str] = field(default_factory=list)
    moving: List[str] = field(default_factory=list)
    sent: List[Tuple[int, int]] = field(default_factory=list)
    planning_ms: List[float] = field(default_factory=list)
    free_end_touches: int = 0
    first_path: int = 0
    declared_m: float = math.nan

    def __post_init__(self) -> None:
        """One robot, one goal."""
        self._rng = np.random.default_rng([self.spec.seed, 2])
        self._robot: KinematicRobot = next(iter(self.world.robots.values()))
        self._goal = next(iter(self.world.goals.values()))
        self._limits = CommanderParams()
        self._moved_s = 0.0

    def run(self) -> TrialResult:
        """Drive until it has arrived, was declared arrived, is stuck, or time is over."""
        reason = self._with_replanning() if self.spec.replanning else self._planned_once()
        declared = not math.isnan(self.declared_m)
        solved = self._arrived()
        touches = self._robot.touches
        return TrialResult(
            self.spec,
            solved,
            declared,
            self.declared_m,
            not solved and not declared,
            tuple(sorted(set(self.stationary) | touches.stationary)),
            tuple(sorted(set(self.moving) | touches.moving)),
            self.free_end_touches,
            self.first_path,
            tuple(self.sent),
            tuple(self.planning_ms),
            self._robot.path_m,
            self.world.now_s,
            touches.least_m,
            reason,
        )

    def _planned_once(self) -> str:
        _, plan = self._plan()
        own = plan.robots.get(self._robot.name)
        if own is None or len(own.path) < 2:
            return f"no path: {plan.reason}"
        for waypoint in own.path[1:]:
            if not self._drive(waypoint):
                return f"blocked on the way to {waypoint.column} by {', '.join(self.stationary) or 'something'}"
        if own.path[-1].column == self._goal.column:
            self._declare()
            return "followed its first path to the end"
        return "the first path ended elsewhere"

    def _with_replanning(self) -> str:
        while self.world.now_s < LIMIT_S:
            if self.spec.planner != "original" and self._arrived():
                self._declare()
                return "arrived"
            request, plan = self._plan()
            own = plan.robots.get(self._robot.name)
            step = None if own is None else own.step
            if step is not None and self.spec.planner != "original" and not check_step(request, plan).safe:
                step = None
            if step is None:
                self._advance(WAIT_S)
            there = step is not None and self._drive(step)
            if there:
                self._moved_s = self.world.now_s
            if self.spec.planner == "original" and self._planned_arrival(own, there):
                self._declare()
                return "the planned waypoint was the goal"
            if self.world.now_s - self._moved_s > PATIENCE_S:
                return f"no motion for {PATIENCE_S:.0f} s: {plan.reason or 'no step was sent'}"
        return f"not there after {LIMIT_S:.0f} s"

    def _planned_arrival(self, own: Optional[RobotPlan], there: bool) -> bool:
        """As published: arrived when the drive succeeded, or none was needed, and what was planned is the goal."""
        if own is None or not own.path or not (there or len(own.path) == 1):
            return False
        return own.path[min(1, len(own.path) - 1)].column == self._goal.column

    def _plan(self) -> Tuple[PlanRequest, FleetPlan]:
        self._advance(THINK_S)
        request = self.world.request({self._robot.name: self._goal.name})
        began_s = time.thread_time()
        plan = self.planner.plan(request, self._rng)
        self.planning_ms.append(1000.0 * (time.thread_time() - began_s))
        own = plan.robots.get(self._robot.name)
        if len(self.planning_ms) == 1 and own is not None:
            self.first_path = len(own.path)
        return request, plan

    def _drive(self, waypoint: Waypoint) -> bool:
        """Drive to a waypoint; false when something blocked the way."""
        robot, world = self._robot, self.world
        target = world.pose_of(waypoint)
        free_end = world.free_at(target, besides=robot.name)
        before = robot.touches
        robot.touches = replace(before, stationary=frozenset(), moving=frozenset())
        self.sent.append(waypoint.column)
        robot.send(target)
        while robot.outcome is Outcome.ACTIVE and world.now_s < LIMIT_S:
            self._advance(TICK_S)
        touched = robot.touches
        self.stationary += sorted(touched.stationary)
        self.moving += sorted(touched.moving)
        self.free_end_touches += free_end and bool(touched.stationary or touched.moving)
        return robot.outcome is Outcome.SUCCEEDED

    def _advance(self, span_s: float) -> None:
        for _ in range(max(1, round(span_s / TICK_S))):
            self.world.advance()
            if self.world.arm is not None and self.world.check_due:
                self.world.arm_enabled = self._arm_may_work(self.world.arm_enabled)

    def _arm_may_work(self, enabled: bool) -> bool:
        """The manipulator's supervision: with the Commander's distances, or the published one."""
        assert self.world.arm is not None
        tip = self.world.arm.tip()
        pose = self._robot.pose
        if self.spec.planner == "original":
            size = self.world.spec.resolution
            apart = np.array([pose.x - tip[0], pose.y - tip[1], EE_HEIGHT_M - tip[2]]) / size
            return bool(np.linalg.norm(apart) >= ORIGINAL_PAUSE_CELLS)
        near = flat_distance(self._robot.solids, tip[0], tip[1])
        if near < self._limits.pause_distance_m:
            return False
        return enabled or near > self._limits.resume_distance_m

    def _arrived(self) -> bool:
        pose = self._robot.pose
        x, y = self.world.spec.column_centre(self._goal.column)
        near = math.hypot(pose.x - x, pose.y - y) <= self._limits.arrival_tolerance_m
        return near or self.world.spec.column_of((pose.x, pose.y)) == self._goal.column

    def _declare(self) -> None:
        x, y = self.world.spec.column_centre(self._goal.column)
        self.declared_m = math.hypot(self._robot.pose.x - x, self._robot.pose.y - y)
