"""A rostest that takes part in the simulated cell's lock-step: however slow it is, no time passes unseen."""

from __future__ import annotations

import threading
from typing import Callable

import rospy
from yarm.msg import SimStatus, StepAck

from yarm.ros.common import names
from yarm.ros.common.acks import step_ack

BEGIN_LIMIT_S = 120.0
"""Wall time in which every node must be up, s."""


class Participant:
    """Acknowledges what the test has taken in; the controls server's ``sync_after`` names the test."""

    def __init__(self) -> None:
        """Advertise."""
        self._lock = threading.Lock()
        self._asked = 0
        self._ack = rospy.Publisher(names.STEP_ACK, StepAck, queue_size=100, tcp_nodelay=True)

    def took(self, stamp: rospy.Time) -> None:
        """The test has heard what it needs of a tick; to be called for each."""
        with self._lock:
            self._ack.publish(step_ack(stamp, self._asked))

    def ask(self, send: Callable[[], object]) -> None:
        """Send one goal or cancel; the tick after the next camera set waits until the controls server has it."""
        with self._lock:
            send()
            self._asked += 1

    @staticmethod
    def wait_for_begin() -> None:
        """Until the lock-step has begun; before, nothing moves."""
        rospy.wait_for_message(names.SIM_STATUS, SimStatus, timeout=BEGIN_LIMIT_S)
