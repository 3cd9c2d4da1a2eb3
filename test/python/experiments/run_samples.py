"""A made-up run for the tests of scoring, writers and plots."""

from __future__ import annotations

import math
from typing import Tuple

from yarm.experiments.run.recorder import ContactSample, PlanSample, Recorder, TaskSample
from yarm.experiments.run.squares import PartSquares
from yarm.geometry import GridSpec
from yarm.robots.hc10 import Station

SPEC = GridSpec()
START_S = 100.0
TOUCH = ContactSample("ankurbot_1", "arm", "table", "table", 0.002, "failure")


LEDGER = (
    (0.0, "state", "", "", "BOUNDLESS"),
    (0.1, "seen", "", "debris_1", "cameras 1, 3; its top at (-0.150, 0.250, 0.770) m, 42 points"),
    (0.1, "assign", "ankurbot_1", "debris_1", "31.0 cells of way; ankurbot_2 45.2"),
    *((float(k), "send", "ankurbot_1", "debris_1", f"False to ({k}, 0) m, 180.00 deg; safe") for k in range(1, 11)),
    (5.9, "switch", "hc10_barc", "", "OFF; ankurbot_1 at 0.21 m"),
    (8.9, "switch", "hc10_barc", "", "ON; nothing near"),
    (10.0, "reached", "ankurbot_1", "debris_1", ""),
    (10.0, "delete", "", "debris_1", ""),
    (12.0, "end", "", "", "succeeded"),
)
"""A ledger of that: s since the beginning, kind, robot, goal, text."""


def plan_sample(robot: str, goal: str, path: Tuple[Tuple[int, int], ...], planning_ms: float = 3.0) -> PlanSample:
    """A solved planning step of one robot along a path of columns."""
    return PlanSample(robot, goal, "SOLVED", planning_ms, planning_ms, 0.5, float(len(path)), True, 333, path)


def drive(recorder: Recorder, robot: str, goal: str, from_xy: Tuple[float, float], to_xy: Tuple[float, float]) -> float:
    """Drive a robot straight to its goal in 10 waypoints and declare it reached; the time it ends, s."""
    now = START_S
    recorder.goal_pose(goal, *to_xy)
    recorder.tasks(now, [TaskSample(robot, goal, "Debris", "assigned")])
    columns = []
    for k in range(11):
        xy = tuple(a + (b - a) * k / 10 for a, b in zip(from_xy, to_xy))
        columns.append(SPEC.column_of(xy))
    for k in range(11):
        x, y = (a + (b - a) * k / 10 for a, b in zip(from_xy, to_xy))
        now = START_S + k
        recorder.plan(now, plan_sample(robot, goal, tuple(columns[k:]), 2.0 + k))
        if k:
            recorder.waypoint(now, robot, x, y, math.pi)
        recorder.pose(now, robot, x, y, math.pi)
    recorder.tasks(now, [TaskSample(robot, goal, "Debris", "reached")])
    return now


def good_run() -> Recorder:
    """One robot at its debris, one pause of the manipulator, nothing touched."""
    recorder = Recorder(SPEC, ["ankurbot_1"], START_S)
    drive(recorder, "ankurbot_1", "debris_1", (0.7, 1.9), (-0.15, 0.25))
    for number, (at_s, *entry) in enumerate(LEDGER, start=1):
        recorder.decision(START_S + at_s, number, *entry)
    recorder.follow_parts([PartSquares("hc10_barc", Station())])
    recorder.sander("hc10_barc", "scan to path", 0.5)
    for k in range(21):
        recorder.tool(START_S + 3.0 + 0.1 * k, "hc10_barc", (-0.43, -0.28 + 0.01 * k, 0.851), (0.0, 0.0, -1.0))
    recorder.manipulator(START_S + 6.0, "hc10_barc", False)
    recorder.manipulator(START_S + 9.0, "hc10_barc", True)
    recorder.clearance(START_S + 3.0, "ankurbot_1", "table", 0.12)
    recorder.clearance(START_S + 3.0, "ankurbot_1", "debris_1", 0.01)
    recorder.contacts(START_S + 2.0, [ContactSample("floor", "floor", "ankurbot_1", "wheel_fl", 0.0001, "allowed")])
    return recorder
