"""A test case that keeps what it hears of topics, and waits for what it expects with a limit."""

from __future__ import annotations

import threading
import time
import unittest
from typing import Any, Callable, ClassVar, Dict, List, Tuple

import rospy

KEPT = 3000
"""Messages of a topic that are kept unless a test says otherwise."""
SHOWN = 400
"""Characters of a message that a failure shows."""


class ListeningTest(unittest.TestCase):
    """Each class that begins with :meth:`listen` hears on its own.

    Attributes:
        limit_s: wall time that anything may take, s.
        kept: the newest messages of each topic, oldest first.
    """

    limit_s = 90.0
    changed: ClassVar[threading.Condition]
    kept: ClassVar[Dict[str, List[Any]]]

    @classmethod
    def listen(cls, *topics: Tuple[str, Any]) -> None:
        """Hear topics of types from now on."""
        cls.changed, cls.kept = threading.Condition(), {}
        for topic, kind in topics:
            cls.keep(topic, kind)

    @classmethod
    def keep(cls, topic: str, kind: Any, most: int = KEPT) -> rospy.Subscriber:
        """Hear one more, of which so many messages are kept; what was kept of it before is dropped."""
        cls.kept[topic] = []

        def receive(message: Any) -> None:
            with cls.changed:
                cls.kept[topic].append(message)
                del cls.kept[topic][:-most]
                cls.changed.notify_all()

        return rospy.Subscriber(topic, kind, receive, queue_size=100, buff_size=1 << 24)

    def wait(self, condition: Callable[[], Any], what: str) -> Any:
        """What a condition gives once it holds; the test fails when that takes too long."""
        with self.changed:
            if not self.changed.wait_for(condition, timeout=self.limit_s):
                newest = "; ".join(f"{topic}: {str(kept[-1])[:SHOWN]}" for topic, kept in self.kept.items() if kept)
                self.fail(f"never came: {what}; the newest of each topic: {newest or 'none'}")
            return condition()

    def fresh(self, topic: str) -> Any:
        """The newest message with a header that is younger than this moment."""
        now_s = rospy.get_time()
        return self.wait(
            lambda: next((m for m in reversed(self.kept[topic]) if m.header.stamp.to_sec() > now_s), None),
            f"a message on {topic} after {now_s:.2f} s",
        )

    def ask(self, question: Callable[[], Any], what: str) -> Any:
        """What a question gives once that is something: it is put again ten times a second of wall time."""
        end = time.monotonic() + self.limit_s
        answer = question()
        while not answer:
            self.assertLess(time.monotonic(), end, f"never came: {what}")
            time.sleep(0.1)
            answer = question()
        return answer
