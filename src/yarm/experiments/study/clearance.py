"""Exact distances in the kinematic world: upright solids against upright solids and against sampled links of an arm."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray, Pose2
from yarm.robots.ankurbot import ANKURBOT_BEAMS, ANKURBOT_DISCS, Beam, Disc

SAMPLE_M = 0.025
"""Spacing of the points on an arm's links, metres; a distance to them is too large by at most its square over 8 R."""

FAR_M = 0.5
"""Distances beyond this need not be exact, metres."""


@dataclass(frozen=True)
class Upright:
    """A rounded rectangle raised between two heights; a disc has half sizes 0, a box has radius 0.

    Attributes:
        centre: x, y, metres, and heading, in the frame of its owner.
        half: half length and half width of the rectangle, metres.
        radius: rounding around it, metres.
        z: lower and upper end, metres.
    """

    centre: Pose2
    half: Tuple[float, float]
    radius: float
    z: Tuple[float, float]

    @property
    def reach(self) -> float:
        """Radius of the circle about its centre that holds it, metres."""
        return math.hypot(*self.half) + self.radius

    def at(self, pose: Pose2) -> Upright:
        """The solid in the world, its owner standing at a pose."""
        return Upright(pose.compose(self.centre), self.half, self.radius, self.z)


def box(x: float, y: float, yaw_rad: float, size: Sequence[float], z_low: float) -> Upright:
    """A box standing on the height z_low; size along x, y, z, metres."""
    return Upright(Pose2(x, y, yaw_rad), (size[0] / 2.0, size[1] / 2.0), 0.0, (z_low, z_low + size[2]))


def uprights(discs: Sequence[Disc], beams: Sequence[Beam]) -> Tuple[Upright, ...]:
    """A mobile robot about its end effector; without the wheels, which are under the body."""
    over = [disc for disc in discs if disc.radius > 0.2 or disc.x == 0.0]
    return (
        *(Upright(Pose2(disc.x, disc.y), (0.0, 0.0), disc.radius, disc.z) for disc in over),
        *(
            Upright(Pose2(sum(b.x) / 2.0, sum(b.y) / 2.0), ((b.x[1] - b.x[0]) / 2.0, (b.y[1] - b.y[0]) / 2.0), 0.0, b.z)
            for b in beams
        ),
    )


ANKURBOT = uprights(ANKURBOT_DISCS, ANKURBOT_BEAMS)
"""Body, end effector, mast and arm of the mobile robot."""


def distance(a: Upright, b: Upright) -> float:
    """Least distance of two upright solids, metres; negative when they overlap (horizontal depth).

    Beyond ``FAR_M`` it may come out too small, but never below ``FAR_M``.
    """
    far = math.hypot(a.centre.x - b.centre.x, a.centre.y - b.centre.y) - a.reach - b.reach
    if far > FAR_M:
        return far
    apart_z = max(a.z[0] - b.z[1], b.z[0] - a.z[1])
    apart = _rectangles(a, b) - a.radius - b.radius
    if apart_z <= 0.0:
        return apart if apart > 0.0 else max(apart, apart_z)
    return math.hypot(max(apart, 0.0), apart_z)


def fleet_distance(solids: Sequence[Upright], others: Sequence[Upright], than_m: float = math.inf) -> float:
    """Least distance between two groups of upright solids where it is below ``than_m``, metres; else that."""
    for a in solids:
        x, y, reach = a.centre.x, a.centre.y, a.reach
        for b in others:
            if math.hypot(x - b.centre.x, y - b.centre.y) - reach - b.reach < than_m:
                than_m = min(than_m, distance(a, b))
    return than_m


@dataclass(frozen=True)
class Cloud:
    """Points, and an upright cylinder about them.

    Attributes:
        points: (n, 3), metres, world.
        middle: x, y of the cylinder's axis, metres.
        reach: its radius, metres.
    """

    points: FloatArray
    middle: Tuple[float, float]
    reach: float


def cloud_of(points: FloatArray) -> Cloud:
    """Points (n, 3), metres, world, with the cylinder about their bounding box; that of none is near to nothing."""
    if len(points) == 0:
        return Cloud(points, (0.0, 0.0), -math.inf)
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    x, y = (0.5 * (low + high)).tolist()
    return Cloud(points, (x, y), 0.5 * math.hypot(*(high - low).tolist()))


def points_distance(solids: Sequence[Upright], cloud: Cloud, than_m: float = math.inf) -> float:
    """Least signed distance of a cloud from upright solids where it is below ``than_m``, metres; else that."""
    for solid in solids:
        far = math.hypot(solid.centre.x - cloud.middle[0], solid.centre.y - cloud.middle[1])
        if far - solid.reach - cloud.reach < than_m:
            than_m = min(than_m, float(_field(solid, cloud.points).min()))
    return than_m


def flat_distance(solids: Sequence[Upright], x_m: float, y_m: float) -> float:
    """Least horizontal distance of a point, metres, world, from upright solids; 0 or less inside."""
    distances = []
    for solid in solids:
        c, s = math.cos(solid.centre.yaw_rad), math.sin(solid.centre.yaw_rad)
        dx, dy = x_m - solid.centre.x, y_m - solid.centre.y
        qx, qy = abs(c * dx + s * dy) - solid.half[0], abs(c * dy - s * dx) - solid.half[1]
        distances.append(math.hypot(max(qx, 0.0), max(qy, 0.0)) + min(max(qx, qy), 0.0) - solid.radius)
    return min(distances, default=math.inf)


def _field(solid: Upright, points: FloatArray) -> FloatArray:
    """Signed distance (n,) of points (n, 3) from one solid."""
    c, s = math.cos(solid.centre.yaw_rad), math.sin(solid.centre.yaw_rad)
    dx, dy = points[:, 0] - solid.centre.x, points[:, 1] - solid.centre.y
    qx = np.abs(c * dx + s * dy) - solid.half[0]
    qy = np.abs(-s * dx + c * dy) - solid.half[1]
    flat = np.hypot(np.maximum(qx, 0.0), np.maximum(qy, 0.0)) + np.minimum(np.maximum(qx, qy), 0.0) - solid.radius
    high = np.maximum(solid.z[0] - points[:, 2], points[:, 2] - solid.z[1])
    outside = np.hypot(np.maximum(flat, 0.0), np.maximum(high, 0.0))
    field: FloatArray = outside + np.minimum(np.maximum(flat, high), 0.0)
    return field


def _rectangles(a: Upright, b: Upright) -> float:
    """Distance of two turned rectangles in the plane; negative by the least way that parts them."""
    apart_a, corners_b = _seen_from(a, b)
    apart_b, corners_a = _seen_from(b, a)
    depth = max(apart_a, apart_b)
    if depth <= 0.0:
        return depth
    return min(_to_rectangle(a, corners_b), _to_rectangle(b, corners_a))


def _seen_from(a: Upright, b: Upright) -> Tuple[float, Tuple[Tuple[float, float], ...]]:
    """How far a rectangle is from another one along its axes, and its corners in the frame of that.

    In plain numbers: of four corners at a time numpy is ten times slower.
    """
    c, s = math.cos(a.centre.yaw_rad), math.sin(a.centre.yaw_rad)
    dx, dy = b.centre.x - a.centre.x, b.centre.y - a.centre.y
    x, y = c * dx + s * dy, c * dy - s * dx
    turn = b.centre.yaw_rad - a.centre.yaw_rad
    c, s = math.cos(turn), math.sin(turn)
    ux, uy, vx, vy = b.half[0] * c, b.half[0] * s, -b.half[1] * s, b.half[1] * c
    apart = max(abs(x) - abs(ux) - abs(vx) - a.half[0], abs(y) - abs(uy) - abs(vy) - a.half[1])
    corners = (
        (x + ux + vx, y + uy + vy),
        (x - ux + vx, y - uy + vy),
        (x - ux - vx, y - uy - vy),
        (x + ux - vx, y + uy - vy),
    )
    return apart, corners


def _to_rectangle(solid: Upright, corners: Tuple[Tuple[float, float], ...]) -> float:
    """Least distance of points in the frame of a rectangle to it; 0 inside."""
    hx, hy = solid.half
    return min(math.hypot(max(abs(x) - hx, 0.0), max(abs(y) - hy, 0.0)) for x, y in corners)
