"""What a robot sweeps on a move that was released, as a page draws it: an outline around it on the floor."""

from __future__ import annotations

import math
from typing import List, Mapping, Optional, Sequence, Tuple

import numpy as np
from scipy.spatial import ConvexHull

from yarm.console.picture import BodyDrawing, Pose
from yarm.geometry import FloatArray, transform_matrix, transform_points, wrap_angle, yaw_of_quaternion
from yarm.geometry.solids import Shape, Solid

Place = Tuple[float, float, float]
"""Of an end effector: x, y, metres, and heading, rad, world."""

CORNERS = 16
"""Of a round solid."""
STEP_RAD = math.radians(5.0)
"""Between two headings of a turn that are looked at; an outline falls short by 1 mm at 1 m."""
HEIGHT_M = 0.025


def outlines(
    body: BodyDrawing, poses: Mapping[str, Pose], at: Pose, places: Sequence[Place], pivot: Pose
) -> List[FloatArray]:
    """A closed line (n, 3) for each part of a move; none while it is not known what the robot looks like.

    Args:
        body: the robot.
        poses: of all frames.
        at: of its end effector.
        places: where that goes, in order.
        pivot: of what it turns about first.
    """
    corners, start = footprint(body, poses), place_of(at)
    if corners is None:
        return []
    about = _turned(np.array([[pivot[0] - at[0], pivot[1] - at[1]]]), -start[2])[0]
    return [swept_outline(corners, a, b, about) for a, b in zip((start, *places), places)]


def footprint(body: BodyDrawing, poses: Mapping[str, Pose]) -> Optional[FloatArray]:
    """Corners (n, 2) around a robot seen from above, metres, in the frame of its seed: x along the arm.

    Args:
        body: the robot.
        poses: of the frames that its solids are fixed to, and of its seed.

    Returns:
        None without solids, or while a frame has not been heard of.
    """
    if any(frame not in poses for frame in (body.seed_frame, *(frame for frame, _ in body.solids))):
        return None
    seen = [transform_points(_matrix(poses[frame]), _corners(solid)) for frame, solid in body.solids]
    if not seen:
        return None
    x, y, yaw = place_of(poses[body.seed_frame])
    return _hull(_turned(np.concatenate(seen)[:, :2] - (x, y), -yaw))


def swept_outline(corners: FloatArray, start: Place, end: Place, pivot: Sequence[float] = (0.0, 0.0)) -> FloatArray:
    """A closed line (n, 3), metres, world, around what a robot sweeps: a turn, then straight at the end's heading.

    Args:
        corners: (n, 2) around the robot, see ``footprint``.
        start: where its end effector is.
        end: where it goes.
        pivot: what it turns about, metres, in the same frame as the corners.
    """
    about = np.asarray(pivot, dtype=float)
    centre = start[:2] + _turned(about[None], start[2])[0]
    angle = wrap_angle(end[2] - start[2])
    headings = start[2] + np.linspace(0.0, angle, 1 + math.ceil(abs(angle) / STEP_RAD))
    passed = [centre + _turned(corners - about, heading) for heading in headings]
    passed.append(end[:2] + _turned(corners, end[2]))
    outline = _hull(np.concatenate(passed))
    return np.column_stack([np.concatenate([outline, outline[:1]]), np.full(len(outline) + 1, HEIGHT_M)])


def place_of(pose: Pose) -> Place:
    """Of an end effector's pose."""
    return pose[0], pose[1], yaw_of_quaternion(pose[3:])


def _matrix(pose: Pose) -> FloatArray:
    return transform_matrix(pose[:3], pose[3:])


def _turned(points: FloatArray, angle_rad: float) -> FloatArray:
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    turned: FloatArray = points @ np.array([[c, s], [-s, c]])
    return turned


def _corners(solid: Solid) -> FloatArray:
    """Points (n, 3) whose hull is around the solid, in the frame it is fixed to."""
    half = solid.half_extent
    around: List[Tuple[float, float]] = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]
    if solid.shape != Shape.BOX:
        outside = 1.0 / math.cos(math.pi / CORNERS)
        angles = np.arange(CORNERS) * 2.0 * math.pi / CORNERS
        around = [(outside * math.cos(angle), outside * math.sin(angle)) for angle in angles]
    return transform_points(solid.pose, [(x * half[0], y * half[1], z * half[2]) for x, y in around for z in (-1, 1)])


def _hull(points: FloatArray) -> FloatArray:
    """The corners of the convex hull of points (n, 2), counter-clockwise."""
    corners: FloatArray = points[ConvexHull(points).vertices]
    return corners
