"""How long a joint plan takes when it is carried out without a barrier, and the one that takes least among many.

The search for a joint plan (``joint_search``) looks for any order that works, with short ways and little turning. When
robots need not wait for each other at every step, it is the time until the last one arrives that counts, and that
follows from who waits for whom: the longest chain of moves in the dependency graph (``joint_plan``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Optional, Sequence

import numpy as np

from yarm.geometry import wrap_angle
from yarm.planning.cspace.robot_space import RobotSpace
from yarm.planning.fleet.fleet import Fleet, Move
from yarm.planning.fleet.joint_plan import Conflicts, StepChoice
from yarm.planning.fleet.joint_search import JointSearch

GOOD_ENOUGH = 1.05
"""A plan that takes no longer than this times the slowest robot alone is not improved."""
PIECE_CELLS = 8
"""A way counts as pieces so long: a robot is waited for until it has passed, and goes up to where it must wait."""
SHARPEST_RAD = math.radians(60.0)
"""At a sharper corner a robot stops."""


@dataclass(frozen=True)
class Pace:
    """How long robots take for their moves.

    Attributes:
        speed_mps: of the end effector on a straight way.
        start_s: lost to the casters, speeding up and braking on a way that begins and ends at rest, s.
        turn_radps: rate of a turn in place.
        turn_start_s: lost in the same way to a turn, s.
    """

    speed_mps: float = 1.0
    start_s: float = 1.5
    turn_radps: float = 0.6
    turn_start_s: float = 1.1

    def seconds(self, space: RobotSpace, move: Move, before: Optional[Move] = None) -> float:
        """Time of a move, s; less when it leads straight on from the one before."""
        turn = abs(wrap_angle(space.headings[move.end[2]] - space.headings[move.start[2]]))
        way_m = _way_m(space, move)
        time_s = way_m / self.speed_mps
        if move.start[2] != move.end[2]:
            time_s += self.turn_start_s + turn / self.turn_radps
        if way_m > 0.0 and not _leads_on(move, before):
            time_s += self.start_s
        return time_s


@dataclass(frozen=True)
class Duration:
    """How long a joint plan takes.

    Attributes:
        last_s: until the last robot that moves has arrived.
        sum_s: sum of these times over the robots.
    """

    last_s: float
    sum_s: float

    def beats(self, other: Duration, share: float = 1.0) -> bool:
        """Whether it is clearly shorter: below a share of the other."""
        return (self.last_s, self.sum_s) < (share * other.last_s, share * other.sum_s)


def duration(fleet: Fleet, moves: Sequence[Move], pace: Pace, conflicts: Conflicts) -> Duration:
    """Time until each robot has made its moves, each piece of them begun as soon as those it waits for have ended."""
    pieces = [piece for move in moves for piece in _pieces(move)]
    choice = StepChoice(fleet, pieces, 1, conflicts)
    ends: List[float] = []
    arrivals: Dict[int, float] = {}
    own: Dict[int, Move] = {}
    for index, move in enumerate(pieces):
        waits = max((ends[k] for k in choice.after(index)), default=0.0)
        free = arrivals.get(move.robot, 0.0)
        before = own.get(move.robot) if free >= waits else None
        ends.append(max(waits, free) + pace.seconds(fleet.spaces[move.robot], move, before))
        arrivals[move.robot], own[move.robot] = ends[-1], move
    return Duration(max(arrivals.values(), default=0.0), sum(arrivals.values()))


def alone_s(fleet: Fleet, robots: Sequence[int], pace: Pace) -> float:
    """Time of the slowest robot on the way that it would take if no other were there, s."""
    slowest = 0.0
    for i in robots:
        path = fleet.alone(i) or ()
        moves = [Move(i, a, b) for a, b in zip(path, path[1:])]
        times = [pace.seconds(fleet.spaces[i], move, before) for move, before in zip(moves, [None, *moves])]
        slowest = max(slowest, sum(times))
    return slowest


@dataclass(frozen=True)
class SoonestPlan:
    """What ``soonest`` found: the moves (None when there are none), how long they take, and the rounds it took."""

    moves: Optional[List[Move]]
    takes: Duration
    rounds: int


def soonest(
    fleets: Sequence[Fleet],
    robots: Sequence[int],
    effort: int,
    more: int,
    pace: Pace,
    conflicts: Conflicts,
    rng: np.random.Generator,
    all_orders: bool = True,
) -> SoonestPlan:
    """The joint plan that takes least time among those that are found.

    Args:
        fleets: the same fleet, with turns that cost differently much beside ways: each leads to other plans.
        robots: those with a target, which can be reached with no other robot there.
        effort: rounds of each fleet's search until one is found.
        more: rounds to look for better ones, after that.
        pace: of the robots.
        conflicts: of their moves.
        rng: of the search.
        all_orders: see ``JointSearch.candidates``.
    """
    best: Optional[List[Move]] = None
    takes = Duration(math.inf, math.inf)
    rounds = 0
    for fleet in fleets:
        enough_s = GOOD_ENOUGH * alone_s(fleet, robots, pace)
        search = JointSearch(fleet, robots, effort if best is None else more)
        for moves in search.candidates(rng, more, all_orders):
            time = duration(fleet, moves, pace, conflicts)
            if time.beats(takes):
                best, takes = moves, time
            if takes.last_s <= enough_s:
                break
        rounds += search.rounds
        if takes.last_s <= enough_s:
            break
    return SoonestPlan(best, takes, rounds)


def _pieces(move: Move) -> List[Move]:
    """A move in pieces; a turn belongs to the first."""
    (ax, ay, _), (bx, by, h) = move.start, move.end
    count = max(1, math.ceil(math.dist((ax, ay), (bx, by)) / PIECE_CELLS))
    shares = [k / count for k in range(1, count)]
    stops = [move.start, *((round(ax + t * (bx - ax)), round(ay + t * (by - ay)), h) for t in shares), move.end]
    return [Move(move.robot, start, end) for start, end in zip(stops, stops[1:])]


def _way_m(space: RobotSpace, move: Move) -> float:
    dx, dy = (space.resolution[k] * (move.end[k] - move.start[k]) for k in (0, 1))
    return math.hypot(dx, dy)


def _leads_on(move: Move, before: Optional[Move]) -> bool:
    """Whether a robot goes on with a move without stopping after the one before."""
    if before is None or before.end[2] != move.end[2] or move.start[2] != move.end[2]:
        return False
    ways = [(m.end[0] - m.start[0], m.end[1] - m.start[1]) for m in (before, move)]
    if (0, 0) in ways:
        return False
    angles = [math.atan2(dy, dx) for dx, dy in ways]
    return abs(wrap_angle(angles[1] - angles[0])) <= SHARPEST_RAD
