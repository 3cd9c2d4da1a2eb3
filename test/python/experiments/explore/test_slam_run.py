"""An exploration with the real SLAM and the explorer's session: what is seen, when maps come, when it ends."""

from __future__ import annotations

import math
from typing import List

import pytest

from support.rooms import block, room
from yarm.experiments.explore.runner import explore
from yarm.experiments.explore.slam_run import MAP_S, SlamExplorer
from yarm.exploration.driver import Driver, Drives
from yarm.exploration.model import Command, Controller, Observation, Step
from yarm.exploration.params import ExploreParams
from yarm.geometry import Pose2
from yarm.resources import resource
from yarm.sim.kinematic.world import KinematicWorld
from yarm.yaml_fields import load_yaml

ARENA = room(block("brick", 1.3, 0.0, (0.2, 0.4, 0.12), "low"), start=Pose2(-0.5, 0.3, 0.2))
PARAMS = ExploreParams(time_limit_s=12.0)


class Turning:
    """Turns on the spot, and is done after a number of passes."""

    def __init__(self, done_at: int = 10**6, v_mps: float = 0.0) -> None:
        self.seen: List[Observation] = []
        self._done_at, self._v_mps = done_at, v_mps

    def step(self, observation: Observation) -> Step:
        self.seen.append(observation)
        done = len(self.seen) > self._done_at
        return Step(Command(self._v_mps, 0.5), "turn", done=done, reason="that is all" if done else "")


class Leg:
    """Drives to a pose of the world, by the driver of the explorers, and is done."""

    def __init__(self, goal: Pose2) -> None:
        self._goal, self._driver = ARENA.start.inverse().compose(goal), Driver(ExploreParams())

    def step(self, observation: Observation) -> Step:
        grid = self._driver.sense(observation)
        driven = self._driver.step(observation)
        if grid is None or observation.pose is None or driven.state is Drives.ARRIVED:
            return Step(done=grid is not None, reason="there")
        if driven.state in (Drives.IDLE, Drives.FAILED):
            self._driver.go(self._driver.field(observation.pose, 0.01), grid.cell_of(self._goal.x, self._goal.y), None)
        return Step(driven.command, "leg")


def explored(controller: Controller, seed: int = 3, **limits: float):
    world = KinematicWorld(ARENA, seed)
    explorer = SlamExplorer(world, PARAMS, lambda: controller, **limits)
    return explore(world, explorer, explorer, seed, PARAMS), explorer


def test_maps_come_as_often_as_the_nodes_and_hold_what_is_low() -> None:
    assert load_yaml(resource("config", "exploration", "slam_gmapping.yaml"))["map_update_interval"] == MAP_S
    turning = Turning()
    record, explorer = explored(turning)
    known = {seen.now_s: seen.map.known_m2 for seen in turning.seen if seen.map is not None}
    grown = {b for a, b in zip(sorted(known), sorted(known)[1:]) if known[b] > known[a] + 0.1}
    assert grown == {MAP_S, 2 * MAP_S}, "what is low adds less"
    assert record.map is explorer.map and record.map is not None
    inside = record.world_from_map.inverse().compose(Pose2(1.2, 0.0))
    row, column = record.map.cell_of(inside.x, inside.y)
    assert record.map.occupied[row - 1 : row + 2, column - 1 : column + 2].any(), "the brick"
    assert record.map.known_m2 > 8.0 and explorer.counts.keyframes > 10 and explorer.slam_cpu_s > 0.0


def test_what_it_believes_is_slams_and_near_the_truth() -> None:
    record, _ = explored(Turning())
    assert record.world_from_map == ARENA.start
    errors = [abs(row.x - row.true_x) + abs(row.y - row.true_y) for row in record.path]
    assert 0.0 < max(errors) < 0.08


def test_it_stands_at_the_limit_and_is_not_done_by_itself_then() -> None:
    record, _ = explored(Turning(v_mps=0.05))
    assert record.end_s == 12.0 and not record.done and record.path[-1].t_s > 13.5
    assert all(row.speed < 0.005 for row in record.path if row.t_s > 12.0)
    assert [event.kind for event in record.events].count("state") == 2, "begun, and over"


def test_a_controller_that_is_done_ends_the_run_with_its_reason() -> None:
    record, _ = explored(Turning(done_at=80, v_mps=0.1))
    assert record.done and record.reason == "that is all" and 8.0 <= record.end_s < 8.5
    record, _ = explored(Turning(done_at=5))
    assert record.done and record.reason.startswith("enclosed")


def test_the_way_back_is_driven_round_what_is_low_and_the_run_ends_at_the_start() -> None:
    """It drives off past the brick; the straight way back leads over it."""
    world = KinematicWorld(ARENA, 3)
    params = ExploreParams(time_limit_s=120.0, return_to_start=True)
    explorer = SlamExplorer(world, params, lambda: Leg(Pose2(1.75, -0.1)))
    record = explore(world, explorer, explorer, 3, params)
    assert record.done and record.reason == "back at the start; there", record.reason
    farthest = max(row.true_x for row in record.path)
    end = record.path[-1]
    assert farthest > ARENA.start.x + 1.5
    assert math.hypot(end.true_x - ARENA.start.x, end.true_y - ARENA.start.y) < 0.2
    assert all(touch.speed <= 0.1 for touch in record.touches), record.touches


@pytest.mark.parametrize("map_s", [1.0, 5.0])
def test_the_same_seed_gives_the_same_run(map_s: float) -> None:
    first, second = (explored(Turning(v_mps=0.05), map_s=map_s)[0] for _ in range(2))
    assert first.path == second.path and first.events == second.events
    assert first.map is not None and second.map is not None and (first.map.cells == second.map.cells).all()
    assert explored(Turning(v_mps=0.05), seed=4, map_s=map_s)[0].path != first.path
