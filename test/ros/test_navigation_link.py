"""The way to move_base by its topics: one goal at a time, its end by name, taken back once."""

from __future__ import annotations

import pytest
import rospy
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from move_base_msgs.msg import MoveBaseActionResult

from yarm.geometry import Pose2
from yarm.inspection.model import Outcome
from yarm.ros.inspection.navigation_link import NavigationLink


class Wire:
    """Stands in for a publisher; keeps what is sent."""

    def __init__(self, topic, *_, **__):
        self.topic, self.sent = topic, []

    def publish(self, message):
        self.sent.append(message)

    def get_num_connections(self):
        return 1


@pytest.fixture
def link(monkeypatch):
    monkeypatch.setattr(rospy, "Publisher", Wire)
    monkeypatch.setattr(rospy, "Subscriber", lambda *_, **__: None)
    monkeypatch.setattr(rospy, "ServiceProxy", lambda *_, **__: None)
    monkeypatch.setattr(rospy, "get_time", lambda: 10.0)
    return NavigationLink("map")


def result(name, status, stamp_s, text=""):
    message = MoveBaseActionResult(status=GoalStatus(goal_id=GoalID(id=name), status=status, text=text))
    message.header.stamp = rospy.Time.from_sec(stamp_s)
    return message


def test_a_goal_is_a_pose_in_the_map_with_a_name_of_its_own(link):
    link.send(Pose2(1.0, 2.0, 0.0), 10.0)
    link.send(Pose2(1.0, 2.0, 0.0), 11.0)
    first, second = link._goal.sent
    assert first.goal.target_pose.header.frame_id == "map" and first.goal.target_pose.pose.position.y == 2.0
    assert first.goal_id.id != second.goal_id.id and first.goal_id.stamp == rospy.Time(10)


def test_its_end_counts_and_that_of_an_older_one_does_not(link):
    link.send(Pose2(1.0, 2.0), 10.0)
    old = link._goal.sent[0].goal_id.id
    link.send(Pose2(3.0, 2.0), 11.0)
    link._on_result(result(old, GoalStatus.PREEMPTED, 11.0))
    assert link.outcome(12.0) == (Outcome.BUSY, "")
    link._on_result(result(link._goal.sent[1].goal_id.id, GoalStatus.ABORTED, 12.0, "no way"))
    assert link.outcome(13.0) == (Outcome.FAILED, "the goal was given up: no way")


def test_it_is_taken_back_once(link):
    link.cancel(10.0)
    assert link._cancel.sent == []
    link.send(Pose2(1.0, 2.0), 10.0)
    link.cancel(11.0)
    link.cancel(12.0)
    assert [message.id for message in link._cancel.sent] == [link._goal.sent[0].goal_id.id]


def test_the_server_lives_while_its_status_comes_and_time_going_back_forgets_it(link):
    assert link.gone(10.0) == "nothing heard of it yet"
    link._on_status(GoalStatusArray())
    assert link.gone(12.0) == "" and link.gone(20.0) == "silent for 10.0 s"
    link.forget()
    assert link.gone(10.0) == "nothing heard of it yet"
