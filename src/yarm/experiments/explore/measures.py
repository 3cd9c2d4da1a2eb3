"""What a record comes to: the measures of an exploration, and whether it kept the rules."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Mapping, Sequence, Tuple

import numpy as np

from yarm.experiments.explore.judge import Judge, WallError
from yarm.experiments.explore.record import CoverageRow, ExploreRecord, PathRow
from yarm.geometry import FloatArray, Pose2, wrap_angle
from yarm.robots.turtlebot import RADIUS_M
from yarm.sim.kinematic.flat_boxes import FlatBoxes

SHARES = (0.90, 0.95, 0.99)
SPEED_SLACK = 0.005
"""m/s; a true speed may be above its limit by this."""
STILL_MPS = 0.005
NEAR_SLACK_M = 0.10
"""Something counts as near when it is nearer than the distance given less this: a map's cells and a loop of 0.1 s."""
LOOK_STEP_M = 0.04
GENTLE_MPS = 0.1
"""No bump may be faster."""


@dataclass(frozen=True)
class Obstacles:
    """Obstacles of one sort.

    Attributes:
        count: how many there are with a visible outline.
        detected: of these, in the final map or seen in one before.
        untouched: of these, in the map before the robot touched them, or never touched.
    """

    count: int
    detected: int
    untouched: int


@dataclass(frozen=True)
class Measures:
    """What is measured of one run; metres, seconds, radians.

    Attributes:
        share: of the mappable cells, known and right at the end.
        known_m2: at the end.
        times: seconds to a share of 90, 95, 99 %; inf where it was not reached.
        distance_m: driven, by the truth.
        turning_rad: turned, by the truth, whatever the direction.
        bumps: times the robot came into contact with something.
        bumped_again: things touched more than once.
        fastest_bump: m/s.
        too_fast_s: seconds above the greatest speed.
        too_fast_near_s: seconds above the speed allowed near obstacles, with one ahead.
        standing: the robot stood still from the time limit on, or from its own end on.
        wall: error of the walls, unaligned.
        wall_fitted: the same after the best rigid fit.
        fit: that fit.
        tall: obstacles that the scan sees.
        low: obstacles that it does not.
        early: the controller ended by itself with less than 99 % mapped.
        pose_rmse_m: of where the robot believed to be.
        step_p50_ms: of the controller's passes, processor time.
        step_p99_ms: of the same.
    """

    share: float
    known_m2: float
    times: Tuple[float, float, float]
    distance_m: float
    turning_rad: float
    bumps: int
    bumped_again: int
    fastest_bump: float
    too_fast_s: float
    too_fast_near_s: float
    standing: bool
    wall: WallError
    wall_fitted: WallError
    fit: Pose2
    tall: Obstacles
    low: Obstacles
    early: bool
    pose_rmse_m: float
    step_p50_ms: float
    step_p99_ms: float

    @property
    def broken_rules(self) -> Tuple[str, ...]:
        """Which rules were not kept, one sentence each."""
        rules = (
            (self.too_fast_s == 0.0, f"{self.too_fast_s:.1f} s above the greatest speed"),
            (self.too_fast_near_s == 0.0, f"{self.too_fast_near_s:.1f} s too fast towards an obstacle"),
            (self.standing, "the robot moved after the end"),
            (self.fastest_bump <= GENTLE_MPS + SPEED_SLACK, f"a bump at {self.fastest_bump:.2f} m/s"),
        )
        return tuple(text for kept, text in rules if not kept)


def measure(record: ExploreRecord, judge: Judge) -> Measures:
    """Everything that is measured of a run."""
    share, wall, fitted, fit = _of_map(record, judge)
    rows = record.path
    touches: Dict[str, int] = {}
    for touch in record.touches:
        touches[touch.block] = touches.get(touch.block, 0) + 1
    return Measures(
        share=share,
        known_m2=0.0 if record.map is None else record.map.known_m2,
        times=times_to(record.coverage),
        distance_m=float(sum(math.hypot(b.true_x - a.true_x, b.true_y - a.true_y) for a, b in zip(rows, rows[1:]))),
        turning_rad=float(sum(abs(wrap_angle(b.true_yaw - a.true_yaw)) for a, b in zip(rows, rows[1:]))),
        bumps=len(record.touches),
        bumped_again=sum(count > 1 for count in touches.values()),
        fastest_bump=max((touch.speed for touch in record.touches), default=0.0),
        too_fast_s=_seconds(rows, [row.speed > record.max_speed + SPEED_SLACK for row in rows]),
        too_fast_near_s=_too_fast_near(record, judge.boxes),
        standing=all(row.speed < STILL_MPS for row in rows if row.t_s > record.end_s + 1e-6),
        wall=wall,
        wall_fitted=fitted,
        fit=fit,
        tall=_obstacles(record, judge, False),
        low=_obstacles(record, judge, True),
        early=record.done and share < SHARES[-1],
        pose_rmse_m=_pose_rmse(rows),
        step_p50_ms=_percentile(record.step_ms, 50),
        step_p99_ms=_percentile(record.step_ms, 99),
    )


def times_to(coverage: Sequence[CoverageRow]) -> Tuple[float, float, float]:
    """Seconds until the share reached each of SHARES for the first time; inf where it never did."""
    first = [next((row.t_s for row in coverage if row.share >= share), math.inf) for share in SHARES]
    return first[0], first[1], first[2]


def _of_map(record: ExploreRecord, judge: Judge) -> Tuple[float, WallError, WallError, Pose2]:
    if record.map is None:
        nothing = judge.wall_error(np.zeros((0, 2)))
        return 0.0, nothing, nothing, Pose2(0.0, 0.0)
    points = judge.occupied_points(record.map, record.world_from_map)
    fit = judge.best_fit(points)
    moved = fit.moved(points)
    return judge.share(record.map, record.world_from_map), judge.wall_error(points), judge.wall_error(moved), fit


def _seconds(rows: Sequence[PathRow], which: Sequence[bool]) -> float:
    """Time that ends at the rows that are marked."""
    return float(sum(b.t_s - a.t_s for a, b, hit in zip(rows, rows[1:], which[1:]) if hit))


def _too_fast_near(record: ExploreRecord, boxes: FlatBoxes) -> float:
    """Seconds in which the robot was above near_speed though its disc, moved ahead, would soon have touched something.

    Looked at from where each stretch between two rows began, along the direction it took.
    """
    rows = record.path
    fast = [i for i, row in enumerate(rows) if i and row.speed > record.near_speed + SPEED_SLACK]
    if not fast or not len(boxes):
        return 0.0
    before: FloatArray = np.array([(rows[i - 1].true_x, rows[i - 1].true_y) for i in fast])
    way = np.array([(rows[i].true_x, rows[i].true_y) for i in fast]) - before
    way /= np.maximum(np.hypot(way[:, 0], way[:, 1]), 1e-9)[:, None]
    near: List[bool] = [False] * len(rows)
    for ahead in np.arange(0.0, record.near_distance - NEAR_SLACK_M - RADIUS_M, LOOK_STEP_M):
        touching = boxes.signed(before + ahead * way).min(axis=1) < RADIUS_M - 0.005
        for index, hit in zip(fast, touching):
            near[index] |= bool(hit)
    return _seconds(rows, near)


def _obstacles(record: ExploreRecord, judge: Judge, low: bool) -> Obstacles:
    touched: Mapping[str, float] = {touch.block: touch.t_s for touch in reversed(record.touches)}
    names = [obstacle.name for obstacle in judge.obstacles if obstacle.low == low]
    at_end = set() if record.map is None else judge.detected(record.map, record.world_from_map)
    seen = record.first_seen
    detected = [name for name in names if name in seen or name in at_end]
    untouched = [n for n in detected if n not in touched or seen.get(n, math.inf) < touched[n]]
    return Obstacles(len(names), len(detected), len(untouched))


def _pose_rmse(rows: Sequence[PathRow]) -> float:
    if not rows:
        return math.nan
    return math.sqrt(float(np.mean([(r.true_x - r.x) ** 2 + (r.true_y - r.y) ** 2 for r in rows])))


def _percentile(values: Sequence[float], percent: float) -> float:
    return float(np.percentile(values, percent)) if len(values) else math.nan
