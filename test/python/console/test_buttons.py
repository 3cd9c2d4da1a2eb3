"""The buttons are the Commander's own table: each leads where it says, and what would be refused says so."""

from __future__ import annotations

import pytest

from yarm.commander.requests import Request, Situation, decide
from yarm.commander.states import TABLE, State
from yarm.console.buttons import REQUESTS, buttons

SITUATIONS = [
    Situation(state, busy, succeeded) for state in State for busy in (False, True) for succeeded in (False, True)
]


@pytest.mark.parametrize("now", SITUATIONS)
def test_each_button_does_what_it_says_or_tells_why_not(now):
    for button in buttons(now):
        verdict = decide(Request(**button.request), now)
        assert verdict.message == button.refusal
        if verdict.transition is not None:
            assert (verdict.transition.target.name, verdict.transition.does) == (button.target, button.does)


@pytest.mark.parametrize("state", State)
def test_every_transition_of_a_state_has_one_button(state):
    wanted = {(row.target.name, row.does) for row in TABLE if row.source is state}
    found = [(button.target, button.does) for button in buttons(Situation(state, succeeded=True))]
    assert len(found) == len(set(found))
    assert set(found) == wanted


def test_a_busy_mission_may_only_be_stopped():
    free = [button.label for button in buttons(Situation(State.BOUNDLESS, busy=True)) if not button.refusal]
    assert free == ["previous_state"]


@pytest.mark.parametrize("now", SITUATIONS)
def test_what_some_request_may_do_now_can_be_pressed(now):
    verdicts = [decide(request, now) for request in REQUESTS]
    allowed = {(row.transition.target.name, row.transition.does) for row in verdicts if not row.message}
    assert {(button.target, button.does) for button in buttons(now) if not button.refusal} == allowed


def test_a_calibration_that_failed_leads_nowhere_but_back():
    now = Situation(State.CALIBRATION, reason="ankurbot_1 does not answer")
    refused = {button.target: button.refusal for button in buttons(now) if button.refusal}
    assert set(refused) == {"MENU", "BOUNDED", "BOUNDLESS"}
    assert all("ankurbot_1 does not answer" in why for why in refused.values())
