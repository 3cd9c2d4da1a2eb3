"""A node outside the cell as a participant of its lock-step: simulated time stands still while it looks and asks."""

from __future__ import annotations

import math
import threading
from typing import Optional

import rospy
from rosgraph_msgs.msg import Clock

from yarm.msg import StepAck
from yarm.ros.common import names
from yarm.ros.common.acks import step_ack

TICK_HZ = 60.0
HALF_TICK_S = 0.5 / TICK_HZ
PERIOD_TICKS = 30
PHASE_TICKS = 15
"""Twice a second; never at a camera set (those are even ticks), so that the Commander is idle, nor when the simulation
looks at its events (every 30th tick)."""


class LockStep:
    """Acknowledges every tick, but for the moments somebody waits for: those it holds until it is asked to go on."""

    def __init__(self) -> None:
        """Acknowledge from now on."""
        self._changed = threading.Condition()
        self._wanted = False
        self._held: Optional[rospy.Time] = None
        self._seen = False
        self._stop_s = math.inf
        self._stopped = False
        self._ack = rospy.Publisher(names.STEP_ACK, StepAck, queue_size=100, tcp_nodelay=True)
        self._clock = rospy.Subscriber("/clock", Clock, self._on_clock, queue_size=100, tcp_nodelay=True)

    @property
    def moment_s(self) -> Optional[float]:
        """The moment that is held, s of simulated time; None while time goes on."""
        with self._changed:
            return float(self._held.to_sec()) if self._held is not None and self._seen else None

    @property
    def stopped(self) -> bool:
        """Time stands still for good, as ``stop_at`` wanted."""
        with self._changed:
            return self._stopped

    def stop_at(self, stop_s: float) -> None:
        """Let time stand still at the first tick at or after a simulated time, s, until the end of the process."""
        with self._changed:
            self._stop_s = stop_s

    def next_moment(self, limit_s: float) -> None:
        """Let time go on to the next moment and hold it there; wait for it no longer than so much wall time, s."""
        with self._changed:
            if self._seen:
                self._go_on()
            self._wanted = self._held is None
            self._seen = self._changed.wait_for(lambda: self._held is not None or self._stopped, timeout=limit_s)

    def release(self) -> None:
        """Let time go on for good."""
        with self._changed:
            self._wanted = False
            self._go_on()

    def _go_on(self) -> None:
        if self._held is not None:
            self._acknowledge(self._held)
            self._held, self._seen = None, False

    def _on_clock(self, message: Clock) -> None:
        with self._changed:
            if message.clock.to_sec() >= self._stop_s - HALF_TICK_S:
                self._stopped = True
                self._changed.notify_all()
            elif self._wanted and round(message.clock.to_sec() * TICK_HZ) % PERIOD_TICKS == PHASE_TICKS:
                self._wanted = False
                self._held = message.clock
                self._changed.notify_all()
            else:
                self._acknowledge(message.clock)

    def _acknowledge(self, stamp: rospy.Time) -> None:
        self._ack.publish(step_ack(stamp, 0))
