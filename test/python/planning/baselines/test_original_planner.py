"""The published planner behaves as published, flaws and all; its waypoint counts are in experiments/study."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, List, Optional

import numpy as np
import pytest

from python.planning.samples import block, request, robot, walls
from yarm.geometry import GridSpec
from yarm.planning.baselines.original_planner import Node, OriginalPlanner, Route
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import Goal, PlanRequest, PlanStatus, Waypoint
from yarm.planning.roadmap.cost_queue import CostQueue
from yarm.planning.scenes.instances import make_instance

SPEC = GridSpec((30, 24, 4), (0.0, 0.0, 0.0), (3.0, 2.4, 0.4))
OPEN = np.zeros(SPEC.shape, dtype=bool)


def ask_in_the_open(column: tuple, occupied: np.ndarray = OPEN) -> PlanRequest:
    return request(SPEC, occupied, [robot("a", column, block(1, 1))], [Goal("t", "Target", (26, 12))])


def test_it_walks_to_the_goal_in_the_open() -> None:
    planner, rng, column = OriginalPlanner(PlannerParams(particles=60)), np.random.default_rng(1), (2, 12)
    for _ in range(60):
        plan = planner.plan(ask_in_the_open(column), rng)
        step = plan.robots["a"].step
        if step is None:
            break
        column = step.column
    assert column == (26, 12)


def goes_into_a_new_wall(seed: int) -> bool:
    planner, rng = OriginalPlanner(PlannerParams(particles=100)), np.random.default_rng(seed)
    first = planner.plan(ask_in_the_open((2, 12)), rng).robots["a"]
    assert first.step is not None
    x = first.step.column[0]
    again = planner.plan(ask_in_the_open((2, 12), walls(SPEC, [(x, x + 1, 0, 24)])), rng).robots["a"]
    return again.step is not None and again.step.column[0] >= x


def test_a_remembered_path_is_followed_into_what_stands_there_now() -> None:
    assert any(goes_into_a_new_wall(seed) for seed in range(10))


def goes(occupied: np.ndarray, margin: int = 2) -> bool:
    """Whether some path through the middle has a next step that it takes for free."""
    ask = ask_in_the_open((2, 12), occupied)
    params = PlannerParams(particles=720, original_margin_cells=margin)
    plan = OriginalPlanner(params).plan(ask, np.random.default_rng(0))
    return plan.robots["a"].step is not None


@pytest.mark.parametrize("margin", [0, 1, 2])
def test_it_keeps_its_margin_from_what_stands_there(margin: int) -> None:
    assert goes(walls(SPEC, [(3, 30, 0, 12 - margin), (3, 30, 13 + margin, 24)]), margin)
    if margin:
        assert not goes(walls(SPEC, [(3, 30, 0, 13 - margin), (3, 30, 12 + margin, 24)]), margin)


def route(*columns: tuple, touching: int = 0) -> Route:
    """A path along columns, of which the way to number ``touching`` was found to touch; 0 for none."""
    path = tuple(Waypoint(column, 0.0) for column in columns)
    return Route(path, tuple(bool(touching) and i == touching for i in range(len(path))))


class Replans:
    """A planner that remembers one path in the open and is asked with a robot somewhere; what it finds is handed in."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, remembered: Route) -> None:
        self.planner = OriginalPlanner(PlannerParams(particles=20))
        self.planner._kept["a"] = ("t", remembered)
        self._patch = monkeypatch

    def step(self, at: tuple, found: Optional[Route]) -> Optional[tuple]:
        """Column of the next step; None when it stays."""

        def one_round(_: object, searches: List[Any]) -> None:
            for search in searches:
                search.queue = CostQueue()
                search.finished = found is not None
                ways = () if found is None else zip(found.path, found.touches)
                search.best = tuple(Node(w.column, 0.0, touches) for w, touches in ways)

        self._patch.setattr("yarm.planning.baselines.original_planner._Map.round", one_round)
        plan = self.planner.plan(ask_in_the_open(at), np.random.default_rng(0)).robots["a"]
        return None if plan.step is None else plan.step.column


GOAL = (26, 12)


def test_it_stays_when_the_shorter_new_path_touches_and_goes_on_remembering(monkeypatch: pytest.MonkeyPatch) -> None:
    replans = Replans(monkeypatch, route((2, 12), (2, 22), GOAL))
    assert replans.step((2, 12), route((2, 12), (10, 12), GOAL, touching=1)) is None
    assert replans.step((2, 12), None) == (2, 22)


def test_it_takes_the_new_path_when_the_shorter_remembered_one_touches(monkeypatch: pytest.MonkeyPatch) -> None:
    replans = Replans(monkeypatch, route((2, 12), (10, 12), GOAL, touching=1))
    assert replans.step((2, 12), route((2, 12), (2, 22), GOAL)) == (2, 22)


def test_it_follows_a_remembered_path_waypoint_by_waypoint_without_checking(monkeypatch: pytest.MonkeyPatch) -> None:
    """Standing on a waypoint it drops it, and takes the next one although the way there was found to touch."""
    replans = Replans(monkeypatch, route((2, 12), (8, 12), (16, 12), GOAL, touching=2))
    assert replans.step((8, 12), None) == (16, 12)
    assert replans.step((12, 12), None) is None
    again = Replans(monkeypatch, route((2, 12), (8, 12), (16, 12), GOAL))
    assert [again.step(at, None) for at in ((2, 12), (8, 12), (16, 12))] == [(8, 12), (16, 12), GOAL]


def test_it_drops_near_waypoints_of_remembered_paths_only(monkeypatch: pytest.MonkeyPatch) -> None:
    found = route((2, 12), (4, 12), (16, 12), GOAL)
    replans = Replans(monkeypatch, route((2, 12), (2, 22), GOAL))
    assert replans.step((2, 12), found) == (4, 12)
    assert replans.step((2, 12), None) == (16, 12)


def test_it_leaves_a_place_inside_the_margin() -> None:
    assert goes(walls(SPEC, [(0, 3, 14, 15)]))


def test_it_keeps_no_margin_between_robots() -> None:
    others = [robot("b", (14, 13), block(1, 1)), robot("c", (14, 11), block(1, 1))]
    ask = ask_in_the_open((14, 12))
    goals = (*ask.goals.values(), Goal("u", "Target", (2, 2)), Goal("v", "Target", (2, 22)))
    crowd = request(SPEC, OPEN, [*ask.robots, *others], goals)
    plan = OriginalPlanner(PlannerParams(particles=720)).plan(crowd, np.random.default_rng(0))
    assert plan.robots["a"].step is not None


def test_it_stays_when_every_next_step_touches() -> None:
    closed = walls(SPEC, [(1, 4, 11, 12), (1, 4, 13, 14), (1, 2, 12, 13), (3, 4, 12, 13)])
    plan = OriginalPlanner().plan(ask_in_the_open((2, 12), closed), np.random.default_rng(0))
    assert plan.status is PlanStatus.TIMEOUT
    assert plan.robots["a"].step is None
    assert "stays" in plan.reason


def test_same_seed_same_plan_and_faults_have_reasons() -> None:
    ask = make_instance("crossing", 1).scene
    request_ = ask.request(ask.starts(), dict(ask.assignments))
    paths: List[object] = []
    for _ in range(2):
        plan = OriginalPlanner().plan(request_, np.random.default_rng(5))
        paths.append({name: entry.path for name, entry in plan.robots.items()})
    assert paths[0] == paths[1]
    broken = replace(request_, occupied=np.zeros((2, 2, 2), dtype=bool))
    assert OriginalPlanner().plan(broken, np.random.default_rng(0)).status is PlanStatus.INVALID_START
