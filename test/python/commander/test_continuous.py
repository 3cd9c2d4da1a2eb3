"""Without a barrier: who goes on, who is waited for, and what is thrown away."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from python.commander.fake_cell import FakeCell, box_cells
from yarm.commander.events import Outcome
from yarm.commander.params import CommanderParams

CORNERS = {"ankurbot_1": (1.95, 1.95, math.pi), "ankurbot_2": (1.95, -1.95, math.pi)}


@pytest.fixture(autouse=True)
def _continuous(monkeypatch):
    monkeypatch.setattr(FakeCell, "execution", "continuous")


def mission(**params):
    """Two robots with a target each that do not meet; the second's is far."""
    cell = FakeCell(CommanderParams(**params), **CORNERS)
    cell.calibrate()
    cell.targets = {"target_1": (1.35, 1.95), "target_2": (-1.65, -1.95), "target_3": (-1.65, 1.95)}
    assert cell.request(jump_state=5).success
    return cell


def sent_to(cell, robot):
    return [time for time, goal in cell.sent if goal.robot == robot and goal.target is not None]


def test_a_robot_goes_on_while_another_still_drives():
    cell = mission()
    cell.run(lambda: len(sent_to(cell, "ankurbot_1")) == 2, 30.0)
    assert cell.robots["ankurbot_2"].goal is not None
    cell.run(cell.idle, 60.0)
    assert (cell.status.outcome, cell.touches) == ("succeeded", [])


@pytest.mark.parametrize(("x", "y", "served"), [(0.35, 0.85, "ankurbot_1"), (1.65, -0.95, "ankurbot_2")])
def test_a_goal_that_comes_is_left_to_who_is_on_its_way_and_is_there_sooner(x, y, served):
    cell = FakeCell(CommanderParams(), **CORNERS)
    cell.calibrate()
    cell.targets = {"target_1": (0.35, 1.95)}
    cell.request(jump_state=5)
    cell.run(lambda: sent_to(cell, "ankurbot_1"), 10.0)
    assert cell.robots["ankurbot_2"].goal is None
    cell.targets["target_2"] = (x, y)
    cell.run(cell.idle, 60.0)
    assert {task.goal: task.robot for task in cell.status.tasks} == {"target_1": "ankurbot_1", "target_2": served}
    assert (cell.status.outcome, cell.touches) == ("succeeded", [])


@pytest.mark.parametrize("delay_s", [0.1, 0.5])
def test_a_plan_takes_effect_a_fixed_time_after_it_was_asked_for(delay_s):
    cell = FakeCell(CommanderParams(plan_delay_s=delay_s), **CORNERS)
    cell.calibrate()
    cell.targets = {"target_1": (1.35, 1.95)}
    cell.request(jump_state=5)
    cell.tick()
    asked = cell.now
    cell.run(lambda: sent_to(cell, "ankurbot_1"), 5.0)
    assert cell.now - asked == pytest.approx(delay_s, abs=1.01 / 30.0)


def test_a_robot_whose_way_is_taken_is_stopped_and_nobody_else():
    cell = mission()
    cell.run(lambda: all(cell.robots[name].goal is not None for name in CORNERS), 10.0)
    first = len(cell.said)
    cell.obstacles["unknown_1"] = box_cells((0.1, -2.2, 0.0), (0.4, -1.7, 1.0))
    cell.run(lambda: any("did not reach" in line for line in cell.said[first:]), 5.0)
    stopped = [line for line in cell.said[first:] if "did not reach" in line]
    assert stopped == ["ankurbot_2 did not reach its waypoint: replan: unknown_1 is in the way"]
    cell.run(cell.idle, 120.0)
    assert (cell.status.outcome, cell.touches) == ("succeeded", [])


def test_one_that_stops_holds_what_is_left_of_its_way_until_it_stands():
    """Its word that it has given up comes before it has braked."""
    cell = mission()
    cell.coast_s = 0.6
    cell.run(lambda: cell.robots["ankurbot_2"].x < 1.5, 10.0)
    cell.obstacles["unknown_1"] = box_cells((-0.5, -2.2, 0.0), (-0.2, -1.7, 1.0))
    cell.run(lambda: any(robot == "ankurbot_2" for _, robot in cell.cancelled), 5.0)
    for _ in range(6):
        cell.tick()
        releases = cell.commander._work._releases
        assert "ankurbot_2" in releases.under_way and len(releases.ahead("ankurbot_2"))
    cell.run(cell.idle, 120.0)
    assert (cell.status.outcome, cell.touches) == ("succeeded", [])


def test_one_that_is_cancelled_is_not_told_how_to_go_on():
    """Its goal moves in the very map with which it would be."""

    def walled(until_s, moved):
        cell = FakeCell(CommanderParams(), ankurbot_1=(1.95, 1.95, math.pi))
        cell.obstacles["wall"] = box_cells((-0.9, 1.25, 0.0), (-0.6, 2.5, 1.3))
        cell.calibrate()
        cell.targets = {"target_1": (-1.95, 0.85)}
        cell.request(jump_state=5)
        cell.run(lambda: cell.now >= until_s, 60.0)
        cell.targets["target_1"] = moved
        cell.run_for(1.0)
        return cell

    quiet = walled(20.0, (-1.95, 0.85))
    told_s = next(time for time, goal in quiet.sent if goal.via)
    cell = walled(told_s - 0.05, (-1.95, 0.35))
    assert (told_s, "ankurbot_1") in cell.cancelled
    assert not [goal for time, goal in cell.sent if time == told_s]


def test_a_plan_that_comes_late_is_taken_at_the_next_look_and_nobody_waits_for_it():
    cell = FakeCell(CommanderParams(), **CORNERS)
    waiting = []

    def begin(planning):
        plan = planning()
        waiting.append(cell.now)
        return lambda: plan if cell.now > waiting[0] + 0.75 else None

    cell.commander._tools = replace(cell.commander._tools, begin=begin)
    cell.calibrate()
    cell.targets = {"target_1": (1.35, 1.95)}
    cell.request(jump_state=5)
    cell.run(lambda: sent_to(cell, "ankurbot_1"), 5.0)
    assert len(waiting) == 1 or waiting[1] >= cell.now
    assert cell.now - waiting[0] == pytest.approx(0.75 + 1.0 / 30.0, abs=1.01 / 30.0)


def test_who_is_waited_for_stands_on_the_task():
    cell = FakeCell(CommanderParams(), ankurbot_1=CORNERS["ankurbot_1"], ankurbot_2=(2.05, -0.65, math.pi / 2))
    cell.calibrate()
    cell.targets = {"target_1": (-1.65, 1.95), "target_2": (2.05, 2.15)}
    cell.request(jump_state=5)
    cell.run(lambda: sent_to(cell, "ankurbot_1"), 10.0)
    cell.robots["ankurbot_1"].stuck = True
    cell.run(lambda: any(task.reason for task in cell.status.tasks), 9.0)
    assert cell.robots["ankurbot_1"].goal is not None
    said = {task.robot: task.reason for task in cell.status.tasks}
    assert said == {"ankurbot_1": "", "ankurbot_2": "waits for ankurbot_1"}


def test_what_comes_to_lie_behind_a_robot_does_not_stop_it():
    cell = mission()
    cell.run(lambda: cell.robots["ankurbot_2"].x < -0.6, 20.0)
    cell.obstacles["unknown_1"] = box_cells((1.7, -2.2, 0.0), (2.1, -1.7, 1.0))
    cell.run_for(0.5)
    assert not any("ankurbot_2 did not reach" in line for line in cell.said)


def test_a_robot_that_is_stuck_holds_up_nobody_that_does_not_need_its_place():
    cell = mission()
    cell.run(lambda: cell.robots["ankurbot_2"].goal is not None, 10.0)
    cell.robots["ankurbot_2"].stuck = True
    cell.run(lambda: not {"target_1", "target_3"} & set(cell.targets), 30.0)
    assert "target_2" in cell.targets


def test_a_robot_is_waited_for_only_until_it_has_passed_what_the_others_move_needs():
    cell = FakeCell(CommanderParams(), ankurbot_1=CORNERS["ankurbot_1"], ankurbot_2=(2.05, -0.65, math.pi / 2))
    cell.calibrate()
    cell.targets = {"target_1": (-1.65, 1.95)}
    cell.request(jump_state=5)
    cell.run(lambda: sent_to(cell, "ankurbot_1"), 10.0)
    cell.targets["target_2"] = (2.05, 2.15)
    cell.run_for(0.5)

    def is_sent_across():
        return any(goal.robot == "ankurbot_2" and goal.target.y > 1.9 for _, goal in cell.sent if goal.target)

    assert not is_sent_across()
    cell.run(is_sent_across, 10.0)
    first = cell.robots["ankurbot_1"]
    assert first.goal is not None and -1.2 < first.x < 0.7
    assert not any("was not sent" in line for line in cell.said)
    cell.run(cell.idle, 60.0)
    assert (cell.status.outcome, cell.touches) == ("succeeded", [])


def test_one_that_says_it_is_there_and_is_not_seen_there_is_planned_for_from_where_it_is():
    cell = mission()
    cell.run(lambda: cell.robots["ankurbot_2"].goal is not None, 10.0)
    cell.run(lambda: cell.robots["ankurbot_2"].x < 1.0, 10.0)
    cell._end("ankurbot_2", Outcome.SUCCEEDED)
    cell.run(lambda: any("is not seen there within 1 s" in line for line in cell.said), 5.0)
    cell.run(cell.idle, 120.0)
    assert (cell.status.outcome, cell.touches) == ("succeeded", [])


def test_the_same_mission_twice_sends_the_same_at_the_same_times():
    def sent():
        cell = mission()
        cell.run(cell.idle, 120.0)
        return [(time, goal) for time, goal in cell.sent]

    assert sent() == sent()


def test_a_robot_that_goes_on_without_a_turn_is_told_so_before_it_brakes():
    cell = FakeCell(CommanderParams(), ankurbot_1=(1.95, 1.95, math.pi))
    cell.obstacles["wall"] = box_cells((-0.9, 1.25, 0.0), (-0.6, 2.5, 1.3))
    cell.calibrate()
    cell.targets = {"target_1": (-1.95, 0.85)}
    cell.request(jump_state=5)
    cell.run(cell.idle, 60.0)
    driven = [(time, goal) for time, goal in cell.sent if goal.target is not None]
    onward = [(time, goal) for time, goal in driven if goal.via]
    assert onward, driven
    for _, goal in onward:
        before = driven[[g for _, g in driven].index(goal) - 1][1]
        assert goal.via[-1] == before.target
        assert {pose.yaw_rad for pose in goal.via} == {goal.target.yaw_rad}
    assert (cell.status.outcome, cell.touches) == ("succeeded", [])
