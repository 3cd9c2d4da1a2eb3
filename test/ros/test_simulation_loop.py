"""What both simulations stand on: the queue of jobs, acknowledgements, the pace, the end of a node."""

from __future__ import annotations

import time

import pytest
import rospy
from geometry_msgs.msg import Twist

from yarm.ros.common.acks import step_ack
from yarm.ros.simulation import loop
from yarm.ros.simulation.loop import Jobs, Pace, Stopwatch, missing_acks
from yarm.sim.robots.errors import CommandError


def sent_by(node):
    message = Twist()
    message._connection_header = {"callerid": f"/{node}"}
    return message


def test_jobs_are_done_in_their_order_and_only_by_who_asks():
    jobs, done = Jobs(), []
    for i in range(5):
        jobs.put(lambda i=i: done.append(i))
    assert done == []
    jobs.work_one(0.0 + 1e-3)
    assert done == [0]
    jobs.work_until(0.0)
    assert done == [0, 1, 2, 3, 4]
    jobs.work_one(1e-3)


def test_commands_are_counted_by_sender_refused_ones_too_and_warned_of_once(monkeypatch):
    said = []
    monkeypatch.setattr(rospy, "logwarn", lambda text, *values: said.append(text % values))
    jobs = Jobs()

    def refuse():
        raise CommandError("speed nan m/s")

    for apply in (lambda: "", refuse, refuse, lambda: "9 clamped"):
        jobs.command("base", sent_by("mux"), apply)
    jobs.command("base", sent_by("somebody"), lambda: "")
    jobs.work_until(0.0)
    assert jobs.commands == {"mux": 4, "somebody": 1}
    assert said == ["base: refused: speed nan m/s (said once)", "base: 9 clamped (said once)"]


def test_who_is_missing_is_named(monkeypatch):
    monkeypatch.setattr(rospy, "get_name", lambda: "/rooms/driver")
    jobs = Jobs()
    assert "driver has not acknowledged" in missing_acks(jobs, ("driver",), 5, counted=False)
    jobs.on_ack(step_ack(rospy.Time(0, 5), 2))
    jobs.work_until(0.0)
    assert missing_acks(jobs, ("driver",), 5, counted=False) is None
    assert "driver says it sent 2 commands, 0 have arrived" in missing_acks(jobs, ("driver",), 5, counted=True)
    assert "has not acknowledged" in missing_acks(jobs, ("driver",), 6, counted=False)


def test_the_pace_waits_for_real_time_catches_up_a_little_and_can_be_off(monkeypatch):
    now_s = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now_s[0])
    waited = []
    jobs = Jobs()
    monkeypatch.setattr(jobs, "work_until", waited.append)
    pace = Pace(0.02, 2.0)
    pace.wait(jobs)
    assert waited == pytest.approx([100.01])
    now_s[0] = 110.0
    pace.wait(jobs)
    assert waited[-1] == pytest.approx(110.0 - loop.BACKLOG_S)
    pace.wait(jobs, 1.0)
    assert waited[-1] == pytest.approx(110.0 - loop.BACKLOG_S + 0.02)
    Pace(0.02, 0.0).wait(jobs)
    assert len(waited) == 3


def test_the_stopwatch_shares_out_what_has_passed(monkeypatch):
    now_s = [0.0]
    monkeypatch.setattr(time, "perf_counter", lambda: now_s[0])
    watch = Stopwatch()
    for part, until_s in (("physics", 0.2), ("wait", 0.5), ("physics", 0.6)):
        now_s[0] = until_s
        watch.lap(part)
    wall_s, parts = watch.take(2)
    assert wall_s == pytest.approx(0.6)
    assert parts == pytest.approx({"physics": 150.0, "wait": 150.0})
    assert watch.take(2)[1] == {}
