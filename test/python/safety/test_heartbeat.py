"""The dead-man's switch: who must be heard, how old a word may be, and what cannot keep it closed."""

from __future__ import annotations

import math

import pytest

from yarm.safety.heartbeat import AHEAD_S, DeadMansSwitch


def switch():
    return DeadMansSwitch({"safety_monitor": 0.25, "commander": 0.6})


def heard(now_s):
    found = switch()
    assert found.hear("safety_monitor", now_s, now_s)
    assert found.hear("commander", now_s, now_s)
    return found


def test_nobody_heard_yet_is_named_with_what_to_do():
    assert switch().objection(1.0) == (
        "stands: nothing heard from safety_monitor yet; start safety_monitor, or set guarded to false to move without "
        "anybody watching"
    )


def test_fresh_words_of_all_close_it_and_the_oldest_allowed_opens_it():
    found = heard(1.0)
    assert found.objection(1.25) == ""
    assert "nothing heard from safety_monitor for more than 0.25 s" in found.objection(1.26)
    found.hear("safety_monitor", 1.55, 1.55)
    assert found.objection(1.55) == ""
    assert "nothing heard from commander for more than 0.6 s" in found.objection(1.7)


def test_a_watcher_may_forbid_and_allow_again():
    found = heard(1.0)
    found.hear("commander", 1.0, 1.1, "no new planning_metadata for more than 1 s")
    assert found.objection(1.1) == "stands: commander forbids motion: no new planning_metadata for more than 1 s"
    found.hear("commander", 1.1, 1.1)
    assert found.objection(1.1) == ""


@pytest.mark.parametrize("stamp_s", [1.0 + 2 * AHEAD_S, 1e9, math.inf, math.nan])
def test_a_word_from_the_future_keeps_nothing_closed(stamp_s):
    found = heard(1.0)
    assert not found.hear("commander", stamp_s, 1.0)
    found.hear("safety_monitor", 2.0, 2.0)
    assert "commander" in found.objection(2.0)


def test_an_older_word_does_not_replace_a_newer_one():
    found = heard(1.0)
    found.hear("commander", 0.2, 1.0, "no planning_metadata yet")
    assert found.objection(1.0) == ""


def test_nobody_needed_lets_everything_move_and_a_reset_forgets():
    assert DeadMansSwitch({}).objection(1.0) == ""
    found = heard(1.0)
    found.reset()
    assert "nothing heard" in found.objection(1.0)


def test_a_persons_stop_opens_it_until_its_release_whoever_is_heard():
    found, nobody = heard(1.0), DeadMansSwitch({})
    for each in (found, nobody):
        each.stop("stopped by a person")
        assert each.objection(1.0) == "stands: stopped by a person"
        each.reset()
        assert each.objection(1.0) == "stands: stopped by a person"
        each.stop("")
    assert "nothing heard" in found.objection(1.0)
    assert nobody.objection(1.0) == ""
