"""The planner with the complete search behind it: what it solves, what it proves, and that nothing goes round."""

from __future__ import annotations

from dataclasses import replace
from typing import List

import numpy as np
import pytest

from yarm.planning.fleet.complete_search import CompleteSearch
from yarm.planning.fleet.joint_native import Outcome, library_path
from yarm.planning.fleet.joint_search import JointSearch
from yarm.planning.fleet.yarm_planner import YarmPlanner
from yarm.planning.model.types import FleetPlan, PlanRequest, PlanStatus, StepCheck
from yarm.planning.scenes.coordination import make_coordinated, slot_scene
from yarm.planning.scenes.scene import PlanScene, Stand
from yarm.planning.scenes.stepping import SteppedRun, step_to_end
from yarm.planning.verification.bruteforce import touches

pytestmark = pytest.mark.skipif(library_path() is None, reason="the package is not built")
SWAP = slot_scene(["......"], 1, ((0, 0), (3, 0), (5, 0)), ((3, 0), (0, 0), (5, 0)))
"""Cart 2 must pass cart 1 in a lane without a bay, wherever that one goes; cart 3 has nothing to do with it."""


def stepped(scene: PlanScene, seed: int = 0, steps: int = 200) -> SteppedRun:
    found: List[str] = []

    def look(request: PlanRequest, plan: FleetPlan, verdict: StepCheck) -> None:
        found.extend([] if verdict.safe else [verdict.reason])
        found.extend(touches(request, plan))

    run = step_to_end(scene, YarmPlanner(), np.random.default_rng(seed), observe=look, most_steps=steps)
    assert not found, f"seed {seed}: {found}"
    return run


@pytest.mark.parametrize("family", ["corridor_bay", "ring", "parking", "pocket", "doors"])
def test_families_are_stepped_to_the_end(family: str) -> None:
    run = stepped(make_coordinated(family, 5).scene, 5)
    assert run.status is PlanStatus.SOLVED, f"{family} 5: {run.reason}"
    assert run.refused == 0


def test_what_the_attempts_before_do_not_solve_is_solved(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(JointSearch, "run", lambda self, rng: None)
    scene = make_coordinated("parking", 2).scene
    assert stepped(scene).status is PlanStatus.SOLVED
    monkeypatch.setattr("yarm.planning.fleet.never_stuck.make_complete_search", lambda fleet, robots: None)
    assert stepped(scene, steps=12).status is PlanStatus.TIMEOUT


def test_the_proof_names_who_and_what_it_needs_and_nobody_else() -> None:
    plan = YarmPlanner().plan(SWAP.request(), np.random.default_rng(0))
    assert plan.status is PlanStatus.INFEASIBLE
    assert "brings cart_2 to target_2 past cart_1:" in plan.reason
    assert "cart_3" not in plan.reason
    assert "without any one of these" in plan.reason
    apart = replace(SWAP, assignments={"cart_1": "target_1", "cart_3": "target_3"})
    assert YarmPlanner().plan(apart.request(), np.random.default_rng(0)).status is PlanStatus.SOLVED


def test_a_thing_that_makes_it_impossible_is_named() -> None:
    """One of two boxes closes the bay: with it away the robots could exchange places."""
    scene = slot_scene(["......", "##.###"], 1, ((0, 0), (5, 0)), ((5, 0), (0, 0)))
    count = len(scene.boxes)
    closed = replace(scene, boxes=(*scene.boxes, (4, 5, 2, 3, 0, 1)))
    plan = YarmPlanner().plan(closed.request(), np.random.default_rng(0))
    assert plan.status is PlanStatus.INFEASIBLE
    assert f"boxes[{count}]" in plan.reason
    assert YarmPlanner().plan(scene.request(), np.random.default_rng(0)).status is PlanStatus.SOLVED


def test_a_proof_is_not_made_twice_and_ends_with_its_problem(monkeypatch: pytest.MonkeyPatch) -> None:
    planner, rng = YarmPlanner(), np.random.default_rng(0)
    crossed = {"cart_1": Stand((2, 0), 0.0), "cart_2": Stand((4, 0), 0.0), "cart_3": Stand((10, 0), 0.0)}
    runs: List[int] = []
    real = CompleteSearch.outcome_within
    monkeypatch.setattr(CompleteSearch, "outcome_within", lambda self, work: runs.append(work) or real(self, work))
    ask = SWAP.request(crossed)
    first = planner.plan(ask, rng)
    made = len(runs)
    assert first.status is PlanStatus.INFEASIBLE and made > 0
    assert planner.plan(ask, rng).reason == first.reason and len(runs) == made
    solvable = replace(ask, assignments={"cart_1": "target_1"})
    assert planner.plan(solvable, rng).status is PlanStatus.SOLVED


def test_an_undecided_search_goes_on_while_nothing_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    """With little work a call, the fleet that stays where it is gets its plan after some calls."""
    monkeypatch.setattr("yarm.planning.fleet.never_stuck.WORK", 3_000)
    monkeypatch.setattr("yarm.planning.fleet.yarm_planner.YarmPlanner._moves_of_some", lambda self, *rest: [])
    monkeypatch.setattr(JointSearch, "run", lambda self, rng: None)
    ask, planner = make_coordinated("parking", 3).scene.request(), YarmPlanner()
    statuses = []
    while not statuses or statuses[-1] is PlanStatus.TIMEOUT:
        plan = planner.plan(ask, np.random.default_rng(0))
        statuses.append(plan.status)
        if statuses[-1] is PlanStatus.TIMEOUT:
            assert "places of the fleet looked at" in plan.reason
        assert len(statuses) < 200
    assert statuses[-1] is PlanStatus.SOLVED and len(statuses) >= 1


def test_a_fleet_that_goes_round_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody finds a plan for all, and those for some lead to and fro: the third time in one place everybody stays."""
    monkeypatch.setattr(JointSearch, "run", lambda self, rng: None)
    monkeypatch.setattr("yarm.planning.fleet.never_stuck.make_complete_search", lambda fleet, robots: None)
    planner, rng = YarmPlanner(), np.random.default_rng(0)
    left = {"cart_1": Stand((0, 0), 0.0), "cart_2": Stand((6, 0), 0.0), "cart_3": Stand((10, 0), 0.0)}
    right = {**left, "cart_1": Stand((2, 0), 0.0)}
    stays = []
    looks: List[bool] = []
    real = YarmPlanner._is_livelock
    monkeypatch.setattr(YarmPlanner, "_is_livelock", lambda self, fleet: looks.append(real(self, fleet)) or looks[-1])
    for stands in (left, right) * 3:
        planner.plan(SWAP.request(stands), rng)
        stays.append(looks[-1])
    assert stays == [False, False, False, False, True, True]


def test_outcomes_mirror_the_header() -> None:
    assert [outcome.name for outcome in Outcome] == ["OPEN", "FOUND", "IMPOSSIBLE", "FULL"]
