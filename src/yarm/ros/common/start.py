"""How every Python node begins: named, connected to each publisher once, and heard to say who can reach it.

rospy connects to a publisher anew for every list of publishers that has it and is not connected yet. When two lists
come close together, as they do when several nodes start to publish on one topic, two threads ask for the same
connection; the second one made closes the first, and what was sent through that is lost: a goal, an acknowledgement,
the only message of a topic that is not latched.

A node obeys whoever can reach its sockets; one that is reached from other machines says so (docs/security.md).
"""

from __future__ import annotations

import os
import sys
import threading
import time
from collections import defaultdict
from contextlib import suppress
from typing import Any, Callable, DefaultDict, Tuple

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rospy.impl.masterslave import ROSHandler

from yarm.ros.common import names
from yarm.safety.listening import exposure
from yarm.safety.supervise import LAST_END, RESTARTS

Connect = Callable[[Any, str, str], Any]
MASTER_WAIT_S, MASTER_POLL_S = 20.0, 0.2
"""Wall time that a command waits for a ROS master, and between two looks, s."""
NO_MASTER = 2
"""Exit code of a command that finds none."""
REPORT_PERIOD_S = 1.0
"""Wall time between two words of a node that was started again, s."""


def init_node(name: str, **options: Any) -> None:
    """``rospy.init_node``, whose arguments these are; from here on each publisher is connected to once."""
    if not hasattr(ROSHandler._connect_topic, "one_at_a_time"):
        ROSHandler._connect_topic = one_at_a_time(ROSHandler._connect_topic)
    rospy.init_node(name, **options)
    exposed = exposure()
    if exposed:
        rospy.logwarn(
            "%s listens on %s: whoever is in that network can read and command it; set ROS_HOSTNAME=localhost before "
            "everything that is started, or see docs/security.md",
            name,
            exposed,
        )
    if RESTARTS in os.environ:
        threading.Thread(target=_tell_restarts, args=(name,), daemon=True).start()


def restarts_status(name: str, count: str, last: str) -> DiagnosticStatus:
    """The diagnostics of a node that was started again so many times because the one before had ended so."""
    return DiagnosticStatus(
        level=DiagnosticStatus.WARN,
        name=f"{name}: supervision",
        message=f"started again, {count} times in all; the one before: {last}",
        hardware_id=name,
        values=[KeyValue("started again", count), KeyValue("the one before", last)],
    )


def _tell_restarts(name: str) -> None:
    publisher = rospy.Publisher(names.DIAGNOSTICS, DiagnosticArray, queue_size=10)
    status = restarts_status(name, os.environ[RESTARTS], os.environ.get(LAST_END, ""))
    rospy.logwarn("%s: %s", name, status.message)
    while not rospy.is_shutdown():
        time.sleep(REPORT_PERIOD_S)
        array = DiagnosticArray(status=[status])
        array.header.stamp = rospy.Time.now()
        with suppress(rospy.ROSException):  # it ends, and the topics are closed
            publisher.publish(array)


def init_command(name: str, wait_s: float = MASTER_WAIT_S, **options: Any) -> None:
    """``init_node`` for a command that a person gives: without a ROS master it ends, with words and exit code 2.

    Args:
        name: of the node; anonymous, so that a command may run more than once.
        wait_s: wall time in which a master that is just being started must answer.
        options: of ``rospy.init_node``.
    """
    uri, until = rosgraph.get_master_uri(), time.monotonic() + wait_s
    if not rosgraph.is_master_online():
        sys.stderr.write(f"{name}: waits up to {wait_s:g} s for the ROS master at {uri}\n")
    while not rosgraph.is_master_online():
        if time.monotonic() >= until:
            sys.stderr.write(
                f"{name}: no ROS master at {uri}: start the system with roslaunch, or set ROS_MASTER_URI\n"
            )
            raise SystemExit(NO_MASTER)
        time.sleep(MASTER_POLL_S)
    init_node(name, anonymous=True, **options)


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
