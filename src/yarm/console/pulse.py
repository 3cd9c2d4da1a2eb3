"""How often each node speaks, and how old what it says is when it comes: of the last few seconds."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from typing import Deque, Dict, Optional, Tuple

import numpy as np

WINDOW_S = 10.0
"""Simulated time that the figures are of, s."""
LEAST_S = 1.0
"""A rate is of so long at least, s."""
MOST = 1000
"""Messages of one topic that are looked at: the newest."""


@dataclass(frozen=True)
class Beat:
    """How one topic comes.

    Attributes:
        topic: its name.
        rate_hz: messages a simulated second.
        p50_ms: median age of what a message is stamped with when it comes, ms of simulated time; None without stamps.
        p99_ms: 99th percentile of the same.
    """

    topic: str
    rate_hz: float
    p50_ms: Optional[float]
    p99_ms: Optional[float]


@dataclass
class _Heard:
    first_s: float
    times: Deque[float] = field(default_factory=lambda: deque(maxlen=MOST))
    ages: Deque[float] = field(default_factory=lambda: deque(maxlen=MOST))


class Pulse:
    """Takes in when messages come. Not thread-safe."""

    def __init__(self) -> None:
        """Nothing has come."""
        self._heard: Dict[Tuple[str, str], _Heard] = {}

    def note(self, node: str, topic: str, now_s: float, stamp_s: Optional[float]) -> None:
        """A message of a node came at a simulated time, s; time that goes backwards begins anew.

        Args:
            node: who sent it.
            topic: on which topic.
            now_s: simulated time, s.
            stamp_s: time it is stamped with, s; None when it has no stamp.
        """
        heard = self._heard.setdefault((node, topic), _Heard(now_s))
        if heard.times and now_s < heard.times[-1]:
            heard = self._heard[node, topic] = _Heard(now_s)
        heard.times.append(now_s)
        heard.ages.append(math.nan if stamp_s is None else max(0.0, now_s - stamp_s))

    def beats(self, now_s: float) -> Dict[str, Beat]:
        """Of each node its most frequent topic, at a simulated time, s; one that has been silent for long has none."""
        found: Dict[str, Beat] = {}
        for (node, topic), heard in list(self._heard.items()):
            beat = _beat(topic, heard, now_s)
            if beat is None:
                del self._heard[node, topic]
            elif node not in found or beat.rate_hz > found[node].rate_hz:
                found[node] = beat
        return found


def _beat(topic: str, heard: _Heard, now_s: float) -> Optional[Beat]:
    recent = [(at, age) for at, age in zip(heard.times, heard.ages) if now_s - WINDOW_S <= at <= now_s]
    if not recent:
        return None
    length_s = now_s - (recent[0][0] if len(recent) == MOST else max(heard.first_s, now_s - WINDOW_S))
    ages = [age for _, age in recent if math.isfinite(age)]
    p50, p99 = (1e3 * np.percentile(ages, [50, 99])).round(1).tolist() if ages else (None, None)
    return Beat(topic, round(len(recent) / max(length_s, LEAST_S), 1), p50, p99)
