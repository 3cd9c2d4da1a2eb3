"""Writes down what the Commander must know after its death, and reads what the one before wrote."""

from __future__ import annotations

from typing import Optional

from yarm.commander.memory import Memory
from yarm.ros.common import names
from yarm.ros.common.journals import NodeJournal


class MemoryBook:
    """The Commander's journal: one record a change of what is to be remembered."""

    def __init__(self) -> None:
        """Read what the Commander before left."""
        self._journal = NodeJournal(names.COMMANDER_NODE)
        self.taken_up = self._journal.last(Memory)
        self._written: Optional[Memory] = None

    @property
    def kept(self) -> bool:
        """Whether anybody would read what is written."""
        return self._journal.kept

    def note(self, memory: Memory) -> None:
        """Write what has changed; a change of state, and of what it does, is on the disk at once."""
        before = self._written
        if memory.same_as(before):
            return
        self._written = memory
        if before is None or self._journal.long:
            self._journal.begin(memory)
        else:
            self._journal.append(memory, sync=(memory.state, memory.work) != (before.state, before.work))
