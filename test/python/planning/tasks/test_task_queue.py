"""Assignment over travel distances, and what happens to goals that wait, move, vanish or cannot be reached."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from python.planning.samples import arm, block, request, walls
from python.planning.samples import robot as robot_at
from yarm.geometry import GridSpec, Mask
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import Column, Goal, GoalKind, PlanRequest, Robot
from yarm.planning.tasks.task import TaskStatus
from yarm.planning.tasks.task_queue import TaskQueue
from yarm.planning.tasks.travel import Travel

SPEC = GridSpec((30, 24, 4), (0.0, 0.0, 0.0), (3.0, 2.4, 0.4))
OPEN = np.zeros(SPEC.shape, dtype=bool)


def robots_at(columns: Dict[str, Column], mask: Optional[Mask] = None) -> List[Robot]:
    return [robot_at(name, column, mask or block(2, 2)) for name, column in columns.items()]


def debris(name: str, column: Column, **more: object) -> Goal:
    return Goal(name, "Debris", column, **more)  # type: ignore[arg-type]


def target(name: str, column: Column, **more: object) -> Goal:
    return Goal(name, "Target", column, **more)  # type: ignore[arg-type]


def run(
    queue: TaskQueue,
    robots: Sequence[Robot],
    goals: Sequence[Goal],
    occupied: np.ndarray = OPEN,
    keep_clear: Optional[np.ndarray] = None,
) -> PlanRequest:
    ask = request(SPEC, occupied, robots)
    queue.update(robots, goals)
    queue.process(ask, keep_clear)
    return replace(ask, goals=queue.goals, assignments=queue.assignments)


def test_each_robot_gets_the_goal_that_makes_the_sum_of_ways_least() -> None:
    queue = TaskQueue()
    run(queue, robots_at({"a": (2, 10), "b": (12, 10)}), [target("near_both", (8, 10)), target("far", (26, 10))])
    assert queue.assignments == {"a": "near_both", "b": "far"}


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_the_assignment_is_optimal_over_travel_distance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    occupied = walls(SPEC, [(14, 16, 0, 18)])
    places = [(int(x), int(y)) for x, y in rng.permutation(np.argwhere(~occupied[..., 0]))[:6]]
    robots = robots_at({"a": places[0], "b": places[1]}, block(1, 1))
    goals = [target(f"t{i}", place) for i, place in enumerate(places[2:4])]
    queue = TaskQueue()
    run(queue, robots, goals, occupied)
    if len(queue.assignments) < 2:
        return
    travel = Travel(request(SPEC, occupied, robots), PlannerParams())
    sums = [sum(travel.distance(r.name, goal)[0] for r, goal in zip(robots, chosen)) for chosen in permutations(goals)]
    named = {goal.name: goal for goal in goals}
    assert sum(travel.distance(r, named[g])[0] for r, g in queue.assignments.items()) == pytest.approx(min(sums))


def test_the_way_counts_not_the_straight_line() -> None:
    queue = TaskQueue()
    run(queue, robots_at({"behind": (11, 2), "free": (26, 12)}), [target("t", (18, 2))], walls(SPEC, [(14, 16, 0, 20)]))
    assert queue.assignments == {"free": "t"}


def test_debris_goes_before_targets_and_the_rest_waits() -> None:
    queue = TaskQueue()
    robots = robots_at({"a": (2, 10)})
    run(queue, robots, [target("t", (4, 10)), debris("d1", (20, 10)), debris("d2", (26, 10))])
    assert queue.assignments == {"a": "d1"}
    waiting = {task.goal.name: task.reason for task in queue.tasks if task.status is TaskStatus.OPEN}
    assert waiting == {"t": "waits for a robot", "d2": "waits for a robot"}
    assert queue.pop("a").goal.name == "d1"
    run(queue, robots_at({"a": (20, 10)}), [target("t", (4, 10)), debris("d2", (26, 10))])
    assert queue.assignments == {"a": "d2"}


def test_debris_that_appears_takes_a_robot_from_its_target() -> None:
    queue = TaskQueue()
    robots = robots_at({"a": (2, 10)})
    run(queue, robots, [target("t", (20, 10))])
    assert queue.assignments == {"a": "t"}
    run(queue, robots, [target("t", (20, 10)), debris("d", (26, 10))])
    assert queue.assignments == {"a": "d"}
    task = queue.task_of("a")
    assert task is not None and task.distance_cells == pytest.approx(24.0), "the way, nothing added for the change"
    idle_too = [*robots, *robots_at({"b": (2, 2)})]
    run(queue, idle_too, [target("t", (20, 10)), debris("d", (26, 10))])
    assert queue.assignments == {"a": "d", "b": "t"}


@pytest.mark.parametrize(("turns_deg", "status"), [((0.0,), "UNREACHABLE"), ((0.0, 90.0), "ASSIGNED")])
def test_a_goal_is_given_at_the_turns_of_the_planner(turns_deg: Tuple[float, ...], status: str) -> None:
    queue = TaskQueue(PlannerParams(turns_deg=turns_deg))
    run(queue, robots_at({"a": (15, 12)}, arm(5)), [target("beside_the_wall", (2, 12))])
    assert [task.status.value for task in queue.tasks] == [status]


def test_a_goal_nobody_can_reach_is_reported_and_tried_again() -> None:
    queue = TaskQueue()
    closed = walls(SPEC, [(18, 20, 0, 24)])
    robots = robots_at({"a": (2, 10)})
    run(queue, robots, [target("t", (26, 10))], closed)
    assert queue.assignments == {}
    assert "no way to t" in queue.unreachable["t"]
    assert queue.done
    run(queue, robots, [target("t", (26, 10))], OPEN)
    assert queue.assignments == {"a": "t"}
    assert not queue.done


def test_a_goal_inside_something_or_outside_is_reported() -> None:
    queue = TaskQueue()
    run(
        queue,
        robots_at({"a": (2, 10)}),
        [target("in", (10, 10)), target("out", (99, 1))],
        walls(SPEC, [(9, 12, 9, 12)]),
    )
    assert "cannot stand" in queue.unreachable["in"]
    assert "outside" in queue.unreachable["out"]


def test_a_goal_that_vanishes_frees_its_robot_and_one_that_moves_is_followed() -> None:
    queue = TaskQueue()
    robots = robots_at({"a": (2, 10), "b": (2, 2)})
    run(queue, robots, [target("t", (20, 10)), debris("d", (20, 2))])
    assert queue.assignments == {"a": "t", "b": "d"} or queue.assignments == {"a": "d", "b": "t"}
    changed = queue.update(robots, [target("t", (20, 10)), debris("d", (22, 4))])
    assert changed == ("d",)
    assert queue.goals["d"].column == (22, 4)
    assert queue.update(robots, [target("t", (20, 10))]) == ("d",)
    assert len(queue.idle) == 1


def test_the_goal_of_a_robot_that_is_gone_is_open_again() -> None:
    queue = TaskQueue()
    run(queue, robots_at({"a": (2, 10)}), [target("t", (20, 10))])
    run(queue, robots_at({"b": (4, 4)}), [target("t", (20, 10))])
    assert queue.assignments == {"b": "t"}


def test_a_goal_for_one_robot_only_goes_to_it() -> None:
    queue = TaskQueue()
    run(queue, robots_at({"a": (2, 10), "b": (12, 10)}), [Goal("home", "Home", (15, 10), robot="a")])
    assert queue.assignments == {"a": "home"}


def test_goals_side_by_side_are_served_one_after_the_other() -> None:
    queue = TaskQueue()
    robots = robots_at({"a": (2, 4), "b": (2, 18)}, arm(6))
    side = walls(SPEC, [(16, 17, 0, 24)])
    side[:, :, 1:] = False
    goals = [debris("d1", (16, 11)), debris("d2", (16, 13))]
    run(queue, robots, goals, side)
    assert len(queue.assignments) == 1
    waiting = next(task for task in queue.tasks if not task.robot)
    assert waiting.reason == "waits until a goal beside it is done"
    queue.pop(next(iter(queue.assignments)))
    run(queue, robots, [waiting.goal], side)
    assert list(queue.assignments.values()) == [waiting.goal.name]


def test_a_robot_with_a_load_goes_to_its_bin_and_serves_no_debris() -> None:
    queue = TaskQueue()
    robots = robots_at({"a": (2, 10), "b": (12, 10)})
    loaded = [replace(robots[0], carries="d0"), robots[1]]
    goals = [debris("d1", (4, 10)), debris("d2", (6, 10)), Goal("bin/a", GoalKind.BIN, (20, 10), robot="a")]
    run(queue, loaded, goals)
    assert queue.assignments == {"a": "bin/a", "b": "d2"}
    assert queue.pop("a").status is TaskStatus.REACHED
    assert queue.finished == ()
    run(queue, loaded, goals[:2])
    assert queue.assignments == {"b": "d2"}
    run(queue, robots, goals[:2])
    assert queue.assignments == {"a": "d1", "b": "d2"}


def test_the_way_on_to_a_bin_counts() -> None:
    """Both pieces are as far from the robot; from one it is half as far to the bin."""
    queue = TaskQueue()
    goals = [debris("far_on", (9, 4), onward=((15, 16),)), debris("near_on", (9, 16), onward=((15, 16), (28, 2)))]
    run(queue, robots_at({"a": (9, 10)}), goals)
    assert queue.assignments == {"a": "near_on"}
    assert queue.task_of("a").distance_cells == pytest.approx(6.0)  # type: ignore[union-attr]


def test_what_cannot_be_carried_on_for_now_is_served_last() -> None:
    queue = TaskQueue()
    wall = walls(SPEC, [(12, 14, 0, 24)])
    goals = [debris("no_way_on", (8, 10), onward=((20, 10),)), debris("way_on", (3, 4), onward=((3, 20),))]
    run(queue, robots_at({"a": (7, 10)}), goals, wall)
    assert queue.assignments == {"a": "way_on"}
    run(queue, robots_at({"a": (7, 10)}), goals[:1], wall)
    assert queue.assignments == {"a": "no_way_on"}


def test_two_robots_with_loads_are_at_a_bin_one_after_the_other() -> None:
    queue = TaskQueue()
    robots = [replace(r, carries=f"d{r.name}") for r in robots_at({"a": (2, 10), "b": (12, 10)})]
    run(queue, robots, [Goal(f"bin/{r.name}", GoalKind.BIN, (20, 10), robot=r.name) for r in robots])
    assert queue.assignments == {"b": "bin/b"}
    assert [task.reason for task in queue.tasks if not task.robot] == ["waits until a goal beside it is done"]


def test_what_is_held_is_no_goal_until_it_is_undone() -> None:
    queue = TaskQueue()
    robots = robots_at({"a": (2, 10)})
    run(queue, robots, [debris("d", (8, 10))])
    queue.hold(queue.pop("a").goal, "a", 3.0)
    assert queue.leaving == {"d"}
    queue.start_over()
    assert queue.leaving == set()
    queue.hold(debris("d", (8, 10)), "a")
    queue.undone("d")
    run(queue, robots, [debris("d", (8, 10))])
    assert queue.assignments == {"a": "d"}


def test_a_robot_that_is_done_leaves_the_columns_to_keep_clear() -> None:
    queue = TaskQueue()
    keep = np.zeros(SPEC.shape[:2], dtype=bool)
    keep[8:20, 6:18] = True
    robots = robots_at({"a": (12, 10), "b": (2, 10)})
    ask = run(queue, robots, [], OPEN, keep)
    task = queue.task_of("a")
    assert task is not None
    assert (task.kind, task.goal.name) == ("Clear", "clear/a")
    there = block(2, 2).at(ask.goals["clear/a"].column)
    assert not keep[there[:, 0], there[:, 1]].any()
    assert queue.task_of("b") is None
    run(queue, robots, [debris("d", (14, 8))], OPEN, keep)
    assert set(queue.assignments.values()) == {"d", "clear/a"} or queue.assignments == {"a": "d"}


def test_where_a_robot_clears_to_it_blocks_nobody_else() -> None:
    queue = TaskQueue()
    keep = np.zeros(SPEC.shape[:2], dtype=bool)
    keep[0:20, :] = True
    robots = robots_at({"a": (18, 10), "b": (2, 10)})
    run(queue, robots, [target("t", (22, 10))], OPEN, keep)
    queue.pop("a")
    run(queue, robots, [target("t2", (22, 10), robot="b")], OPEN, keep)
    place = queue.goals["clear/a"].column
    assert max(abs(place[0] - 22), abs(place[1] - 10)) > 2


def test_a_rejected_pair_waits_for_the_map_to_change() -> None:
    queue = TaskQueue()
    robots = robots_at({"a": (2, 10)})
    run(queue, robots, [target("t", (20, 10))])
    queue.reject("a", "the planner found no way")
    run(queue, robots, [target("t", (20, 10))])
    assert queue.assignments == {}
    assert queue.unreachable == {"t": "the planner found no way"}
    run(queue, robots, [target("t", (20, 10))], walls(SPEC, [(28, 30, 0, 2)]))
    assert queue.assignments == {"a": "t"}


def test_pop_without_a_task_is_refused() -> None:
    with pytest.raises(KeyError, match="nobody"):
        TaskQueue().pop("nobody")
