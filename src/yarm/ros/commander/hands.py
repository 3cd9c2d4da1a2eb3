"""What hands say with stamps, in lock-step, handed on with the map of its time."""

from __future__ import annotations

import threading
from collections import deque
from typing import Callable, Collection, Deque, Dict, Tuple

from yarm.commander.events import Grasp
from yarm.ros.common.clock import SAME_STAMP_S

LIMIT_S = 5.0
"""Longest wall time that a map waits for the words of its time, s."""


class HandWords:
    """Words by the time at which they are so. Thread-safe: they come on threads of their own."""

    def __init__(self, hand_on: Callable[[Grasp], None], limit_s: float = LIMIT_S) -> None:
        """Nothing said yet; a change is handed on by ``take``."""
        self._hand_on, self._limit_s = hand_on, limit_s
        self._condition = threading.Condition()
        self._said: Deque[Tuple[float, Grasp]] = deque()
        self._newest_s: Dict[str, float] = {}
        self._so: Dict[str, bool] = {}

    def say(self, stamp_s: float, word: Grasp) -> None:
        """A hand's word at a time, s."""
        with self._condition:
            self._newest_s[word.robot] = stamp_s
            self._said.append((stamp_s, word))
            self._condition.notify_all()

    def take(self, stamp_s: float) -> bool:
        """Hand on what has changed up to a time, s, once every hand that ever spoke has; False when one is silent."""
        with self._condition:
            known = self._condition.wait_for(
                lambda: all(newest >= stamp_s - SAME_STAMP_S for newest in self._newest_s.values()), self._limit_s
            )
            kept = deque(entry for entry in self._said if entry[0] > stamp_s + SAME_STAMP_S)
            for said_s, word in self._said:
                if said_s <= stamp_s + SAME_STAMP_S and self._so.get(word.robot) is not word.grasping:
                    self._so[word.robot] = word.grasping
                    self._hand_on(word)
            self._said = kept
        return known

    def follow(self, robots: Collection[str]) -> None:
        """Wait for the hands of these robots only."""
        with self._condition:
            self._newest_s = {name: stamp_s for name, stamp_s in self._newest_s.items() if name in robots}
            self._said = deque(entry for entry in self._said if entry[1].robot in robots)

    def forget(self) -> None:
        """A new run: what was said before is no longer so."""
        with self._condition:
            self._said.clear()
            self._newest_s.clear()
            self._so.clear()
