"""The soak's random debris, and that each thing that must hold can fail."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from python.experiments.run_samples import SPEC, START_S, good_run
from yarm.experiments.run.cases import CASES, Case
from yarm.experiments.run.record import NodeUsage, RunInfo
from yarm.experiments.run.recorder import Recorder, TaskSample
from yarm.experiments.run.soak import PART_X_M, PART_Y_M, MissionRow, drops, judge_soak, soak_line

ROW = MissionRow(0, 0.0, 20.0, "debris_0000_1", 1, 0, 0, 600.0)
NODE = NodeUsage("perception", 0.1, 3.0, 60.0, 104.0, 100.0)


def test_debris_falls_on_the_part_far_enough_apart() -> None:
    rng = np.random.default_rng(3)
    seen = [drops(mission, rng) for mission in range(200)]
    assert {len(found) for found in seen} == {1, 2}
    for found in seen:
        for drop in found:
            assert PART_X_M[0] <= drop.x_m <= PART_X_M[1]
            assert PART_Y_M[0] <= drop.y_m <= PART_Y_M[1]
        if len(found) == 2:
            assert math.hypot(found[0].x_m - found[1].x_m, found[0].y_m - found[1].y_m) >= 0.30
    assert len({drop.name for found in seen for drop in found}) == sum(len(found) for found in seen)
    assert drops(5, np.random.default_rng(9)) == drops(5, np.random.default_rng(9))


@pytest.mark.parametrize(
    ("usage", "lost", "rows", "fault"),
    [
        ([NODE], [], [ROW], ""),
        (
            [replace(NODE, memory_end_mb=150.0)],
            [],
            [ROW],
            "perception has grown by 50 MB in the second half of the soak (limit 30 MB)",
        ),
        ([replace(NODE, node="run_experiment", memory_end_mb=150.0)], [], [ROW], ""),
        ([NODE], ["commander"], [ROW], "commander has ended or was started again"),
        ([NODE], [], [], "no mission was run"),
    ],
)
def test_a_soak_is_judged(usage: list, lost: list, rows: list, fault: str) -> None:
    assert judge_soak(usage, lost, rows, 30.0) == ((fault,) if fault else ())


def test_a_refused_goal_is_no_fault_in_a_soak_and_one_in_a_mission() -> None:
    recorder: Recorder = good_run()
    recorder.tasks(START_S, [TaskSample("", "debris_2", "Debris", "unreachable", "no way to column (12, 4)")])
    info = RunInfo("soak", 1, "boundless", "succeeded")
    assert recorder.finish(info, CASES["soak"], 0.12).success
    assert not recorder.finish(info, Case("x", ""), 0.12).success
    recorder.tasks(START_S, [TaskSample("", "debris_3", "Debris", "waiting")])
    assert not recorder.finish(info, CASES["soak"], 0.12).success
    assert SPEC.shape == (50, 50, 20)


def test_the_line_on_a_soak_adds_up() -> None:
    rows = [ROW, replace(ROW, index=1, end_s=45.0, refused=1)]
    assert soak_line(rows) == "soak: 2 missions in 45 s; 2 debris reached, 1 refused, 0 failure contacts"
    assert soak_line([]) == "soak: no mission"
