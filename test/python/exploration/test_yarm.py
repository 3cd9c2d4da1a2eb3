"""Whole explorations of small arenas by the explorers that plan, and how they end."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import pytest

from python.exploration.explorer_samples import observe, run_on
from python.navigation.map_samples import drawn
from yarm.experiments.explore.record import ExploreRecord
from yarm.experiments.explore.runner import run_kinematic
from yarm.exploration.nearest import NearestController
from yarm.exploration.params import ExploreParams
from yarm.exploration.registry import CONTROLLERS, make_controller
from yarm.exploration.yarm import YarmController
from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap
from yarm.robots.turtlebot import RADIUS_M
from yarm.sim.scenes.arena import Arena, Block

WALLS = (
    Block("south", "wall", Pose2(0.0, -1.525), (3.1, 0.05, 0.6)),
    Block("north", "wall", Pose2(0.0, 1.525), (3.1, 0.05, 0.6)),
    Block("west", "wall", Pose2(-1.525, 0.0), (0.05, 3.0, 0.6)),
    Block("east", "wall", Pose2(1.525, 0.0), (0.05, 3.0, 0.6)),
)
INNER = Block("inner", "wall", Pose2(0.3, 0.75), (0.05, 1.5, 0.6))
BRICK = Block("brick", "low", Pose2(0.9, -0.6), (0.2, 0.1, 0.1))


def arena(start: Pose2, *blocks: Block) -> Arena:
    return Arena("small", "custom", 0, (-1.5, -1.5), (1.5, 1.5), (*WALLS, *blocks), start)


def explore(name: str, room: Arena, limit_s: float = 200.0, seed: int = 3) -> ExploreRecord:
    params = ExploreParams(controller=name, time_limit_s=limit_s)
    return run_kinematic(room, make_controller(params, seed), seed, params)


def share_free(record: ExploreRecord, room: Arena) -> float:
    """Of the places where the robot fits, those known to be free."""
    assert record.map is not None
    points = np.stack(np.meshgrid(np.arange(-1.4, 1.41, 0.1), np.arange(-1.4, 1.41, 0.1)), axis=-1).reshape(-1, 2)
    clear = np.ones(len(points), bool)
    for block in room.blocks:
        away = np.maximum(np.abs(points - (block.pose.x, block.pose.y)) - np.array(block.size[:2]) / 2, 0.0)
        clear &= np.hypot(away[:, 0], away[:, 1]) > RADIUS_M
    cells = record.map.cells_of(points[clear])
    return float(record.map.free[cells[:, 0], cells[:, 1]].mean())


@lru_cache(maxsize=None)
def explored() -> ExploreRecord:
    return explore("yarm", arena(Pose2(-0.8, -0.8, 1.0), INNER, BRICK))


def test_it_maps_everything_says_so_and_stands() -> None:
    record = explored()
    assert record.done and "nothing is left" in record.reason and record.end_s < 150.0
    assert share_free(record, arena(Pose2(-0.8, -0.8), INNER, BRICK)) == 1.0
    assert record.path[-1].v == 0.0 and record.path[-1].w == 0.0


def test_the_low_brick_is_mapped_and_not_touched() -> None:
    record = explored()
    assert not record.touches and record.map is not None
    around = [record.map.cell_of(0.9 + dx, -0.6 + dy) for dx in (-0.1, 0.0, 0.1) for dy in (-0.05, 0.05)]
    assert any(record.map.occupied[cell] for cell in around)


def test_speeds_keep_the_limits() -> None:
    told = np.array([(row.v, row.w) for row in explored().path])
    assert told[:, 0].max() <= 0.3 + 1e-9 and np.abs(told[:, 1]).max() <= 1.8 + 1e-9


def test_it_never_turns_for_as_long_as_the_reports_full_turn() -> None:
    longest = turning = 0
    for row in explored().path:
        turning = turning + 1 if row.v == 0.0 and row.w != 0.0 else 0
        longest = max(longest, turning)
    assert 5 < longest < 100, "passes of 0.1 s; the report's takes 270 of every 1010"


def test_the_same_run_gives_the_same_events() -> None:
    again = explore("yarm", arena(Pose2(-0.8, -0.8, 1.0), INNER, BRICK))
    assert again.events == explored().events


@pytest.mark.parametrize("yaw_rad", [math.pi, math.pi / 2, 0.0])
def test_a_start_against_a_wall_is_left(yaw_rad: float) -> None:
    room = arena(Pose2(-1.5 + RADIUS_M + 0.002, 0.0, yaw_rad))
    record = explore("yarm", room, 100.0)
    assert share_free(record, room) > 0.97


def test_nearest_maps_most_of_it() -> None:
    room = arena(Pose2(-0.8, -0.8, 1.0), INNER)
    record = explore("nearest", room)
    assert share_free(record, room) > 0.9


def test_what_is_left_is_listed_with_the_reason() -> None:
    gap = drawn("??#???\n#.#.#?\n#....#\n######", scale=12)
    controller = YarmController(ExploreParams(), 0)
    steps, _ = run_on(controller, gap, Pose2(1.2, 0.9), 120.0)
    assert steps[-1].done
    left = [event for step in steps for event in step.events if event.kind == "left"]
    assert left and all(dict(event.details)["reason"] for event in left)
    assert steps[-1].reason.startswith("nothing is left to map but")
    assert controller.step(observe(200.0, Pose2(1.2, 0.9), gap)).done


def test_an_enclosed_start_ends_it_with_that_reason() -> None:
    box = drawn("#####\n#####\n##.##\n#####\n#####", scale=5)
    steps, _ = run_on(YarmController(ExploreParams(), 0), box, Pose2(0.625, 0.625), 20.0)
    assert steps[-1].done and "enclosed" in steps[-1].reason
    steps, _ = run_on(NearestController(ExploreParams(controller="nearest"), 0), box, Pose2(0.625, 0.625), 20.0)
    assert steps[-1].done and "enclosed" in steps[-1].reason


def test_without_a_map_or_a_pose_it_waits() -> None:
    controller = YarmController(ExploreParams(), 0)
    step = controller.step(observe(0.0, Pose2(0.0, 0.0), None))
    assert step.behaviour == "wait" and "map" in step.reason and step.command.v_mps == 0.0 and not step.done


@pytest.mark.parametrize("name", sorted({"yarm", "nearest", "explore_lite"} & set(CONTROLLERS)))
def test_a_map_that_is_resized_moved_or_redrawn_does_no_harm(name: str) -> None:
    controller = make_controller(ExploreParams(controller=name), 1)
    rooms = [
        drawn("??????\n?....?\n?....?\n??????", scale=10),
        GridMap(np.kron(np.array([[-1, 0, 0, 0, -1]], np.int8), np.ones((60, 12), np.int8)), 0.04, Pose2(-0.5, -0.5)),
        GridMap(np.full((7, 5), -1, np.int8), 0.1, Pose2(1.0, 1.0)),
        drawn("##????\n#....?\n#....?\n######", scale=20),
    ]
    for i in range(40):
        step = controller.step(observe(0.1 * i, Pose2(1.2, 1.0, 0.1 * i), rooms[i // 10], i // 10, jumped=i % 10 == 0))
        assert math.isfinite(step.command.v_mps) and abs(step.command.v_mps) <= 0.3


@pytest.mark.parametrize("name", ["explore_lite", "nearest", "yarm"])
def test_a_picture_gets_every_frontier_while_it_goes_on(name: str) -> None:
    controller = make_controller(ExploreParams(controller=name), 1)
    room = drawn("##????\n#....?\n#....?\n######", scale=20)
    steps = [controller.step(observe(0.1 * i, Pose2(1.2, 1.0), room, 1)) for i in range(5)]
    frontiers = steps[-1].intent.frontiers
    assert frontiers and all(math.isfinite(f.score) for f in frontiers)
    assert any(not f.refused and f.x > 1.5 for f in frontiers)
