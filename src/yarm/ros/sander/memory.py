"""Writes down what the sander must know after its death, and reads what the one before wrote."""

from __future__ import annotations

from typing import Optional, Tuple

import rospy

from yarm.control.sander.memory import PlanRecord, SanderMemory, SanderRecord
from yarm.control.sander.planner import RasterPlan
from yarm.records import RecordError, read
from yarm.ros.common.journals import NodeJournal


class SanderBook:
    """The sander's journal: begun anew with every raster, then how far it is."""

    def __init__(self, node: str) -> None:
        """Read what the sander before left."""
        self._node = node
        self._journal = NodeJournal(node)
        self._written: Optional[SanderMemory] = None
        self._plan: Optional[RasterPlan] = None
        self.taken_up = self._read()

    def note(self, memory: SanderMemory, plan: Optional[RasterPlan]) -> None:
        """Write what has changed; a change of state is on the disk at once."""
        if not self._journal.kept:
            return
        before = self._written
        if before is None or plan is not self._plan or self._journal.long:
            self._journal.begin(SanderRecord(memory, None if plan is None else PlanRecord.of(plan)))
        elif memory.as_good_as(before):
            return
        else:
            self._journal.append(SanderRecord(memory), sync=memory.state is not before.state)
        self._written, self._plan = memory, plan

    def _read(self) -> Optional[Tuple[SanderMemory, Optional[RasterPlan]]]:
        last = self._journal.last(SanderRecord)
        if last is None:
            return None
        try:
            first = read(SanderRecord, self._journal.found.records[0])
        except RecordError as error:
            rospy.logwarn("%s: the raster in its journal is not understood: %s", self._node, error)
            return last.now, None
        return last.now, None if first.plan is None else first.plan.plan()
