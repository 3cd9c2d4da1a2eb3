"""What is known of a system, a cell, a robot in a room or the youBot on its floor: whichever is heard."""

from __future__ import annotations

import threading
from typing import Any, Callable, Dict, List, Mapping, Sequence, Union

from yarm.console.cell import Part
from yarm.console.picture import Area
from yarm.ros.console.cell_book import CellBook
from yarm.ros.console.events import EventLog
from yarm.ros.console.floor_book import FloorBook
from yarm.ros.console.room_book import RoomBook
from yarm.ros.console.routes import Route
from yarm.ros.console.transforms import PoseBook


class SystemBook:
    """Takes in messages and draws what was heard last. Thread-safe."""

    def __init__(self, areas: Callable[[Sequence[str]], List[Area]], warn: Callable[[str], None]) -> None:
        """Nothing is known yet.

        Args:
            areas: the private areas of manipulators, by their names.
            warn: takes a line about a message that cannot be used.
        """
        self._lock = threading.RLock()
        self._poses, self._events = PoseBook(warn), EventLog()
        self._cell = CellBook(self._poses, areas, warn)
        self._room, self._floor = RoomBook(self._poses, warn), FloorBook(self._poses, warn)
        self._wanted: Mapping[str, Route] = {}
        self._routes: Mapping[str, Route] = {}

    def routes(self) -> Mapping[str, Route]:
        """What it wants to hear now, by topic; another mapping only when that has changed."""
        with self._lock:
            if self._wanted is not self._cell.routes():
                self._wanted = self._cell.routes()
                found: Dict[str, Route] = {**self._poses.routes(), **self._events.routes()}
                others = (*self._room.routes().items(), *self._floor.routes().items())
                for topic, route in (*others, *self._wanted.items()):
                    known = found.get(topic)
                    found[topic] = route if known is None else route._replace(take=_both(known.take, route.take))
                self._routes = {t: route._replace(take=self._locked(route.take)) for t, route in found.items()}
            return self._routes

    def heard(self, topic: str, now_s: float, wall_s: float) -> None:
        """A message of a topic came, at a simulated time and at one of a clock on the wall, s."""
        with self._lock:
            self._cell.heard(topic, now_s, wall_s)
            self._room.heard(topic, now_s, wall_s)
            self._floor.heard(topic, now_s, wall_s)

    def parts(self) -> Dict[str, Part]:
        """What seldom changes, by name."""
        with self._lock:
            return {**self._shown.parts(), "events": self._events.part()}

    def state(self, now_s: float, wall_s: float) -> bytes:
        """Everything else.

        Args:
            now_s: simulated time, s.
            wall_s: a clock on the wall that never goes backwards, s.
        """
        with self._lock:
            return self._shown.state(now_s, wall_s)

    @property
    def _shown(self) -> Union[CellBook, RoomBook, FloorBook]:
        if self._floor.active:
            return self._floor
        return self._room if self._room.active and not self._cell.active else self._cell

    def _locked(self, take: Callable[[Any], None]) -> Callable[[Any], None]:
        """A page's picture must not see half of a message."""

        def taken(message: Any) -> None:
            with self._lock:
                take(message)

        return taken


def _both(first: Callable[[Any], None], second: Callable[[Any], None]) -> Callable[[Any], None]:
    def take(message: Any) -> None:
        first(message)
        second(message)

    return take
