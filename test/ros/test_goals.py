"""The goals of rostests: sent again while nothing may move, and only then."""

from __future__ import annotations

import pytest
import rospy
from actionlib_msgs.msg import GoalStatus
from yarm.msg import MoveRobotGoal

from support import goals
from yarm.safety.heartbeat import DeadMansSwitch

NOT_YET = DeadMansSwitch({"commander": 0.6}).objection(0.0)


class Client:
    """An action client whose goals end in a given order."""

    def __init__(self, *ends):
        self.ends, self.sent, self.text = list(ends), 0, ""

    def send_goal_and_wait(self, *_):
        state, self.text = self.ends[min(self.sent, len(self.ends) - 1)]
        self.sent += 1
        return state

    def get_goal_status_text(self):
        return self.text


@pytest.fixture(name="words", autouse=True)
def words_fixture(monkeypatch):
    """The Commander's words that a test waits for come at once; they are counted."""
    heard = []
    monkeypatch.setattr(rospy, "wait_for_message", lambda topic, *_, **__: heard.append(topic))
    return heard


def test_a_goal_is_sent_again_with_each_word_until_it_is_permitted(words):
    client = Client((GoalStatus.REJECTED, NOT_YET), (GoalStatus.REJECTED, NOT_YET), (GoalStatus.SUCCEEDED, ""))
    assert goals.send_when_permitted(client, MoveRobotGoal(), 30.0) == GoalStatus.SUCCEEDED
    assert (client.sent, len(words)) == (3, 2)


@pytest.mark.parametrize(
    "end", [(GoalStatus.REJECTED, "target must be finite"), (GoalStatus.PREEMPTED, ""), (GoalStatus.ABORTED, NOT_YET)]
)
def test_any_other_end_is_the_end(end, words):
    client = Client(end)
    assert goals.send_when_permitted(client, MoveRobotGoal(), 30.0) == end[0]
    assert (client.sent, words) == (1, [])


def test_waiting_has_a_limit(monkeypatch):
    monkeypatch.setattr(goals, "PERMISSION_LIMIT_S", 0.0)
    with pytest.raises(AssertionError, match="no permission to move within 0 s: stands: nothing heard from commander"):
        goals.send_when_permitted(Client((GoalStatus.REJECTED, NOT_YET)), MoveRobotGoal(), 30.0)
