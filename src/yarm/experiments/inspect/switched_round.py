"""The report's round with those of its program's faults that are the round's own."""

from __future__ import annotations

import math
from typing import Sequence

from yarm.experiments.inspect.switches import Switches
from yarm.inspection.boxes import Box
from yarm.inspection.flow import Flow
from yarm.inspection.model import ClearCostmaps, Observation, Stage
from yarm.inspection.printed_round import ORIGIN, PAUSE_S
from yarm.inspection.report_round import Plannable, ReportRound, ReportRoundParams
from yarm.inspection.viewpoints import Gap


class SwitchedRound(ReportRound):
    """The report's, with faults."""

    def __init__(self, boxes: Sequence[Box], plannable: Plannable, gap: Gap, switches: Switches) -> None:
        """Visit these boxes.

        Args:
            boxes: known boxes.
            plannable: asks the navigation, as it knows the map now.
            gap: distance from a point to the nearest body.
            switches: the faults.
        """
        params = ReportRoundParams(order="exact" if switches.exact_order else "greedy")
        pause_s = PAUSE_S if switches.sleeps else 0.0
        super().__init__(boxes, plannable, gap, params, not switches.no_neighbours, pause_s)
        self._switches = switches
        if switches.no_goal_limit:
            self._goal_limit_s = math.inf

    def _localise(self, seen: Observation) -> Flow:
        believed = seen.pose or ORIGIN
        if self._switches.turns_lost:
            seen = yield self._say(ClearCostmaps(), Stage.LOCALISE)  # a second, in which the navigation gets its map
        else:
            seen = yield from super()._localise(seen)
        if self._switches.turns_lost or self._switches.home_early:
            self.home = believed
        return seen
