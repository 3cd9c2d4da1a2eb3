"""A loop that is woken by ``/clock`` and makes one pass at every tenth (or other share) of a simulated second."""

from __future__ import annotations

import threading
from typing import Optional

import rospy
from rosgraph_msgs.msg import Clock

from yarm.ros.common.clock import ClockWatch

WAKE_S = 0.2
"""Wall time after which the loop looks whether it is to end, s."""


class Passes:
    """Counts the passes. The loop's thread calls :meth:`wait`; the clock comes in on another."""

    def __init__(self, period_s: float, sync: bool) -> None:
        """Listen to the clock.

        Args:
            period_s: simulated time between two passes.
            sync: lock-step: passes lie at whole periods, and no time is skipped.
        """
        self._period_s, self._sync = period_s, sync
        self._tick = threading.Condition()
        self._now_s, self._due = 0.0, 0
        self._went_back = self._repeated = False
        self.at_s = 0.0
        """Time of the pass that came last."""
        self._clock = ClockWatch()
        self._clock.on_reset(self._on_reset)
        self._subscriber = rospy.Subscriber("/clock", Clock, self._on_clock, queue_size=100, tcp_nodelay=True)

    def wait(self, ready: bool) -> Optional[float]:
        """Time of the next pass, or None when it has not come within a moment of wall time.

        Args:
            ready: lock-step begins only when everybody hears everybody.
        """
        with self._tick:
            if self._count() < self._due:
                self._tick.wait(WAKE_S)
            count = self._count()
            if count < self._due or self._now_s <= 0.0 or not ready:
                return None
            self.at_s = count * self._period_s if self._sync else self._now_s
            self._due, self._repeated = count + 1, False
            return self.at_s

    def take_repeated(self) -> bool:
        """Whether the moment of the last pass has been said again since: somebody has not heard its answer."""
        with self._tick:
            repeated = self._repeated and self._count() + 1 == self._due
            self._repeated = self._repeated and not repeated
            return repeated

    def take_reset(self) -> bool:
        """Whether time has gone backwards since the last call."""
        with self._tick:
            went_back, self._went_back = self._went_back, False
            if went_back:
                self._due = 0
            return went_back

    def _count(self) -> int:
        return int(round(self._now_s / self._period_s, 6))

    def _on_clock(self, message: Clock) -> None:
        with self._tick:
            now_s = message.clock.to_sec()
            self._repeated = now_s == self._now_s
            self._now_s = now_s
            self._tick.notify_all()

    def _on_reset(self) -> None:
        with self._tick:
            self._went_back = True
            self._tick.notify_all()
