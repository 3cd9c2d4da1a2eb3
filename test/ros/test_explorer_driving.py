"""What the explorer sends: a command a pass, or goals for move_base, and commands for what is no drive to a goal."""

from __future__ import annotations

import pytest
import rospy

from yarm.exploration.model import Command, Intent
from yarm.exploration.session import SessionStep, State
from yarm.geometry import Pose2
from yarm.ros.common import names
from yarm.ros.exploration.driving import DrivesByMoveBase, DrivesItself


class Wire:
    """Stands in for a publisher; keeps what is sent."""

    heard = 1

    def __init__(self, topic, *_, **__):
        self.topic, self.sent = topic, []

    def publish(self, message):
        self.sent.append(message)

    def get_num_connections(self):
        return self.heard


@pytest.fixture(autouse=True)
def wires(monkeypatch):
    made = {}
    monkeypatch.setattr(rospy, "Publisher", lambda topic, *_, **__: made.setdefault(topic, Wire(topic)))
    monkeypatch.setattr(rospy, "Subscriber", lambda *_, **__: None)
    return made


def passed(command, goal=None, state=State.EXPLORING):
    return SessionStep(command, state, "drive", "", 1.0, 2.0, 3.0, 0, 0.0, (), (), Intent(goal), ())


def test_by_itself_it_commands_at_every_pass(wires):
    driving = DrivesItself()
    assert [driving.drive(passed(Command(v, 0.5)), 1.0) for v in (0.0, 0.2)] == [1, 1]
    assert [(sent.linear.x, sent.angular.z) for sent in wires[names.TELEOP].sent] == [(0.0, 0.5), (0.2, 0.5)]
    assert driving.connected()


def test_a_goal_goes_out_once_by_a_name_of_its_own_and_is_taken_back_by_it(wires):
    driving = DrivesByMoveBase("map")
    goals, cancels = wires["move_base/goal"].sent, wires["move_base/cancel"].sent
    for x in (1.0, 1.0, 2.0):
        assert driving.drive(passed(Command(0.2), Pose2(x, 0.5, 0.0)), 12.5) == 0
    assert [goal.goal.target_pose.pose.position.x for goal in goals] == [1.0, 2.0]
    assert goals[0].goal_id.id != goals[1].goal_id.id
    assert goals[0].goal.target_pose.header.frame_id == "map" and goals[0].goal_id.stamp == rospy.Time(12, 500000000)
    assert driving.drive(passed(Command(), Pose2(2.0, 0.5, 0.0), State.PAUSED), 13.0) == 0
    assert [cancel.id for cancel in cancels] == [goals[1].goal_id.id] and not wires[names.NAVI].sent


def test_backing_off_counts_as_the_command_it_is(wires):
    driving = DrivesByMoveBase("map")
    driving.drive(passed(Command(0.2), Pose2(1.0, 0.0)), 1.0)
    assert driving.drive(passed(Command(-0.08), Pose2(1.0, 0.0)), 1.1) == 1
    assert wires[names.NAVI].sent[0].linear.x == -0.08 and len(wires["move_base/cancel"].sent) == 1


def test_when_time_goes_back_the_goal_is_sent_anew(wires):
    driving = DrivesByMoveBase("map")
    driving.drive(passed(Command(0.2), Pose2(1.0, 0.0)), 9.0)
    driving.forget()
    driving.drive(passed(Command(0.2), Pose2(1.0, 0.0)), 1.0)
    assert len(wires["move_base/goal"].sent) == 2


def test_somebody_must_hear_goals_cancellations_and_commands(wires):
    driving = DrivesByMoveBase("map")
    assert driving.connected()
    wires["move_base/cancel"].heard = 0
    assert not driving.connected()
