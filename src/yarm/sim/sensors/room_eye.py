"""The TurtleBot's depth camera, and the laser scan that is made of its middle rows."""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import Optional, Sequence

import numpy as np

from yarm.geometry import FloatArray, IntArray, quaternion_from_rpy, transform_matrix
from yarm.geometry.scans import RangeArray, Scan
from yarm.robots import turtlebot
from yarm.sim.scenes.bodies import FramedSolid
from yarm.sim.sensors.camera_model import CameraModel, DepthImage, Rays, SolidSet
from yarm.sim.sensors.cameras import best_rays
from yarm.sim.sensors.noise import FloatImage, NormalPool

_FOV_RAD = 2.0 * math.atan(0.5 * turtlebot.CAMERA_WIDTH_PX / turtlebot.CAMERA_FOCAL_PX)
CAMERA = CameraModel(
    turtlebot.CAMERA_WIDTH_PX, turtlebot.CAMERA_HEIGHT_PX, _FOV_RAD, turtlebot.DEPTH_MIN_M, turtlebot.DEPTH_MAX_M
)
SLICE = CameraModel(CAMERA.width, turtlebot.SCAN_ROWS, _FOV_RAD, CAMERA.near_m, CAMERA.far_m)
"""The middle rows of the camera: the same rays, and no more."""
SLICE_TOP = (CAMERA.height - SLICE.height) // 2
LOST_BEYOND = NormalDist().inv_cdf(1.0 - 0.5 * turtlebot.SCAN_LOST)
"""A beam is lost when a standard normal number is farther from 0 than this."""
IMAGE_NOISE, LOST_NOISE = 1, 2
"""Numbers of the noises in the pool."""


def optical_mount() -> FloatArray:
    """T_base_optical (4, 4) of the depth camera's optical frame in base_link."""
    mount = turtlebot.DEPTH_CAMERA
    place = (mount.x, mount.y, turtlebot.CAMERA_Z_M - turtlebot.BASE_LINK_Z_M)
    ahead = transform_matrix(place, quaternion_from_rpy(0.0, 0.0, mount.yaw_rad))
    optical = transform_matrix((0.0, 0.0, 0.0), quaternion_from_rpy(-0.5 * math.pi, 0.0, -0.5 * math.pi))
    result: FloatArray = ahead @ optical
    return result


def beam_columns() -> IntArray:
    """(SCAN_BEAMS,) column of the image that each beam reads, right to left: the one nearest to its bearing."""
    half = 0.5 * turtlebot.SCAN_FOV_RAD
    bearings = np.linspace(-half, half, turtlebot.SCAN_BEAMS)
    columns = np.floor(0.5 * CAMERA.width - CAMERA.focal_px * np.tan(bearings))
    result: IntArray = np.clip(columns, 0, CAMERA.width - 1).astype(np.int64)
    return result


class RoomEye:
    """Depth camera and scan among solids that never move. Not thread-safe."""

    def __init__(
        self, solids: Sequence[FramedSolid], poses: FloatArray, seed: int, noise: bool, rays: Optional[Rays] = None
    ) -> None:
        """Look at solids.

        Args:
            solids: what there is to see besides the floor.
            poses: T_world_solid (n, 4, 4) of their centres.
            seed: of the noise.
            noise: whether depths are noisy and beams get lost.
            rays: how rays are cast; None for the best there is.
        """
        self._solids, self._poses = SolidSet(solids), poses
        self._rays = rays or best_rays()
        self._pool = NormalPool(seed) if noise else None
        self._slice, self._image = DepthImage.blank(SLICE), DepthImage.blank(CAMERA)
        self._T_base_optical = optical_mount()
        self._columns = beam_columns()
        across = (self._columns + 0.5 - 0.5 * CAMERA.width) / CAMERA.focal_px
        self._range_of_depth = np.sqrt(1.0 + across**2).astype(np.float32)

    def scan(self, T_world_base: FloatArray, stamp_s: float, frame: int) -> Scan:
        """The scan from where base_link is; ``frame`` numbers the images."""
        depth = self._depth(SLICE, self._slice, T_world_base, frame, SLICE_TOP)
        nearest = np.fmin.reduce(depth, axis=0)
        ranges: RangeArray = nearest[self._columns] * self._range_of_depth
        with np.errstate(invalid="ignore"):
            bad = (ranges < turtlebot.SCAN_RANGE_MIN_M) | (ranges > turtlebot.SCAN_RANGE_MAX_M)
        if self._pool is not None:
            bad |= np.abs(self._pool.take(turtlebot.SCAN_BEAMS, LOST_NOISE, frame)) > LOST_BEYOND
        ranges[bad] = np.nan
        half = 0.5 * turtlebot.SCAN_FOV_RAD
        return Scan(
            stamp_s,
            ranges,
            -half,
            2.0 * half / (turtlebot.SCAN_BEAMS - 1),
            turtlebot.SCAN_RANGE_MIN_M,
            turtlebot.SCAN_RANGE_MAX_M,
            turtlebot.DEPTH_CAMERA,
        )

    def depth(self, T_world_base: FloatArray, frame: int) -> FloatImage:
        """Depth image (480, 640), metres; NaN where nothing is measured and where the robot's own plate is."""
        depth = self._depth(CAMERA, self._image, T_world_base, frame, 0)
        depth[turtlebot.HIDDEN_ROWS_FROM :] = np.nan
        return depth

    def _depth(
        self, model: CameraModel, image: DepthImage, T_world_base: FloatArray, frame: int, top: int
    ) -> FloatImage:
        """Measured depths of a camera whose first row is row ``top`` of the whole image."""
        T_world_optical = T_world_base @ self._T_base_optical
        self._rays.floor(model, image, T_world_optical)
        self._rays.add(model, image, np.linalg.inv(T_world_optical), self._solids, self._poses)
        depth: FloatImage = image.depth.copy()
        if self._pool is not None:
            normals = self._pool.take(CAMERA.pixels, IMAGE_NOISE, frame)
            first = top * model.width
            depth += image.sigma * normals[first : first + model.pixels].reshape(depth.shape)
        depth[(depth < model.near_m) | (depth > model.far_m)] = np.nan
        return depth
