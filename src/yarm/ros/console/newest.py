"""The newest message of each topic, and when something came of it last."""

from __future__ import annotations

import math
from typing import Any, Callable, Collection, Dict, Mapping, Tuple

from yarm.ros.common.status_age import STALE_S
from yarm.ros.console.routes import Route

NEVER = (-math.inf, -math.inf)


class Newest:
    """Not thread-safe."""

    def __init__(self) -> None:
        """Nothing has come yet."""
        self._messages: Dict[str, Any] = {}
        self._came: Dict[str, Tuple[float, float]] = {}

    def routes(self, kinds: Mapping[str, Any], raw: Collection[Any] = ()) -> Dict[str, Route]:
        """Topics whose newest message is kept, by their types; those of the types ``raw`` come as bytes."""
        return {topic: Route(kind, self._keep(topic), raw=kind in raw) for topic, kind in kinds.items()}

    def get(self, topic: str, default: Any = None) -> Any:
        """The newest message of a topic; ``default`` before there is one."""
        return self._messages.get(topic, default)

    def came(self, topic: str, now_s: float, wall_s: float) -> None:
        """A message of a topic came, at a simulated time and at one of a clock on the wall, s."""
        self._came[topic] = (wall_s, now_s)

    def last(self, topic: str) -> Tuple[float, float]:
        """When a message of a topic came last: by a clock on the wall and simulated, s; ``NEVER`` when none did."""
        return self._came.get(topic, NEVER)

    def has_come(self, topic: str) -> bool:
        """Whether a message of a topic ever came."""
        return topic in self._came

    def silence(self, topic: str, sender: str, now_s: float, wall_s: float) -> str:
        """That nothing more comes from a sender: of a slow simulator's time, not of ours; empty when it comes.

        So it is of what never came: whether it should have is for others to say.
        """
        last_wall_s, last_s = self.last(topic)
        if not self.has_come(topic) or min(wall_s - last_wall_s, abs(now_s - last_s)) <= STALE_S:
            return ""
        return f"nothing heard {sender} for {wall_s - last_wall_s:.0f} s: what is shown is old"

    def _keep(self, topic: str) -> Callable[[Any], None]:
        def keep(message: Any) -> None:
            self._messages[topic] = message

        return keep
