"""The loop: what a controller is shown, what is noted, when it ends."""

from __future__ import annotations

from typing import List

import numpy as np

from yarm.experiments.explore.runner import STAND_S, TIMED_PASSES, run_kinematic
from yarm.exploration.model import LOOP_S, Command, Event, Observation, Step
from yarm.exploration.params import ExploreParams
from yarm.geometry import Pose2
from yarm.sim.scenes.arena import Arena, Block

WALL = Block("wall", "wall", Pose2(2.025, 0.0), (0.05, 4.0, 0.6))
BRICK = Block("brick", "low", Pose2(1.0, 0.0), (0.2, 0.4, 0.1))
ARENA = Arena("t", "custom", 0, (-3.0, -3.0), (3.0, 3.0), (WALL, BRICK), Pose2(0.0, 0.0))
PARAMS = ExploreParams(controller="straight", time_limit_s=6.0)


class Straight:
    """Drives ahead, and is done after a number of passes."""

    def __init__(self, done_at: int = 10**6) -> None:
        self.seen: List[Observation] = []
        self._done_at = done_at

    def step(self, observation: Observation) -> Step:
        self.seen.append(observation)
        events = tuple(Event(observation.now_s, "bump") for _ in observation.bumps)
        return Step(Command(0.2, 0.0), "ahead", events, len(self.seen) > self._done_at, "that is all")


def test_a_controller_sees_everything_and_the_run_ends_at_the_limit() -> None:
    controller = Straight()
    record = run_kinematic(ARENA, controller, 1, PARAMS)
    assert [o.now_s for o in controller.seen[:3]] == [0.0, 0.1, 0.2] and len(controller.seen) == 60
    first, last = controller.seen[0], controller.seen[-1]
    assert first.map is not None and first.map_count == 1 and first.scan is not None
    assert first.low is not None and len(first.low.points) > 0 and controller.seen[1].low is None
    assert last.pose is not None and abs(last.pose.x - record.path[59].true_x) < 1e-9, "the map is drawn from the truth"
    assert not record.done and record.end_s == 6.0
    assert record.path[-1].speed == 0.0 and record.path[-1].v == 0.0 and record.path[-1].t_s > 7.5
    assert [event.kind for event in record.events] == ["bump"] and record.touches[0].low
    assert record.behaviours["ahead"] == sum([0.1] * 60) and len(record.step_ms) == len(range(0, 60, TIMED_PASSES))


def test_low_things_are_in_the_map_before_and_after_a_touch() -> None:
    controller = Straight()
    record = run_kinematic(ARENA, controller, 1, PARAMS)
    seen = controller.seen[10].map
    assert seen is not None and seen.occupied[seen.cell_of(0.925, 0.0)] and record.map is not None
    flat = Block("flat", "low", Pose2(0.6, 0.0), (0.2, 0.4, 0.05))
    record = run_kinematic(
        Arena("t", "custom", 0, (-3.0, -3.0), (3.0, 3.0), (WALL, flat), Pose2(0, 0)), Straight(), 1, PARAMS
    )
    assert record.map is not None
    near = record.map.occupied[slice(*np.array([-1, 2]) + record.map.cell_of(0.5, 0.0)[0])]
    assert near[:, record.map.cell_of(0.5, 0.0)[1] - 1 : record.map.cell_of(0.5, 0.0)[1] + 2].any(), "it was bumped"


def test_a_controller_that_is_done_ends_the_run() -> None:
    record = run_kinematic(ARENA, Straight(done_at=20), 1, PARAMS)
    assert record.done and record.end_s == 2.0 and record.reason == "that is all"
    after = [row for row in record.path if row.t_s > 2.05]
    assert len(after) == round(STAND_S / LOOP_S) - 1 and all(row.speed == 0.0 for row in after), "watched standing"


def test_the_share_is_asked_for_once_a_second() -> None:
    asked: List[float] = []

    def watch(now_s: float, grid: object) -> float:
        asked.append(now_s)
        return 0.5

    record = run_kinematic(ARENA, Straight(), 1, PARAMS, watch)
    assert asked[:3] == [0.0, 1.0, 2.0] and record.coverage[2].share == 0.5 and record.coverage[2].known_m2 > 0.0


def test_the_same_seed_gives_the_same_run() -> None:
    first, second = (run_kinematic(ARENA, Straight(), 5, PARAMS) for _ in range(2))
    assert first.path == second.path and first.events == second.events
    assert run_kinematic(ARENA, Straight(), 6, PARAMS).path != first.path
