"""A plan that takes longer than a map: what goes on meanwhile, and what has changed when it is there."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from python.commander.fake_cell import FakeCell, box_cells

pytestmark = pytest.mark.usefixtures("execution")

LATE_S = 3.0
START = (0.65, 1.6, math.pi)
IN_THE_WAY = box_cells((-0.9, 1.25, 0.0), (-0.6, 2.5, 1.3))


class SlowThought:
    """Makes each plan at once, and gives it so much later; the first may fail instead."""

    def __init__(self, cell, fails=False):
        self.cell = cell
        self.fails = fails
        self.asked = []

    def begin(self, planning):
        plan, since, nth = planning(), self.cell.now, len(self.asked)
        self.asked.append(since)

        def answer():
            if self.cell.now < since + LATE_S:
                return None
            if self.fails and nth == 0:
                raise RuntimeError("no thought")
            return plan

        return answer


def thinking(fails=False, **others):
    """A robot with a target for which the first plan is being made."""
    cell = FakeCell(ankurbot_1=START, **others)
    cell.calibrate()
    thought = SlowThought(cell, fails)
    cell.commander._tools = replace(cell.commander._tools, begin=thought.begin)
    cell.targets = {"target_1": (-1.95, 1.6)}
    assert cell.request(jump_state=5).success
    cell.run(lambda: thought.asked, 5.0)
    cell.run_for(LATE_S / 2.0)
    assert cell.sent == [] or all(goal.target is None for _, goal in cell.sent)
    return cell, thought


def steps_sent(cell):
    return [(time, goal) for time, goal in cell.sent if goal.target is not None]


def asked_before_the_first_step(cell, thought):
    return sum(since < steps_sent(cell)[0][0] for since in thought.asked)


def test_the_maps_are_taken_while_a_plan_is_made_and_it_is_carried_out_when_it_is_there():
    cell, thought = thinking()
    assert cell.status.reason == "a plan is being made"
    assert cell.commander.objection(cell.now) == ""
    assert cell.commander.cell.map.stamp_s == cell.now
    cell.run(lambda: steps_sent(cell), 10.0)
    assert asked_before_the_first_step(cell, thought) == 1
    assert steps_sent(cell)[0][0] == pytest.approx(thought.asked[0] + LATE_S, abs=2.0 / 30.0)
    cell.run(cell.idle, 120.0)
    assert (cell.status.outcome, cell.touches) == ("succeeded", [])


def test_what_has_come_into_the_way_meanwhile_stops_the_step_before_it_is_sent():
    cell, _ = thinking()
    cell.obstacles["unknown_1"] = IN_THE_WAY
    cell.run(lambda: any("a step was not sent" in line for line in cell.said), 10.0)
    assert steps_sent(cell) == []
    del cell.obstacles["unknown_1"]
    cell.run(cell.idle, 120.0)
    assert (cell.status.outcome, cell.touches) == ("succeeded", [])


def test_a_plan_to_where_the_goal_no_longer_is_is_thrown_away():
    cell, thought = thinking()
    cell.targets["target_1"] = (0.65, -1.95)
    cell.run(lambda: steps_sent(cell), 20.0)
    assert asked_before_the_first_step(cell, thought) == 2
    assert steps_sent(cell)[0][0] >= thought.asked[1] + LATE_S
    cell.run(cell.idle, 120.0)
    assert (cell.status.outcome, cell.touches) == ("succeeded", [])


def test_a_plan_from_where_the_robot_no_longer_stands_is_thrown_away():
    cell, thought = thinking()
    cell.robots["ankurbot_1"].y += 0.4
    cell.run(lambda: steps_sent(cell), 20.0)
    assert asked_before_the_first_step(cell, thought) == 2
    cell.run(cell.idle, 120.0)
    assert (cell.status.outcome, cell.touches) == ("succeeded", [])


def test_a_robot_that_comes_meanwhile_is_held_against_the_plan_too(execution):
    """A step is refused; a plan that all carry out, each for itself, no longer starts where they stand."""
    cell, thought = thinking(ankurbot_2=(0.65, -1.9, math.pi))
    other = cell.robots["ankurbot_2"]
    other.x, other.y = -0.9, 1.7
    if execution == "steps":
        cell.run(lambda: any("a step was not sent" in line for line in cell.said), 10.0)
    else:
        cell.run(lambda: len(thought.asked) == 2, 10.0)
    assert steps_sent(cell) == []
    cell.run(cell.idle, 120.0)
    assert (cell.status.outcome, cell.touches) == ("succeeded", [])


def test_a_planner_that_fails_is_asked_again():
    cell, thought = thinking(fails=True)
    with pytest.raises(RuntimeError, match="no thought"):
        cell.run_for(LATE_S)
    cell.run(lambda: len(thought.asked) == 2, 1.0)
    cell.run(cell.idle, 120.0)
    assert cell.status.outcome == "succeeded"


def test_a_mission_that_is_stopped_while_it_thinks_leaves_nothing_behind():
    cell, thought = thinking()
    assert cell.request(previous_state=True).success
    cell.run_for(2.0 * LATE_S)
    assert steps_sent(cell) == []
    assert cell.request(jump_state=5).success
    cell.run(lambda: steps_sent(cell), 20.0)
    assert steps_sent(cell)[0][0] >= thought.asked[1] + LATE_S
