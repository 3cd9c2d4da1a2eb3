"""Node ``cmd_vel_mux``: the source with the highest priority drives the base (yarm.control.mux)."""

from __future__ import annotations

import threading
from functools import partial

import rospy
from geometry_msgs.msg import Twist
from std_msgs.msg import String

from yarm.control.mux import Mux, MuxParams, mux_inputs
from yarm.params import ParamError
from yarm.ros.common import names
from yarm.ros.common.params import load_params
from yarm.ros.common.start import init_node

IDLE = "idle"
CHECK_S = 0.1
"""Simulated time between two looks for a source that has fallen silent, s."""


class MuxNode:
    """One subscriber a source, one publisher."""

    def __init__(self, params: MuxParams) -> None:
        """Listen.

        Raises:
            ParamError: the sources are not well defined.
        """
        inputs = mux_inputs(params)
        self._lock = threading.Lock()
        self._mux = Mux(inputs)
        self._said = ""
        self._velocity = rospy.Publisher(names.BASE_VELOCITY, Twist, queue_size=10, tcp_nodelay=True)
        self._active = rospy.Publisher(names.MUX_ACTIVE, String, queue_size=10, latch=True)
        self._tell()
        self._subscribers = [
            rospy.Subscriber(
                names.mux_input(item.name), Twist, partial(self._on_command, item.name), queue_size=10, tcp_nodelay=True
            )
            for item in inputs
        ]
        self._timer = rospy.Timer(rospy.Duration(CHECK_S), self._check, reset=True)

    def _on_command(self, name: str, message: Twist) -> None:
        with self._lock:
            if self._mux.take(name, rospy.get_time()):
                self._velocity.publish(message)
            self._tell()

    def _check(self, _: object) -> None:
        with self._lock:
            self._mux.expire(rospy.get_time())
            self._tell()

    def _tell(self) -> None:
        """Say who has the right, when that has changed."""
        active = self._mux.active or IDLE
        if active != self._said:
            self._said = active
            self._active.publish(String(active))


def main() -> None:
    """Run the node."""
    init_node("cmd_vel_mux")
    try:
        node = MuxNode(load_params(MuxParams))
    except ParamError as error:
        rospy.logfatal("%s", error)
        raise SystemExit(1) from error
    rospy.spin()
    del node
