#!/usr/bin/env python3
"""docs/ros_api.md (yarm.ros.api) against a running system: every topic, type, sender and service."""

import sys
import time
import unittest

import rosgraph
import rospy
import rosservice
import rostest
from yarm.msg import ObjectRegistry

from yarm.ros import api, names

ROBOTS = ("ankurbot_1", "ankurbot_2")
ARMS = ("hc10_barc",)
LIMIT_S = 180.0


def expanded(name):
    """Every real name a name with placeholders stands for."""
    found = [name]
    for mark, values in (("{robot}", ROBOTS), ("{arm}", ARMS), ("{n}", "1234"), ("{caster}", names.CASTERS)):
        found = [text.replace(mark, value) for text in found for value in values if mark in text] or found
    return ["/" + text.lstrip("/") for text in found]


def publishers():
    """Names of the nodes that publish each topic."""
    published, _, _ = rosgraph.Master(rospy.get_name()).getSystemState()
    return {topic: {node.lstrip("/") for node in nodes} for topic, nodes in published}


class ApiTest(unittest.TestCase):
    """One running system for all checks."""

    @classmethod
    def setUpClass(cls):
        """Wait until the registry and the sander's topics stand; then the action servers do too."""
        rospy.wait_for_message(names.OBJECT_REGISTRY, ObjectRegistry, timeout=LIMIT_S)
        wanted = {expanded(names.move_robot(robot) + "/result")[0] for robot in ROBOTS + ARMS}
        wanted |= {expanded(topic.name)[0] for topic in api.TOPICS}
        deadline = time.monotonic() + LIMIT_S
        while wanted - set(publishers()) and time.monotonic() < deadline:
            time.sleep(0.5)
        cls.publishers = publishers()
        cls.types = dict(rosgraph.Master(rospy.get_name()).getTopicTypes())

    def test_every_topic_of_the_table_exists_with_its_type(self):
        """Name and type."""
        wanted = {name: topic.type for topic in api.TOPICS for name in expanded(topic.name)}
        wrong = {name: self.types.get(name) for name in wanted if self.types.get(name) != wanted[name]}
        self.assertEqual(wrong, {})

    def test_every_sender_of_the_table_publishes(self):
        """Who sends it; in one process the perception nodes appear under the manager's name."""
        silent = []
        perception = {api.MERGE, api.ASSOC, api.MAP}
        for topic in api.TOPICS:
            for sender in topic.sender.split(", "):
                if sender == "people" or topic.name in (names.DIAGNOSTICS, names.STEP_ACK):
                    continue
                for name in expanded(topic.name):
                    accepted = {sender, "perception"} if sender in perception else {sender}
                    if not self.publishers.get(name, set()) & accepted:
                        silent.append(f"{name}: {sender}, but published by {self.publishers.get(name)}")
        self.assertEqual(silent, [])

    def test_nothing_is_published_that_the_table_does_not_name(self):
        """No undocumented topic; actions and ROS's own topics apart."""
        known = {name for topic in api.TOPICS for name in expanded(topic.name)}
        actions = tuple(name + "/" for action in api.ACTIONS for name in expanded(action.name))
        own = ("/rosout", "/rosout_agg")
        extra = [t for t in self.publishers if t not in known and not t.startswith(actions) and t not in own]
        self.assertEqual([t for t in extra if "/bond" not in t and "parameter_" not in t], [])

    def test_every_service_has_its_type(self):
        """Services."""
        for service in api.SERVICES:
            self.assertEqual(rosservice.get_service_type("/" + service.name), service.type)


if __name__ == "__main__":
    rospy.init_node("api_test")
    rostest.rosrun("yarm", "api", ApiTest, sys.argv)
