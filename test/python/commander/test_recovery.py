"""Robots outside the volume, robots that stand in something for a while, robots that stand still: all go on."""

from __future__ import annotations

import math

import pytest

from python.commander.fake_cell import FakeArm, FakeCell, box_cells
from yarm.commander.params import CommanderParams
from yarm.geometry import wrap_angle

pytestmark = pytest.mark.usefixtures("execution")

START = (0.65, 1.6, math.pi)
SECOND = (0.65, -1.9, math.pi)
OUTSIDE = (3.13, 0.62, math.pi + 0.2)


def mission(target=(-1.9, 1.65), params=None, **robots):
    """A cell in BOUNDLESS with one target."""
    cell = FakeCell(params, **(robots or {"ankurbot_1": START}))
    cell.arms["hc10_barc"] = FakeArm()
    cell.calibrate()
    cell.targets["target_1"] = target
    assert cell.request(jump_state=5).success
    return cell


def push(cell, name, pose):
    """Something takes a robot elsewhere."""
    cell.robots[name].x, cell.robots[name].y, cell.robots[name].yaw = pose


def said(cell, words):
    return any(words in line for line in cell.said)


@pytest.mark.parametrize("pose", [OUTSIDE, (0.3, -3.4, math.pi / 2), (-4.5, 0.65, 0.1), (2.51, 2.7, -math.pi / 2)])
def test_a_robot_pushed_out_of_the_volume_comes_straight_in_and_its_mission_goes_on(pose):
    cell = mission()
    cell.run(lambda: cell.robots["ankurbot_1"].goal is not None, 10.0)
    push(cell, "ankurbot_1", pose)
    cell.robots["ankurbot_1"].stuck = True
    cell.run(lambda: said(cell, "is outside the mapped volume at"), 40.0)
    cell.robots["ankurbot_1"].stuck = False
    assert [t.status for t in cell.status.tasks if t.goal == "inside/ankurbot_1"] == ["backing_out"]
    sent = cell.sent[-1][1].target
    assert sent.yaw_rad == pytest.approx(math.remainder(pose[2], 2 * math.pi))
    cell.run(cell.idle, 120.0)
    assert cell.status.outcome == "succeeded"
    assert cell.touches == []


def test_a_robot_comes_in_whatever_became_of_the_goal_it_has_reached():
    """The goal of an earlier step has nothing to say about the way in."""
    cell = mission(target=(1.25, 1.65))
    cell.run(lambda: said(cell, "target_1 is deleted"), 60.0)
    push(cell, "ankurbot_1", OUTSIDE)
    cell.run(lambda: said(cell, "is outside the mapped volume at"), 10.0)
    cell.run(cell.idle, 60.0)
    assert not said(cell, "its goal has moved or gone")
    assert cell.status.outcome == "succeeded"


def test_no_way_in_is_said_with_what_to_do_and_the_others_go_on():
    cell = mission(ankurbot_1=START, ankurbot_2=SECOND)
    cell.run(lambda: cell.robots["ankurbot_1"].goal is not None, 10.0)
    cell.obstacles["unknown_1"] = box_cells((2.0, -0.4, 0.0), (2.5, 1.6, 1.2))
    push(cell, "ankurbot_1", OUTSIDE)
    cell.robots["ankurbot_1"].stuck = True
    cell.run(lambda: any(t.status == "reached" for t in cell.status.tasks), 120.0)
    view = next(t for t in cell.status.tasks if t.goal == "inside/ankurbot_1")
    assert (view.robot, view.status) == ("ankurbot_1", "stopped")
    assert "outside the mapped volume, and no straight way in is free: clear the border" in view.reason
    assert next(t.robot for t in cell.status.tasks if t.goal == "target_1") == "ankurbot_2"
    assert cell.touches == []
    cell.robots["ankurbot_1"].stuck = False
    cell.obstacles.clear()
    cell.run(cell.idle, 60.0)
    assert cell.status.outcome == "succeeded"
    assert cell.robots["ankurbot_1"].x < 2.5


def test_the_way_in_keeps_the_margin_above_and_below_too():
    cell = mission()
    cell.run(lambda: cell.robots["ankurbot_1"].goal is not None, 10.0)
    cell.obstacles["unknown_1"] = box_cells((1.0, -2.4, 0.79), (2.5, 2.4, 0.845))  # the cell just under the arm's
    push(cell, "ankurbot_1", OUTSIDE)
    cell.robots["ankurbot_1"].stuck = True
    cell.run(lambda: any("no straight way in is free" in t.reason for t in cell.status.tasks), 40.0)
    assert not any(t.status == "backing_out" for t in cell.status.tasks)


def test_a_robot_that_seems_to_stand_in_something_goes_on_when_the_map_is_right_again():
    cell = mission()
    robot = cell.robots["ankurbot_1"]
    cell.obstacles["unknown_7"] = box_cells((robot.x - 0.1, robot.y - 0.1, 0.8), (robot.x + 0.3, robot.y + 0.1, 0.95))
    cell.run_for(20.0)
    assert cell.status.busy
    assert robot.goal is None
    words = [t.reason for t in cell.status.tasks] + [cell.status.reason]
    assert any("unknown_7" in reason for reason in words), words
    cell.obstacles.clear()
    cell.touches.clear()
    cell.run(cell.idle, 60.0)
    assert cell.status.outcome == "succeeded"
    assert cell.touches == []


def test_moving_without_motion_ends_after_10_s_though_maps_stand_still_and_nobody_complains():
    cell = mission(params=CommanderParams(stale_map_s=60.0))
    cell.run(lambda: cell.robots["ankurbot_1"].goal is not None, 10.0)
    cell.robots["ankurbot_1"].stuck = True
    cell.silent = True
    began = cell.now
    cell.run(lambda: cell.robots["ankurbot_1"].goal is None, 15.0)
    assert cell.now - began >= 9.5
    cell.run_for(0.1)
    assert "moving" not in {task.status for task in cell.status.tasks}
    cell.robots["ankurbot_1"].stuck = False
    cell.silent = False
    cell.run(cell.idle, 60.0)
    assert cell.status.outcome == "succeeded"


def test_nothing_may_move_without_maps_or_servers():
    cell = FakeCell(ankurbot_1=START)
    assert cell.commander.objection(0.0) == "no planning_metadata yet"
    cell.run_for(0.2)
    assert cell.commander.objection(cell.now) == ""
    cell.lose("ankurbot_1")
    cell.run_for(0.1)
    assert cell.commander.objection(cell.now) == "the action server of ankurbot_1 is lost"
    cell.find("ankurbot_1")
    cell.run_for(0.1)
    assert cell.commander.objection(cell.now) == ""
    cell.silent = True
    cell.run_for(cell.params.stale_map_s + 0.1)
    assert cell.commander.objection(cell.now) == "no new planning_metadata for more than 1 s"
    cell.silent = False
    cell.run_for(0.1)
    assert cell.commander.objection(cell.now) == ""


@pytest.mark.parametrize("turned_deg", [20.0, 50.0, 75.0])
def test_a_robot_stopped_in_the_midst_of_a_turn_goes_on_where_only_its_own_headings_fit(turned_deg):
    """Quarter turns from a heading in between lead only to others in between, and none of them fits into the lane."""
    cell = FakeCell(ankurbot_1=(0.3, -1.75, -math.pi / 2))
    cell.statics = {
        f"wall_{i + 1}": box_cells((-2.45, y, 0.0), (-0.4, y + 0.09, 1.2)) for i, y in enumerate((-2.5, -1.1))
    }
    cell.calibrate()
    cell.targets["target_1"] = (-1.9, -1.75)
    assert cell.request(jump_state=5).success
    robot = cell.robots["ankurbot_1"]
    cell.run(lambda: abs(wrap_angle(robot.yaw + math.pi / 2)) > math.radians(turned_deg), 30.0)
    cell.lose("ankurbot_1")
    cell.run_for(0.5)
    assert abs(wrap_angle(robot.yaw + math.pi / 2)) < math.radians(turned_deg + 5.0)
    cell.find("ankurbot_1")
    cell.run(cell.idle, 120.0)
    assert cell.status.outcome == "succeeded", cell.status
    assert cell.touches == []
