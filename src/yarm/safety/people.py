"""Where somebody who moves by himself may be by the time a robot stands: a disc that grows.

How fast it grows bounds his speed whatever way he turns: 1.6 m/s when he is first seen, as ISO 13855 has people walk
who were not watched before; then, as he is watched, down to his measured speed and twice its uncertainty. With the way
that the robot still makes, this is the protective separation distance of ISO/TS 15066: his way while the robot reacts
and brakes, the robot's way meanwhile, and how uncertain places are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Mapping, Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray
from yarm.safety.clearance import Body, Disc, Foresight, Motion

SIGMAS = 2.0
"""So many standard deviations count as certain."""


@dataclass(frozen=True)
class Tracked:
    """Something nobody registered, as it is followed.

    Attributes:
        number: of its track; on the map it is ``unknown_<number>``.
        position_m: middle of its box, metres, world.
        velocity_mps: along x and y, m/s, world.
        extent_m: edges of its box, metres.
        place_sigma_m: standard deviation of its place, the greater of those along x and y, metres.
        speed_sigma_mps: likewise of its velocity, m/s.
        age_s: since it was first seen, s.
        stamp_s: of the place.
    """

    number: int
    position_m: Tuple[float, float, float]
    velocity_mps: Tuple[float, float]
    extent_m: Tuple[float, float, float]
    place_sigma_m: float
    speed_sigma_mps: float
    age_s: float
    stamp_s: float

    @property
    def name(self) -> str:
        """On the map."""
        return f"unknown_{self.number}"


@dataclass(frozen=True)
class Apart:
    """How far a robot is from somebody who moves by himself, and how far it must be.

    Attributes:
        who: his name on the map; empty for nobody.
        distance_m: between the robot's surface and where he may be now, metres.
        required_m: protective separation distance of ISO/TS 15066, metres.
    """

    who: str = ""
    distance_m: float = math.inf
    required_m: float = 0.0

    @property
    def room_m(self) -> float:
        """What is left between them, metres."""
        return self.distance_m - self.required_m


NOBODY = Apart()


@dataclass(frozen=True)
class Walking:
    """How people are taken to move.

    Attributes:
        unwatched_mps: speed of one who was not watched before.
        watched_s: so long after he was first seen his own speed alone counts.
        slowest_mps: what was watched and is slower stands.
    """

    unwatched_mps: float = 1.6
    watched_s: float = 1.0
    slowest_mps: float = 0.3

    def bound_mps(self, seen: Tracked) -> float:
        """Speed that somebody has at most, whatever way he turns, m/s."""
        speed = math.hypot(*seen.velocity_mps)
        own = speed + SIGMAS * seen.speed_sigma_mps
        watched = min(1.0, seen.age_s / self.watched_s) if self.watched_s > 0.0 else 1.0
        if watched >= 1.0 and speed < self.slowest_mps:
            return 0.0
        return max(own, self.unwatched_mps + watched * (own - self.unwatched_mps))


def disc_of(seen: Tracked, walking: Walking) -> Disc:
    """Where he may be at the time of his place, and how that grows."""
    x, y, z = seen.position_m
    length, width, height = seen.extent_m
    radius_m = math.hypot(length, width) / 2.0 + SIGMAS * seen.place_sigma_m
    return Disc(x, y, radius_m, z + height / 2.0, walking.bound_mps(seen))


def people_among(bodies: Sequence[Body], tracks: Sequence[Tracked], walking: Walking, now_s: float) -> Tuple[Body, ...]:
    """Bodies with the discs of those that are followed, who move by these alone; and those that the map does not show.

    Args:
        bodies: everything nobody registered, as the map shows it.
        tracks: what is followed.
        walking: how people move.
        now_s: time, s.
    """
    followed: Mapping[str, Tracked] = {seen.name: seen for seen in tracks}
    shown = {body.name for body in bodies}
    found = []
    for body in bodies:
        seen = followed.get(body.name)
        disc = None if seen is None else disc_of(seen, walking)
        if seen is None or disc is None:
            found.append(body)
        else:
            moves = disc if disc.speed_mps > 0.0 else None
            found.append(Body(body.name, body.solids, body.boxes, (0.0, 0.0), now_s - seen.stamp_s, moves))
    for name, seen in followed.items():
        if name not in shown:
            found.append(Body(name, (), None, (0.0, 0.0), now_s - seen.stamp_s, disc_of(seen, walking)))
    return tuple(found)


def separation(points: FloatArray, motion: Motion, body: Body, sight: Foresight, clearance_m: float) -> Apart:
    """How far a robot is from somebody, and must be: the way of both until it stands, whatever way, and a clearance.

    Args:
        points: (n, 3) on the robot's surface, metres, world.
        motion: of the robot.
        body: who it is; only one with a disc.
        sight: how the robot reacts and brakes.
        clearance_m: what must be left.
    """
    if body.disc is None:
        return NOBODY
    stand_s = sight.time_to_stand_s(motion)
    speed_mps = motion.fastest_mps(sight.reach_m)
    robot_m = speed_mps * (sight.latency_s + speed_mps / (2.0 * sight.deceleration_mps2))
    person_m = body.disc.speed_mps * (body.age_s + stand_s)
    return Apart(body.name, body.disc.distance(points, 0.0), person_m + robot_m + clearance_m)


def sigma_of(covariance: FloatArray) -> float:
    """Greatest standard deviation of a covariance (2, 2)."""
    return float(math.sqrt(max(0.0, float(np.linalg.eigvalsh(covariance)[-1]))))
