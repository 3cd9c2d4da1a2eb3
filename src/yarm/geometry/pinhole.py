"""A pinhole camera without distortion, and flat faces as it sees them.

Image coordinates: x right, y down, whole numbers at the middle of the pixels (as OpenCV). Optical frames: x right,
y down, z forward.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from yarm.geometry.grid import FloatArray
from yarm.geometry.poses import Pose2

NEAR_M = 0.02
"""Nothing nearer than this is projected, metres."""


@dataclass(frozen=True)
class Pinhole:
    """Size and optics of a camera, all in pixels."""

    width: int
    height: int
    focal_px: float
    centre_x: float
    centre_y: float

    @property
    def matrix(self) -> FloatArray:
        """(3, 3) from the optical frame to homogeneous pixels."""
        return np.array([[self.focal_px, 0.0, self.centre_x], [0.0, self.focal_px, self.centre_y], [0.0, 0.0, 1.0]])

    def project(self, points: npt.ArrayLike) -> FloatArray:
        """Pixels (..., 2) of points (..., 3) in the optical frame, metres; NaN where a point is not in front."""
        array = np.asarray(points, dtype=float)
        depth = np.where(array[..., 2:3] > NEAR_M, array[..., 2:3], np.nan)
        pixels: FloatArray = self.focal_px * array[..., :2] / depth + (self.centre_x, self.centre_y)
        return pixels


@dataclass(frozen=True)
class BoxSize:
    """Outer measures of an upright box, metres: width and height of its tag's face, and its depth behind the face."""

    width: float = 0.5
    depth: float = 0.16
    height: float = 0.4


def footprint(box: Pose2, size: BoxSize) -> FloatArray:
    """(4, 2) corners of a box on the floor, counter-clockwise from the front left, metres.

    The box's pose is its middle on the floor, and its front is the side its yaw points to.
    """
    along = 0.5 * size.depth * np.array([math.cos(box.yaw_rad), math.sin(box.yaw_rad)])
    across = 0.5 * size.width * np.array([-math.sin(box.yaw_rad), math.cos(box.yaw_rad)])
    signs = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    return np.array([(box.x, box.y) + a * along + b * across for a, b in signs])


def level_camera(robot: Pose2, mount: Pose2, height_m: float) -> FloatArray:
    """T_world_optical (4, 4) of a camera that looks level, from the robot's pose and the camera's place on it."""
    pose = robot.compose(mount)
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    return np.array([[s, 0.0, c, pose.x], [-c, 0.0, s, pose.y], [0.0, -1.0, 0.0, height_m], [0.0, 0.0, 0.0, 1.0]])


def tag_face(box: Pose2, size: BoxSize) -> FloatArray:
    """T_world_face (4, 4) of a box's tag: origin in its top left corner, x right and y down as one looks at it.

    The box's pose is its middle on the floor, and the tag is on the side its yaw points to.
    """
    c, s = math.cos(box.yaw_rad), math.sin(box.yaw_rad)
    middle = np.array([box.x, box.y, size.height]) + 0.5 * size.depth * np.array([c, s, 0.0])
    right = np.array([-s, c, 0.0])
    pose = np.eye(4)
    pose[:3, 0], pose[:3, 1], pose[:3, 2] = right, (0.0, 0.0, -1.0), np.cross(right, (0.0, 0.0, -1.0))
    pose[:3, 3] = middle - 0.5 * size.width * right
    return pose


def face_corners(width_m: float, height_m: float) -> FloatArray:
    """(4, 3) corners of a face in its own frame: top left, top right, bottom right, bottom left."""
    return np.array([[0, 0, 0], [width_m, 0, 0], [width_m, height_m, 0], [0, height_m, 0]], dtype=float)


def plane_homography(camera: Pinhole, T_optical_face: FloatArray) -> FloatArray:
    """(3, 3) from a face's own x, y, metres, to homogeneous pixels; the third is the depth, metres."""
    homography: FloatArray = camera.matrix @ T_optical_face[:3, [0, 1, 3]]
    return homography
