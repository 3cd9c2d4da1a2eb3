"""How every Python node begins: named, and connected to each publisher once.

rospy connects to a publisher anew for every list of publishers that has it and is not connected yet. When two lists
come close together, as they do when several nodes start to publish on one topic, two threads ask for the same
connection; the second one made closes the first, and what was sent through that is lost: a goal, an acknowledgement,
the only message of a topic that is not latched.
"""

from __future__ import annotations

import threading
from collections import defaultdict
from typing import Any, Callable, DefaultDict, Tuple

import rospy
from rospy.impl.masterslave import ROSHandler

Connect = Callable[[Any, str, str], Any]


def init_node(name: str, **options: Any) -> None:
    """``rospy.init_node``, whose arguments these are; from here on each publisher is connected to once."""
    if not hasattr(ROSHandler._connect_topic, "one_at_a_time"):
        ROSHandler._connect_topic = one_at_a_time(ROSHandler._connect_topic)
    rospy.init_node(name, **options)


def one_at_a_time(connect: Connect) -> Connect:
    """A connecting function that lets one thread at a time connect a topic to a publisher.

    Who comes second finds the connection there; other topics and publishers are not held up.
    """
    locks: DefaultDict[Tuple[str, str], threading.Lock] = defaultdict(threading.Lock)

    def connect_once(handler: Any, topic: str, uri: str) -> Any:
        with locks[topic, uri]:
            return connect(handler, topic, uri)

    connect_once.one_at_a_time = True  # type: ignore[attr-defined]
    return connect_once
