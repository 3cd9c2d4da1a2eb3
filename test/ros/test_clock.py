"""Time that goes backwards is noticed once, by whoever asked to be told."""

from __future__ import annotations

import pytest
import rospy
from rosgraph_msgs.msg import Clock

from yarm.params import ParamError
from yarm.ros.common import clock, params
from yarm.ros.sander.params import SanderNodeParams


@pytest.fixture(name="watch")
def watch_fixture(monkeypatch):
    """A watch whose clock the test tells."""
    monkeypatch.setattr(clock.rospy, "Subscriber", lambda topic, kind, callback, **_: callback)
    return clock.ClockWatch()


def tell(watch, *times_s):
    for time_s in times_s:
        watch._on_clock(Clock(rospy.Time.from_sec(time_s)))


def test_a_restart_is_told_once_to_everybody(watch):
    told = []
    watch.on_reset(lambda: told.append("a"))
    watch.on_reset(lambda: told.append("b"))
    tell(watch, 10.0, 11.0, 0.5, 0.6, 0.7)
    assert told == ["a", "b"]
    tell(watch, 0.1)
    assert told == ["a", "b", "a", "b"]


def test_messages_out_of_order_and_leaps_ahead_are_no_restart(watch):
    told = []
    watch.on_reset(lambda: told.append("a"))
    tell(watch, 10.0, 10.05, 10.0, 9.96, 500.0)
    assert told == []


def test_the_first_time_of_all_is_no_restart(watch):
    told = []
    watch.on_reset(lambda: told.append("a"))
    tell(watch, 0.0)
    assert told == []


def test_parameters_come_from_the_nodes_own_names(monkeypatch):
    monkeypatch.setattr(params.rospy, "get_param", lambda name, default: {"scan_every": 2} if name == "~" else default)
    monkeypatch.setattr(params.rospy, "get_name", lambda: "/hc10_state_machine")
    assert params.load_params(SanderNodeParams).scan_every == 2


def test_a_wrong_parameter_is_named_with_the_node(monkeypatch):
    monkeypatch.setattr(params.rospy, "get_param", lambda name, default: {"scan_evry": 2})
    monkeypatch.setattr(params.rospy, "get_name", lambda: "/hc10_state_machine")
    with pytest.raises(ParamError, match=r"/hc10_state_machine: scan_evry: unknown parameter; known: .*scan_every"):
        params.load_params(SanderNodeParams)
