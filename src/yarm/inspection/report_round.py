"""The report's round: turn twice, one viewpoint a box, nearest next, three headings at each, home."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Dict, List, Optional, Sequence

import numpy as np

from yarm.geometry import Pose2
from yarm.inspection.boxes import Box
from yarm.inspection.flow import Flow, RoundFlow, WholeFlow
from yarm.inspection.model import ClearCostmaps, Drive, Look, Observation, Outcome, Reading, Spin, Stage, Stand
from yarm.inspection.tour import exact_tour, greedy_tour
from yarm.inspection.viewpoints import ANGLES_DEG, Gap, Viewpoint, angles_beside, first_reachable
from yarm.params import param

LOCALISE_TURNS = 2
Plannable = Callable[[Pose2, Pose2], bool]
"""Whether the navigation has a way from a pose to another, tolerance 0."""


@dataclass(frozen=True)
class ReportRoundParams:
    """Numbers of the report's round."""

    turn_rate: float = param(0.2, "rad/s", "of the turns that localise", low=0.05, high=3.0)
    heading_step: float = param(math.pi / 32, "rad", "to either side of straight ahead at a box", low=0.0, high=1.0)
    images: int = param(7, "", "at each heading", low=1, high=1000)
    tries: int = param(2, "", "at a box whose goal fails", low=1, high=10)
    order: str = param("greedy", "", "in which boxes are visited", choices=("greedy", "exact"))
    goal_limit: float = param(60.0, "s", "a goal has failed after this long", low=1.0, high=600.0)
    look_limit: float = param(5.0, "s", "a look has ended after this long", low=0.1, high=60.0)


class ReportRound(RoundFlow):
    """The report's round."""

    def __init__(
        self,
        boxes: Sequence[Box],
        plannable: Plannable,
        gap: Gap,
        params: Optional[ReportRoundParams] = None,
        beside: bool = True,
        pause_s: float = 0.0,
    ) -> None:
        """Visit these boxes.

        Args:
            boxes: known boxes.
            plannable: asks the navigation, as it knows the map now.
            gap: distance from a point to the nearest body.
            params: the report's own unless given.
            beside: whether neighbours and narrow places change the angles that are tried.
            pause_s: between two images.
        """
        super().__init__(boxes)
        self._plannable = plannable
        self._gap = gap
        self._params = params or ReportRoundParams()
        self._beside = beside
        self._pause_s = pause_s
        self._heading_step_rad, self._goal_limit_s = self._params.heading_step, self._params.goal_limit

    def _localise(self, seen: Observation) -> Flow:
        """Two turns; home is where it is then, if that is known."""
        for _ in range(LOCALISE_TURNS):
            seen = yield self._say(Spin(2.0 * math.pi, self._params.turn_rate), Stage.LOCALISE)
        self.home = seen.pose
        return seen

    def _round(self, seen: Observation) -> WholeFlow:
        seen = yield from self._localise(seen)
        if self.home is None:
            yield self._say(Stand(), Stage.FAILED, reason="no pose after the turns; give one and start again")
            return
        views = self._choose(seen)
        for view in self._ordered(views, self.home):
            seen = yield from self._visit(view, seen)
        yield from self._go_home(seen, "")

    def _instead(self, seen: Observation) -> Optional[WholeFlow]:
        why, self._called_home = (self._called_home, "") if self.home is not None else ("", self._called_home)
        return self._go_home(seen, why) if why else None

    def _go_home(self, seen: Observation, why: str) -> WholeFlow:
        assert self.home is not None
        ended = {verdict.box for verdict in self.verdicts}
        for number, box in sorted(self._boxes.items()):
            if number not in ended:
                self._judge(box, Reading(), seen, why)
        seen = yield self._say(Drive(self.home, self._goal_limit_s), Stage.HOME)
        missed = "" if seen.outcome == Outcome.DONE else f"not home: {seen.reason}"
        yield self._say(Stand(), Stage.FAILED if missed else Stage.DONE, reason=missed)

    def _choose(self, seen: Observation) -> Dict[int, Viewpoint]:
        """One viewpoint a box; boxes without any get their reason now."""
        views = {}
        here = seen.pose or Pose2(0.0, 0.0)
        for number, box in sorted(self._boxes.items()):
            others = [other for other in self._boxes.values() if other is not box]
            angles = angles_beside(box, others, self._gap) if self._beside else ANGLES_DEG
            view = first_reachable(box, lambda pose: self._plannable(here, pose), angles)
            if view is None:
                self._judge(box, Reading(), seen, "no viewpoint of it can be reached")
            else:
                views[number] = view
                tried = " ".join(str(angle) for angle in angles)
                self._chosen(seen, view, f"the first that can be reached; angles in the order {tried}")
        return views

    def _ordered(self, views: Dict[int, Viewpoint], home: Pose2) -> List[Viewpoint]:
        """By straight distances."""
        stops = list(views.values())
        places = np.array([(view.pose.x, view.pose.y) for view in stops] + [(home.x, home.y)])
        costs = np.linalg.norm(places[:, None] - places[None], axis=2)
        solve = greedy_tour if self._params.order == "greedy" else exact_tour
        return [stops[i] for i in solve(costs, [view.box for view in stops]).stops]

    def _visit(self, view: Viewpoint, seen: Observation) -> Flow:
        for attempt in range(self._params.tries):
            seen = yield self._say(Drive(view.pose, self._goal_limit_s), Stage.DRIVE, view.box)
            if seen.outcome == Outcome.DONE:
                seen = yield from self._look(view, seen)
                return seen
            self._note(seen, "failed", box=view.box, attempt=attempt + 1, reason=seen.reason)
            if attempt + 1 < self._params.tries:
                seen = yield self._say(ClearCostmaps(), Stage.LOCALISE, view.box)
                seen = yield self._say(Spin(2.0 * math.pi, self._params.turn_rate), Stage.LOCALISE, view.box)
        self._judge(self._boxes[view.box], Reading(), seen, f"its viewpoint was not reached: {seen.reason}")
        return seen

    def _look(self, view: Viewpoint, seen: Observation) -> Flow:
        """Three headings in place, each a goal of its own; where the goal ends, it looks."""
        reading = Reading()
        for turn in (self._heading_step_rad, 0.0, -self._heading_step_rad):
            goal = Pose2(view.pose.x, view.pose.y, view.pose.yaw_rad + turn)
            seen = yield self._say(Drive(goal, self._goal_limit_s), Stage.DRIVE, view.box)
            look = Look(view.box, self._params.images, self._params.look_limit, self._pause_s)
            seen = yield self._say(look, Stage.LOOK, view.box)
            reading = seen.reading or reading
        self._judge(self._boxes[view.box], reading, seen, "" if reading.tag >= 0 else "no tag had enough votes")
        return seen
