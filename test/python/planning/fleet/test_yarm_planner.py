"""The promises of the planner: safe steps, progress, completeness, and reasons a person can act on."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np
import pytest

from python.planning.samples import arm, block, request, robot, walls
from yarm.geometry import GridSpec, Mask, wrap_angle
from yarm.params import ParamError
from yarm.planning.fleet.yarm_planner import YarmPlanner
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import FleetPlan, Goal, PlanRequest, PlanStatus, Robot, Waypoint
from yarm.planning.roadmap import graph
from yarm.planning.roadmap.roadmap import even_roadmap
from yarm.planning.scenes.instances import FAMILIES, make_instance
from yarm.planning.scenes.stepping import step_to_end
from yarm.planning.verification.checker import check_step

SPEC = GridSpec((30, 24, 4), (0.0, 0.0, 0.0), (3.0, 2.4, 0.4))
OPEN = np.zeros(SPEC.shape, dtype=bool)


def plan_once(ask: PlanRequest, planner: Optional[YarmPlanner] = None, seed: int = 0) -> FleetPlan:
    return (planner or YarmPlanner()).plan(ask, np.random.default_rng(seed))


def moved(one: Robot, step: Optional[Waypoint]) -> Robot:
    if step is None:
        return one
    angle = wrap_angle(step.yaw_rad - one.yaw_rad)
    mask = one.mask if abs(angle) < 1e-6 else one.mask.turned(angle, SPEC)
    return Robot(one.name, step.column, step.yaw_rad, Mask(mask.cells, step.yaw_rad))


def run(
    robots: Sequence[Robot],
    goals: Sequence[Goal],
    occupied: np.ndarray = OPEN,
    assignments: Optional[Mapping[str, str]] = None,
    steps: int = 40,
) -> Tuple[List[Robot], int]:
    """Step until nobody has anything to do; every step is held against the independent checker."""
    planner, rng, robots = YarmPlanner(), np.random.default_rng(0), list(robots)
    for count in range(steps):
        ask = request(SPEC, occupied, robots, goals, assignments)
        plan = planner.plan(ask, rng)
        verdict = check_step(ask, plan)
        assert verdict.safe, verdict.reason
        wanted = {name: entry.step for name, entry in plan.robots.items() if entry.step is not None}
        if not wanted:
            return robots, count
        robots = [moved(one, wanted.get(one.name)) for one in robots]
    raise AssertionError(f"still moving after {steps} steps")


def columns(robots: Sequence[Robot]) -> Dict[str, Tuple[int, int]]:
    return {one.name: one.column for one in robots}


def targets(**places: Tuple[int, int]) -> List[Goal]:
    return [Goal(name, "Target", place) for name, place in places.items()]


@pytest.mark.parametrize("family", sorted(FAMILIES))
def test_seeded_instances_are_solved_without_a_refused_step(family: str) -> None:
    planner = YarmPlanner()
    for seed in range(900, 903):
        instance = make_instance(family, seed)
        result = step_to_end(instance.scene, planner, np.random.default_rng(seed), clearance=False)
        assert result.status is PlanStatus.SOLVED, f"seed {seed}: {result.reason}"
        assert result.refused == 0, f"seed {seed}: {result.refusals}"


def test_a_free_way_is_one_straight_step() -> None:
    robots, steps = run([robot("a", (2, 3), block(2, 2))], targets(t=(25, 19)))
    assert columns(robots) == {"a": (25, 19)}
    assert steps == 1


def test_a_straight_plan_makes_no_graph_until_it_is_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    made: List[int] = []
    real = graph.Delaunay
    monkeypatch.setattr(graph, "Delaunay", lambda points: made.append(len(points)) or real(points))
    even_roadmap.cache_clear()
    ask = request(SPEC, OPEN, [robot("a", (2, 3), block(2, 2))], targets(t=(25, 19)))
    plan = plan_once(ask, YarmPlanner(PlannerParams(particles=40)))
    assert plan.status is PlanStatus.SOLVED
    assert made == []
    assert len(plan.graph.particles) == 40
    assert plan.graph.edges.max() == 39
    assert made == [40]


def test_robots_far_apart_move_at_the_same_time() -> None:
    robots = [robot("a", (2, 2), block(2, 2)), robot("b", (2, 20), block(2, 2))]
    _, steps = run(robots, targets(ta=(26, 2), tb=(26, 20)))
    assert steps == 1


def test_crossing_robots_both_arrive() -> None:
    robots = [robot("a", (2, 12), block(2, 2)), robot("b", (14, 2), block(2, 2))]
    after, steps = run(robots, targets(ta=(26, 12), tb=(14, 20)))
    assert columns(after) == {"a": (26, 12), "b": (14, 20)}
    assert steps <= 4


def test_head_on_in_a_corridor_one_backs_into_the_bay() -> None:
    occupied = walls(SPEC, [(5, 25, 0, 10), (5, 25, 13, 24)])
    occupied[13:18, 13:17] = False
    robots = [robot("a", (2, 11), block(1, 1)), robot("b", (27, 11), block(1, 1))]
    after, _ = run(robots, targets(ta=(27, 11), tb=(2, 11)), occupied)
    assert columns(after) == {"a": (27, 11), "b": (2, 11)}


def test_a_robot_without_a_goal_steps_aside() -> None:
    occupied = walls(SPEC, [(10, 20, 0, 10), (10, 20, 13, 24)])
    robots = [robot("a", (2, 11), block(1, 1)), robot("idle", (15, 11), block(1, 1))]
    ask = request(SPEC, occupied, robots, targets(ta=(27, 11)), {"a": "ta"})
    plan = plan_once(ask)
    assert plan.robots["idle"].goal == ""
    assert plan.robots["idle"].step is not None
    after, _ = run(robots, targets(ta=(27, 11)), occupied, {"a": "ta"})
    assert columns(after)["a"] == (27, 11)


def test_a_robot_at_its_goal_lets_another_pass_and_comes_back() -> None:
    occupied = walls(SPEC, [(10, 20, 0, 10), (10, 20, 13, 24)])
    robots = [robot("a", (2, 11), block(1, 1)), robot("b", (15, 11), block(1, 1))]
    after, _ = run(robots, targets(ta=(27, 11), tb=(15, 11)), occupied)
    assert columns(after) == {"a": (27, 11), "b": (15, 11)}


def test_those_who_can_go_do_not_wait_for_one_who_cannot() -> None:
    robots = [robot("a", (2, 2), block(2, 2)), robot("b", (2, 12), block(2, 2)), robot("c", (2, 20), block(2, 2))]
    plan = plan_once(request(SPEC, OPEN, robots, targets(ta=(26, 12), tb=(26, 13), tc=(26, 20))))
    assert plan.status is PlanStatus.INFEASIBLE
    assert {entry.status for entry in plan.robots.values()} == {PlanStatus.SOLVED, PlanStatus.TIMEOUT}
    assert "no order of moves through any cell brings a to ta and b to tb: they cannot stand there" in plan.reason
    assert plan.robots["c"].step is not None
    assert sum(entry.step is not None for entry in plan.robots.values()) == 2


def test_a_heading_that_is_wanted_is_reached() -> None:
    goal = Goal("t", "Home", (15, 12), yaw_rad=0.4)
    after, _ = run([robot("a", (15, 6), arm(4))], [goal])
    assert abs(wrap_angle(after[0].yaw_rad - 0.4)) < math.radians(1.0)
    assert after[0].column == (15, 12)


def test_at_the_goal_nothing_is_sent() -> None:
    plan = plan_once(request(SPEC, OPEN, [robot("a", (5, 5), block(1, 1))], targets(t=(5, 5))))
    assert plan.status is PlanStatus.SOLVED
    assert plan.robots["a"].step is None


def test_a_wall_across_is_infeasible_and_the_reason_names_it() -> None:
    occupied = walls(SPEC, [(14, 16, 0, 24)])
    objects = {"wall": np.argwhere(occupied)}
    ask = request(SPEC, occupied, [robot("a", (5, 5), block(1, 1))], targets(t=(25, 5)), objects=objects)
    plan = plan_once(ask)
    assert plan.status is PlanStatus.INFEASIBLE
    assert "stopped by wall" in plan.reason
    assert plan.robots["a"].step is None


def test_a_goal_that_is_occupied_or_out_of_reach_is_an_invalid_goal() -> None:
    occupied = walls(SPEC, [(20, 24, 4, 8)])
    objects = {"crate": np.argwhere(occupied)}
    one = [robot("a", (5, 5), block(1, 1))]
    assert "crate" in plan_once(request(SPEC, occupied, one, targets(t=(21, 5)), objects=objects)).reason
    for column in ((30, 3), (-1, 3)):
        plan = plan_once(request(SPEC, OPEN, one, targets(t=column)))
        assert plan.status is PlanStatus.INVALID_GOAL
        assert "outside" in plan.reason
    unknown = request(SPEC, OPEN, one, targets(t=(5, 6)), {"a": "nowhere"})
    assert plan_once(unknown).status is PlanStatus.INVALID_GOAL


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (robot("a", (40, 3), block(1, 1)), "outside the grid"),
        (robot("a", (4, 3), block(1, 1), math.nan), "not finite"),
        (Robot("a", (4, 3), 0.0, Mask(np.zeros((0, 3), dtype=np.int64))), "no cells"),
        (Robot("a", (4, 3), 0.0, Mask(np.array([(0, 0, 0), (60, 0, 0)]))), "larger than the grid"),
    ],
)
def test_a_robot_that_cannot_be_planned_for_is_an_invalid_start_and_the_others_go_on(bad: Robot, words: str) -> None:
    good = robot("b", (5, 15), block(1, 1))
    ask = request(SPEC, OPEN, [good], targets(tb=(20, 15)), {"a": "ta", "b": "tb"})
    ask = replace(ask, robots=(bad, good), goals={**ask.goals, "ta": Goal("ta", "Target", (9, 9))})
    plan = plan_once(ask)
    assert plan.robots["a"].status is PlanStatus.INVALID_START
    assert words in plan.robots["a"].reason
    assert plan.robots["b"].step is not None


def test_a_robot_inside_something_is_an_invalid_start() -> None:
    occupied = walls(SPEC, [(4, 7, 4, 7)])
    one = [robot("a", (5, 5), block(1, 1))]
    plan = plan_once(request(SPEC, occupied, one, targets(t=(20, 5)), objects={"crate": np.argwhere(occupied)}))
    assert plan.status is PlanStatus.INVALID_START
    assert "overlaps crate" in plan.reason


def test_requests_that_make_no_sense_are_refused_with_a_reason() -> None:
    one = robot("a", (5, 5), block(1, 1))
    ask = request(SPEC, OPEN, [one], targets(t=(20, 5)))
    assert "map of shape" in plan_once(replace(ask, occupied=np.zeros((3, 3, 3), dtype=bool))).reason
    assert "unique" in plan_once(replace(ask, robots=(one, one))).reason
    assert "not there" in plan_once(replace(ask, assignments={"z": "t"})).reason
    assert plan_once(replace(ask, robots=(), assignments={})).status is PlanStatus.SOLVED


def test_parameters_out_of_range_are_refused_by_name() -> None:
    with pytest.raises(ParamError, match="particles"):
        YarmPlanner(PlannerParams(particles=-3))


def test_the_same_generator_gives_the_same_plan() -> None:
    scene = make_instance("crossing", 3).scene
    trails = [step_to_end(scene, YarmPlanner(), np.random.default_rng(7), clearance=False).trails for _ in range(2)]
    assert trails[0] == trails[1]


def test_a_plan_is_kept_while_it_is_free_and_dropped_when_it_is_not() -> None:
    planner = YarmPlanner()
    occupied = walls(SPEC, [(14, 16, 6, 24)])
    one = robot("a", (5, 20), block(1, 1))
    first = plan_once(request(SPEC, occupied, [one], targets(t=(25, 20))), planner)
    again = plan_once(request(SPEC, occupied, [one], targets(t=(25, 20))), planner)
    assert again.robots["a"].path == first.robots["a"].path
    assert again.iterations == 0
    changed = walls(SPEC, [(14, 16, 0, 18)])
    new = plan_once(request(SPEC, changed, [one], targets(t=(25, 20))), planner)
    assert new.status is PlanStatus.SOLVED
    assert new.robots["a"].path != first.robots["a"].path


def test_a_shorter_way_that_opens_is_taken() -> None:
    planner = YarmPlanner()
    one = robot("a", (5, 20), block(1, 1))
    long_way = plan_once(request(SPEC, walls(SPEC, [(14, 16, 6, 24)]), [one], targets(t=(25, 20))), planner)
    short = plan_once(request(SPEC, OPEN, [one], targets(t=(25, 20))), planner)
    assert short.robots["a"].length_cells < 0.8 * long_way.robots["a"].length_cells


def test_debris_that_is_the_goal_is_no_obstacle_and_other_debris_is() -> None:
    occupied = OPEN.copy()
    cells = np.array([(20, 10, 0), (20, 11, 0)])
    occupied[tuple(cells.T)] = True
    goal = Goal("d", "Debris", (20, 10), cells)
    one = robot("a", (5, 10), block(1, 1))
    assert plan_once(request(SPEC, occupied, [one], [goal])).status is PlanStatus.SOLVED
    beside = Goal("t", "Target", (20, 10))
    assert plan_once(request(SPEC, occupied, [one], [beside])).status is PlanStatus.INVALID_GOAL


def test_a_robot_right_beside_a_wall_gets_away_and_around_it() -> None:
    occupied = walls(SPEC, [(0, 20, 8, 9)])
    after, _ = run([robot("a", (10, 9), block(3, 3))], targets(t=(10, 2)), occupied)
    assert columns(after) == {"a": (10, 2)}


def test_robots_that_stand_side_by_side_get_apart() -> None:
    robots = [robot("a", (10, 10), block(2, 2)), robot("b", (12, 10), block(2, 2))]
    after, _ = run(robots, targets(ta=(20, 10), tb=(2, 10)))
    assert columns(after) == {"a": (20, 10), "b": (2, 10)}


def test_a_robot_partly_outside_comes_in() -> None:
    after, _ = run([robot("a", (28, 12), block(4, 2))], targets(t=(10, 12)))
    assert columns(after) == {"a": (10, 12)}
