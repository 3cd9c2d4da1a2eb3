"""What the recorder keeps of a mission: times from its beginning, ways, clearances, pauses, kinds of contact."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Sequence, Tuple

import pytest

from python.experiments.run_samples import SPEC, START_S, TOUCH, plan_sample
from yarm.control.sander.states import SanderState
from yarm.experiments.run.cases import Case, case_of, expected_goals
from yarm.experiments.run.record import NodeUsage, PathRow, RunInfo, RunRecord
from yarm.experiments.run.recorder import ContactSample, Recorder, TaskSample
from yarm.experiments.run.squares import parts_of
from yarm.experiments.run.track import Track
from yarm.geometry.kinds import ContactKind
from yarm.sim.scenes.scene import load_scene

DONE = RunInfo("x", 1, "boundless", "succeeded")


@pytest.fixture(name="recorder")
def recorder_fixture() -> Recorder:
    return Recorder(SPEC, ["ankurbot_1"], START_S, path_period_s=0.1)


def finished(recorder: Recorder, usage: Sequence[NodeUsage] = ()) -> RunRecord:
    return recorder.finish(DONE, Case("x", "made up"), 0.12, usage)


def test_poses_are_thinned_to_the_period_and_the_way_is_that_of_the_kept_ones(recorder: Recorder) -> None:
    for k in range(101):
        recorder.pose(START_S + 0.01 * k, "ankurbot_1", 0.01 * k, 0.0, 0.0)
    record = finished(recorder)
    times = [row.time_s for row in record.path]
    assert times == pytest.approx([0.1 * k for k in range(11)])
    assert record.robots[0].path_m == pytest.approx(1.0)


def test_positions_are_kept_in_cells_too(recorder: Recorder) -> None:
    recorder.pose(START_S, "ankurbot_1", -2.5, 2.5, 0.4)
    (row,) = finished(recorder).path
    assert (row.column_x, row.column_y, row.yaw_rad) == pytest.approx((0.0, 50.0, 0.4))


def test_a_robot_that_comes_late_is_recorded_too(recorder: Recorder) -> None:
    recorder.pose(START_S + 1.0, "ankurbot_2", 0.0, 0.0, 0.0)
    recorder.waypoint(START_S + 2.0, "ankurbot_2", 0.25, -0.05, 0.0)
    record = finished(recorder)
    assert [robot.name for robot in record.robots] == ["ankurbot_1", "ankurbot_2"]
    assert (record.waypoints[0].column_x, record.waypoints[0].column_y) == SPEC.column_of((0.25, -0.05))


def test_waypoints_are_counted_and_belong_to_the_goal_planned_for(recorder: Recorder) -> None:
    recorder.waypoint(START_S, "ankurbot_1", 0.0, 0.0, 0.0)
    recorder.plan(START_S + 1.0, plan_sample("ankurbot_1", "debris_1", ((1, 1), (2, 2))))
    recorder.waypoint(START_S + 1.0, "ankurbot_1", 0.1, 0.0, 0.0)
    assert recorder.waypoints_sent == 2
    rows = finished(recorder).waypoints
    assert [(row.index, row.goal) for row in rows] == [(0, ""), (1, "debris_1")]


def test_it_does_not_matter_whether_the_plan_or_its_waypoint_is_heard_of_first() -> None:
    rows = []
    for plan_first in (True, False):
        recorder = Recorder(SPEC, ["ankurbot_1"], START_S)
        for k, goal in enumerate(("debris_1", "debris_2")):
            now_s, plan = START_S + 1.0 + k, plan_sample("ankurbot_1", goal, ((1, 1), (2, 2)))
            if plan_first:
                recorder.plan(now_s, plan)
            recorder.waypoint(now_s, "ankurbot_1", 0.1 * k, 0.0, 0.0)
            if not plan_first:
                recorder.plan(now_s, plan)
        record = finished(recorder)
        rows.append((record.waypoints, record.timing))
    assert rows[0] == rows[1]
    assert [row.goal for row in rows[0][0]] == ["debris_1", "debris_2"]
    assert [row.waypoint for row in rows[0][1]] == [0, 1]


@pytest.mark.parametrize(
    ("second", "replans"),
    [
        (((2, 2), (3, 3)), 0),  # what was left of it
        (((1, 1), (2, 2), (3, 3)), 0),  # the same again
        (((3, 3),), 0),  # there
        (((2, 2), (4, 4)), 1),
        (((1, 1), (3, 3)), 1),
    ],
)
def test_a_replan_is_a_path_that_is_not_the_rest_of_the_one_before(
    recorder: Recorder, second: Sequence, replans: int
) -> None:
    recorder.plan(START_S, plan_sample("ankurbot_1", "debris_1", ((1, 1), (2, 2), (3, 3))))
    recorder.plan(START_S + 1.0, plan_sample("ankurbot_1", "debris_1", tuple(second)))
    assert finished(recorder).robots[0].replans == replans


def test_a_path_to_another_goal_is_no_replan(recorder: Recorder) -> None:
    recorder.plan(START_S, plan_sample("ankurbot_1", "debris_1", ((1, 1), (2, 2))))
    recorder.plan(START_S + 1.0, plan_sample("ankurbot_1", "debris_2", ((5, 5), (6, 6))))
    assert finished(recorder).robots[0].replans == 0


def test_the_least_clearance_is_kept_and_the_own_goal_does_not_count(recorder: Recorder) -> None:
    recorder.clearance(START_S + 1.0, "ankurbot_1", "table", 0.3)
    recorder.clearance(START_S + 1.0, "ankurbot_1", "stand", 0.2)
    recorder.clearance(START_S + 1.0, "ankurbot_1", "table", 0.25)
    recorder.tasks(START_S, [TaskSample("ankurbot_1", "debris_1", "Debris", "assigned")])
    recorder.clearance(START_S + 1.0, "ankurbot_1", "debris_1", 0.0)
    recorder.clearance(START_S + 1.0, "somebody", "table", 0.0)
    robot = finished(recorder).robots[0]
    assert (robot.min_clearance_m, robot.nearest) == (0.2, "stand")


def test_touching_a_goal_of_somebody_else_is_a_failure_whatever_the_simulator_says(recorder: Recorder) -> None:
    touch = ContactSample("debris_1", "base_link", "ankurbot_1", "ee", 0.001, "allowed")
    recorder.tasks(START_S, [TaskSample("ankurbot_2", "debris_1", "Debris", "assigned")])
    recorder.contacts(START_S + 1.0, [touch])
    assert recorder.failures == 1
    assert any("ankurbot_1 (ee) touched debris_1" in fault for fault in finished(recorder).faults)


def test_contacts_of_before_the_mission_are_kept_and_its_ways_are_not(recorder: Recorder) -> None:
    recorder.pose(START_S - 5.0, "ankurbot_1", 1.0, 1.0, 0.0)
    recorder.waypoint(START_S - 4.0, "ankurbot_1", 1.0, 1.0, 0.0)
    recorder.contacts(START_S - 3.0, [TOUCH])
    recorder.begin(START_S + 10.0)
    record = finished(recorder)
    assert record.waypoints == () and record.robots[0].path_m == 0.0
    assert [tally.first_s for tally in record.contacts] == pytest.approx([-13.0])
    (row,) = record.path
    assert (row.time_s, row.x_m) == (0.0, 1.0)  # where it stands when the mission begins


def test_a_pause_that_never_ends_has_no_end(recorder: Recorder) -> None:
    recorder.manipulator(START_S + 1.0, "hc10_barc", True)
    recorder.manipulator(START_S + 2.0, "hc10_barc", False)
    recorder.manipulator(START_S + 3.0, "hc10_barc", False)
    recorder.manipulator(START_S + 4.0, "hc10_two", False)
    recorder.manipulator(START_S + 5.0, "hc10_two", True)
    pauses = {pause.manipulator: pause for pause in recorder.pauses}
    assert len(recorder.pauses) == 2
    assert pauses["hc10_barc"].start_s == 2.0 and math.isnan(pauses["hc10_barc"].end_s)
    assert (pauses["hc10_two"].start_s, pauses["hc10_two"].end_s) == (4.0, 5.0)


def test_only_the_first_declaration_of_a_goal_counts(recorder: Recorder) -> None:
    recorder.goal_pose("debris_1", 0.0, 0.0)
    recorder.pose(START_S + 2.9, "ankurbot_1", 0.05, 0.0, 0.0)
    recorder.tasks(START_S + 3.0, [TaskSample("ankurbot_1", "debris_1", "Debris", "reached")])
    recorder.pose(START_S + 5.0, "ankurbot_1", 2.0, 0.0, 0.0)
    recorder.tasks(START_S + 6.0, [TaskSample("", "debris_1", "Debris", "failed", "gone")])
    (goal,) = finished(recorder).goals
    assert (goal.robot, goal.declared_s, goal.reached, goal.status) == ("ankurbot_1", 3.0, True, "reached")
    assert goal.distance_m == pytest.approx(0.05)


def test_a_place_to_wait_is_no_goal(recorder: Recorder) -> None:
    recorder.tasks(START_S, [TaskSample("ankurbot_1", "clear/a", "Clear", "assigned")])
    assert recorder.goals == ()


def test_nodes_are_sorted_by_what_they_cost(recorder: Recorder) -> None:
    usage = [NodeUsage(name, share, 1.0, 10.0, 10.0) for name, share in (("a", 0.1), ("b", 0.9), ("c", 0.3))]
    assert [node.node for node in finished(recorder, usage).usage] == ["b", "c", "a"]


def test_a_track_gives_back_what_it_was_given_in_order() -> None:
    rows = tuple(PathRow(0.1 * k, f"robot_{k % 3}", 1.0 * k, -2.0 * k, 0.01 * k, 3.0 * k, 4.0 * k) for k in range(10))
    track = Track()
    for row in rows:
        track.add(row)
    assert track.rows() == rows
    assert Track().rows() == ()


def test_a_scene_that_is_nobodys_case_makes_no_demands() -> None:
    case = case_of("my_own")
    assert (case.name, case.min_pauses, case.min_replans, case.refusals) == ("my_own", 0, 0, False)


def test_goals_that_events_bring_are_expected_too() -> None:
    assert expected_goals(load_scene("1m1ma")) == {"debris_1"}
    unnamed = Path(__file__).parents[3] / "system" / "mission_unnamed.yaml"
    assert expected_goals(load_scene(str(unnamed))) == {"debris_auto_1", "debris_auto_2"}
    assert expected_goals(load_scene("single")) == {
        thing.name for thing in load_scene("single").things_of("Target")
    } | {thing.name for thing in load_scene("single").things_of("Debris")}


def test_of_a_cell_that_begins_anew_only_contacts_are_kept() -> None:
    scene = load_scene("1m1ma")
    recorder = Recorder(SPEC, ["ankurbot_1"], START_S)
    recorder.follow_parts(parts_of(scene))
    recorder.pose(START_S, "ankurbot_1", 1.0, 0.0, 0.0)
    recorder.waypoint(START_S + 1.0, "ankurbot_1", 0.1, 0.0, 0.0)
    recorder.tasks(START_S + 2.0, [TaskSample("ankurbot_1", "debris_1", "Debris", "reached")])
    recorder.sander("hc10_barc", SanderState.SCAN_TO_PATH.words, 0.5)
    recorder.contacts(START_S + 3.0, [TOUCH])
    recorder.begin_again()
    recorder.begin(2.0)
    recorder.pose(3.0, "ankurbot_1", -1.0, 0.0, 0.0)
    record = finished(recorder)
    assert [(row.time_s, row.x_m) for row in record.path] == [(1.0, -1.0)]
    assert (record.waypoints, record.goals, record.robots[0].path_m) == ((), (), 0.0)
    assert "never came to its raster" in record.squares[0].reason
    assert recorder.failures == 1


def test_what_was_done_while_nobody_recorded_counts_as_the_commander_says(recorder: Recorder) -> None:
    """Not so what is declared later, by whoever stands elsewhere."""
    recorder.pose(START_S, "ankurbot_1", 5.0, 0.0, 0.0)
    recorder.resume()
    tasks = [TaskSample("ankurbot_1", "debris_1", "Debris", "reached")]
    recorder.tasks(START_S + 5.0, [*tasks, TaskSample("ankurbot_1", "debris_2", "Debris", "moving")])
    recorder.pose(START_S + 6.0, "ankurbot_1", 5.0, 0.0, 0.0)
    recorder.goal_pose("debris_2", 0.0, 0.0)
    recorder.tasks(START_S + 7.0, [*tasks, TaskSample("ankurbot_1", "debris_2", "Debris", "reached")])
    unseen, seen = finished(recorder).goals
    assert (unseen.reached, math.isnan(unseen.distance_m)) == (True, True)
    assert (seen.reached, seen.distance_m) == (False, 5.0)
    case, gap = Case("x", "made up", min_pauses=1), replace(DONE, unrecorded_s=2.0)
    assert "the manipulator paused 0 times, 1 expected" in recorder.finish(DONE, case, 0.12).faults
    (fault,) = recorder.finish(gap, case, 0.12).faults
    assert "debris_2 was declared reached while ankurbot_1 stood 5.00 m away" in fault


@pytest.mark.parametrize("poses_first", [False, True])
def test_words_and_poses_that_come_late_are_put_together_by_their_stamps(poses_first: bool) -> None:
    """Who stood still for five seconds hears all that was kept for it, topic by topic; of the poses only the last."""
    for heard_from_s, reached, missed_s in ((1.0, True, 0.0), (4.9, True, 4.0), (2.5, False, 0.0)):
        recorder = Recorder(SPEC, ["ankurbot_1"], START_S)
        recorder.goal_pose("debris_1", 0.0, 0.0)
        away_m = 0.0 if reached else 3.0
        early = [(0.1 * k, 0.9) for k in range(10)]
        late = [(0.1 * k, away_m if k <= 25 else 5.0) for k in range(int(10 * heard_from_s), 51)]

        def poses(rows: Sequence[Tuple[float, float]], to: Recorder = recorder) -> None:
            for time_s, x_m in rows:
                to.pose(START_S + time_s, "ankurbot_1", x_m, 0.0, 0.0)

        poses([*early, *((0.1 * k, away_m) for k in range(10, 25) if heard_from_s == 2.5)])
        if poses_first:
            poses(late)
        recorder.tasks(START_S + 2.5, [TaskSample("ankurbot_1", "debris_1", "Debris", "reached")])
        if not poses_first:
            poses(late)
        (goal,) = finished(recorder).goals
        assert goal.reached is reached
        assert recorder.missed_s == pytest.approx(missed_s)


def test_a_touch_that_nobody_recorded_is_told_by_the_simulator(recorder: Recorder) -> None:
    pair = f"{TOUCH.body_a} {TOUCH.body_b}"
    recorder.touched(START_S + 5.0, [pair])
    (told,) = finished(recorder).contacts
    assert (told.kind, told.messages, told.first_s) == (ContactKind.FAILURE, 0, 5.0)
    recorder.contacts(START_S + 4.0, [TOUCH])
    recorder.touched(START_S + 6.0, [pair])
    (told,) = finished(recorder).contacts
    assert (told.messages, told.first_s, told.depth_m) == (1, 4.0, TOUCH.depth_m)
