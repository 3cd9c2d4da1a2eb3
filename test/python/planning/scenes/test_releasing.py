"""Without a barrier: any interleaving and any delay of released moves is free of contact, and nobody waits for ever."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import List, Tuple

import numpy as np
import pytest

from yarm.planning.model.types import FleetPlan, PlannedMove, PlanRequest, PlanStatus, Waypoint
from yarm.planning.registry import make_planner
from yarm.planning.scenes.coordination import make_coordinated
from yarm.planning.scenes.instances import make_instance
from yarm.planning.scenes.releasing import Release, ReleasedRun, release_to_end, waits, way_cells
from yarm.planning.scenes.scene import PlanScene
from yarm.planning.scenes.scene_file import load_scene
from yarm.planning.verification.checker import check_release, chessboard_clearance, robotless_map, sweep_of

SCENES = Path(__file__).parents[4] / "scenes/planning"


def scene_of(family: str, seed: int) -> PlanScene:
    if family in ("crossing", "table_and_stand", "open"):
        return make_instance(family, seed, robots=3).scene
    return make_coordinated(family, seed).scene


def clearance(release: Release) -> int:
    """Least number of free cells between the sweep of what moves and anything else, whoever is where in it."""
    going = {**release.under_way, **release.released}
    sweeps = [sweep_of(release.request, robot, *going.get(robot.name, (None,))) for robot in release.request.robots]
    return chessboard_clearance(robotless_map(release.request), sweeps)


def carry_out(scene: PlanScene, seed: int, replans: bool) -> Tuple[List[Release], ReleasedRun]:
    delays = np.random.default_rng([seed, 1])

    def duration(move: PlannedMove) -> float:
        return float(way_cells(move) * np.exp(delays.normal(0.0, 1.5)) + 0.01)

    seen: List[Release] = []
    run = release_to_end(
        scene,
        make_planner("yarm"),
        np.random.default_rng(seed),
        duration=duration,
        replans=replans,
        observe=seen.append,
    )
    return seen, run


@pytest.mark.parametrize("replans", [False, True])
@pytest.mark.parametrize("family", ["crossing", "table_and_stand", "corridor_bay", "ring", "pocket", "tee", "doors"])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_any_delay_of_released_moves_is_safe_and_ends(family: str, seed: int, replans: bool) -> None:
    scene = scene_of(family, seed)
    seen, run = carry_out(scene, seed, replans)
    assert run.refusals == []
    assert run.status is PlanStatus.SOLVED, run.reason
    assert min(clearance(release) for release in seen) >= 1


def test_without_its_edges_the_same_plan_is_refused_by_the_checker() -> None:
    """The property above can fail: an order that nobody waits for sends robots into each other."""

    class Unordered:
        def __init__(self) -> None:
            self._planner = make_planner("yarm")

        def reset(self) -> None:
            self._planner.reset()

        def plan(self, request: PlanRequest, rng: np.random.Generator) -> FleetPlan:
            plan = self._planner.plan(request, rng)
            return replace(plan, moves=tuple(replace(move, after=(), behind=()) for move in plan.moves))

    scene = load_scene(SCENES / "head_on.yaml")
    run = release_to_end(scene, Unordered(), np.random.default_rng(0), replans=False)
    assert any("would touch" in reason or "would come within" in reason for reason in run.refusals)


def test_a_release_is_held_against_moves_under_way_and_robots_that_stand() -> None:
    scene = load_scene(SCENES / "head_on.yaml")
    request = scene.request()
    right, left = Waypoint((13, 3), 0.0), Waypoint((12, 3), 0.0)
    assert check_release(request, {"cart_1": (Waypoint((5, 3), 0.0),)}, {}).safe
    assert not check_release(request, {"cart_1": (Waypoint((22, 3), 0.0),)}, {}).safe
    met = check_release(request, {"cart_1": (right,)}, {"cart_2": (left,)})
    assert not met.safe
    assert "cart_1 and cart_2" in met.reason
    assert check_release(request, {}, {"cart_1": (right,), "cart_2": (left,)}).safe, (
        "only what is released now is asked"
    )
    twice = check_release(request, {"cart_1": (right,)}, {"cart_1": (left,)})
    assert twice.reason == "not in the request, or under way already: cart_1"


def test_who_waits_for_whom_is_told_by_robot_and_number() -> None:
    run = release_to_end(load_scene(SCENES / "head_on.yaml"), make_planner("yarm"), np.random.default_rng(0))
    assert run.first is not None
    told = [(move.robot, after) for move, after in waits(run.first)]
    assert told[0] == ("cart_1", ())
    assert told[4] == ("cart_2", ("cart_1.1", "cart_1.2", "cart_1.3"))
