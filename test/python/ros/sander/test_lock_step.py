"""In lock-step the sander and the controls server wait for each other, also when one never had a tick."""

from __future__ import annotations

from typing import List

import pytest
import rospy
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from yarm.msg import StepAck

from support.ears import SENDER, Ears
from yarm.ros.common import names
from yarm.ros.sander.node import SanderNode
from yarm.ros.sander.params import SanderNodeParams

TICK_S = 1 / 60


class Told:
    """A sander in lock-step, and the ticks it has worked on."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self._ears = Ears()
        self._ears.put_on(patch)
        self._node = SanderNode(SanderNodeParams(sync=True))
        self._arm = self._node._params.arm

    def joints(self, tick: int) -> None:
        stamp = rospy.Time.from_sec(tick * TICK_S)
        named = self._node._joint_names
        message = JointState(header=Header(stamp=stamp), name=named, position=[0.0] * len(named))
        self._tell(names.joint_states(self._arm), message)

    def controls_done(self, tick: int, sent: int = 0) -> None:
        stamp = Header(stamp=rospy.Time.from_sec(tick * TICK_S))
        message = StepAck(header=stamp, node=SENDER["callerid"].strip("/"), commands_sent=sent)
        self._tell(names.sander_command_ack(self._arm), message)

    def _tell(self, topic: str, message: object) -> None:
        (ear,) = self._ears.by_topic(topic)
        ear.tell(message, lambda: None)

    def worked_on(self) -> List[int]:
        """Ticks since the last time, as the node's loop takes them."""
        node, ticks = self._node, []
        while node._joints and node._ready(node._joints[0].header.stamp.to_sec()):
            joints = node._joints.popleft()
            node._tick(joints)
            ticks.append(round(joints.header.stamp.to_sec() / TICK_S))
        return ticks


@pytest.fixture(name="told")
def told_fixture(monkeypatch: pytest.MonkeyPatch) -> Told:
    return Told(monkeypatch)


def test_a_tick_waits_for_the_controls_server(told: Told) -> None:
    told.joints(60)
    assert told.worked_on() == []
    told.controls_done(60)
    assert told.worked_on() == [60]
    told.joints(61)
    assert told.worked_on() == [], "what was done before does not count for it"
    told.controls_done(61, sent=1)
    assert told.worked_on() == [], "what was sent has not come"


def test_one_that_never_came_is_answered_with_the_next(told: Told) -> None:
    """The controls server does nothing more before the sander has answered tick 63."""
    told.joints(60)
    told.controls_done(60)
    assert told.worked_on() == [60]
    told.controls_done(63)
    assert told.worked_on() == []
    told.joints(66)
    assert told.worked_on() == [66]
    told.joints(67)
    assert told.worked_on() == []
