"""What is recorded of an exploration does not depend on which of a moment's messages comes first."""

from __future__ import annotations

import itertools
from typing import List, Tuple

import pytest
import rospy
from nav_msgs.msg import Odometry
from yarm.msg import Contact, Contacts, ExplorerStatus

from support.ears import Ears
from yarm.experiments.explore.record import ExploreRecord
from yarm.exploration.session import State
from yarm.geometry import Pose2
from yarm.robots import turtlebot
from yarm.ros.common import names
from yarm.ros.common.conversions import pose_message
from yarm.ros.exploration.experiment import Exploration
from yarm.ros.exploration.experiment_params import ExplorationRunParams
from yarm.ros.exploration.params import explorer_params

BEGUN_S = 10.0
LOOP_S = 0.1
Told = Tuple[str, int]
"""Kind of message, and the pass it is of."""


def recorded(patch: pytest.MonkeyPatch, order: List[Told]) -> ExploreRecord:
    """The record of a run whose messages came in this order, one more moment of each kind after them."""
    ears = Ears()
    with patch.context() as replaced:
        ears.put_on(replaced)
        explore, _ = explorer_params({}, "explorer")
        node = Exploration(ExplorationRunParams(), explore)
        last = max(count for _, count in order) + 1
        for kind, count in [*order, ("status", last), ("truth", last)]:
            topic, message = MESSAGES[kind](BEGUN_S + count * LOOP_S)
            (ear,) = ears.by_topic(topic)
            ear.tell(message, lambda: None)
        return node.record("")


def status(now_s: float) -> Tuple[str, ExplorerStatus]:
    message = ExplorerStatus(state=State.EXPLORING.value, moving=True, elapsed=now_s - BEGUN_S, left=60.0)
    message.header.stamp, message.started = rospy.Time.from_sec(now_s), rospy.Time.from_sec(BEGUN_S)
    message.has_pose, message.pose = True, pose_message(0.0, 0.0, 0.0, 0.0)
    return names.explorer("status"), message


def truth(now_s: float) -> Tuple[str, Odometry]:
    message = Odometry()
    message.header.stamp = rospy.Time.from_sec(now_s)
    place = Pose2(now_s - BEGUN_S, 0.0, now_s - BEGUN_S)
    message.pose.pose = pose_message(place.x, place.y, 0.0, place.yaw_rad)
    return names.SIM_POSE, message


def contacts(now_s: float) -> Tuple[str, Contacts]:
    message = Contacts(contacts=[Contact(body_a=turtlebot.TYPE, body_b="brick_1")])
    message.header.stamp = rospy.Time.from_sec(now_s)
    return names.SIM_CONTACTS, message


MESSAGES = {"status": status, "truth": truth, "contacts": contacts}


ORDERS = itertools.permutations([[("status", 0)], [("truth", 0), ("truth", 1)], [("contacts", 0)]])


@pytest.mark.parametrize("order", ORDERS, ids=lambda order: "-".join(part[0][0] for part in order))
def test_where_it_was_and_what_it_touched_at_the_start(
    order: List[List[Told]], monkeypatch: pytest.MonkeyPatch
) -> None:
    record = recorded(monkeypatch, [told for part in order for told in part])
    assert [row.t_s for row in record.path] == pytest.approx([0.0, 2 * LOOP_S])
    assert [row.true_yaw for row in record.path] == pytest.approx([0.0, 2 * LOOP_S])
    assert [touch.t_s for touch in record.touches] == pytest.approx([0.0])
