"""Robots that the planner has moved aside stay there until those they made way for are done.

Sent out of columns to be kept clear before that, they would stand in the way again, and be moved aside again, for ever.
"""

from __future__ import annotations

from typing import Collection, Dict, FrozenSet, Mapping, Set


class StoodAside:
    """Who went into the columns without a goal of its own, and for whose sake."""

    def __init__(self) -> None:
        """Nobody."""
        self._outside: Set[str] = set()
        self._served: Dict[str, FrozenSet[str]] = {}

    def update(self, inside: Mapping[str, bool], served: Collection[str]) -> Set[str]:
        """Take in where the idle robots are.

        Args:
            inside: for each idle robot whether it stands in the columns to be kept clear.
            served: names of the goals that robots are on their way to.

        Returns:
            idle robots that stand inside, were idle outside before, and whose moving aside still serves somebody.
        """
        for name in [name for name, is_in in inside.items() if is_in and name in self._outside]:
            self._served[name] = frozenset(served)
        self._outside = {name for name, is_in in inside.items() if not is_in}
        self._served = {
            name: goals for name, goals in self._served.items() if inside.get(name, False) and goals & set(served)
        }
        return set(self._served)
