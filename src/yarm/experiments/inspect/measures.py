"""What a round comes to, by the truth: boxes read, home, time, and what the time went into."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, Iterator, List, Tuple

from yarm.experiments.inspect.record import PathRow, RoundRecord
from yarm.experiments.statistics import percentile
from yarm.geometry import Pose2, wrap_angle
from yarm.inspection.model import Stage, reading_words

HOME_M, HOME_RAD = 0.10, 0.1
"""The robot is home within this of where it began."""
MOVING_MPS, TURNING_RADPS = 0.02, 0.05
"""From this speed on a robot drives, and from this rate on one that does not drive turns."""


@dataclass(frozen=True)
class Measures:
    """Figures of merit of a round.

    Attributes:
        boxes: in the layout.
        right: whose verdict is what they bear.
        named_wrong: that were given a tag they do not bear.
        end_s: when the round ended.
        kept: home in time, by the truth.
        home_m: from where it ended to where it began, metres.
        home_rad: the same, of the heading.
        distance_m: driven.
        goals: given to the navigation.
        goals_failed: of them.
        bumps: contacts.
        images: looked at.
        place_p50_m: how far the robot was from where it believed to be, median, metres.
        place_p95_m: 95th percentile.
        place_p95_deg: the same of the heading, degrees.
        driving_s: seconds of moving along.
        turning_s: of turning in place.
        looking_s: of standing and looking.
        slowest_look_s: the longest look, from where the robot stands to its verdict; 0 without one.
        standing_s: of standing otherwise.
        computing_s: processor seconds of deciding and recognising.
    """

    boxes: int
    right: int
    named_wrong: int
    end_s: float
    kept: bool
    home_m: float
    home_rad: float
    distance_m: float
    goals: int
    goals_failed: int
    bumps: int
    images: int
    place_p50_m: float
    place_p95_m: float
    place_p95_deg: float
    driving_s: float
    turning_s: float
    looking_s: float
    slowest_look_s: float
    standing_s: float
    computing_s: float


def measure(record: RoundRecord) -> Measures:
    """Figures of merit of a record.

    Raises:
        ValueError: nothing of the way was recorded.
    """
    if not record.path:
        raise ValueError(f"round in {record.info.layout}: no row of the way was recorded")
    verdicts = [(verdict.reading.tag, record.truth[verdict.box]) for verdict in record.verdicts]
    first, last = record.path[0], record.path[-1]
    home_m = math.hypot(last.true_x - first.true_x, last.true_y - first.true_y)
    home_rad = abs(wrap_angle(last.true_yaw - first.true_yaw))
    home = home_m <= HOME_M and home_rad <= HOME_RAD
    drives = [order for order in record.orders if order.doing == "drive"]
    off_m, off_deg = _place_errors(record)
    spent = _seconds(record)
    return Measures(
        boxes=len(record.boxes),
        right=sum(tag == truth for tag, truth in verdicts),
        named_wrong=sum(tag > 0 and tag != truth for tag, truth in verdicts),
        end_s=record.end_s,
        kept=record.stage == Stage.DONE and record.end_s <= record.info.time_limit_s and home,
        home_m=home_m,
        home_rad=home_rad,
        distance_m=sum(math.hypot(b.true_x - a.true_x, b.true_y - a.true_y) for a, b in _steps(record)),
        goals=len(drives),
        goals_failed=sum(order.outcome == "failed" for order in drives),
        bumps=len(record.touches),
        images=len(record.looks),
        place_p50_m=percentile(off_m, 50),
        place_p95_m=percentile(off_m, 95),
        place_p95_deg=percentile(off_deg, 95),
        driving_s=spent["driving"],
        turning_s=spent["turning"],
        looking_s=spent["looking"],
        slowest_look_s=max((o.end_s - o.start_s for o in record.orders if o.doing == "look"), default=0.0),
        standing_s=spent["standing"],
        computing_s=record.computing_s,
    )


def faults_of(record: RoundRecord, measures: Measures) -> Tuple[str, ...]:
    """Everything that is wrong with a round, one sentence each; none when all is right and it is home in time."""
    found: List[str] = []
    for verdict in record.verdicts:
        read, truth = reading_words(verdict.reading.tag), reading_words(record.truth[verdict.box])
        if read != truth:
            found.append(
                f"box {verdict.box} is {truth} and was read as {read}: {verdict.reason or 'no doubt was seen'}"
            )
    told = {verdict.box for verdict in record.verdicts}
    found += [f"box {box.number} ended without a verdict" for box in record.boxes if box.number not in told]
    if record.stage != Stage.DONE:
        found.append(f"the round ended in {record.stage}: {record.reason or 'no reason given'}")
    elif not measures.kept:
        found.append(
            f"home {measures.home_m:.2f} m and {measures.home_rad:.2f} rad from the start at {record.end_s:.0f} s "
            f"(limits {HOME_M} m, {HOME_RAD} rad, {record.info.time_limit_s:g} s)"
        )
    return tuple(found)


def _steps(record: RoundRecord) -> Iterator[Tuple[PathRow, PathRow]]:
    return zip(record.path, record.path[1:])


def _place_errors(record: RoundRecord) -> Tuple[List[float], List[float]]:
    """Distance, metres, and angle, degrees, of belief and truth at each row that has a belief."""
    off_m, off_deg = [], []
    for row in record.path:
        if math.isfinite(row.x):
            believed = record.map_in_world.compose(Pose2(row.x, row.y, row.yaw))
            off_m.append(math.hypot(believed.x - row.true_x, believed.y - row.true_y))
            off_deg.append(abs(math.degrees(wrap_angle(believed.yaw_rad - row.true_yaw))))
    return off_m, off_deg


def _seconds(record: RoundRecord) -> Dict[str, float]:
    """What the time of the round went into."""
    spent = dict.fromkeys(("driving", "turning", "looking", "standing"), 0.0)
    for a, b in _steps(record):
        dt_s = b.t_s - a.t_s
        if a.doing == "look":
            spent["looking"] += dt_s
        elif math.hypot(b.true_x - a.true_x, b.true_y - a.true_y) >= MOVING_MPS * dt_s:
            spent["driving"] += dt_s
        elif abs(wrap_angle(b.true_yaw - a.true_yaw)) >= TURNING_RADPS * dt_s:
            spent["turning"] += dt_s
        else:
            spent["standing"] += dt_s
    return spent
