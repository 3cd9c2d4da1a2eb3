"""Takes a film of a running system beside whoever runs it: a page shows it afterwards."""

from __future__ import annotations

import threading
import time
from typing import Callable, Optional

import rospy

from yarm.console.film import Film
from yarm.ros.console.cell_words import private_areas
from yarm.ros.console.routes import Feed
from yarm.ros.console.system_book import SystemBook
from yarm.ros.console.throttle import throttled

SHARED = ("/tf", "/tf_static")
"""Topics that others in the process of an experiment listen to, as messages."""
KEPT_S = 1800.0
"""Simulated time that a film has, s: of a run that takes longer the last."""
POLL_S = 0.1
"""Wall time between two pictures at least, s: a simulation that runs fast gets fewer of them."""


class Filmer:
    """Listens, and takes a picture whenever it is time to, on a thread of its own."""

    def __init__(
        self,
        title: str,
        rate_hz: float,
        now_s: Callable[[], float] = rospy.get_time,
        before: Optional[Film] = None,
    ) -> None:
        """Begin.

        Args:
            title: of the film.
            rate_hz: pictures a second of simulated time.
            now_s: gives simulated time, s.
            before: what a process before has left, if there was one.
        """
        self.film = Film(title, KEPT_S)
        if before is not None:
            self.film.begin_with(before)
        self._period_s, self._now_s = 1.0 / rate_hz, now_s
        self._book = SystemBook(private_areas, throttled(rospy.logwarn))
        self._last_s = 0.0
        self._feed = Feed(self._book, SHARED, guest=True)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def end(self) -> Film:
        """The film, with a last picture."""
        self._ended.set()
        self._thread.join()
        self._take(max(self._last_s, self._now_s()))
        return self.film

    def _run(self) -> None:
        while not self._ended.wait(POLL_S):
            now_s = self._now_s()
            if now_s > 0.0 and not self._last_s <= now_s < self._last_s + self._period_s:
                self._take(now_s)

    def _take(self, now_s: float) -> None:
        self._last_s = now_s
        self.film.add(now_s, self._book.parts(), self._book.state(now_s, time.monotonic()))


def filmer_of(title: str, rate_hz: float, before: Optional[Film] = None) -> Optional[Filmer]:
    """One that has begun, or none when no picture is wanted (0 a second)."""
    return Filmer(title, rate_hz, before=before) if rate_hz > 0.0 else None
