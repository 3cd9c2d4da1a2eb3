"""Runs a controller in a simulated room at 10 Hz: observation in, command out, everything noted."""

from __future__ import annotations

import time
from typing import Callable, Dict, List, Optional, Protocol

from yarm.experiments.explore.record import (
    IN_WORLD,
    BehaviourClock,
    CoverageRow,
    ExploreRecord,
    PathRow,
    TouchRow,
)
from yarm.experiments.explore.true_mapper import TrueMapper
from yarm.exploration.deadline import faded
from yarm.exploration.model import LOOP_S, Command, Controller, Event, LowView, Observation, Step
from yarm.exploration.params import ExploreParams
from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap
from yarm.navigation.overlay import Overlay
from yarm.sim.kinematic.world import KinematicWorld
from yarm.sim.room_robot import RoomRobot
from yarm.sim.scenes.arena import Arena

DRAW_PASSES = 2
"""Every n-th scan is drawn."""
MAP_PASSES = 10
"""Every n-th pass brings a new map, besides those in which something low was found."""
LOW_PASSES = 2
"""Every n-th depth image is looked at for low obstacles."""
COVERAGE_PASSES = 10
TIMED_PASSES = 7
"""Every n-th pass has its processor time measured, which may cost as much as the pass; no multiple of the others."""
STAND_S = 2.0
"""The robot is watched so long after the time limit."""

Watch = Callable[[float, GridMap], float]
"""Given the time and the map, once a second; gives back the share of the arena that is mapped."""


class Senses(Protocol):
    """What the robot is given to see; how it maps and localises."""

    @property
    def world_from_map(self) -> Pose2:
        """Pose of the map's frame in the world."""

    @property
    def map(self) -> Optional[GridMap]:
        """The newest, with what is too low for the scan; None before the first."""

    def observe(self, now_s: float, passes: int) -> Observation:
        """Measure, and bring the map up to date."""


class TrueSenses:
    """The newest of everything; the map is drawn from the true pose, in the world's frame."""

    world_from_map = IN_WORLD

    def __init__(self, world: RoomRobot) -> None:
        """Nothing measured."""
        self._world = world
        self._mapper = TrueMapper(world.arena.lower, world.arena.upper)
        self._overlay = Overlay()
        self._bare = self._mapper.map()
        self._counts = (-1, -1)
        self._versions = 0
        self.map: Optional[GridMap] = self._bare

    def observe(self, now_s: float, passes: int) -> Observation:
        """Measure, draw, and bring the map up to date."""
        world = self._world
        scan, bumps = world.scan(), world.take_bumps()
        low = world.low_view() if passes % LOW_PASSES == 0 else None
        if passes % DRAW_PASSES == 0:
            self._mapper.add(scan, world.truth)
        if passes % MAP_PASSES == 0:
            self._bare = self._mapper.map()
        if low is not None:
            self._overlay.see(world.truth, low, scan)
        for bump in bumps:
            if bump.pressed:
                self._overlay.bump(world.truth, bump.bumper, self._bare)
        counts = (passes // MAP_PASSES, self._overlay.count)
        if counts != self._counts:
            self._counts = counts
            self._versions += 1
            self.map = self._overlay.over(self._bare)
        odometry = world.odometry()
        return Observation(
            now_s=now_s,
            odometry=odometry,
            map_from_odom=world.truth.compose(odometry.pose.inverse()),
            scan=scan,
            bumps=bumps,
            map=self.map,
            map_count=self._versions,
            low=None if low is None else LowView(now_s, low),
        )


class _Notes:
    """What is written down on the way."""

    def __init__(self, watch: Optional[Watch]) -> None:
        self._watch = watch
        self._clock = BehaviourClock()
        self.path: List[PathRow] = []
        self.coverage: List[CoverageRow] = []
        self.events: List[Event] = []
        self.step_ms: List[float] = []

    @property
    def behaviours(self) -> Dict[str, float]:
        """Seconds in each."""
        return self._clock.seconds

    def timed(self, controller: Controller, observation: Observation, passes: int) -> Step:
        """The controller's step; of every so many it is noted what they took."""
        if passes % TIMED_PASSES:
            return controller.step(observation)
        began = time.thread_time()
        step = controller.step(observation)
        self.step_ms.append(1e3 * (time.thread_time() - began))
        return step

    def note(self, observation: Observation, step: Step, told: Command, world: RoomRobot, senses: Senses) -> None:
        """One pass."""
        now_s = observation.now_s
        self.events.extend(step.events)
        self._clock.spend(step.behaviour, LOOP_S)
        true, believed = world.truth, senses.world_from_map.compose(observation.pose or IN_WORLD)
        self.path.append(
            PathRow(
                now_s,
                *(true.x, true.y, true.yaw_rad, believed.x, believed.y, believed.yaw_rad),
                told.v_mps,
                told.w_radps,
                world.true_speed_mps,
            )
        )
        if len(self.path) % COVERAGE_PASSES == 1 and senses.map is not None:
            self.cover(now_s, senses.map)

    def cover(self, now_s: float, grid_map: GridMap) -> None:
        """One more row of coverage."""
        share = float("nan") if self._watch is None else self._watch(now_s, grid_map)
        self.coverage.append(CoverageRow(now_s, grid_map.known_m2, share))


def run_kinematic(
    arena: Arena, controller: Controller, seed: int, params: ExploreParams, watch: Optional[Watch] = None
) -> ExploreRecord:
    """One exploration, until the controller is done or the time is over; the robot brakes in time for that.

    Args:
        arena: the room.
        controller: decides.
        seed: of the sensors' and the odometry's noise.
        params: what the controller was made with.
        watch: asked once a second what the map is worth.
    """
    world = KinematicWorld(arena, seed)
    return explore(world, TrueSenses(world), controller, seed, params, watch)


def explore(
    world: RoomRobot,
    senses: Senses,
    controller: Controller,
    seed: int,
    params: ExploreParams,
    watch: Optional[Watch] = None,
    mode: str = "kinematic",
) -> ExploreRecord:
    """One exploration in a world, as ``run_kinematic``.

    Args:
        world: moves the robot.
        senses: what the controller is given to see.
        controller: decides.
        seed: of the run, for the record.
        params: what the controller was made with.
        watch: asked once a second what the map is worth.
        mode: name of the world, for the record.
    """
    notes = _Notes(watch)
    passes, end_s, last = 0, params.time_limit_s, Step()
    while passes * LOOP_S < end_s + STAND_S:
        now_s = round(passes * LOOP_S, 6)
        over = now_s >= end_s - 1e-9
        observation = senses.observe(now_s, passes)
        step = last if over else notes.timed(controller, observation, passes)
        told = Command() if step.done else faded(step.command, now_s, params.time_limit_s)
        notes.note(observation, Step(behaviour="stand") if over else step, told, world, senses)
        last = step
        if step.done and not over:
            end_s = now_s
            if senses.map is not None:
                notes.cover(now_s, senses.map)
        world.step(told.v_mps, told.w_radps, LOOP_S)
        passes += 1
    return ExploreRecord(
        arena=world.arena.name,
        controller=params.controller,
        seed=seed,
        mode=mode,
        time_limit_s=params.time_limit_s,
        max_speed=params.max_speed,
        near_speed=params.near_speed,
        near_distance=params.near_distance,
        end_s=end_s,
        done=last.done,
        reason=last.reason,
        path=tuple(notes.path),
        coverage=tuple(notes.coverage),
        touches=tuple(TouchRow.of(touch) for touch in world.touches),
        events=tuple(notes.events),
        behaviours=notes.behaviours,
        step_ms=tuple(notes.step_ms),
        map=senses.map,
        world_from_map=senses.world_from_map,
    )
