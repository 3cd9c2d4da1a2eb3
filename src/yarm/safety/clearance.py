"""How much room a robot has ahead of its motion, from known solids and the grid; shares no code with the planner.

A robot is a cloud of points on its surface, everything else solids with signed distances. What is asked for is not how
near a robot stands to something but how near its motion will bring it, and that of the other where it is known.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray, GridSpec, IntArray, Pose2, wrap_angle
from yarm.geometry.solids import Shape, Solid

ARRIVED_M = 0.012
"""So near to where it was sent a robot stands: a hand is brought to 1 cm, and its work there belongs to the goal."""
PASSED_M = 0.1
"""A pose that a robot goes by is behind it once the robot has been so near: it passes corners within 0.04 m."""


@dataclass(frozen=True)
class Disc:
    """Where somebody may be: on the floor, within a radius that grows with time.

    Attributes:
        x: of its middle, metres, world.
        y: likewise.
        radius_m: at the beginning.
        top_m: height of who it is.
        speed_mps: by which the radius grows.
    """

    x: float
    y: float
    radius_m: float
    top_m: float
    speed_mps: float

    def distance(self, points: FloatArray, after_s: float) -> float:
        """Least distance of points (n, 3), metres, world, to whoever may be in it after a time; negative inside."""
        beside = np.hypot(points[:, 0] - self.x, points[:, 1] - self.y) - self.radius_m - self.speed_mps * after_s
        above = points[:, 2] - self.top_m
        apart = np.where(above > 0.0, np.hypot(np.maximum(beside, 0.0), above), beside)
        return float(apart.min())


@dataclass(frozen=True, eq=False)
class Body:
    """Something that must not be touched.

    Attributes:
        name: of the object.
        solids: in the world frame.
        boxes: (n, 6) further boxes, lower and upper corner, metres, world (occupied cells).
        velocity_mps: how the boxes move, world; (0, 0): they stand.
        age_s: how long ago the boxes, or the disc, were there.
        disc: where it may be besides, when it moves by itself.
    """

    name: str
    solids: Tuple[Solid, ...] = ()
    boxes: Optional[FloatArray] = None
    velocity_mps: Tuple[float, float] = (0.0, 0.0)
    age_s: float = 0.0
    disc: Optional[Disc] = None


@dataclass(frozen=True)
class Motion:
    """How a robot moves: velocity of its end effector, m/s, world, and yaw rate, rad/s."""

    vx: float = 0.0
    vy: float = 0.0
    yaw_rate: float = 0.0

    def fastest_mps(self, reach_m: float) -> float:
        """Speed of a point that far from the end effector, at most."""
        return math.hypot(self.vx, self.vy) + reach_m * abs(self.yaw_rate)


@dataclass(frozen=True)
class Passing:
    """A pose that a robot still passes, and when."""

    pose: Pose2
    after_s: float


@dataclass(frozen=True)
class Foresight:
    """How far ahead the monitor looks.

    Attributes:
        latency_s: time from a pose to the robot braking.
        deceleration_mps2: braking of its fastest point.
        reach_m: distance of its fastest point from the end effector.
        first_m: of a step not yet begun, this much of the way is looked at.
        first_rad: likewise of its turn.
        samples: poses looked at on a stretch.
    """

    latency_s: float = 0.2
    deceleration_mps2: float = 1.5
    reach_m: float = 1.65
    first_m: float = 0.15
    first_rad: float = 0.12
    samples: int = 4

    def time_to_stand_s(self, motion: Motion) -> float:
        """From now until a robot that is stopped stands."""
        return self.latency_s + motion.fastest_mps(self.reach_m) / self.deceleration_mps2


@dataclass(frozen=True)
class Ahead:
    """Room ahead of a robot.

    Attributes:
        distance_m: least distance to anything on the way, metres; negative inside, inf when nothing is near.
        nearest: what that is.
        closing: the motion brings the robot nearer to something that comes within the limit.
    """

    distance_m: float
    nearest: str
    closing: bool


def way_ahead(way: Sequence[Pose2], pose: Pose2) -> Tuple[Pose2, ...]:
    """What is left of the poses a robot goes by, its target last, when those it has come near to are behind."""
    passed = 0
    while passed < len(way) - 1 and pose.distance(way[passed]) < PASSED_M:
        passed += 1
    return tuple(way[passed:])


def coasting(
    pose: Pose2, motion: Motion, target: Optional[Pose2], sight: Foresight, via: Sequence[Pose2] = ()
) -> List[Passing]:
    """Poses a robot still passes before it can stand, and the first stretch of the step it was sent on.

    A robot on its way to a target brakes there by itself, so nothing beyond the target counts, nor beyond the farthest
    of the poses that it goes by.
    """
    speed = motion.fastest_mps(sight.reach_m)
    time_s = sight.latency_s + speed / (2.0 * sight.deceleration_mps2) if speed > 1e-3 else 0.0
    travel, turn = time_s * math.hypot(motion.vx, motion.vy), time_s * motion.yaw_rate
    heading = math.atan2(motion.vy, motion.vx)
    if target is not None:
        left = wrap_angle(target.yaw_rad - pose.yaw_rad)
        travel = min(travel, max(pose.distance(end) for end in (*via, target)) + 0.01)
        if turn * left > 0.0:
            turn = math.copysign(min(abs(turn), abs(left)), turn)
    shares = [k / sight.samples for k in range(1, sight.samples + 1)]
    stand_s = sight.time_to_stand_s(motion)
    passed = [
        Passing(
            Pose2(
                pose.x + share * travel * math.cos(heading),
                pose.y + share * travel * math.sin(heading),
                pose.yaw_rad + share * turn,
            ),
            share * stand_s,
        )
        for share in (shares if time_s > 0.0 else [])
    ]
    first = _first_stretch(pose, via[0] if via else target, sight) if target is not None else []
    return passed + [Passing(each, stand_s) for each in first]


def _first_stretch(pose: Pose2, target: Pose2, sight: Foresight) -> List[Pose2]:
    left = wrap_angle(target.yaw_rad - pose.yaw_rad)
    if abs(left) > math.radians(2.0):
        return [Pose2(pose.x, pose.y, pose.yaw_rad + math.copysign(min(abs(left), sight.first_rad), left))]
    way = pose.distance(target)
    if way < ARRIVED_M:
        return []
    share = min(1.0, sight.first_m / way)
    return [Pose2(pose.x + share * (target.x - pose.x), pose.y + share * (target.y - pose.y), pose.yaw_rad)]


def room_ahead(
    points: FloatArray, pose: Pose2, height_m: float, passed: Sequence[Passing], bodies: Sequence[Body], limit_m: float
) -> Ahead:
    """Least distance of a robot to any body at the poses ahead.

    A body that moves is looked at twice, as if it stood and as it moves: whoever walks may stop, or turn. One
    with a disc may be anywhere in it.

    Args:
        points: (n, 3) on its surface, in the end effector's frame, metres.
        pose: of its end effector now.
        height_m: of its end effector above the floor.
        passed: ahead.
        bodies: everything it must not touch.
        limit_m: a body nearer than this on the way, and nearer or deeper inside than now, is being closed in on.
    """
    if not passed:
        return Ahead(math.inf, "", False)
    now = placed(points, pose, height_m)
    ahead = np.stack([placed(points, each.pose, height_m) for each in passed])
    result = Ahead(math.inf, "", False)
    for body in bodies:
        rooms = [_room(now, ahead, body, limit_m)]
        if body.velocity_mps != (0.0, 0.0):
            passed_s = body.age_s + np.array([0.0, *(each.after_s for each in passed)])
            ways = passed_s[:, None] * np.array([[*body.velocity_mps, 0.0]])
            rooms.append(_room(now - ways[0], ahead - ways[1:, None], body, limit_m))
        if body.disc is not None:
            rooms.append(_room_beside(body.disc, body.age_s, now, ahead, passed, limit_m))
        least = min(room for room, _ in rooms)
        if any(closing for _, closing in rooms):
            return Ahead(least, body.name, True)
        if least < result.distance_m:
            result = Ahead(least, body.name, False)
    return result


def _room(now: FloatArray, ahead: FloatArray, body: Body, limit_m: float) -> Tuple[float, bool]:
    """Least distance of points ahead (m, n, 3), and whether that closes in, from where the points (n, 3) are now."""
    flat = ahead.reshape(-1, 3)
    low, high = flat.min(axis=0) - 0.5, flat.max(axis=0) + 0.5
    least = distance(flat, body, low, high)
    if least >= limit_m:
        return least, False
    before = distance(now, body, low, high)
    if least < before - 1e-3:
        return least, True
    deeper = before <= 0.0 and max(_inside(points, body) for points in ahead) > _inside(now, body)
    return least, deeper


def _room_beside(
    disc: Disc, age_s: float, now: FloatArray, ahead: FloatArray, passed: Sequence[Passing], limit_m: float
) -> Tuple[float, bool]:
    """The same for somebody who may walk any way: nearer than he may be already is closing in, by whomever."""
    before = disc.distance(now, age_s)
    least = min(disc.distance(points, age_s + each.after_s) for points, each in zip(ahead, passed))
    return least, least < limit_m and least < before - 1e-3


def _inside(points: FloatArray, body: Body) -> int:
    """How many points (n, 3) lie in a body's boxes: these have no common depth, as a solid has."""
    if body.boxes is None:
        return 0
    inside = np.zeros(len(points), dtype=bool)
    for box in body.boxes:
        inside |= np.all((points > box[:3]) & (points < box[3:]), axis=1)
    return int(inside.sum())


def placed(points: FloatArray, pose: Pose2, height_m: float) -> FloatArray:
    """Points (n, 3) of a robot in the world, its end effector at a pose and height, metres."""
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    x = pose.x + c * points[:, 0] - s * points[:, 1]
    y = pose.y + s * points[:, 0] + c * points[:, 1]
    return np.column_stack([x, y, points[:, 2] + height_m])


def distance(points: FloatArray, body: Body, low: FloatArray, high: FloatArray) -> float:
    """Least signed distance of points (n, 3) to a body; inf when it lies outside the box from low to high."""
    least = math.inf
    for solid in body.solids:
        centre, reach = solid.pose[:3, 3], float(np.linalg.norm(solid.half_extent))
        if np.all(centre + reach > low) and np.all(centre - reach < high):
            least = min(least, float(signed_distance(points, solid).min()))
    if body.boxes is not None and len(body.boxes):
        near = body.boxes[np.all((body.boxes[:, 3:] > low) & (body.boxes[:, :3] < high), axis=1)]
        for box in near:
            gap = np.maximum(np.maximum(box[:3] - points, points - box[3:]), 0.0)
            least = min(least, float(np.sqrt((gap * gap).sum(axis=1).min())))
    return least


def column_boxes(spec: GridSpec, cells: IntArray) -> FloatArray:
    """Boxes (n, 6), lower and upper corner, metres, world, of cells (m, 3): one for each run of cells above each other.

    A standing person is a dozen boxes instead of hundreds of cells, so that one look stays short.
    """
    if len(cells) == 0:
        return np.zeros((0, 6))
    ordered = np.unique(cells, axis=0)
    step = np.diff(ordered, axis=0)
    begins = np.concatenate([[True], np.any(step != (0, 0, 1), axis=1)])
    ends = np.concatenate([begins[1:], [True]])
    half = spec.resolution / 2.0
    return np.hstack([spec.centres(ordered[begins]) - half, spec.centres(ordered[ends]) + half])


def signed_distance(points: FloatArray, solid: Solid) -> FloatArray:
    """Distance (n,) of points (n, 3), metres, world, to a solid's surface; negative inside."""
    rotation = solid.pose[:3, :3]
    local = (points - solid.pose[:3, 3]) @ rotation
    half = solid.half_extent
    if solid.shape == Shape.SPHERE:
        result: FloatArray = np.linalg.norm(local, axis=1) - half[0]
        return result
    if solid.shape == Shape.CYLINDER:
        outside = np.column_stack([np.hypot(local[:, 0], local[:, 1]) - half[0], np.abs(local[:, 2]) - half[2]])
    else:
        outside = np.abs(local) - half
    beyond: FloatArray = np.linalg.norm(np.maximum(outside, 0.0), axis=1)
    depth: FloatArray = np.minimum(outside.max(axis=1), 0.0)
    return beyond + depth
