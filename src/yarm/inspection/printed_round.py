"""The round as the report's program was printed, faults included; kept to be compared with.

Its goals are never asked how they ended, have no time limit, and are chosen by ways from (0, 0, 0).
"""

from __future__ import annotations

import math
from typing import Dict, Optional, Sequence

from yarm.geometry import Pose2
from yarm.inspection.boxes import Box
from yarm.inspection.flow import Flow
from yarm.inspection.model import Drive, Observation, Spin, Stage
from yarm.inspection.report_round import Plannable, ReportRound, ReportRoundParams
from yarm.inspection.viewpoints import Viewpoint, viewpoint

LOCALISE_RAD = 0.6
"""3 s at 0.2 rad/s."""
HEADING_STEP_RAD = math.pi / 40
PAUSE_S = 0.17
"""Of sleep after each image."""
DISTANCES_M, UNCHECKED_M = (0.5, 0.4, 0.3, 0.2, 0.6, 0.6), 0.7
"""Tried in this order; the last is taken without asking."""
ANGLES_DEG = (0, 30, 60, -30, -60)
CROWDED_DEG, BEHIND_M, CROWDED_M = (0, 30, -30), 0.2, 0.15
"""At these angles a viewpoint is ruled out when a box's centre is so near to the point so far behind it."""
ORIGIN = Pose2(0.0, 0.0)


class PrintedRound(ReportRound):
    """The printed program's round. Of the numbers it takes how fast it turns, how many images, in which order."""

    def __init__(self, boxes: Sequence[Box], plannable: Plannable, params: Optional[ReportRoundParams] = None) -> None:
        """Visit these boxes.

        Args:
            boxes: known boxes.
            plannable: asks the navigation, as it knows the map now.
            params: the report's own unless given.
        """
        super().__init__(boxes, plannable, lambda x, y: math.inf, params, pause_s=PAUSE_S)
        self._heading_step_rad = HEADING_STEP_RAD
        self._goal_limit_s = math.inf

    def _localise(self, seen: Observation) -> Flow:
        """Home is taken wherever it believes to be by then."""
        seen = yield self._say(Spin(LOCALISE_RAD, self._params.turn_rate), Stage.LOCALISE)
        self.home = seen.pose or ORIGIN
        return seen

    def _choose(self, seen: Observation) -> Dict[int, Viewpoint]:
        views = {}
        for number, box in sorted(self._boxes.items()):
            views[number] = view = self._view_of(box)
            self._chosen(seen, view, "the first with a way from (0, 0, 0), or the last of all, unasked")
        return views

    def _view_of(self, box: Box) -> Viewpoint:
        for distance in DISTANCES_M:
            for angle in ANGLES_DEG:
                view = viewpoint(box, distance, angle)
                if not self._crowded(box, distance, angle) and self._plannable(ORIGIN, view.pose):
                    return view
        return viewpoint(box, UNCHECKED_M, ANGLES_DEG[0])

    def _crowded(self, box: Box, distance_m: float, angle_deg: int) -> bool:
        """Its one look at neighbours: by their centres, which lie inside their bodies."""
        behind = viewpoint(box, distance_m + BEHIND_M, angle_deg).pose
        centres = [other.pose for other in self._boxes.values()]
        return angle_deg in CROWDED_DEG and any(behind.distance(centre) <= CROWDED_M for centre in centres)

    def _visit(self, view: Viewpoint, seen: Observation) -> Flow:
        """However the goal ended, what is seen counts for this box."""
        seen = yield self._say(Drive(view.pose, self._goal_limit_s), Stage.DRIVE, view.box)
        seen = yield from self._look(view, seen)
        return seen
