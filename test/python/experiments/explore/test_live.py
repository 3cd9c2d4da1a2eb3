"""The record of a run, put together from what is heard of it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from yarm.experiments.explore.live import LiveRecorder
from yarm.exploration.model import LOOP_S, Command, Event
from yarm.exploration.params import ExploreParams
from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap
from yarm.sim.scenes.arena import Arena, Block
from yarm.sim.touches import APART_S

BRICK = Block("brick", "low", Pose2(2.0, 0.0), (0.2, 0.4, 0.1))
WALL = Block("wall", "wall", Pose2(3.0, 0.0), (0.05, 4.0, 0.6))
START = Pose2(1.0, -1.0, math.pi / 2)
ARENA = Arena("t", "custom", 0, (-3.0, -3.0), (4.0, 3.0), (BRICK, WALL), START)
MAP = GridMap(np.zeros((20, 20), np.int8), 0.05, Pose2(0.0, 0.0))


def recorder(watch=lambda t_s, grid: 0.25):
    return LiveRecorder(ARENA, ExploreParams(controller="nearest"), 7, watch, START)


def drive(live, seconds, v=0.2, began_s=0.0):
    """Truth at 50 Hz and passes at 10 Hz of a straight way from the start."""
    for i in range(round(seconds * 50)):
        t_s = began_s + i / 50
        live.truth(t_s, START.compose(Pose2(v * t_s, 0.0)))
        if i % 5 == 0:
            live.passed(t_s, "ahead", Pose2(v * t_s, 0.0), Command(v, 0.0), 2.0)


def test_rows_hold_truth_belief_and_the_speed_between_them():
    live = recorder()
    drive(live, 3.0)
    record = live.finish(3.0, True, "that is all", {})
    assert (record.mode, record.controller, record.seed, record.reason) == ("physics", "nearest", 7, "that is all")
    assert len(record.path) == 30
    row = record.path[20]
    assert (row.true_x, row.true_y) == pytest.approx((1.0, -1.0 + 0.2 * row.t_s))
    assert (row.x, row.y, row.yaw) == pytest.approx((row.true_x, row.true_y, math.pi / 2))
    assert row.speed == pytest.approx(0.2)
    assert record.path[0].speed == 0.0
    assert record.behaviours == {"ahead": pytest.approx(30 * LOOP_S)}


def test_what_comes_before_the_start_or_twice_does_not_count():
    live = recorder()
    live.passed(-0.5, "stand", START, Command(), 1.0)
    drive(live, 1.0)
    live.passed(0.9, "stand", START, Command(), 1.0)
    assert len(live.finish(1.0, False, "", {}).path) == 10


def test_coverage_is_noted_once_a_second_and_at_the_end():
    shares = iter((0.2, 0.7))
    live = recorder(lambda t_s, grid: next(shares))
    live.map(0.0, MAP)
    drive(live, 2.0)
    live.map(2.0, MAP)
    drive(live, 1.55, began_s=2.0)
    record = live.finish(3.5, False, "", {"brick": 1.0})
    assert [row.share for row in record.coverage] == [0.2, 0.2, 0.7, 0.7, 0.7]
    assert record.coverage[0].known_m2 == pytest.approx(1.0)
    assert record.first_seen == {"brick": 1.0}
    assert record.map is MAP


def test_a_contact_that_goes_on_is_one_touch_and_a_later_one_another():
    live = recorder()
    drive(live, 2.0, v=0.1)
    for t_s in (2.0, 2.02, 2.1):
        live.touch(t_s, "brick", 1.0, -0.6)
    live.touch(2.1, "wall", 3.0, 0.0)
    live.touch(2.1 + APART_S + 0.02, "brick", 1.0, -0.6)
    record = live.finish(3.0, False, "", {})
    assert [(t.block, t.low) for t in record.touches] == [("brick", True), ("wall", False), ("brick", True)]
    assert live.bumps == 3
    assert record.touches[0].speed == pytest.approx(0.1)
    assert record.touches[0].bearing_rad == pytest.approx(0.0, abs=0.05)


def test_contacts_that_come_before_or_after_the_poses_around_them_are_the_same_touches():
    def touches(heard_after):
        live = recorder()
        for i in range(100):
            if i == 50 + heard_after:
                live.touch(1.0, "brick", 1.0, -0.6)
            live.truth(i / 50, START.compose(Pose2(0.0 if i < 50 else 0.1 * (i - 50) / 50, 0.0)))
        return live.finish(2.0, False, "", {}).touches

    assert touches(0) == touches(1) == touches(8) and len(touches(0)) == 1


def test_a_contact_before_the_start_is_no_bump():
    live = recorder()
    drive(live, 2.0, v=0.0)
    live.touch(-1.0, "wall", 0.0, 0.0)
    live.touch(-math.inf, "wall", 0.0, 0.0)
    assert live.bumps == 0


def test_events_are_kept_in_order_and_an_empty_run_has_an_empty_record():
    live = recorder()
    events = (Event(0.0, "state"), Event(1.0, "bump"))
    for event in events:
        live.event(event)
    record = live.finish(0.0, False, "the explorer has not started", {})
    assert record.events == events
    assert record.path == ()
    assert record.map is None
