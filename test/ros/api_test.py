#!/usr/bin/env python3
"""The tables of docs/ros_api.md against a running system: every topic, type, sender and service."""

import sys
import time
import unittest

import rosgraph
import rospy
import rosservice
import rostest

from yarm.control.mux import MuxParams, mux_inputs
from yarm.ros.common import api, api_explorer, api_inspection, api_navigation, api_rooms, api_youbot, names
from yarm.ros.common.start import init_node

ROBOTS = ("ankurbot_1", "ankurbot_2")
ARMS = ("hc10_barc",)
LIMIT_S = 180.0
MARKS = (
    ("{robot}", ROBOTS),
    ("{arm}", ARMS),
    ("{n}", "1234"),
    ("{caster}", names.CASTERS),
    ("{source}", [item.name for item in mux_inputs(MuxParams())]),
)
TABLES = {
    "cell": (api.TOPICS, api.SERVICES, api.ACTIONS),
    "youbot": (api_youbot.TOPICS, api_youbot.SERVICES, ()),
    "room": (api_rooms.TOPICS, api_rooms.SERVICES, ()),
    "exploration": (api_explorer.EVERY_TOPIC, api_explorer.EVERY_SERVICE, ()),
    "inspection": (api_inspection.EVERY_TOPIC, api_inspection.EVERY_SERVICE, api_navigation.ACTIONS),
    "known_room": (api_navigation.EVERY_TOPIC, api_navigation.EVERY_SERVICE, api_navigation.ACTIONS),
}


def expanded(name):
    """Every real name a name with placeholders stands for."""
    found = [name]
    for mark, values in MARKS:
        found = [text.replace(mark, value) for text in found for value in values if mark in text] or found
    return ["/" + text.lstrip("/") for text in found]


def senders(topic):
    """The nodes that send on a topic, as far as this test starts them and the table names them one by one."""
    not_here = ("people",) if rospy.get_param("~system") == "exploration" else ("people", "explorer")
    return [s for s in topic.sender.split(", ") if s not in not_here and topic.name != names.DIAGNOSTICS]


def publishers():
    """Names of the nodes that publish each topic."""
    published, _, _ = rosgraph.Master(rospy.get_name()).getSystemState()
    return {topic: {node.lstrip("/") for node in nodes} for topic, nodes in published}


def topic_types():
    """Type of each topic that somebody sends or hears."""
    return dict(rosgraph.Master(rospy.get_name()).getTopicTypes())


def silent(topics, published):
    """Senders of a table that do not send; in one process the perception nodes appear under the manager's name."""
    perception = {api.MERGE, api.ASSOC, api.MAP}
    found = []
    for topic in topics:
        for sender in senders(topic):
            accepted = {sender, "perception"} if sender in perception else {sender}
            found += [
                f"{name}: {sender}, but published by {published.get(name)}"
                for name in expanded(topic.name)
                if not published.get(name, set()) & accepted
            ]
    return found


class ApiTest(unittest.TestCase):
    """One running system for all checks."""

    @classmethod
    def setUpClass(cls):
        """Wait until every sender sends, somebody sends the results of every action, and every service is there."""
        topics, cls.services, cls.actions = TABLES[rospy.get_param("~system")]
        cls.documented = {name for topic in topics for name in expanded(topic.name)}
        cls.topics = [topic for topic in topics if "lock-step only" not in topic.rate]
        deadline = time.monotonic() + LIMIT_S
        while not cls.complete() and time.monotonic() < deadline:
            time.sleep(0.5)
        cls.publishers = publishers()
        cls.types = topic_types()

    @classmethod
    def complete(cls):
        """Whether nothing of the table is missing."""
        published = publishers()
        results = {name for action in cls.actions for name in expanded(action.name + "/result")}
        known = {name for topic in cls.topics for name in expanded(topic.name)}
        services = {f"/{service.name}" for service in cls.services}
        here = results <= set(published) and known <= set(topic_types())
        return here and services <= set(rosservice.get_service_list()) and not silent(cls.topics, published)

    def test_every_topic_of_the_table_exists_with_its_type(self):
        """Name and type."""
        wanted = {name: topic.type for topic in self.topics for name in expanded(topic.name)}
        wrong = {name: self.types.get(name) for name in wanted if self.types.get(name) != wanted[name]}
        self.assertEqual(wrong, {})

    def test_every_sender_of_the_table_publishes(self):
        """Who sends it."""
        self.assertEqual(silent(self.topics, self.publishers), [])

    def test_nothing_is_published_that_the_table_does_not_name(self):
        """No undocumented topic; actions and ROS's own topics apart."""
        known = self.documented
        actions = tuple(name + "/" for action in self.actions for name in expanded(action.name))
        own = ("/rosout", "/rosout_agg")
        extra = [t for t in self.publishers if t not in known and not t.startswith(actions) and t not in own]
        self.assertEqual([t for t in extra if "/bond" not in t and "parameter_" not in t], [])

    def test_every_service_has_its_type(self):
        """Services."""
        for service in self.services:
            self.assertEqual(rosservice.get_service_type("/" + service.name), service.type)


if __name__ == "__main__":
    init_node("api_test")
    rostest.rosrun("yarm", "api", ApiTest, sys.argv)
