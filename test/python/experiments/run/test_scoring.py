"""Scoring: what makes a run a success, and that each single fault makes it none."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Callable

import pytest

from python.experiments.run_samples import SPEC, START_S, TOUCH, drive, good_run, plan_sample
from yarm.commander.params import Removal
from yarm.experiments.run.cases import Case
from yarm.experiments.run.record import RunInfo, RunRecord
from yarm.experiments.run.recorder import ContactSample, Recorder, TaskSample

CASE = Case("made_up", "for tests", min_pauses=1)
DONE = RunInfo("made_up", 1, "boundless", outcome="succeeded", sim_s=12.0)


def scored(recorder: Recorder, info: RunInfo = DONE, case: Case = CASE) -> RunRecord:
    return recorder.finish(info, case, arrival_limit_m=0.12)


def test_a_clean_run_is_a_success() -> None:
    record = scored(good_run())
    assert record.success, record.faults
    (robot,) = record.robots
    assert robot.goals == ("debris_1",)
    assert robot.time_s == pytest.approx(10.0)
    assert robot.waypoints == 10
    assert robot.path_m == pytest.approx(math.hypot(0.85, 1.65))
    assert (robot.plans, robot.replans) == (11, 0)
    assert robot.planning_p50_ms == pytest.approx(7.0)
    assert (robot.min_clearance_m, robot.nearest) == (0.12, "table")
    assert [(p.start_s, p.end_s) for p in record.pauses] == [(6.0, 9.0)]


def test_every_pose_is_kept_with_its_robot_and_cell() -> None:
    recorder = good_run()
    drive(recorder, "ankurbot_2", "debris_2", (0.0, 1.0), (1.0, 1.0))
    rows = scored(recorder).path
    assert [row.robot for row in rows] == ["ankurbot_1"] * 11 + ["ankurbot_2"] * 11
    last = rows[-1]
    assert (last.time_s, last.x_m, last.y_m, last.yaw_rad) == (10.0, 1.0, 1.0, math.pi)
    assert (last.column_x, last.column_y) == pytest.approx((35.0, 35.0))


def test_debris_that_goes_to_a_bin_must_lie_in_one_at_the_end() -> None:
    to_bin = replace(DONE, removal="bin")
    recorder = good_run()
    recorder.in_bins({"debris_1": "bin_1"})
    recorder.in_bins({"debris_1": ""})
    record = scored(recorder, to_bin)
    assert record.faults == ("debris_1 was declared done by ankurbot_1 and lies in no bin",)
    assert [(goal.reached, goal.bin) for goal in record.goals] == [(False, "")]
    recorder.in_bins({"debris_1": "bin_1"})
    record = scored(recorder, to_bin)
    assert record.success, record.faults
    assert [(goal.reached, goal.bin) for goal in record.goals] == [(True, "bin_1")]


def test_a_piece_that_a_hand_has_lost_is_a_fault_where_none_may_be_lost() -> None:
    to_bin = replace(DONE, removal="bin")
    recorder = good_run()
    recorder.in_bins({"debris_1": "bin_1"}, 2)
    assert scored(recorder, to_bin).success
    assert scored(recorder, to_bin, replace(CASE, holds=True)).faults == (
        "hands lost a piece 2 times on the way, none may be lost",
    )
    recorder.in_bins({"debris_1": "bin_1"}, 0)
    assert scored(recorder, to_bin, replace(CASE, holds=True)).success


def test_a_target_is_reached_by_the_robot_whatever_becomes_of_debris() -> None:
    recorder = good_run()
    recorder.in_bins({"debris_1": "bin_1"})
    recorder.goal_pose("target_1", 1.0, 1.0)
    recorder.tasks(START_S + 11.0, [TaskSample("ankurbot_1", "target_1", "Target", "reached")])
    faults = scored(recorder, replace(DONE, removal="bin")).faults
    assert len(faults) == 1
    assert faults[0].startswith("target_1 was declared reached while ankurbot_1 stood 1.")


def touch(recorder: Recorder) -> None:
    recorder.contacts(START_S + 3.0, [TOUCH])


def touch_foreign_debris(recorder: Recorder) -> None:
    recorder.goal_pose("debris_2", 0.0, 0.0)
    recorder.contacts(START_S + 3.0, [ContactSample("debris_2", "handle", "ankurbot_1", "ee", 0.001, "allowed")])


def declare_elsewhere(recorder: Recorder) -> None:
    recorder.goal_pose("debris_2", 1.0, 1.0)
    recorder.tasks(START_S + 11.0, [TaskSample("ankurbot_1", "debris_2", "Debris", "reached")])


def leave_undone(recorder: Recorder) -> None:
    recorder.tasks(START_S, [TaskSample("", "debris_2", "Debris", "unreachable", "no way to column (12, 4)")])


@pytest.mark.parametrize(
    ("spoil", "fault"),
    [
        (touch, r"ankurbot_1 \(arm\) touched table \(table\) at 3.0 s, 2.0 mm deep"),
        (touch_foreign_debris, r"ankurbot_1 \(ee\) touched debris_2"),
        (declare_elsewhere, r"debris_2 was declared reached while ankurbot_1 stood 1\.\d\d m away \(limit 0.12 m\)"),
        (leave_undone, r"debris_2 was not reached \(unreachable\): no way to column \(12, 4\)"),
    ],
)
def test_each_fault_alone_spoils_the_run(spoil: Callable[[Recorder], None], fault: str) -> None:
    recorder = good_run()
    spoil(recorder)
    record = scored(recorder)
    assert not record.success
    assert len(record.faults) == 1
    with pytest.raises(AssertionError, match=fault):
        raise AssertionError(record.faults[0])


def test_touching_ones_own_goal_is_allowed() -> None:
    recorder = good_run()
    recorder.contacts(START_S + 9.9, [ContactSample("ankurbot_1", "ee", "debris_1", "handle", 0.001, "allowed")])
    assert scored(recorder).success


def test_a_mission_that_did_not_succeed_is_a_fault_with_its_reason() -> None:
    record = scored(good_run(), RunInfo("made_up", 1, "boundless", outcome="failed", reason="stale metadata"))
    assert record.faults == ("the Commander's mission ended 'failed': stale metadata",)
    assert "ended 'never'" in scored(good_run(), RunInfo("made_up", 1, "boundless")).faults[0]


def test_a_mission_without_goals_is_no_success() -> None:
    assert scored(Recorder(SPEC, ["ankurbot_1"], START_S), case=Case("x", "")).faults == (
        "no goal was ever seen by the Commander",
    )


def test_expected_pauses_and_replans_must_happen() -> None:
    recorder = Recorder(SPEC, ["ankurbot_1"], START_S)
    drive(recorder, "ankurbot_1", "debris_1", (0.7, 1.9), (-0.15, 0.25))
    record = scored(recorder, case=Case("x", "", min_pauses=1, min_replans=2))
    assert record.faults == (
        "the manipulator paused 0 times, 1 expected",
        "paths changed 0 times under way, 2 expected",
    )


def test_where_everybody_has_something_to_reach_a_robot_that_reached_nothing_is_a_fault() -> None:
    recorder = Recorder(SPEC, ["ankurbot_1", "ankurbot_2"], START_S)
    drive(recorder, "ankurbot_1", "debris_1", (0.7, 1.9), (-0.15, 0.25))
    assert scored(recorder, case=Case("x", "")).success
    record = scored(recorder, case=Case("x", "", everybody=True))
    assert record.faults == ("ankurbot_2 reached nothing: in this case every robot has something to reach",)


def test_to_a_bin_one_robot_may_bring_everything_in_a_layout_that_a_seed_draws() -> None:
    case = Case("x", "", min_pauses=1, min_replans=1, everybody=True)
    assert case.for_layout(True, Removal.BIN) == case
    assert case.for_layout(False, Removal.DELETE) == case
    assert case.for_layout(False, Removal.BIN) == Case("x", "", min_pauses=1)
    assert case.for_layout(True, Removal.DELETE, sands_elsewhere=True).min_pauses == 0


def test_a_changed_path_is_a_replan_and_the_rest_of_the_old_one_is_not() -> None:
    recorder = Recorder(SPEC, ["ankurbot_1"], START_S)
    for path in [((1, 1), (5, 5), (9, 9)), ((5, 5), (9, 9)), ((5, 5), (7, 9), (9, 9)), ((9, 9),)]:
        recorder.plan(START_S, plan_sample("ankurbot_1", "debris_1", path))
    recorder.plan(START_S, plan_sample("ankurbot_1", "debris_2", ((9, 9), (3, 3))))
    assert scored(recorder).robots[0].replans == 1


def test_contacts_are_tallied_by_pair_with_the_deepest_kept() -> None:
    recorder = good_run()
    for depth in (0.001, 0.004, 0.002):
        recorder.contacts(START_S + 1.0, [ContactSample("table", "table", "ankurbot_1", "arm", depth, "failure")])
    tally = scored(recorder).contacts[0]
    assert (tally.pair, tally.links, tally.messages) == (("ankurbot_1", "table"), ("arm", "table"), 3)
    assert tally.depth_m == pytest.approx(0.004)


def test_a_pause_told_twice_is_one_pause() -> None:
    recorder = Recorder(SPEC, [], START_S)
    for now, moving in [(1.0, True), (2.0, False), (3.0, False), (4.0, True), (5.0, True), (6.0, False)]:
        recorder.manipulator(START_S + now, "hc10_barc", moving)
    spans = [(p.start_s, p.end_s) for p in recorder.pauses]
    assert spans[0] == (2.0, 4.0)
    assert spans[1][0] == 6.0
    assert math.isnan(spans[1][1])
