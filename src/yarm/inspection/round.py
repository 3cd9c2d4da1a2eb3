"""Our round: sure of its place first, views and order solved together, home in time whatever happens."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Optional, Sequence, Set, Tuple

from yarm.geometry import Pose2
from yarm.inspection.boxes import Box
from yarm.inspection.flow import Flow, RoundFlow, WholeFlow
from yarm.inspection.model import (
    UNSEEN,
    ClearCostmaps,
    Drive,
    Look,
    Observation,
    Outcome,
    Reading,
    Spin,
    Stage,
    Stand,
)
from yarm.inspection.times import DriveTimes
from yarm.inspection.tour_plan import Budget, Chance, Lengths, Plan, Planner, roomy
from yarm.inspection.viewpoints import Gap, Viewpoint
from yarm.params import param
from yarm.tags.evidence import ACCEPTING

CHECK_S = 1.0
IN_HAND_WORTH = 0.01
"""Of another look at a box that has an answer already, against 1 of the first look at one."""


@dataclass(frozen=True)
class RoundParams:
    """Numbers of our round."""

    time_limit_s: float = param(480.0, "s", "the robot is home by this long after the start", low=10.0, high=36000.0)
    margin_s: float = param(10.0, "s", "of that kept in hand", low=0.0, high=600.0)
    turn_rate: float = param(0.6, "rad/s", "of the turns that localise", low=0.05, high=3.0)
    turns: int = param(2, "", "turns after which it asks for a pose instead", low=1, high=10)
    sure: float = param(ACCEPTING, "", "probability at which looking ends", low=0.5, high=1.0)
    doubtful: float = param(0.95, "", "below this a box is looked at again from elsewhere", low=0.5, high=1.0)
    views: int = param(3, "", "views of a box at most", low=1, high=20)
    images: int = param(5, "", "of a view at most", low=1, high=100)
    look_limit: float = param(2.0, "s", "a look ends after this long", low=0.1, high=60.0)
    goal_slack_s: float = param(
        10.0, "s", "a goal has failed this long after it should be reached", low=1.0, high=600.0
    )


class Round(RoundFlow):
    """Our round."""

    def __init__(
        self,
        boxes: Sequence[Box],
        lengths: Lengths,
        chance: Chance,
        params: Optional[RoundParams] = None,
        gap: Gap = roomy,
    ) -> None:
        """Visit these boxes.

        Args:
            boxes: known boxes.
            lengths: asks the navigation, as it knows the map now.
            chance: how likely a view decides.
            params: the defaults unless given.
            gap: distance from a point to the nearest body.
        """
        super().__init__(boxes)
        self._lengths = lengths
        self._planner = Planner(lengths, chance, gap)
        self._params = params or RoundParams()
        self._times = DriveTimes()
        self._left: Dict[int, Box] = dict(self._boxes)
        self._seen: Dict[int, List[Viewpoint]] = {}
        self._best: Dict[int, Reading] = {}
        self._blocked: Dict[int, str] = {}
        self._hopeless: Set[int] = set()
        self._going_home = False
        self._checked_s = -math.inf
        self._why = ""
        self.tour: Tuple[Viewpoint, ...] = ()
        """Views of the cheapest round from the last stop on, in visiting order."""

    def home_s(self, pose: Optional[Pose2]) -> float:
        """What the way home from a pose hardly ever exceeds, s; 0 while home is not known."""
        if pose is None or self.home is None:
            return 0.0
        length = float(self._lengths(pose, [self.home])[0])
        straight = pose.distance(self.home)
        return self._times.late_s(
            DriveTimes.undisturbed_s(length if math.isfinite(length) else straight, pose, self.home)
        )

    def _left_s(self, now_s: float) -> float:
        return self._params.time_limit_s - self._params.margin_s - now_s

    def _instead(self, seen: Observation) -> Optional[WholeFlow]:
        """Looked at once a second: when the way home takes all the time that is left, home it is."""
        if self._going_home or self.home is None:
            return None
        if self._called_home:
            return self._homewards(seen, self._called_home)
        if seen.now_s < self._checked_s + CHECK_S:
            return None
        self._checked_s = seen.now_s
        late = self.home_s(seen.pose) + CHECK_S >= self._left_s(seen.now_s)
        return self._homewards(seen, "no time is left for more") if late else None

    def _round(self, seen: Observation) -> WholeFlow:
        for _ in range(self._params.turns):
            if not seen.localised:
                seen = yield self._say(Spin(2.0 * math.pi, self._params.turn_rate), Stage.LOCALISE)
        if not seen.localised or seen.pose is None:
            reason = "the place is not certain after turning; give a pose (2D Pose Estimate) and start again"
            yield self._say(Stand(), Stage.FAILED, reason=reason)
            return
        self.home = seen.start or seen.pose
        while self._left:
            view = self._next(seen)
            if view is None:
                break
            seen = yield from self._visit(view, seen)
        yield from self._homewards(seen, "")

    def _next(self, seen: Observation) -> Optional[Viewpoint]:
        """The first view of the cheapest round over the most boxes that ends in time; the others are named.

        The round is planned with what drives usually take: it is planned again after each of them. That the robot is
        home in time rests on the next view, and the way home from there, by what hardly ever is exceeded.
        """
        assert self.home is not None and seen.pose is not None
        budget = Budget(self._left_s(seen.now_s), self._times.typical, self._params.look_limit)
        worth = {box: IN_HAND_WORTH if self._has_answer(number) else 1.0 for number, box in self._left.items()}
        plan = self._planner.plan(seen.pose, self.home, worth, self._seen, budget)
        for number in plan.unreachable:
            self._end(number, seen, self._blocked.get(number, "no view of it that is left can be reached"))
        self.tour = plan.views
        for number in sorted(set(self._left) - {view.box for view in plan.views} - self._hopeless):
            self._hopeless.add(number)
            self._note(seen, "hopeless", box=number, left_s=round(budget.left_s, 1))
        if plan.views and self._fits(plan.views[0], seen):
            self._why = self._why_of(plan)
            return plan.views[0]
        return self._quickest(seen)

    def _has_answer(self, number: int) -> bool:
        return self._best.get(number, Reading()).tag != UNSEEN

    def _quickest(self, seen: Observation) -> Optional[Viewpoint]:
        """The view that is taken and come home from soonest, of a box without an answer, if there is time for it."""
        assert seen.pose is not None
        boxes = [box for number, box in self._left.items() if not self._has_answer(number)]
        views = [view for box in boxes for view in self._planner.fresh(box, seen.pose, self._seen)]
        if not views:
            return None
        view = min(views, key=lambda view: self._late_there_and_home_s(view, seen))
        self._why = "the quickest; there is no time for more"
        return view if self._fits(view, seen) else None

    def _why_of(self, plan: Plan) -> str:
        """Why the first view of a plan is the next."""
        view = plan.views[0]
        chance = self._planner.chance_of(self._boxes[view.box], view)
        before = self._best.get(view.box)
        again = "" if before is None else f"again, as the looks before leave {before.probability:.3f}; "
        boxes, cost = len(plan.views), plan.cost_s
        rank = "the cheapest round" if plan.gap == 0.0 else f"a round at most {100 * plan.gap:.0f} % above the cheapest"
        return f"{again}first of {rank} over the {boxes} left ({cost:.0f} s); decides with {chance:.2f}"

    def _fits(self, view: Viewpoint, seen: Observation) -> bool:
        """Whether this view and then the way home end in time."""
        return self._late_there_and_home_s(view, seen) + self._params.look_limit <= self._left_s(seen.now_s)

    def _late_there_and_home_s(self, view: Viewpoint, seen: Observation) -> float:
        """What the ways to a view and from there home hardly ever exceed."""
        assert seen.pose is not None
        there = DriveTimes.undisturbed_s(float(self._lengths(seen.pose, [view.pose])[0]), seen.pose, view.pose)
        return self._times.late_s(there) + self.home_s(view.pose)

    def _visit(self, view: Viewpoint, seen: Observation) -> Flow:
        assert seen.pose is not None
        due_s = DriveTimes.undisturbed_s(float(self._lengths(seen.pose, [view.pose])[0]), seen.pose, view.pose)
        began_s = seen.now_s
        limit_s = self._times.late_s(due_s) + self._params.goal_slack_s
        self._seen.setdefault(view.box, []).append(view)
        self._chosen(seen, view, self._why)
        seen = yield self._say(Drive(view.pose, limit_s), Stage.DRIVE, view.box)
        if seen.outcome != Outcome.DONE:
            self._blocked[view.box] = f"its view at {view.distance_m:g} m, {view.angle_deg:g} deg: {seen.reason}"
            self._note(seen, "failed", box=view.box, reason=seen.reason)
            seen = yield self._say(ClearCostmaps(), Stage.DRIVE, view.box)
            if not seen.localised:
                seen = yield self._say(Spin(2.0 * math.pi, self._params.turn_rate), Stage.LOCALISE, view.box)
            return self._given_up(view.box, seen)
        self._times.add(due_s, seen.now_s - began_s)
        seen = yield self._say(Look(view.box, self._params.images, self._params.look_limit), Stage.LOOK, view.box)
        return self._read(view.box, seen)

    def _read(self, number: int, seen: Observation) -> Observation:
        reading = seen.reading or Reading()
        best = self._best.get(number, Reading())
        self._best[number] = best = reading if reading.probability >= best.probability else best
        if best.tag == UNSEEN and seen.reason:
            self._blocked[number] = seen.reason
        decided = best.tag != UNSEEN and best.probability >= self._params.doubtful
        if decided:
            self._end(number, seen, "")
            return seen
        return self._given_up(number, seen)

    def _given_up(self, number: int, seen: Observation) -> Observation:
        """After the last view that is allowed a box ends with what is known of it."""
        if len(self._seen[number]) >= self._params.views:
            doubt = f"in doubt after {self._params.views} views"
            self._end(number, seen, self._blocked.get(number, doubt))
        return seen

    def _homewards(self, seen: Observation, why: str) -> WholeFlow:
        assert self.home is not None
        self._going_home = True
        for number in sorted(self._left):
            self._end(number, seen, why or "no time was left for it")
        while True:
            limit_s = max(self._left_s(seen.now_s) + self._params.margin_s, 1.0)
            seen = yield self._say(Drive(self.home, limit_s), Stage.HOME)
            if seen.outcome == Outcome.DONE:
                yield self._say(Stand(), Stage.DONE)
                return
            if seen.now_s >= self._params.time_limit_s:
                yield self._say(Stand(), Stage.FAILED, reason=f"not home in time: {seen.reason}")
                return
            self._note(seen, "failed", home=1, reason=seen.reason)
            seen = yield self._say(ClearCostmaps(), Stage.HOME)
            if not seen.localised:
                seen = yield self._say(Spin(2.0 * math.pi, self._params.turn_rate), Stage.HOME)

    def _end(self, number: int, seen: Observation, reason: str) -> None:
        self._judge(self._left.pop(number), self._best.get(number, Reading()), seen, reason)
