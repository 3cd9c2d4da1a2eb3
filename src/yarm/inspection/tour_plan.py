"""Viewpoints and order solved together: which view of which box next, so that the whole round is cheapest."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Dict, List, Mapping, Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray, Pose2
from yarm.inspection.boxes import Box
from yarm.inspection.times import DriveTimes
from yarm.inspection.tour import MOST_EXACT, Tour, largest_tour
from yarm.inspection.viewpoints import Gap, Viewpoint, viewpoint

DISTANCES_M = (0.45, 0.55, 0.65, 0.8, 0.95)
ANGLES_DEG = (0, 20, -20, 40, -40, 60, -60)
FAR_DISTANCES_M, FLAT_ANGLES_DEG = (0.8, 0.95, 1.1, 1.25), (70, -70, 75, -75)
"""Tried only where none of the others can be reached: such looks seldom decide."""
MOST_VIEWS = 12
"""Views of a box that take part in the tour; the likeliest ones."""
AGAIN_S = 25.0
"""What a view that does not decide costs: coming back for another."""
LEAST_CHANCE = 0.05
ALIKE_M, ALIKE_DEG = 0.15, 20.0
"""Views so far apart, in distance or in angle, are alike by exp(-1/2); chosen, not fitted."""
LEAST_NEW = 0.25
"""However like others that did not decide, a view keeps this share of its chance."""
ROOMY_M, TIGHT_M, TIGHT_S = 0.30, 0.20, 6.0
"""A view with less than the first free around it costs more, with the second or less so much more: the robot is stopped
before what is that near, and turns there slowly or not at all."""

Lengths = Callable[[Pose2, Sequence[Pose2]], FloatArray]
"""Length of the way from a pose to each of some others, metres; inf where there is none."""
Chance = Callable[[Box, Viewpoint], float]
"""Probability that a view of a box decides what is on it."""


@dataclass(frozen=True)
class Plan:
    """The rest of a round.

    Attributes:
        views: in visiting order; boxes that do not fit into the time have none.
        cost_s: expected, with the way home and the price of views that may not decide.
        unreachable: boxes without any view that can be reached.
        gap: how much more than the cheapest over the same boxes it costs at most, as a share.
    """

    views: Tuple[Viewpoint, ...]
    cost_s: float
    unreachable: Tuple[int, ...]
    gap: float = 0.0


@dataclass(frozen=True)
class Budget:
    """The time that a round may take.

    Attributes:
        left_s: until it has to be over.
        ratio: how much longer than undisturbed a drive usually takes.
        look_s: of a look at most.
    """

    left_s: float
    ratio: float
    look_s: float

    def fits(self, cost_s: float, stops: int) -> bool:
        """Whether a round of this undisturbed time with so many looks is over in time."""
        return self.ratio * cost_s + self.look_s * stops <= self.left_s


def roomy(x: float, y: float) -> float:
    """Room without end around every point, metres."""
    return math.inf


def novelty(view: Viewpoint, before: Sequence[Viewpoint]) -> float:
    """Share of its chance that a view of a box keeps after others of it that did not decide, LEAST_NEW to 1."""
    kept = 1.0
    for other in before:
        far = (view.distance_m - other.distance_m) / ALIKE_M
        aside = (view.angle_deg - other.angle_deg) / ALIKE_DEG
        kept *= 1.0 - math.exp(-0.5 * (far**2 + aside**2))
    return max(kept, LEAST_NEW)


class Planner:
    """Solves the rest of a round from wherever the robot stands."""

    def __init__(self, lengths: Lengths, chance: Chance, gap: Gap = roomy) -> None:
        """Plan with these ways, chances, and distances to the nearest body."""
        self._lengths = lengths
        self._ask = chance
        self._gap = gap
        self._chances: Dict[Tuple[Box, Viewpoint], float] = {}

    def candidates(self, box: Box, here: Pose2, before: Sequence[Viewpoint] = ()) -> List[Viewpoint]:
        """Views of a box that can be reached and may decide, the likeliest after others that did not first."""
        usual = self._able(box, here, before, DISTANCES_M, ANGLES_DEG)
        return usual or self._able(box, here, before, FAR_DISTANCES_M, FLAT_ANGLES_DEG)

    def _able(
        self,
        box: Box,
        here: Pose2,
        before: Sequence[Viewpoint],
        distances_m: Sequence[float],
        angles_deg: Sequence[int],
    ) -> List[Viewpoint]:
        views = [viewpoint(box, distance, angle) for distance in distances_m for angle in angles_deg]
        chances = [self.chance_of(box, view) for view in views]
        reached = np.isfinite(self._lengths(here, [view.pose for view in views]))
        order = sorted(range(len(views)), key=lambda i: (-novelty(views[i], before) * chances[i], i))
        good = [i for i in order if reached[i] and chances[i] >= LEAST_CHANCE]
        return [views[i] for i in good[:MOST_VIEWS]]

    def chance_of(self, box: Box, view: Viewpoint) -> float:
        """Probability that a view decides; asked once for each, as the boxes do not move."""
        if (box, view) not in self._chances:
            self._chances[box, view] = self._ask(box, view)
        return self._chances[box, view]

    def price_s(self, box: Box, view: Viewpoint, before: Sequence[Viewpoint] = ()) -> float:
        """What a view costs beside the way to it: that it may not decide, and that there is little room.

        Args:
            box: that is looked at.
            view: of it.
            before: views that did not decide; one like them is not likely to.
        """
        room_m = self._gap(view.pose.x, view.pose.y)
        tight = min(max((ROOMY_M - room_m) / (ROOMY_M - TIGHT_M), 0.0), 1.0)
        chance = novelty(view, before) * self.chance_of(box, view)
        return (1.0 / max(chance, LEAST_CHANCE) - 1.0) * AGAIN_S + tight * TIGHT_S

    def fresh(self, box: Box, here: Pose2, seen: Mapping[int, Sequence[Viewpoint]]) -> List[Viewpoint]:
        """Candidates of a box that were not taken yet."""
        before = seen.get(box.number, ())
        taken = {(view.distance_m, view.angle_deg) for view in before}
        return [view for view in self.candidates(box, here, before) if (view.distance_m, view.angle_deg) not in taken]

    def plan(
        self,
        here: Pose2,
        home: Pose2,
        boxes: Mapping[Box, float],
        seen: Mapping[int, Sequence[Viewpoint]],
        budget: Budget,
    ) -> Plan:
        """The cheapest round over those of the boxes that are worth most together and can be visited in time.

        Args:
            here: where the robot stands.
            home: where it ends.
            boxes: that are left, and what a visit to each is worth.
            seen: views already taken of a box, which are not taken again.
            budget: time that is left.
        """
        views: List[Viewpoint] = []
        prices: List[float] = []
        unreachable = []
        for box in boxes:
            fresh = self.fresh(box, here, seen)
            if not fresh:
                unreachable.append(box.number)
            views += fresh
            prices += [self.price_s(box, view, seen.get(box.number, ())) for view in fresh]
        worth = {box.number: value for box, value in boxes.items()}
        tour = self._solve(here, home, views, prices, worth, budget)
        return Plan(tuple(views[i] for i in tour.stops), tour.cost, tuple(unreachable), tour.gap)

    def _solve(
        self,
        here: Pose2,
        home: Pose2,
        views: Sequence[Viewpoint],
        prices: Sequence[float],
        worth: Mapping[int, float],
        budget: Budget,
    ) -> Tour:
        poses = [view.pose for view in views]
        n = len(poses)
        costs = np.full((n + 1, n + 1), math.inf)
        for i, pose in enumerate(poses):
            costs[i, :n] = self._times(pose, poses) + np.array(prices)
            costs[i, n] = self._times(pose, [home])[0]
        costs[n] = self._times(here, [*poses, home]) + np.array([*prices, 0.0])
        box_of = [view.box for view in views]
        if len(set(box_of)) <= MOST_EXACT:
            return largest_tour(costs, box_of, budget.fits, worth)
        from yarm.inspection.tour_search import searched_tour  # OR-tools is slow to import  # noqa: PLC0415

        return searched_tour(costs, box_of, budget.fits, worth)

    def _times(self, start: Pose2, goals: Sequence[Pose2]) -> FloatArray:
        lengths = self._lengths(start, goals)
        return np.array([DriveTimes.undisturbed_s(float(way), start, goal) for way, goal in zip(lengths, goals)])
