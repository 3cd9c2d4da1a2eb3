"""Random cells: the same for the same kind and seed, always clear at the start, with the trouble they are named for."""

from __future__ import annotations

import math
from typing import Dict, List

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from yarm.geometry import GridSpec
from yarm.geometry.kinds import GOAL_KINDS, ObjectKind
from yarm.sim.checks.cell_check import unreachable_goals
from yarm.sim.engine.world import SimWorld
from yarm.sim.scenes.random_cell import (
    APART_M,
    CLOSE_M,
    KINDS,
    MOST_DEBRIS,
    MOST_OBSTACLES,
    MOST_ROBOTS,
    PERSON,
    SLIP_M,
    TROUBLES,
    random_cell,
)
from yarm.sim.scenes.scene import Scene
from yarm.sim.scenes.specs import ThingSpec
from yarm.sim.scenes.variation import BORDER_CELLS, CLEAR_CELLS, start_cells

SPEC = GridSpec()
kinds = st.sampled_from(KINDS)
seeds = st.integers(0, 2**31 - 1)
few = settings(max_examples=12, deadline=None)


def everything(scene: Scene) -> Dict[str, ThingSpec]:
    """Things by name, those of events too."""
    spawned = [event.spawn for event in scene.events if event.spawn is not None]
    return {thing.name: thing for thing in (*scene.things, *spawned)}


def goals(scene: Scene) -> List[ThingSpec]:
    return [thing for thing in everything(scene).values() if thing.kind in GOAL_KINDS]


@few
@given(kinds, seeds)
def test_equal_seeds_give_equal_cells_and_others_do_not(kind: str, seed: int) -> None:
    cell = random_cell(kind, seed)
    assert cell == random_cell(kind, seed)
    assert cell != random_cell(kind, (seed + 1) % 2**31)
    assert (cell.name, cell.seed) == (f"random_{kind}", seed)


@few
@given(kinds, seeds)
def test_robots_start_inside_and_clear_of_each_other(kind: str, seed: int) -> None:
    scene = random_cell(kind, seed)
    assert 1 <= len(scene.robots) <= MOST_ROBOTS
    shapes = [start_cells(robot, SPEC)[:, :2] for robot in scene.robots]
    for i, shape in enumerate(shapes):
        assert np.all(shape >= BORDER_CELLS)
        assert np.all(shape < np.subtract(SPEC.shape[:2], BORDER_CELLS))
        for other in shapes[:i]:
            gap = np.abs(shape[:, None] - other[None]).max(axis=2).min()
            assert gap > CLEAR_CELLS


@few
@given(kinds, seeds)
def test_what_a_cell_has_is_within_the_limits(kind: str, seed: int) -> None:
    scene = random_cell(kind, seed)
    found = everything(scene)
    assert len(found) == len(scene.things) + sum(event.spawn is not None for event in scene.events)
    assert goals(scene)
    registered = [t for t in found.values() if t.kind == ObjectKind.OBSTACLE and t.name.startswith("obstacle_")]
    assert len(registered) <= MOST_OBSTACLES
    trouble = 2 if "close" in (kind, *(TROUBLES if kind == "mixed" else ())) else 0
    trouble += 1 if kind in ("slips", "mixed") else 0
    debris = [t for t in goals(scene) if t.kind == ObjectKind.DEBRIS]
    assert len(debris) <= MOST_DEBRIS + trouble
    for event in scene.events:
        assert all(name in found or name.startswith("ankurbot_") for name in event.names())


@few
@given(st.sampled_from([kind for kind in KINDS if kind not in ("close", "mixed")]), seeds)
def test_goals_are_apart(kind: str, seed: int) -> None:
    places = [(t.x, t.y) for t in goals(random_cell(kind, seed))]
    for i, place in enumerate(places):
        assert all(math.dist(place, other) >= APART_M for other in places[:i])


@few
@given(seeds)
def test_two_pieces_are_close_together(seed: int) -> None:
    places = [(t.x, t.y) for t in goals(random_cell("close", seed))]
    gaps = sorted(math.dist(a, b) for i, a in enumerate(places) for b in places[:i])
    assert CLOSE_M[0] - 1e-9 <= gaps[0] <= CLOSE_M[1] + 1e-9
    assert all(gap >= APART_M for gap in gaps[1:])


def test_each_kind_has_its_trouble() -> None:
    for seed in range(10):
        slips = random_cell("slips", seed)
        (push,) = [event for event in slips.events if event.push]
        assert SLIP_M[0] <= math.hypot(push.dx_m, push.dy_m) <= SLIP_M[1]
        assert everything(slips)[push.push].kind == ObjectKind.DEBRIS
        assert any(not t.registered for t in random_cell("unregistered", seed).things)
        off, on = (event for event in random_cell("camera", seed).events if event.camera)
        assert (off.camera, off.enabled, on.enabled) == (on.camera, False, True)
        assert on.when.after_s > off.when.after_s
        crowded = random_cell("crowded", seed)
        stands = {(robot.x, robot.y) for robot in crowded.robots}
        assert len(crowded.robots) >= 2
        assert sum((t.x, t.y) in stands for t in goals(crowded)) == 2


def test_a_person_walks_a_way_that_was_clear_and_is_gone() -> None:
    for seed in range(10):
        come, walk, gone = (event for event in random_cell("walker", seed).events if PERSON in repr(event))
        assert come.spawn is not None
        assert (walk.move, gone.delete) == (PERSON, PERSON)
        assert not come.spawn.registered
        assert 0.0 in (walk.dx_m, walk.dy_m)
        walked_s = abs(walk.dx_m + walk.dy_m) / walk.speed_mps
        assert gone.when.after_s > walk.when.after_s + walked_s


def test_mixed_cells_have_more_than_one_trouble() -> None:
    told = set()
    for seed in range(20):
        cell = random_cell("mixed", seed)
        marks = {
            "slips": any(event.push for event in cell.events),
            "camera": any(event.camera for event in cell.events),
            "walker": PERSON in everything(cell),
            "unreachable": "target_inside" in everything(cell),
            "unregistered": "box_1" in everything(cell),
            "crowded": "target_under_1" in everything(cell),
        }
        told |= {name for name, there in marks.items() if there}
        assert sum(marks.values()) >= 1
    assert told == set(TROUBLES) - {"close"}


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_overlaps_or_touches_at_the_start(kind: str) -> None:
    """The simulator refuses scenes whose bodies overlap; what falls later has its place too."""
    for seed in range(2):
        with SimWorld(random_cell(kind, seed)) as world:
            world.run(0.5)
            assert world.failures() == []


def test_cell_check_finds_the_target_nobody_can_reach_and_ways_to_others() -> None:
    reasons = unreachable_goals(random_cell("unreachable", 5))
    assert "target_inside: no robot can get to column" in reasons["target_inside"]
    assert "debris_1" not in reasons
    assert unreachable_goals(random_cell("plain", 0)) == {}


def test_a_kind_that_is_none_is_refused() -> None:
    with pytest.raises(ValueError, match="expected one of plain, slips"):
        random_cell("calm", 1)
