"""The same warning not again and again."""

from __future__ import annotations

import math
import time
from typing import Callable, Dict

AGAIN_S = 5.0
"""Wall time between two warnings of the same words, s."""
MOST = 50
"""Different words that are remembered."""


def throttled(warn: Callable[[str], None], clock: Callable[[], float] = time.monotonic) -> Callable[[str], None]:
    """The same, but each text at most once in a while."""
    said: Dict[str, float] = {}

    def say(text: str) -> None:
        now_s = clock()
        if now_s - said.get(text, -math.inf) >= AGAIN_S:
            if len(said) >= MOST:
                said.clear()
            said[text] = now_s
            warn(text)

    return say
