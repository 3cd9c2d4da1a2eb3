"""Which topics a book of a running system listens to, and how they get there: from the graph, or from a recording."""

from __future__ import annotations

import struct
import threading
import time
from typing import Any, Callable, Collection, Dict, Mapping, NamedTuple, Optional, Protocol

import rospy
from rospy.impl.tcpros import DEFAULT_BUFF_SIZE

from yarm.console.pulse import Beat, Pulse
from yarm.ros.common.checks import sender_of

HELD = 5
"""Messages of one topic that wait."""
LARGEST_BYTES = 2**22
STAMP, SEQUENCE_BYTES = struct.Struct("<II"), 4
"""Of a header's bytes: the stamp, behind the sequence number."""


class Route(NamedTuple):
    """One topic: its type, who takes its messages in, how many wait, and whether they come as ``rospy.AnyMsg``."""

    kind: Any
    take: Callable[[Any], None]
    held: int = HELD
    raw: bool = False


class Book(Protocol):
    """What is known of a system from its messages."""

    def routes(self) -> Mapping[str, Route]:
        """What it wants to hear now, by topic; after a message that changed it, another mapping."""

    def heard(self, topic: str, now_s: float, wall_s: float) -> None:
        """A message of a topic has been taken in, at a simulated time and at one of a clock on the wall, s."""


class Feed:
    """Listens to a book's topics on the graph, and changes with it. Thread-safe."""

    def __init__(self, book: Book, guest_of: Collection[str] = (), guest: bool = False) -> None:
        """Subscribe.

        Args:
            book: who wants to hear.
            guest_of: topics that somebody else in this process hears, too, as messages: all subscribers of one topic
                in one process get the same, so these never come as bytes.
            guest: how many messages wait is left to whoever else hears a topic: the last word on that counts for all.
        """
        self._book, self._guest_of, self._guest = book, guest_of, guest
        self._lock, self._following = threading.RLock(), False
        self._subscribers: Dict[str, rospy.Subscriber] = {}
        self._followed: Mapping[str, Route] = {}
        self._pulse, self._pulse_lock = Pulse(), threading.Lock()
        self.follow()

    def follow(self) -> None:
        """Listen to what the book wants now, and to nothing else."""
        with self._lock:
            if self._following:  # called by a latched message that came while we subscribe; who subscribes looks again
                return
            self._following = True
            try:
                while self._followed is not self._book.routes():
                    self._followed = self._book.routes()
                    self._subscribe(self._followed)
            finally:
                self._following = False

    def _subscribe(self, wanted: Mapping[str, Route]) -> None:
        for topic in [topic for topic in self._subscribers if topic not in wanted]:
            self._subscribers.pop(topic).unregister()
        for topic, route in wanted.items():
            if topic not in self._subscribers:
                self._subscribers[topic] = rospy.Subscriber(
                    topic,
                    rospy.AnyMsg if route.raw and topic not in self._guest_of else route.kind,
                    self._taker(topic, route),
                    queue_size=None if self._guest else route.held,
                    buff_size=DEFAULT_BUFF_SIZE if self._guest else LARGEST_BYTES,
                    tcp_nodelay=True,
                )

    def beats(self) -> Dict[str, Beat]:
        """How each node's topics come, by the node's name without its slash."""
        with self._pulse_lock:
            return self._pulse.beats(rospy.get_time())

    def _taker(self, topic: str, route: Route) -> Callable[[Any], None]:
        def take(message: Any) -> None:
            route.take(message)
            now_s = rospy.get_time()
            self._book.heard(topic, now_s, time.monotonic())
            with self._pulse_lock:
                self._pulse.note(sender_of(message), topic, now_s, stamp_of(message, route.kind))
            if self._book.routes() is not self._followed:
                self.follow()

        return take


def stamp_of(message: Any, kind: Any) -> Optional[float]:
    """The stamp of a message of a type, or of its bytes, s; None when it has none, or the time 0."""
    if "header" not in kind.__slots__[:1]:
        return None
    if isinstance(message, rospy.AnyMsg):
        stamp_s = sum(part * unit for part, unit in zip(STAMP.unpack_from(message._buff, SEQUENCE_BYTES), (1.0, 1e-9)))
    else:
        stamp_s = message.header.stamp.to_sec()
    return stamp_s if stamp_s > 0.0 else None
