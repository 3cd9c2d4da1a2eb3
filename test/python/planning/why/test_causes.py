"""What is said of a goal without a robot, of a robot that stands, and of what is not there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from python.planning.samples import SMALL, block, request, robot, walls
from yarm.planning.model.types import FleetPlan, Goal, GoalKind, PlanStatus, RobotPlan, Waypoint
from yarm.planning.registry import make_planner
from yarm.planning.scenes.scene_file import load_scene
from yarm.planning.why.causes import Circumstances, why
from yarm.planning.why.changes import ChangeKind
from yarm.resources import resource

OPEN = walls(SMALL, [])


def goal(name, column, **fields):
    return Goal(name, GoalKind.TARGET, column, **fields)


def test_a_goal_shut_in_names_the_smallest_change():
    scene = load_scene(resource("scenes", "planning", "walled_in.yaml"))
    answer = why("goals[0]", Circumstances(scene.request()))
    cause = answer.causes[0]
    assert (cause.kind, cause.robot) == ("unreachable", "cart_1")
    assert [change.kind for change in cause.changes] == [ChangeKind.MOVE]
    assert cause.changes[0].metres == pytest.approx(0.3) and cause.changes[0].thing in answer.text


def test_a_goal_that_others_won_says_what_they_serve_and_at_what_cost():
    robots = [robot("a", (2, 2), block(1, 1)), robot("b", (12, 2), block(1, 1))]
    goals = [goal("near", (4, 2)), goal("other", (12, 6)), goal("left", (8, 9))]
    asked = request(SMALL, OPEN, robots, goals, {"a": "near", "b": "other"})
    causes = why("left", Circumstances(asked)).causes
    assert [(c.kind, c.robot, c.others) for c in causes] == [("taken", "b", ("other",)), ("taken", "a", ("near",))]
    assert causes[0].cost_cells < causes[1].cost_cells
    assert "cost 2.0 cells" in causes[1].text


def test_a_robot_that_waits_names_whom_for_and_the_cells_they_share():
    robots = [robot("a", (2, 5), block(2, 2)), robot("b", (12, 5), block(2, 2))]
    goals = [goal("right", (12, 5)), goal("left", (2, 5))]
    lane = walls(SMALL, [(0, 16, 0, 3), (0, 5, 8, 12), (11, 16, 8, 12)])
    asked = request(SMALL, lane, robots, goals)
    plan = make_planner("yarm").plan(asked, np.random.default_rng(0))
    waiting = [name for name, entry in plan.robots.items() if entry.step is None and entry.path]
    assert waiting, plan.reason
    (cause, *_) = why(waiting[0], Circumstances(asked, plan)).causes
    assert (cause.kind, cause.robot) == ("waiting", waiting[0]) and cause.others == tuple({"a", "b"} - {waiting[0]})
    assert len(cause.cells) and str(len(cause.cells)) in cause.text


def test_a_robot_under_way_or_without_a_goal_is_said_to_be():
    asked = request(
        SMALL, OPEN, [robot("a", (2, 2), block(1, 1)), robot("b", (9, 9), block(1, 1))], [goal("g", (6, 2))]
    )
    step = Waypoint((6, 2), 0.0)
    entry = RobotPlan("a", "g", PlanStatus.SOLVED, path=(Waypoint((2, 2), 0.0), step), step=step)
    plan = FleetPlan(PlanStatus.SOLVED, "", {"a": entry})
    assert "its next waypoint is (6, 2)" in why("a", Circumstances(asked, plan)).text
    assert why("g", Circumstances(asked, plan)).text == why("a", Circumstances(asked, plan)).text
    assert why("b", Circumstances(asked, plan)).text == "b has no goal"
    assert "nothing is planned for it yet" in why("a", Circumstances(asked)).text


def test_a_robot_that_the_planner_gave_up_on_says_its_reason():
    asked = request(SMALL, OPEN, [robot("a", (2, 2), block(1, 1))], [goal("g", (6, 2))])
    entry = RobotPlan("a", "g", PlanStatus.TIMEOUT, "no joint plan in 500 rounds")
    answer = why("a", Circumstances(asked, FleetPlan(PlanStatus.TIMEOUT, "", {"a": entry})))
    assert answer.text == "a waits: no joint plan in 500 rounds"


@pytest.mark.parametrize(
    ("fields", "words"),
    [({"column": (99, 2)}, "outside the 16 x 12 columns"), ({"column": (6, 2), "robot": "ghost"}, "ghost only")],
)
def test_a_goal_that_is_wrong_in_itself_says_so(fields, words):
    asked = request(SMALL, OPEN, [robot("a", (2, 2), block(1, 1))], [goal("g", **fields)], {})
    (cause,) = why("g", Circumstances(asked)).causes
    assert cause.kind == "fault" and words in cause.text


def test_a_goal_given_back_for_good_says_why():
    asked = request(SMALL, OPEN, [robot("a", (2, 2), block(1, 1))])
    circumstances = replace(Circumstances(asked), refused={"debris_1": "not taken in three tries"})
    assert why("debris_1", circumstances).text == "debris_1 was given back: not taken in three tries"


def test_a_name_that_nothing_has_is_answered_with_what_there_is():
    asked = request(SMALL, OPEN, [robot("a", (2, 2), block(1, 1))], [goal("g", (6, 2))])
    with pytest.raises(KeyError, match="ghost is neither a goal nor a robot; there is g, a"):
        why("ghost", Circumstances(asked))
