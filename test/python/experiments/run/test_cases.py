"""Layouts of the missions can be done: robots are assigned, have paths and get there (no physics, no HC10)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from yarm.experiments.run.cases import expected_goals, layout_of
from yarm.experiments.study.kinematic import KinematicWorld
from yarm.geometry import GridSpec
from yarm.planning.fleet.yarm_planner import YarmPlanner
from yarm.planning.tasks.task_queue import TaskQueue
from yarm.planning.verification.checker import check_step
from yarm.sim.scenes.scene import Scene, load_scene

SEEDS = range(20)
"""Cheap checks over 200 seeds are in sim/scenes; these plan."""
MOST_STEPS = 60


def with_everything_there(scene: Scene) -> Scene:
    """The scene with what its events spawn already there."""
    spawned = tuple(event.spawn for event in scene.events if event.spawn is not None)
    return replace(scene, things=(*scene.things, *spawned))


@pytest.mark.parametrize("name", ["1m1ma", "2m1ma", "3m"])
def test_the_goals_of_every_layout_are_reached_step_by_step(name: str) -> None:
    """Assigned, planned, checked and moved as the Commander does it, without physics and without the HC10."""
    for seed in SEEDS:
        world = KinematicWorld(with_everything_there(load_scene(name, seed)), GridSpec())
        queue, planner, rng = TaskQueue(), YarmPlanner(), np.random.default_rng(seed)
        reason = ""
        for _ in range(MOST_STEPS):
            request = world.request({})
            queue.update(request.robots, list(world.goals.values()))
            queue.process(request)
            assert not queue.unreachable, (name, seed, queue.unreachable)
            for robot in request.robots:
                goal = queue.assignments.get(robot.name)
                if goal is not None and robot.column == world.goals[goal].column:
                    queue.pop(robot.name)
                    del world.goals[goal]
            if not world.goals:
                break
            request = world.request(dict(queue.assignments))
            plan = planner.plan(request, rng)
            reason = plan.reason
            assert check_step(request, plan).safe, (name, seed)
            for robot_plan in plan.robots.values():
                if robot_plan.step is not None:
                    world.robots[robot_plan.robot].base.pose = world.pose_of(robot_plan.step)
        assert not world.goals, (name, seed, reason)


def test_a_layout_is_written_in_metres_and_degrees() -> None:
    scene = load_scene("2m1ma", 7)
    layout = layout_of(scene)
    assert set(layout) == {
        "ankurbot_1",
        "ankurbot_2",
        *expected_goals(scene),
        "first debris slips",
        "second debris slips",
    }
    assert layout["ankurbot_1"]["x"] == scene.robots[0].x
    assert abs(layout["ankurbot_1"]["heading_deg"] - 180.0) <= 30.0
    assert layout["first debris slips"] == {"dx": scene.events[2].dx_m, "dy": scene.events[2].dy_m}
