"""Which buttons the controls server presses."""

from __future__ import annotations

import pytest

from yarm.control.actions import ArmAction
from yarm.control.base.controller import Outcome
from yarm.control.sander.client import SanderClient
from yarm.control.sander.states import Button, SanderReport, SanderState


def report(state: int, **rest) -> SanderReport:
    return SanderReport(SanderState(state), **rest)


@pytest.mark.parametrize("action", ["DANCE", "", "True", "calibration"])
def test_unknown_actions_are_refused_by_name(action):
    assert repr(action) in SanderClient.refusal(action, report(4))


@pytest.mark.parametrize("state", [0, 1, 2, 3, 5])
@pytest.mark.parametrize("action", ["ON", "OFF"])
def test_switching_is_refused_outside_state_4(action, state):
    assert f"in state {state}" in SanderClient.refusal(action, report(state))


def test_switching_an_unheard_sander_is_refused():
    assert "has not reported" in SanderClient.refusal("ON", None)


@pytest.mark.parametrize("action", ["CALIBRATION", "CLEANUP"])
@pytest.mark.parametrize("state", range(6))
def test_calibration_and_cleanup_are_taken_in_every_state(action, state):
    assert SanderClient.refusal(action, report(state)) == ""


def test_calibration_presses_its_way_to_state_4_stopped():
    client = SanderClient(60.0)
    client.start(ArmAction.CALIBRATE)
    assert client.step(report(0, enabled=True), 0.0).switch is False
    assert client.step(report(0), 0.1).press is Button.ADVANCE
    assert client.step(report(0), 0.2).press is None
    assert client.step(report(1, moving=True), 0.3).press is None
    assert client.step(report(2, moving=True), 5.0).press is None
    assert client.step(report(3), 8.0).press is Button.START
    assert client.step(report(4), 8.1).outcome is Outcome.SUCCEEDED


def test_a_lost_press_is_repeated():
    client = SanderClient(60.0)
    client.start(ArmAction.CALIBRATE)
    pressed = [client.step(report(3), 0.1 * tick).press for tick in range(25)]
    assert pressed.count(Button.START) == 3


def test_a_held_sander_is_set_going_again():
    client = SanderClient(60.0)
    client.start(ArmAction.CALIBRATE)
    assert client.step(report(1, moving=False), 0.0).press is Button.ADVANCE


def test_cleanup_stores_from_teleoperation_and_from_sanding():
    for state in (3, 4):
        client = SanderClient(60.0)
        client.start(ArmAction.CLEANUP)
        assert client.step(report(state, moving=True), 0.0).press is Button.STORE
        assert client.step(report(5, moving=True), 0.1).press is None
        assert client.step(report(0), 3.0).outcome is Outcome.SUCCEEDED


@pytest.mark.parametrize(("action", "wanted"), [("ON", True), ("OFF", False)])
def test_switch_succeeds_once_applied(action, wanted):
    client = SanderClient(60.0)
    client.start(ArmAction(action))
    assert client.step(report(4, enabled=not wanted), 0.0).switch is wanted
    assert client.step(report(4, enabled=wanted), 0.1).outcome is Outcome.SUCCEEDED


def test_switch_aborts_when_the_sander_leaves():
    client = SanderClient(60.0)
    client.start(ArmAction.OFF)
    assert client.step(report(5, enabled=True), 0.0).outcome is Outcome.ABORTED


def test_giving_up_names_state_and_reason():
    client = SanderClient(10.0)
    client.start(ArmAction.CALIBRATE)
    client.step(report(1, moving=True), 0.0)
    ended = client.step(report(1, reason="no path found"), 10.1)
    assert ended.outcome is Outcome.ABORTED
    assert "state 1 (scanning)" in ended.reason and "no path found" in ended.reason


def test_giving_up_on_a_silent_sander():
    client = SanderClient(10.0)
    client.start(ArmAction.CLEANUP)
    client.step(None, 0.0)
    assert "unheard of" in client.step(None, 11.0).reason
