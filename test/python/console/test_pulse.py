"""Rates and ages of what nodes say."""

from __future__ import annotations

import pytest

from yarm.console.pulse import MOST, WINDOW_S, Pulse


def heard(pulse, count, rate_hz, age_s=0.05, topic="t", node="n", begin_s=100.0):
    for i in range(count):
        now_s = begin_s + i / rate_hz
        pulse.note(node, topic, now_s, None if age_s is None else now_s - age_s)
    return begin_s + count / rate_hz


@pytest.mark.parametrize("count", [90, 600, 3 * MOST])
def test_a_steady_topic_has_its_rate_and_age(count):
    pulse = Pulse()
    beat = pulse.beats(heard(pulse, count, 30.0))["n"]
    assert beat.rate_hz == pytest.approx(30.0, rel=0.02)
    assert (beat.topic, beat.p50_ms, beat.p99_ms) == ("t", 50.0, 50.0)


def test_one_that_is_seldom_late_shows_it_in_its_99th_percentile():
    pulse = Pulse()
    for i in range(200):
        pulse.note("n", "t", 100.0 + 0.05 * i, 100.0 + 0.05 * i - (0.4 if i % 20 == 0 else 0.02))
    beat = pulse.beats(110.0)["n"]
    assert (beat.p50_ms, beat.p99_ms) == (20.0, 400.0)


def test_of_a_node_its_most_frequent_topic_is_shown():
    pulse = Pulse()
    heard(pulse, 100, 10.0, topic="slow")
    beat = pulse.beats(heard(pulse, 600, 60.0, None, "fast"))["n"]
    assert (beat.topic, beat.p50_ms, beat.p99_ms) == ("fast", None, None)


def test_who_has_been_silent_for_long_has_no_figures():
    pulse = Pulse()
    end_s = heard(pulse, 100, 10.0)
    assert set(pulse.beats(end_s)) == {"n"}
    assert pulse.beats(end_s + WINDOW_S + 1.0) == {}


def test_one_message_is_no_high_rate():
    pulse = Pulse()
    pulse.note("n", "t", 5.0, None)
    assert pulse.beats(5.0)["n"].rate_hz == 1.0


def test_time_that_goes_back_begins_anew():
    pulse = Pulse()
    heard(pulse, 100, 10.0)
    pulse.note("n", "t", 1.0, 0.9)
    assert pulse.beats(1.0)["n"].rate_hz == 1.0
