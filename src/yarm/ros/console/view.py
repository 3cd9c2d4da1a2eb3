"""What a page shows of a running system: its book, the health of its nodes, and the last minutes of both."""

from __future__ import annotations

import time
from typing import Mapping

import rospy

from yarm.console.cell import Part
from yarm.console.params import ConsoleParams
from yarm.ros.console.cell_words import private_areas
from yarm.ros.console.health import HealthWatch
from yarm.ros.console.routes import Feed
from yarm.ros.console.system_book import SystemBook
from yarm.ros.console.throttle import throttled


class LiveView:
    """Listens to a running system's topics. Thread-safe."""

    def __init__(self, params: ConsoleParams) -> None:
        """Subscribe."""
        self._book = SystemBook(private_areas, throttled(rospy.logwarn))
        feed = Feed(self._book)
        self._health = HealthWatch(params.health_s, feed.beats)

    def parts(self) -> Mapping[str, Part]:
        """Bodies and cameras, health, events."""
        return {**self._book.parts(), "health": self._health.part()}

    def now_s(self) -> float:
        """Simulated time, s."""
        return float(rospy.get_time())

    def state(self) -> bytes:
        """Everything else, as it is now."""
        return self._book.state(self.now_s(), time.monotonic())
