"""How much room a robot has ahead of its motion, from known solids and the grid; shares no code with the planner.

A robot is a cloud of points on its surface, everything else solids with signed distances. What is asked for is not how
near a robot stands to something but how near its motion will bring it, and that of the other where it is known.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Callable, List, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray, GridSpec, IntArray, Pose2, wrap_angle
from yarm.geometry.solids import Shape, Solid

ARRIVED_M = 0.012
"""So near to where it was sent a robot stands: a hand is brought to 1 cm, and its work there belongs to the goal."""
PASSED_M = 0.1
"""A pose that a robot goes by is behind it once the robot has been so near: it passes corners within 0.04 m."""
BEYOND_M = 0.5
"""What is farther than this from the box about a robot's way does not count as near."""
GROUP_M = 0.3
"""Points of a robot within cubes of this size are looked at together first."""


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

    @cached_property
    def extents(self) -> Tuple[FloatArray, FloatArray]:
        """Centres (n, 3) of its solids, metres, world, and half their sizes (n, 3) along their own axes."""
        if not self.solids:
            return np.zeros((0, 3)), np.zeros((0, 3))
        return np.array([s.pose[:3, 3] for s in self.solids]), np.array([s.half_extent for s in self.solids])


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
    if not passed or not bodies:
        return Ahead(math.inf, "", False)
    now = placed(points, pose, height_m)
    ahead = _way(points, [each.pose for each in passed], height_m)
    roughly, at_most_m = _roughly(ahead, bodies)
    result = Ahead(math.inf, "", False)
    for body, at_least_m in zip(bodies, roughly):
        counts_m = max(limit_m, min(result.distance_m, at_most_m))
        rooms = [_room(now, ahead, body, at_least_m, limit_m, counts_m)]
        if body.velocity_mps != (0.0, 0.0):
            passed_s = body.age_s + np.array([0.0, *(each.after_s for each in passed)])
            ways = passed_s[:, None] * np.array([[*body.velocity_mps, 0.0]])
            towards = ahead.moved(-ways[1:])
            rooms.append(_room(now - ways[0], towards, body, _roughly(towards, [body])[0][0], limit_m, counts_m))
        if body.disc is not None:
            rooms.append(_room_beside(body.disc, body.age_s, now, ahead.points, passed, limit_m))
        least = min(room for room, _ in rooms)
        if any(closing for _, closing in rooms):
            return Ahead(least, body.name, True)
        if least < result.distance_m:
            result = Ahead(least, body.name, False)
    return result


@dataclass(frozen=True, eq=False)
class _Way:
    """A robot's points at m poses, in groups that lie together.

    Attributes:
        points: (m, n, 3), metres, world, group after group.
        sizes: (g,) points of each group.
        middles: (m, g, 3) of the groups.
        radii: (g,) about the middles, metres.
    """

    points: FloatArray
    sizes: IntArray
    middles: FloatArray
    radii: FloatArray

    def moved(self, by: FloatArray) -> _Way:
        """The same with each pose (m, 3) elsewhere."""
        return _Way(self.points + by[:, None], self.sizes, self.middles + by[:, None], self.radii)

    def box(self, beyond_m: float) -> Tuple[FloatArray, FloatArray]:
        """Lower and upper corner about all of it and a margin."""
        return self.points.min(axis=(0, 1)) - beyond_m, self.points.max(axis=(0, 1)) + beyond_m

    def near(self, at_middles: FloatArray, than_m: float) -> FloatArray:
        """Points (k, 3) that may be nearest to something, and nearer than a distance, by those (m * g,) of the middles.

        No point is nearer than its group's middle less the radius, and none of all but one farther than the nearest
        middle and its radius.
        """
        least = at_middles.reshape(len(self.points), -1)
        than_m = min(than_m, float((least + self.radii).min()) + 1e-9)
        found: FloatArray = self.points[np.repeat(least - self.radii < than_m, self.sizes, axis=1)]
        return found


def _way(points: FloatArray, poses: Sequence[Pose2], height_m: float) -> _Way:
    """A robot's points (n, 3), in the frame of its end effector, at poses of that."""
    cubes = np.floor(points / GROUP_M).astype(np.int64)
    cubes -= cubes.min(axis=0)
    keys = (cubes[:, 0] * 4096 + cubes[:, 1]) * 4096 + cubes[:, 2]
    order = np.argsort(keys, kind="stable")
    ordered, keys = points[order], keys[order]
    begins = np.flatnonzero(np.concatenate([[True], keys[1:] != keys[:-1]]))
    low, high = np.minimum.reduceat(ordered, begins), np.maximum.reduceat(ordered, begins)
    radii: FloatArray = 0.5 * _length(high - low)
    both = np.concatenate([ordered, 0.5 * (low + high)])
    at = _placed(both, poses, height_m)
    sizes = np.diff(np.concatenate([begins, [len(points)]]))
    return _Way(at[:, : len(points)], sizes, at[:, len(points) :], radii)


def _roughly(way: _Way, bodies: Sequence[Body]) -> Tuple[List[FloatArray], float]:
    """Of each body, how near each of its solids and then of its boxes comes at least; and how near any comes at most.

    By spheres about what is in the way's groups and about the solids; inf for what the way's box does not reach.
    """
    low, high = way.box(BEYOND_M)
    middles, radii = way.middles.reshape(-1, 1, 3), np.tile(way.radii, len(way.points))[:, None]
    found, at_most_m = [], math.inf
    for body in bodies:
        centres, half = body.extents
        reach = _length(half)
        within = np.all((centres + reach[:, None] > low) & (centres - reach[:, None] < high), axis=1)
        at_least = np.full(len(within), math.inf)
        if within.any():
            apart = _length(middles - centres[within])
            at_least[within] = (apart - radii).min(axis=0) - reach[within]
            at_most_m = min(at_most_m, float(((apart + radii).min(axis=0) - half[within].min(axis=1)).min()))
        if body.boxes is not None and len(body.boxes):
            within = np.all((body.boxes[:, 3:] > low) & (body.boxes[:, :3] < high), axis=1)
            of_boxes = np.full(len(within), math.inf)
            if within.any():
                gaps = _gap(middles, body.boxes[within])
                of_boxes[within] = (gaps - radii).min(axis=0)
                at_most_m = min(at_most_m, float((gaps + radii).min()))
            at_least = np.concatenate([at_least, of_boxes])
        found.append(at_least)
    return found, at_most_m + 1e-9


def _room(
    now: FloatArray, ahead: _Way, body: Body, at_least_m: FloatArray, limit_m: float, counts_m: float
) -> Tuple[float, bool]:
    """Least distance of a way ahead, and whether that closes in, from where the points (n, 3) are now.

    Whatever is farther than ``counts_m``, which is no less than the limit, may come out as inf.
    """
    least = _distance_of_way(ahead, body, at_least_m, counts_m)
    if least >= limit_m:
        return least, False
    before = distance(now, body, *ahead.box(BEYOND_M))
    if least < before - 1e-3:
        return least, True
    deeper = before <= 0.0 and max(_inside(points, body) for points in ahead.points) > _inside(now, body)
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
    at: FloatArray = _placed(points, [pose], height_m)[0]
    return at


def _placed(points: FloatArray, poses: Sequence[Pose2], height_m: float) -> FloatArray:
    """The same (m, n, 3) at m poses."""
    x, y, yaw = (column[:, None] for column in np.array([(p.x, p.y, p.yaw_rad) for p in poses]).T)
    c, s = np.cos(yaw), np.sin(yaw)
    at = np.empty((len(poses), len(points), 3))
    at[..., 0] = x + c * points[:, 0] - s * points[:, 1]
    at[..., 1] = y + s * points[:, 0] + c * points[:, 1]
    at[..., 2] = points[:, 2] + height_m
    return at


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
            least = min(least, float(_gap(points, box).min()))
    return least


def _distance_of_way(way: _Way, body: Body, at_least_m: FloatArray, than_m: float) -> float:
    """The same of a robot's points on a way where it is less than a distance, else inf or anything farther."""
    least = math.inf
    for part in np.flatnonzero(at_least_m < than_m):
        if at_least_m[part] < min(least, than_m):
            field = _field_of(body, int(part))
            points = way.near(field(way.middles.reshape(-1, 3)), min(least, than_m))
            if len(points):
                least = min(least, float(field(points).min()))
    return least


def _field_of(body: Body, part: int) -> Callable[[FloatArray], FloatArray]:
    """Distances of points to a solid of a body, or to the box that follows them."""
    if part < len(body.solids):
        return lambda points: signed_distance(points, body.solids[part])
    assert body.boxes is not None
    box = body.boxes[part - len(body.solids)]
    return lambda points: _gap(points, box)


def _gap(points: FloatArray, box: FloatArray) -> FloatArray:
    """Distance of points (..., 3) to boxes (..., 6), 0 inside, metres."""
    return _length(np.maximum(np.maximum(box[..., :3] - points, points - box[..., 3:]), 0.0))


def _length(vectors: FloatArray) -> FloatArray:
    """Of vectors (..., k)."""
    result: FloatArray = np.sqrt(np.einsum("...k,...k->...", vectors, vectors))
    return result


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
        result: FloatArray = _length(local) - half[0]
        return result
    if solid.shape == Shape.CYLINDER:
        outside = np.column_stack([np.hypot(local[:, 0], local[:, 1]) - half[0], np.abs(local[:, 2]) - half[2]])
    else:
        outside = np.abs(local) - half
    beyond = _length(np.maximum(outside, 0.0))
    depth: FloatArray = np.minimum(outside.max(axis=1), 0.0)
    return beyond + depth
