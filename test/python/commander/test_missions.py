"""Whole missions and every fault in simulated time, without ROS: the core, the real planner, a kinematic cell."""

from __future__ import annotations

import math

import pytest

from python.commander.fake_cell import SPEC, FakeArm, FakeCell, box_cells
from yarm.commander.events import GoalDone, Hold, Outcome, TaskState
from yarm.commander.params import CommanderParams
from yarm.commander.states import State
from yarm.control.sander.states import SanderState

pytestmark = pytest.mark.usefixtures("execution")

START = (0.65, 1.6, math.pi)
SECOND = (0.65, -1.9, math.pi)


def cell_with(debris=(), targets=(), arm=True, params=None, **robots):
    cell = FakeCell(params, **(robots or {"ankurbot_1": START}))
    if arm:
        cell.arms["hc10_barc"] = FakeArm()
    cell.debris = {f"debris_{i + 1}": at for i, at in enumerate(debris)}
    cell.targets = {f"target_{i + 1}": at for i, at in enumerate(targets)}
    cell.calibrate()
    return cell


def boundless(cell):
    reply = cell.request(jump_state=5)
    assert reply.success
    assert "goes on in the background" in reply.message


def outcome_of(cell, limit_s=120.0):
    cell.run(cell.idle, limit_s)
    assert cell.touches == []
    return cell.status


def moving(cell, name="ankurbot_1"):
    return lambda: cell.robots[name].goal is not None


CORNER = {"targets": [(-2.35, -2.35)], "arm": False}
"""A target that a robot which starts square to the walls reaches only askew."""


@pytest.mark.parametrize(("turns_deg", "outcome"), [((0.0, 90.0, -90.0), "failed"), ((0.0, 45.0, -45.0), "succeeded")])
def test_the_task_queue_and_the_planner_make_the_same_turns(turns_deg, outcome):
    params = CommanderParams(turns_deg=turns_deg, finer_turns_deg=(), give_up_s=5.0)
    cell = cell_with(**CORNER, params=params)
    boundless(cell)
    assert outcome_of(cell).outcome == outcome
    assert (outcome == "succeeded") == (cell.targets == {})


def test_robots_turn_finer_before_a_mission_is_given_up_and_as_ever_in_the_next():
    cell = cell_with(**CORNER, params=CommanderParams(finer_after_s=3.0, give_up_s=8.0))
    boundless(cell)
    began_s = cell.now
    assert outcome_of(cell).outcome == "succeeded"
    assert cell.commander.cell.turns_finer and cell.targets == {}
    assert [text for text in cell.said if "robots turn by 45, -45 deg, too (finer_turns_deg)" in text]
    steps = [at_s for at_s, goal in cell.sent if at_s > began_s and goal.target is not None]
    assert steps and min(steps) > began_s + 3.0
    cell.targets["target_2"] = (1.0, -2.0)
    assert cell.request(current_state=True).success
    assert outcome_of(cell).outcome == "succeeded"
    assert not cell.commander.cell.turns_finer


def test_calibration_keeps_association_off_until_clouds_are_learnt():
    cell = cell_with()
    assert [on for _, on in cell.association] == [False, True]
    (off, _), (on, _) = cell.association
    assert on - off >= cell.params.settle_s
    assert cell.commander.cell.answers["hc10_barc"].area == (11, 29, 17, 32, 0, 10)


def test_a_redo_switches_association_off_and_on_again():
    cell = cell_with()
    assert cell.request(current_state=True).success
    cell.run(cell.idle, 20.0)
    assert [on for _, on in cell.association] == [False, True, False, True]
    assert cell.status.outcome == "succeeded"


@pytest.mark.parametrize("outcome", [o for o in Outcome if o is not Outcome.SUCCEEDED])
def test_only_succeeded_is_a_calibration(outcome):
    cell = FakeCell(ankurbot_1=START)
    cell.fail_next["ankurbot_1"] = (outcome, "no reason")
    cell.request(current_state=True)
    cell.request(next_state=True)
    cell.run(cell.idle, 20.0)
    assert cell.status.outcome == "failed"
    assert f"ankurbot_1 did not calibrate: {outcome.value} no reason" in cell.status.reason
    assert "has not succeeded yet" in cell.request(next_state=True).message
    assert cell.request(current_state=True).success
    cell.run(cell.idle, 20.0)
    assert cell.status.outcome == "succeeded"


def test_calibration_without_a_server_fails_by_name_and_time():
    cell = FakeCell(ankurbot_1=START)
    cell.lost.add("ankurbot_1")
    cell.request(current_state=True)
    cell.request(next_state=True)
    cell.run(cell.idle, 30.0)
    assert cell.status.reason == "no action server ankurbot_1/move_robot within 10 s"


def test_a_bad_answer_fails_the_calibration():
    cell = FakeCell(ankurbot_1=START)
    cell.fail_next["ankurbot_1"] = (Outcome.SUCCEEDED, "SPACE=?")
    cell.request(current_state=True)
    cell.request(next_state=True)
    cell.run(cell.idle, 20.0)
    assert "ankurbot_1: calibration answer 'SPACE=?'" in cell.status.reason


def test_one_robot_clears_debris_while_the_manipulator_pauses():
    cell = cell_with()
    cell.run_for(0.2)
    assert cell.arms["hc10_barc"].on
    cell.debris["debris_1"] = (-0.12, 0.10)
    boundless(cell)
    status = outcome_of(cell)
    assert (status.outcome, [t.status for t in status.tasks]) == ("succeeded", ["reached"])
    assert cell.debris == {}
    told = [action for _, action in cell.arms["hc10_barc"].told]
    assert told == ["CALIBRATION", "ON", "OFF", "ON"]
    assert cell.arms["hc10_barc"].on


def test_two_robots_reach_two_debris():
    cell = cell_with([(-0.15, 0.2), (-0.2, -0.2)], ankurbot_1=START, ankurbot_2=SECOND)
    boundless(cell)
    assert sorted(t.status for t in outcome_of(cell).tasks) == ["reached", "reached"]


def test_more_goals_than_robots_are_done_one_after_the_other():
    cell = cell_with(targets=[(1.25, 1.65), (0.65, 1.65), (1.35, -1.65)], arm=False)
    boundless(cell)
    status = outcome_of(cell)
    assert {t.goal: t.status for t in status.tasks} == {f"target_{i}": "reached" for i in (1, 2, 3)}


def test_debris_that_appears_in_mid_mission_is_taken_up():
    cell = cell_with(targets=[(-1.9, 1.65)], arm=False)
    boundless(cell)
    cell.run(moving(cell), 10.0)
    cell.debris["debris_9"] = (-0.1, 0.2)
    status = outcome_of(cell)
    assert {t.goal for t in status.tasks if t.status == "reached"} == {"target_1", "debris_9"}


def test_bounded_leaves_the_private_area_alone():
    cell = cell_with([(-0.12, 0.10)], params=CommanderParams(give_up_s=5.0))
    assert cell.request(jump_state=4).success
    status = outcome_of(cell)
    assert status.outcome == "failed"
    assert status.tasks[0].status == "unreachable"
    assert "debris_1 cannot be reached" in status.reason
    assert [goal for _, goal in cell.sent if goal.target is not None] == []


def test_nothing_to_do_ends_well_after_a_while():
    cell = cell_with(arm=False)
    boundless(cell)
    begun = cell.now
    assert outcome_of(cell).outcome == "succeeded"
    assert cell.now - begun == pytest.approx(cell.params.linger_s, abs=0.1)


def test_current_looks_for_more_and_cleanup_sends_everybody_home():
    cell = cell_with([(-0.12, 0.10)])
    boundless(cell)
    outcome_of(cell)
    cell.debris["debris_2"] = (-0.2, 0.15)
    assert cell.request(current_state=True).success
    assert outcome_of(cell).outcome == "succeeded"
    assert cell.request(next_state=True).success
    assert outcome_of(cell).outcome == "succeeded"
    robot = cell.robots["ankurbot_1"]
    assert (robot.x, robot.y) == pytest.approx(START[:2], abs=0.06)
    assert cell.arms["hc10_barc"].state is SanderState.STORAGE
    assert cell.request(next_state=True).success
    assert cell.status.state is State.IDLE


def test_who_has_left_its_home_for_others_goes_there_again_before_cleanup_ends():
    homes = {"ankurbot_1": START, "ankurbot_2": SECOND}
    cell = cell_with(targets=[(-1.9, 1.2)], arm=False, **homes)
    boundless(cell)
    assert outcome_of(cell).outcome == "succeeded"
    assert cell.request(next_state=True).success
    home = cell.robots["ankurbot_2"]
    cell.run(lambda: any("ankurbot_2 has reached home" in text for text in cell.said), 60.0)
    home.x -= 0.5
    assert cell.status.busy, "ankurbot_1 is still on its way"
    assert outcome_of(cell).outcome == "succeeded"
    for name, pose in homes.items():
        assert (cell.robots[name].x, cell.robots[name].y) == pytest.approx(pose[:2], abs=0.06), name
    views = {view.goal: view.status for view in cell.status.tasks}
    assert views == {f"home/{name}": TaskState.REACHED for name in homes}


def test_busy_refuses_all_but_previous_which_stops_at_the_waypoint():
    cell = cell_with(targets=[(-1.9, 1.65)], arm=False)
    boundless(cell)
    cell.run(moving(cell), 10.0)
    for fields in ({"next_state": True}, {"current_state": True}, {"jump_state": 4}):
        reply = cell.request(**fields)
        assert not reply.success
        assert "busy" in reply.message
    goal = cell.robots["ankurbot_1"].goal.target
    assert cell.request(previous_state=True).success
    assert (cell.status.state, cell.status.busy) == (State.MENU, True)
    assert "ankurbot_1" in cell.status.reason
    cell.run(cell.idle, 20.0)
    assert cell.status.outcome == "stopped"
    robot = cell.robots["ankurbot_1"]
    assert (robot.x, robot.y) == pytest.approx((goal.x, goal.y))
    sent = len(cell.sent)
    cell.run_for(3.0)
    assert len(cell.sent) == sent


def test_silent_perception_stops_robots_and_the_mission_goes_on_afterwards():
    cell = cell_with(targets=[(-1.9, 1.65)], arm=False)
    boundless(cell)
    cell.run(moving(cell), 10.0)
    cell.silent = True
    cell.run(lambda: cell.robots["ankurbot_1"].goal is None, 3.0)
    assert "no new planning_metadata for more than 1 s" in cell.status.reason
    where = (cell.robots["ankurbot_1"].x, cell.robots["ankurbot_1"].y)
    cell.run_for(3.0)
    assert (cell.robots["ankurbot_1"].x, cell.robots["ankurbot_1"].y) == where
    cell.silent = False
    assert outcome_of(cell).outcome == "succeeded"


def test_a_robot_that_does_not_move_is_stopped_after_10_s_and_tried_again():
    cell = cell_with(targets=[(-1.9, 1.65)], arm=False)
    boundless(cell)
    cell.run(moving(cell), 10.0)
    cell.robots["ankurbot_1"].stuck = True
    begun = cell.now
    cell.run(lambda: any("has not moved for 10 s" in line for line in cell.said), 12.0)
    assert cell.now - begun >= 9.5
    assert "has not moved for 10 s" in cell.status.tasks[0].reason
    cell.robots["ankurbot_1"].stuck = False
    assert outcome_of(cell).outcome == "succeeded"


def test_a_lost_server_stops_every_robot_and_is_named():
    cell = cell_with(targets=[(-1.9, 1.65), (-1.9, -1.65)], arm=False, ankurbot_1=START, ankurbot_2=SECOND)
    boundless(cell)
    cell.run(lambda: moving(cell)() and moving(cell, "ankurbot_2")(), 10.0)
    cell.lose("ankurbot_1")
    cell.run_for(0.2)
    assert cell.robots["ankurbot_2"].goal is None
    assert cell.status.reason == "the action server of ankurbot_1 is lost: every robot is stopped"
    cell.find("ankurbot_1")
    assert outcome_of(cell).outcome == "succeeded"


@pytest.mark.parametrize("outcome", [o for o in Outcome if o is not Outcome.SUCCEEDED])
def test_every_other_end_of_a_step_is_tried_again(outcome):
    cell = cell_with(targets=[(-1.9, 1.65)], arm=False)
    boundless(cell)
    cell.fail_next["ankurbot_1"] = (outcome, "because")
    cell.run(lambda: any(f"{outcome.value} because" in line for line in cell.said), 10.0)
    assert outcome_of(cell).outcome == "succeeded"


def test_debris_that_slips_is_followed():
    cell = cell_with([(-0.12, 0.10)])
    boundless(cell)
    cell.run(moving(cell), 10.0)
    cell.run_for(0.5)
    cell.debris["debris_1"] = (-0.22, -0.15)
    assert outcome_of(cell).outcome == "succeeded"
    assert any("its goal has moved or gone" in line for line in cell.said)
    assert cell.debris == {}


def test_debris_that_vanishes_frees_its_robot():
    cell = cell_with([(-0.12, 0.10)])
    boundless(cell)
    cell.run(moving(cell), 10.0)
    cell.run_for(0.3)
    cell.debris.clear()
    assert outcome_of(cell).outcome == "succeeded"


def test_something_dropped_on_the_path_stops_the_step_and_is_driven_round():
    cell = cell_with(targets=[(-1.9, 1.65)], arm=False)
    boundless(cell)
    cell.run(moving(cell), 10.0)
    target = cell.robots["ankurbot_1"].goal.target
    x, y = (cell.robots["ankurbot_1"].x + target.x) / 2, (cell.robots["ankurbot_1"].y + target.y) / 2
    cell.obstacles["unknown_1"] = box_cells((x - 0.15, y - 0.1, 0.7), (x - 0.05, y + 0.1, 0.95))
    cell.run(lambda: any("unknown_1 is in the way" in line for line in cell.said), 2.0)
    cell.obstacles.clear()
    assert outcome_of(cell).outcome == "succeeded"


def test_an_unreachable_goal_is_named_and_done_when_the_way_is_free():
    cell = cell_with(targets=[(-1.9, 1.65)], arm=False)
    cell.obstacles["unknown_1"] = box_cells((-0.2, 0.6, 0.0), (0.2, 2.5, 1.2))
    cell.obstacles["unknown_2"] = box_cells((-0.2, -2.5, 0.0), (0.2, -0.6, 1.2))
    boundless(cell)
    cell.run_for(4.0)
    assert cell.status.busy
    assert cell.status.tasks[0].status == "unreachable"
    assert "target_1 cannot be reached" in cell.status.reason
    cell.obstacles.clear()
    assert outcome_of(cell).outcome == "succeeded"


def test_a_refused_deletion_is_asked_for_again():
    cell = cell_with([(-0.12, 0.10)])
    cell.deletes = False
    boundless(cell)
    cell.run(lambda: any("was not deleted" in line for line in cell.said), 60.0)
    assert cell.status.busy
    cell.deletes = True
    assert outcome_of(cell).outcome == "succeeded"
    assert cell.debris == {}


def test_what_a_mission_has_reached_is_no_goal_of_the_next_while_the_map_shows_it():
    cell = cell_with([(-0.12, 0.10)], arm=False)
    cell.deletes = False
    boundless(cell)
    cell.run(lambda: any("was not deleted" in line for line in cell.said), 60.0)
    assert [(t.goal, t.status) for t in cell.status.tasks] == [("debris_1", "reached")]
    assert cell.request(previous_state=True).success
    cell.run(cell.idle, 20.0)
    sent = len(cell.sent)
    boundless(cell)
    cell.run_for(0.5)
    assert cell.status.tasks == ()
    assert len(cell.sent) == sent


def test_the_simulator_started_again_leads_through_calibration_back_into_the_mission():
    cell = cell_with([(-0.12, 0.10)])
    boundless(cell)
    cell.run(moving(cell), 10.0)
    cell.restart()
    assert cell.status.state is State.CALIBRATION
    cell.run(lambda: cell.status.state is State.BOUNDLESS, 20.0)
    assert outcome_of(cell).outcome == "succeeded"
    assert cell.debris == {}


def test_a_hold_of_the_safety_monitor_is_the_reason_given():
    cell = cell_with(targets=[(-1.9, 1.65)], arm=False)
    boundless(cell)
    cell.run(moving(cell), 10.0)
    cell._events.append(Hold("ankurbot_1", True, "too near the table"))
    cell.run_for(0.1)
    cell.robots["ankurbot_1"].goal, goal = None, cell.robots["ankurbot_1"].goal
    cell._events.append(preempted(goal))
    cell.run(lambda: any("too near the table" in line for line in cell.said), 2.0)
    cell._events.append(Hold("ankurbot_1", False))
    assert outcome_of(cell).outcome == "succeeded"


def preempted(goal):
    return GoalDone(goal.robot, goal.serial, Outcome.PREEMPTED, "cancelled")


def test_supervision_runs_outside_missions_and_has_hysteresis():
    cell = cell_with()
    arm = cell.arms["hc10_barc"]
    cell.run_for(0.2)
    assert arm.on
    cell.debris["debris_1"] = (arm.tip[0] + 0.20, arm.tip[1])
    cell.run_for(0.2)
    assert not arm.on
    cell.debris["debris_1"] = (arm.tip[0] + 0.42, arm.tip[1])
    cell.run_for(0.2)
    assert not arm.on
    cell.debris["debris_1"] = (arm.tip[0] + 0.60, arm.tip[1])
    cell.run_for(0.2)
    assert arm.on


def test_a_switch_that_fails_is_sent_again():
    cell = cell_with()
    cell.run_for(0.2)
    cell.fail_next["hc10_barc"] = (Outcome.ABORTED, "busy")
    cell.debris["debris_1"] = (-0.25, 0.1)
    cell.run_for(0.2)
    assert cell.arms["hc10_barc"].on
    cell.run_for(1.0)
    assert not cell.arms["hc10_barc"].on


def test_the_same_events_give_the_same_actions():
    def run():
        cell = cell_with([(-0.15, 0.2), (-0.2, -0.2)], ankurbot_1=START, ankurbot_2=SECOND)
        boundless(cell)
        outcome_of(cell)
        return [(round(at, 6), goal) for at, goal in cell.sent]

    assert run() == run()


SECOND_AREA = "SPACE=SWITCH/AREA=30,48,6,21,0,10"


def two_arms(debris=(), params=None):
    """Two manipulators far apart, each with an area of its own, and a robot away from both."""
    cell = FakeCell(params, ankurbot_1=(0.65, 2.0, math.pi))
    cell.arms["hc10_barc"] = FakeArm()
    cell.arms["hc10_barc_2"] = FakeArm(tip=(1.25, -1.10, 0.75), area=SECOND_AREA)
    cell.debris = {f"debris_{i + 1}": at for i, at in enumerate(debris)}
    cell.calibrate()
    return cell


def test_each_manipulator_answers_for_its_own_area():
    known = two_arms().commander.cell
    assert known.answers["hc10_barc"].area == (11, 29, 17, 32, 0, 10)
    assert known.answers["hc10_barc_2"].area == (30, 48, 6, 21, 0, 10)
    areas = known.private_areas()
    assert sorted(areas) == ["hc10_barc", "hc10_barc_2"]
    assert areas["hc10_barc"].sum() == 19 * 16
    assert areas["hc10_barc_2"].sum() == 19 * 16
    assert not (areas["hc10_barc"] & areas["hc10_barc_2"]).any()
    assert (known.private_columns() == (areas["hc10_barc"] | areas["hc10_barc_2"])).all()


def test_debris_near_one_manipulator_pauses_that_one_alone():
    cell = two_arms()
    first, second = cell.arms["hc10_barc"], cell.arms["hc10_barc_2"]
    cell.run(lambda: first.on and second.on, 10.0)
    cell.debris["debris_1"] = (1.20, -1.05)
    cell.run(lambda: not second.on, 5.0)
    cell.run_for(3.0)
    assert first.on
    assert not second.on
    assert [action for _, action in first.told].count("OFF") == 0
    del cell.debris["debris_1"]
    cell.run(lambda: second.on, 5.0)


def test_bounded_keeps_out_of_every_manipulators_area():
    cell = two_arms([(1.25, -1.10)], CommanderParams(give_up_s=5.0))
    assert cell.request(jump_state=4).success
    status = outcome_of(cell)
    assert status.outcome == "failed"
    assert "debris_1 cannot be reached" in status.reason
    assert [goal for _, goal in cell.sent if goal.target is not None] == []


def test_both_manipulators_go_to_storage():
    cell = two_arms()
    assert cell.request(next_state=True).success
    boundless(cell)
    cell.run(cell.idle, 60.0)
    assert cell.request(next_state=True).success
    cell.run(cell.idle, 60.0)
    assert {arm.state for arm in cell.arms.values()} == {SanderState.STORAGE}


def test_a_robot_moved_aside_into_an_area_stays_until_the_other_has_passed():
    """Sent out at once it would stand in the way again, and be moved aside again, for ever."""
    cell = FakeCell(ankurbot_1=(-0.35, 1.05, math.pi), ankurbot_2=(1.9, 1.9, 0.0))
    cell.statics = {
        "table": box_cells((-1.45, 0.50, 0.0), (-0.55, 1.70, 0.70)),
        "hc10_barc_2_table": box_cells((0.55, -1.70, 0.0), (1.45, -0.50, 0.70)),
    }
    cell.arms["hc10_barc"] = FakeArm(tip=(-1.25, 1.40, 0.75), area="SPACE=SWITCH/AREA=1,19,28,43,0,10")
    cell.arms["hc10_barc_2"] = FakeArm(tip=(1.25, -1.40, 0.75), area=SECOND_AREA)
    cell.debris = {"debris_2": (1.15, -1.05)}
    cell.calibrate()
    boundless(cell)
    status = outcome_of(cell)
    assert status.outcome == "succeeded"
    assert len([goal for _, goal in cell.sent if goal.target is not None]) < 12
    assert not any(cell.commander.cell.private_columns()[cell_of(robot)] for robot in cell.robots.values())


def cell_of(robot):
    return SPEC.column_of((robot.x, robot.y))
