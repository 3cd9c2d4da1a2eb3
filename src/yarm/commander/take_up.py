"""Between a Commander's death and its work going on: wait until everything that the work needs is known again."""

from __future__ import annotations

from typing import List, Optional

from yarm.commander.activity import Activity, Ending
from yarm.commander.cell_state import CellState
from yarm.commander.events import Action, TaskView
from yarm.commander.memory import Memory
from yarm.commander.pieces import Load

CLOCK_BACK_S = 0.1
"""A map older than the memory by more than this is of a simulator that was started again, s."""


class TakeUp(Activity):
    """Stands until map, registry and action servers are there, and hands have been drawn up.

    An action server counts as there once it has ended whatever the former Commander had sent.
    """

    def __init__(self, cell: CellState, memory: Memory, work: Activity) -> None:
        """Before some work.

        Args:
            cell: restored from the memory.
            memory: of the former Commander.
            work: what goes on afterwards.
        """
        super().__init__(cell)
        self.memory = memory
        self.work = work
        self.clock_went_back = False
        self._there_s: Optional[float] = None
        self.reason = self._waiting()

    def advance(self, now_s: float) -> List[Action]:
        """Done when nothing is missing any more."""
        if self.cell.map is not None and self.cell.map.stamp_s < self.memory.stamp_s - CLOCK_BACK_S:
            self.clock_went_back = True
            self.finish(Ending.SUCCEEDED)
            return []
        missing = self._missing()
        if missing:
            self.reason, self._there_s = self._waiting(missing), None
            return []
        self._there_s = now_s if self._there_s is None else self._there_s
        if self.memory.at_work and now_s - self._there_s < self.cell.params.retry_s:
            self.reason = self._waiting(f"the hand of {', '.join(self.memory.at_work)} to be drawn up")
            return []
        for robot, load in self.cell.loads.items():
            self.cell.loads[robot] = Load(load.piece, self.cell.pieces.get(load.piece), load.seen)
        self.finish(Ending.SUCCEEDED)
        return []

    def tasks(self) -> List[TaskView]:
        """The tasks as they were left."""
        return self.work.tasks()

    def _missing(self) -> str:
        cell = self.cell
        if cell.map is None:
            return "planning_metadata"
        if not cell.registry_complete:
            return "object_registry, with the frames of every robot in it on /tf"
        silent = [name for name in cell.mobiles + cell.manipulators if name not in cell.connected]
        return f"the action server of {', '.join(silent)}" if silent else ""

    def _waiting(self, missing: str = "") -> str:
        was = f"{self.memory.state.name} goes on after the Commander's death"
        return f"{was}; waits for {missing or self._missing()}"
