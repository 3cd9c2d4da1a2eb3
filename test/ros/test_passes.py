"""The loop woken by /clock: one pass a period, whole periods in lock-step, what is said again, time that goes back."""

from __future__ import annotations

import pytest
import rospy
from rosgraph_msgs.msg import Clock

from yarm.ros.common.passes import Passes


@pytest.fixture
def wall(monkeypatch):
    """Where nobody simulates: the time that rospy tells, s."""
    told = [0.0]
    monkeypatch.setattr(rospy, "Subscriber", lambda *_, **__: None)
    monkeypatch.setattr(rospy, "get_time", lambda: told[0])
    return told


@pytest.fixture
def passes(wall):
    return Passes(0.1, sync=True)


def tick(passes, now_s):
    passes._on_clock(Clock(rospy.Time(0, round(now_s * 1e9))))


def test_one_pass_a_period_at_whole_periods(passes):
    assert passes.wait(True) is None
    times = []
    for i in range(1, 13):
        tick(passes, 0.05 * i)
        now_s = passes.wait(True)
        times += [] if now_s is None else [now_s]
    assert times == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6])


def test_nothing_begins_before_everybody_is_there(passes):
    tick(passes, 1.0)
    assert passes.wait(False) is None
    assert passes.wait(True) == 1.0


def test_a_moment_said_again_is_answered_again_once_each_time(passes):
    tick(passes, 1.0)
    assert passes.wait(True) == 1.0 and not passes.take_repeated()
    tick(passes, 1.0)
    assert passes.take_repeated() and not passes.take_repeated()
    tick(passes, 1.05)
    assert not passes.take_repeated()


def test_time_that_goes_back_begins_anew(passes):
    tick(passes, 9.0)
    passes.wait(True)
    passes._on_reset()
    tick(passes, 2.0)
    assert passes.take_reset() and not passes.take_reset()
    assert passes.wait(True) == 2.0


def test_without_lock_step_a_pass_has_the_time_it_was_woken_at(wall):
    passes = Passes(0.1, sync=False)
    assert passes.wait(True) is None
    tick(passes, 1.234)
    assert passes.wait(True) == 1.234
    tick(passes, 1.29)
    assert passes.wait(True) is None


def test_where_nobody_simulates_wall_time_counts_and_it_wakes_when_a_pass_is_due(wall):
    passes = Passes(0.1, sync=False)
    wall[0] = 1000.04
    assert passes.wait(True) == 1000.04
    assert passes.wait(True) is None
    assert passes._until_due_s() == pytest.approx(0.06)
    wall[0] = 1000.1
    assert passes.wait(True) == 1000.1


def test_in_lock_step_nothing_begins_without_the_clock(wall, passes):
    wall[0] = 1000.0
    assert passes.wait(True) is None
