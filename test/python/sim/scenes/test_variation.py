"""Layouts from seeds: the same for the same seed, different for others, always within the scene's ranges and clear."""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from functools import lru_cache
from typing import Any, Dict, List, Set, Tuple

import numpy as np
import pytest

from yarm.geometry import GridSpec, Pose2
from yarm.robots.ankurbot import ARM_REACH_M, ankurbot_mask
from yarm.sim.checks.cell_check import check_scene
from yarm.sim.scenes.scene import Scene, SceneError, load_scene, scene_from, shipped_scenes, with_layout
from yarm.sim.scenes.specs import RobotSpec, ThingSpec
from yarm.sim.scenes.variation import CLEAR_CELLS, INSIDE

SPEC = GridSpec()
SEEDS = range(200)
VARIED = [name for name in shipped_scenes() if load_scene(name).vary is not None]


@lru_cache(maxsize=None)
def nominal(name: str) -> Scene:
    return load_scene(name)


@lru_cache(maxsize=None)
def layout(name: str, seed: int) -> Scene:
    """A scene laid out by a seed, once for all tests."""
    return with_layout(nominal(name), seed)


def goals_of(scene: Scene) -> Dict[str, ThingSpec]:
    spawned = [event.spawn for event in scene.events if event.spawn is not None]
    return {thing.name: thing for thing in (*scene.things, *spawned)}


def columns_of(robot: RobotSpec) -> Set[Tuple[int, int]]:
    ee = Pose2(robot.x, robot.y, robot.heading_rad).compose(Pose2(ARM_REACH_M, 0.0))
    column = SPEC.column_of((ee.x, ee.y))
    x, y = SPEC.column_centre(column)
    return {(int(c[0]), int(c[1])) for c in ankurbot_mask(SPEC, ee.yaw_rad, (ee.x - x, ee.y - y)).at(column)}


def least_gap(one: Set[Tuple[int, int]], other: Set[Tuple[int, int]]) -> int:
    """Columns from one to the other, diagonally too; 0 when they share one."""
    a, b = np.array(sorted(one)), np.array(sorted(other))
    return int(np.abs(a[:, None] - b[None]).max(axis=2).min())


def test_the_missions_vary_and_the_scenes_of_the_study_do_not() -> None:
    assert VARIED == ["1m1ma", "1m1ma_bin", "2m1ma", "2m1ma_bin", "2m2ma", "3m", "3m6_bin"]


@pytest.mark.parametrize("name", shipped_scenes())
def test_the_same_seed_gives_the_same_layout_and_the_scenes_own_the_files(name: str) -> None:
    scene = load_scene(name)
    assert load_scene(name, scene.seed) == scene == load_scene(name, -1)
    assert load_scene(name, 77) == load_scene(name, 77)
    assert (load_scene(name, 77) == scene) is (name not in VARIED)
    layouts = {repr(load_scene(name, seed)) for seed in range(20)}
    assert len(layouts) == (20 if name in VARIED else 1)


@pytest.mark.parametrize("name", VARIED)
def test_every_layout_is_within_the_ranges_and_nothing_else_changes(name: str) -> None:
    scene = load_scene(name)
    vary = scene.vary
    assert vary is not None
    far: List[float] = []
    for seed in SEEDS:
        laid = layout(name, seed)
        assert replace(laid, robots=scene.robots, things=scene.things, events=scene.events) == scene
        for robot, file in zip(laid.robots, scene.robots):
            far.append(math.hypot(robot.x - file.x, robot.y - file.y))
            assert far[-1] <= vary.start_m
            assert abs(robot.heading_rad - file.heading_rad) <= vary.start_rad
        goals = goals_of(laid)
        for thing in goals.values():
            assert vary.places[thing.name].holds((thing.x, thing.y)), (seed, thing)
        for event, file_event in zip(laid.events, scene.events):
            assert (event.name, event.when) == (file_event.name, file_event.when)
            if event.push:
                end = (goals[event.push].x + event.dx_m, goals[event.push].y + event.dy_m)
                assert vary.places[event.push].holds(end), (seed, event)
                assert vary.slip_m[0] - 1e-9 <= math.hypot(event.dx_m, event.dy_m) <= vary.slip_m[1] + 1e-9
    assert max(far) > 0.8 * vary.start_m


@pytest.mark.parametrize("name", VARIED)
def test_every_robot_starts_inside_the_volume_and_clear_of_the_others(name: str) -> None:
    for seed in SEEDS:
        shapes = [columns_of(robot) for robot in layout(name, seed).robots]
        for i, shape in enumerate(shapes):
            cells = np.array(sorted(shape))
            assert np.all(cells >= 2) and np.all(cells < np.subtract(SPEC.shape[:2], 2)), (name, seed)
            assert all(least_gap(shape, other) > CLEAR_CELLS for other in shapes[:i]), (name, seed)


def test_points_within_a_robot_are_in_its_cells() -> None:
    rng = np.random.default_rng(5)
    for _ in range(200):
        x, y, heading_rad = rng.uniform((-2.5, -2.5, -math.pi), (2.5, 2.5, math.pi))
        robot = replace(nominal("1m1ma").robots[0], x=x, y=y, heading_rad=heading_rad)
        columns = columns_of(robot)
        pose = Pose2(x, y, heading_rad)
        for ahead, left in INSIDE:
            point = pose.compose(Pose2(ahead, left))
            assert SPEC.column_of((point.x, point.y)) in columns


@pytest.mark.parametrize("name", VARIED)
def test_cell_check_passes_layouts(name: str) -> None:
    for seed in (10, 11, 12):
        findings = check_scene(layout(name, seed))
        assert [finding.text for finding in findings if not finding.holds] == [], seed


SMALL: Dict[str, Any] = {
    "name": "small",
    "robots": [{"name": "ankurbot_1", "type": "ankurbot", "x": 1.9, "y": 1.9, "heading_deg": 180}],
    "targets": [{"name": "target_1", "x": -2.0, "y": -1.0}],
    "vary": {"start_m": 0.3, "turn_deg": 10, "places": [{"name": "target_1", "x": [-2.1, -1.9], "y": [-1.1, -0.9]}]},
}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"start_m": 3}, "vary.start_m = 3: expected a number within 0 to 1 m"),
        ({"slip_m": [0.2, 0.1]}, "vary.slip_m = [0.2, 0.1]: expected the lesser number first"),
        ({"places": [{"name": "target_9", "x": [0, 1], "y": [0, 1]}]}, "target_9"),
        ({"wobble": 1}, "vary.wobble = 1: expected no such key"),
    ],
)
def test_faults_of_a_vary_block_are_named(changes: Dict[str, Any], words: str) -> None:
    scene = copy.deepcopy(SMALL)
    scene["vary"].update(changes)
    with pytest.raises(SceneError, match="expected") as raised:
        scene_from(scene, "bad.yaml")
    assert words in str(raised.value)


def test_ranges_that_leave_no_room_are_refused() -> None:
    scene = copy.deepcopy(SMALL)
    scene["robots"].append({"name": "ankurbot_2", "type": "ankurbot", "x": 1.9, "y": 1.5, "heading_deg": 180})
    scene["vary"]["start_m"] = 0.1
    with pytest.raises(SceneError, match="a start for ankurbot_2 is not found"):
        with_layout(scene_from(scene, "tight.yaml"), 9)
