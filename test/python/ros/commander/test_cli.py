"""What commander_cli makes of the age of a status."""

from __future__ import annotations

from collections import deque

import pytest
import rospy
from yarm.msg import CommanderStatus

from yarm.commander.states import TABLE, State, Trigger, find
from yarm.ros.commander.cli import FIRST_WORD_S, Session, parser, run_mode
from yarm.ros.common.status_age import LOST_S, STALE_S, silence


def status_of(stamp_s):
    message = CommanderStatus(state_name="BOUNDLESS", busy=True)
    message.header.stamp = rospy.Time.from_sec(stamp_s)
    return message


@pytest.mark.parametrize("age_s", [-0.1, 0.0, 1.0, STALE_S])
def test_a_status_of_the_last_seconds_is_news(age_s):
    assert silence(status_of(100.0), 100.0 + age_s, STALE_S) == ""


def test_an_old_status_names_its_age_and_who_is_silent():
    said = silence(status_of(100.0), 142.5, STALE_S)
    assert said == ("nothing heard from commander for 42.5 s: what commander/status shows is that old; is it running?")
    assert LOST_S > STALE_S


def test_status_does_not_wait_for_minutes():
    assert parser().parse_args(["status"]).timeout == FIRST_WORD_S
    assert parser().parse_args(["run"]).timeout > FIRST_WORD_S


class Lagging(Session):
    """A Commander whose status of before the request is still on its way when the answer has come."""

    def __init__(self):
        self._status = CommanderStatus(state=State.IDLE)
        self.asked, self.coming = [], deque()

    def ask(self, quiet=False, **fields):
        del quiet
        ((trigger, value),) = fields.items()
        row = find(TABLE, State(self._status.state), Trigger(trigger), int(value))
        assert row is not None and len(self.asked) < 4, (self._status, fields)
        self.asked.append(trigger)
        self._status = CommanderStatus(state=self._status.state, outcome=self._status.outcome)
        self.coming.append(CommanderStatus(state=row.target, busy=True))
        self.coming.append(CommanderStatus(state=row.target, outcome="succeeded"))

    def status(self):
        return self._status

    def _wait(self, ready, what):
        while not ready():
            assert self.coming, f"nothing comes any more: {what}"
            self._status = self.coming.popleft()


def test_a_status_of_before_the_request_is_not_taken_for_its_outcome():
    session = Lagging()
    assert run_mode(session, State.BOUNDLESS, [], True) == 0
    assert session.asked == ["current_state", "next_state", "next_state", "jump_state"]
    assert session.status().state == State.BOUNDLESS
