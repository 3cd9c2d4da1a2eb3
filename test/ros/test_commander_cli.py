"""The command line of the Commander: which status is the answer to a request."""

from __future__ import annotations

import threading

import pytest
import rospy
from yarm.msg import CommanderStatus
from yarm.srv import StateChangeResponse

from yarm.ros.commander import cli

LATER_S = 0.3


def said(stamp_s: float, entered_s: float, state: int = CommanderStatus.BOUNDLESS, **fields: object) -> CommanderStatus:
    """A status of a time, in a state since another."""
    message = CommanderStatus(state=state, elapsed_s=stamp_s - entered_s, **fields)
    message.header.stamp = rospy.Time.from_sec(stamp_s)
    return message


@pytest.fixture(name="session")
def session_fixture(monkeypatch) -> cli.Session:
    """One that hears what the test tells it, at 20 s."""
    monkeypatch.setattr(cli.rospy, "Subscriber", lambda *_, **__: None)
    monkeypatch.setattr(cli.rospy, "ServiceProxy", lambda *_: None)
    monkeypatch.setattr(cli.rospy, "wait_for_service", lambda *_, **__: None)
    monkeypatch.setattr(cli.rospy, "get_time", lambda: 20.0)
    monkeypatch.setattr(cli.rospy, "is_shutdown", lambda: False)
    return cli.Session(10.0)


def test_a_status_sent_before_the_request_is_not_its_answer(session):
    session._on_status(said(19.0, 10.0, outcome="succeeded"))

    def serve(_):
        session._on_status(said(20.0, 10.0, outcome="succeeded"))  # it was under way when the request came
        threading.Timer(LATER_S, session._on_status, [said(20.02, 20.02, busy=True)]).start()
        return StateChangeResponse(True, "state 5 BOUNDLESS entered")

    session._service = serve
    session.ask(current_state=True)
    assert session.status().busy


@pytest.mark.parametrize(
    ("status", "new"),
    [
        (said(20.0, 10.0), False),
        (said(20.0, 19.5), True),
        (said(20.0, 10.0, CommanderStatus.MENU), True),
    ],
)
def test_a_state_entered_again_is_told_by_when(status, new):
    assert cli.entered_since(status, said(19.0, 10.0)) is new


def test_a_refusal_ends_the_command_with_its_code(session):
    session._on_status(said(19.0, 10.0))
    session._service = lambda _: StateChangeResponse(False, "refused: busy")
    with pytest.raises(cli.CliError, match="refused: busy") as error:
        session.ask(current_state=True)
    assert error.value.code == cli.REFUSED
