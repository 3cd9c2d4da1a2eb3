"""A loop that makes one pass at every tenth (or other share) of a second of ``/clock``, or of wall time without it."""

from __future__ import annotations

import threading
from typing import Optional

import rospy
from rosgraph_msgs.msg import Clock

from yarm.ros.common.clock import ClockWatch

WAKE_S = 0.2
"""Wall time after which the loop looks whether it is to end, s."""
LEAST_WAIT_S = 0.001
"""Wall time that is waited at least for a pass whose time has not come, s."""


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
        self._clock_s: Optional[float] = None
        self._due = 0
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
            if self._count(self._now_s()) < self._due:
                self._tick.wait(self._until_due_s())
            now_s = self._now_s()
            count = self._count(now_s)
            if count < self._due or now_s <= 0.0 or not ready:
                return None
            self.at_s = count * self._period_s if self._sync else now_s
            self._due, self._repeated = count + 1, False
            return self.at_s

    def take_repeated(self) -> bool:
        """Whether the moment of the last pass has been said again since: somebody has not heard its answer."""
        with self._tick:
            repeated = self._repeated and self._count(self._now_s()) + 1 == self._due
            self._repeated = self._repeated and not repeated
            return repeated

    def take_reset(self) -> bool:
        """Whether time has gone backwards since the last call."""
        with self._tick:
            went_back, self._went_back = self._went_back, False
            if went_back:
                self._due = 0
            return went_back

    def _now_s(self) -> float:
        """What the clock says; where nobody simulates, and there is no lock-step, wall time."""
        if self._clock_s is not None:
            return self._clock_s
        return 0.0 if self._sync else float(rospy.get_time())

    def _until_due_s(self) -> float:
        """Wall time to wait: whoever is not woken by a clock wakes when the next pass is due."""
        if self._clock_s is not None or self._sync:
            return WAKE_S
        return min(WAKE_S, max(LEAST_WAIT_S, self._due * self._period_s - self._now_s()))

    def _count(self, now_s: float) -> int:
        return int(round(now_s / self._period_s, 6))

    def _on_clock(self, message: Clock) -> None:
        with self._tick:
            now_s = message.clock.to_sec()
            self._repeated = now_s == self._clock_s
            self._clock_s = now_s
            self._tick.notify_all()

    def _on_reset(self) -> None:
        with self._tick:
            self._went_back = True
            self._tick.notify_all()
