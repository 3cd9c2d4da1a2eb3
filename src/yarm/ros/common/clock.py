"""Simulated time: which stamps are the same, and the one place where Python nodes notice that it goes backwards.

The simulator may be stopped and started again in mid-run; then ``/clock`` jumps back and everything that remembers
stamps (tf buffers, plans, timers, action goals) must start afresh (C++: yarm/sync/clock.hpp).
"""

from __future__ import annotations

import math
import threading
from typing import Callable, List, Optional

import rospy
from rosgraph_msgs.msg import Clock

SAME_TICK_S = 1e-4
"""Stamps that are less apart are of one tick of the simulation (1/240 s): what differs is rounding, s."""
SAME_STAMP_S = 0.004
"""Stamps that are less apart, by less than a tick, are of one camera set, s."""
JUMP_BACK_S = 0.1
"""A step back of more than this is a restart, not reordering, s."""


class ClockWatch:
    """Calls every registered function once when simulated time has gone backwards. Thread-safe."""

    def __init__(self) -> None:
        """Watch ``/clock``; without simulated time nothing ever happens."""
        self._lock = threading.Lock()
        self._last: Optional[rospy.Time] = None
        self._callbacks: List[Callable[[], None]] = []
        self._subscriber = rospy.Subscriber("/clock", Clock, self._on_clock, queue_size=10)

    @property
    def newest_s(self) -> float:
        """The newest time, s; inf before there is any."""
        with self._lock:
            return math.inf if self._last is None else float(self._last.to_sec())

    def on_reset(self, callback: Callable[[], None]) -> None:
        """Register a function without arguments, called from the subscriber's thread."""
        with self._lock:
            self._callbacks.append(callback)

    def _on_clock(self, message: Clock) -> None:
        with self._lock:
            jumped = self._last is not None and (self._last - message.clock).to_sec() > JUMP_BACK_S
            self._last = message.clock
            callbacks = list(self._callbacks) if jumped else []
        if jumped:
            rospy.logwarn("time went backwards to %.3f s: the simulator was started again", message.clock.to_sec())
        for callback in callbacks:
            callback()
