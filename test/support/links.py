"""Who hears whom, as a rostest asks it of a running graph."""

from __future__ import annotations

import time
from xmlrpc.client import ServerProxy

import rosgraph
import rospy

LIMIT_S = 60.0
LOOK_AGAIN_S = 0.05


def linked(sender: str, topic: str, receiver: str) -> bool:
    """Whether one node's messages on a topic reach another; names without their first slash."""
    try:
        uri = rosgraph.Master(rospy.get_name()).lookupNode(f"/{sender}")
        connections = ServerProxy(uri).getBusInfo(rospy.get_name())[2]
    except (rosgraph.MasterException, OSError):
        return False
    return any(entry[1] == f"/{receiver}" and entry[2] == "o" and entry[4] == f"/{topic}" for entry in connections)


def wait_until_heard(topic: str, receiver: str) -> None:
    """Until a node hears what this one publishes on a topic.

    The number of a publisher's connections does not tell: the node itself and rosout may be among them.

    Raises:
        AssertionError: it does not within LIMIT_S.
    """
    end = time.monotonic() + LIMIT_S
    while not linked(rospy.get_name().strip("/"), topic, receiver):
        assert time.monotonic() < end, f"{receiver} does not hear {topic} within {LIMIT_S:.0f} s"
        time.sleep(LOOK_AGAIN_S)
