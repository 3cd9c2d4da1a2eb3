#!/usr/bin/env python3
"""A hand as other nodes see it: it picks a piece of debris up, holds it and lets it go, by topics and services."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import rospy
import rosservice
import rostest
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64
from std_srvs.srv import Empty
from tf2_msgs.msg import TFMessage
from yarm.msg import Contacts, GripperState

from yarm.ros.common import api, names
from yarm.ros.common.start import init_node

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.links import wait_until_heard
from support.listening import ListeningTest

ROBOT, PIECE = "ankurbot_1", "debris_1"
JOINTS, GRASPING, LIFT = names.joint_states(ROBOT), names.gripper(ROBOT, "grasping"), names.lift_command(ROBOT)
STATE = names.gripper(ROBOT, "state")
STROKE_M, UP_M, MET_M = 0.2, 0.002, 0.165
LIFTED_M = 0.85


class HandTest(ListeningTest):
    """One launch serves every check; they run in the order of their names."""

    @classmethod
    def setUpClass(cls) -> None:
        """Hear everything, and be heard."""
        cls.listen((JOINTS, JointState), (GRASPING, Bool), ("/tf", TFMessage), ("/rosout", Log))
        cls.keep(names.SIM_CONTACTS, Contacts, most=100_000)
        cls.keep(STATE, GripperState, most=100_000)
        cls.lift = rospy.Publisher(LIFT, Float64, queue_size=10)
        wait_until_heard(LIFT, "simulation")
        cls.on = rospy.ServiceProxy(names.gripper(ROBOT, "on"), Empty)
        cls.off = rospy.ServiceProxy(names.gripper(ROBOT, "off"), Empty)
        cls.on.wait_for_service(timeout=cls.limit_s)
        cls.off.wait_for_service(timeout=cls.limit_s)

    def lift_m(self) -> float:
        """How far down the hand is by the newest joint states."""
        message = self.kept[JOINTS][-1]
        return float(message.position[message.name.index("lift_joint")])

    def height_m(self, after_s: float) -> float:
        """Height of the piece at a moment after the one given, s."""

        def found() -> Any:
            heard = (t for message in reversed(self.kept["/tf"]) for t in message.transforms)
            return next((t for t in heard if t.child_frame_id == PIECE and t.header.stamp.to_sec() > after_s), None)

        return float(self.wait(found, f"a pose of {PIECE} after {after_s:.2f} s").transform.translation.z)

    def grasping(self, wanted: bool) -> Any:
        """The newest word on the cup is the one that is wanted."""
        return lambda: self.kept[GRASPING] and self.kept[GRASPING][-1].data is wanted

    def test_a_at_first_the_hand_is_drawn_up_and_empty(self) -> None:
        """The latched word is heard by whoever comes late."""
        self.wait(self.grasping(False), "that nothing hangs on the cup")
        self.wait(lambda: self.kept[JOINTS] and abs(self.lift_m()) < UP_M, "the hand drawn up")

    def test_b_the_table_of_the_interface_is_true(self) -> None:
        """Topics by their types, and services."""
        types = dict(rospy.get_published_topics("/"))
        self.assertEqual(types[f"/{GRASPING}"], "std_msgs/Bool")
        for service in api.HAND_SERVICES:
            name = "/" + service.name.replace("{robot}", ROBOT)
            self.assertEqual(rosservice.get_service_type(name), service.type)
        told = {topic.name.replace("{robot}", ROBOT): topic.type for topic in api.HAND_TOPICS}
        self.assertEqual(told, {LIFT: "std_msgs/Float64", GRASPING: "std_msgs/Bool", STATE: "yarm/GripperState"})
        self.assertEqual(types[f"/{STATE}"], "yarm/GripperState")

    def test_c_bad_commands_are_refused_and_named(self) -> None:
        """Neither moves the hand."""
        for bad in (math.nan, 0.5):
            self.lift.publish(Float64(bad))
        self.wait(
            lambda: any(LIFT in log.msg and "must be within 0 to 0.2 m" in log.msg for log in self.kept["/rosout"]),
            "a warning",
        )
        self.fresh(JOINTS)
        self.assertLess(abs(self.lift_m()), UP_M)

    def test_d_it_picks_holds_and_lets_go(self) -> None:
        """Down on the piece, up with it, and off."""
        self.on()
        self.lift.publish(Float64(STROKE_M))
        self.wait(self.grasping(True), "the piece on the cup")
        self.wait(lambda: 0.1 < self.lift_m() < MET_M, "the cup on the piece")
        self.lift.publish(Float64(0.0))
        self.wait(lambda: abs(self.lift_m()) < UP_M, "the hand drawn up again")
        self.assertGreater(self.height_m(rospy.get_time()), LIFTED_M)
        self.assertEqual([word.data for word in self.kept[GRASPING]], [False, True])
        words = list(self.kept[STATE])
        stamps = [word.header.stamp for word in words]
        self.assertEqual(stamps, sorted(set(stamps)))
        turns = [b.grasping for a, b in zip(words, words[1:]) if a.grasping is not b.grasping]
        self.assertEqual((words[0].grasping, turns), (False, [True]))
        self.off()
        self.wait(self.grasping(False), "that the cup has let go")
        fallen_s = rospy.get_time() + 1.0
        self.assertLess(self.height_m(fallen_s), LIFTED_M)
        contacts = [contact for message in self.kept[names.SIM_CONTACTS] for contact in message.contacts]
        pairs = {(contact.link_a, contact.link_b) for contact in contacts if contact.kind == "failure"}
        self.assertEqual(pairs, set())
        self.assertTrue(any("hand" in (contact.link_a, contact.link_b) for contact in contacts))


if __name__ == "__main__":
    init_node("hand_test")
    rostest.rosrun("yarm", "hand", HandTest, sys.argv)
