"""What the TurtleBot's depth camera measures in an arena: the scan at its height, and what stands lower."""

from __future__ import annotations

from typing import Optional, Tuple

import numpy as np

from yarm.geometry import FloatArray, Pose2
from yarm.geometry.scans import Scan
from yarm.robots import turtlebot as robot
from yarm.sim.kinematic.flat_boxes import FlatBoxes, Hits
from yarm.sim.sensors.noise import FloatImage, NormalPool, axial_sigma

LOW_EVERY = 8
"""Every n-th column of the image looks for low obstacles."""
LOW_FAR_M = 2.5
"""Low obstacles farther than this do not stand out from the floor's noise."""
HIDDEN_SLOPE = (robot.HIDDEN_ROWS_FROM - 0.5 * robot.CAMERA_HEIGHT_PX) / robot.CAMERA_FOCAL_PX
"""The lowest visible line of sight falls by this for each metre of depth."""


class DepthSensor:
    """Rays from where the camera is; its noise is that of yarm.sim.sensors.noise."""

    def __init__(self, boxes: FlatBoxes, seed: int) -> None:
        """Blocks that reach up to the camera are in the scan, the others are low."""
        tall = boxes.heights >= robot.CAMERA_Z_M
        self._tall = boxes.subset(np.flatnonzero(tall))
        self._low = boxes.subset(np.flatnonzero(~tall))
        self._pool = NormalPool(seed)
        self._stray = np.random.default_rng([seed, 2])
        self._frame = 0
        self._increment = robot.SCAN_FOV_RAD / (robot.SCAN_BEAMS - 1)
        self._bearings: FloatArray = -0.5 * robot.SCAN_FOV_RAD + self._increment * np.arange(robot.SCAN_BEAMS)
        self._depth_share: FloatArray = np.cos(self._bearings)
        self._cast_from: Optional[Pose2] = None

    def scan(self, base: Pose2, stamp_s: float) -> Scan:
        """The scan from a pose of the base in the world."""
        hits = self._walls(base.compose(robot.DEPTH_CAMERA))
        nothing = ~(hits.ranges <= robot.SCAN_RANGE_MAX_M)
        depth = (np.where(nothing, 1.0, hits.ranges) * self._depth_share).astype(np.float32)
        self._frame += 1
        normals = self._pool.take(robot.SCAN_ROWS * robot.SCAN_BEAMS, 0, self._frame)
        nearest: FloatImage = normals.reshape(robot.SCAN_ROWS, robot.SCAN_BEAMS).min(axis=0)
        noisy = depth + axial_sigma(depth, hits.cosines.astype(np.float32)) * nearest
        ranges = (noisy / self._depth_share).astype(np.float32)
        ranges[nothing | (ranges < robot.SCAN_RANGE_MIN_M) | (ranges > robot.SCAN_RANGE_MAX_M)] = np.nan
        ranges[self._stray.random(robot.SCAN_BEAMS) < robot.SCAN_LOST] = np.nan
        return Scan(
            stamp_s,
            ranges,
            -0.5 * robot.SCAN_FOV_RAD,
            self._increment,
            robot.SCAN_RANGE_MIN_M,
            robot.SCAN_RANGE_MAX_M,
            robot.DEPTH_CAMERA,
        )

    def _walls(self, sensor: Pose2) -> Hits:
        """What the scan's rays meet; the rays of a place are cast once, for the scan and for what is low."""
        if self._cast_from != sensor:
            self._cast_from = sensor
            self._cast = self._tall.cast(sensor.x, sensor.y, self._bearings + sensor.yaw_rad)
        return self._cast

    def low_view(self, base: Pose2) -> FloatArray:
        """(n, 2) where rays enter low obstacles that the image shows, base frame, metres."""
        if not len(self._low):
            return np.zeros((0, 2))
        sensor = base.compose(robot.DEPTH_CAMERA)
        near = self._low.near(sensor.x, sensor.y, LOW_FAR_M)
        if not near:
            return np.zeros((0, 2))
        low = self._low.subset(np.array(near))
        bearings = self._bearings[::LOW_EVERY]
        enter, cosines = self._shown(low, sensor, bearings)
        boxes, beams = np.nonzero(np.isfinite(enter))
        share = self._depth_share[::LOW_EVERY][beams]
        depth = (enter[boxes, beams] * share).astype(np.float32)
        normals = self._pool.take(max(1, len(depth)), 1, self._frame)[: len(depth)]
        noisy = depth + axial_sigma(depth, cosines[boxes, beams].astype(np.float32)) * normals
        ranges = noisy / share
        x = robot.DEPTH_CAMERA.x + ranges * np.cos(bearings[beams])
        y = robot.DEPTH_CAMERA.y + ranges * np.sin(bearings[beams])
        points: FloatArray = np.stack([x, y], axis=1).astype(float)
        return points

    def _shown(self, low: FlatBoxes, sensor: Pose2, bearings: FloatArray) -> Tuple[FloatArray, FloatArray]:
        """(n, m) distance to each low box along each bearing, inf where the image does not show it; cosines there.

        What hides it: the scan's walls, the robot's own plate, and a nearer low box when the line of sight over it
        passes above.
        """
        world_bearings = bearings + sensor.yaw_rad
        enter, leave, cosines = low.spans(sensor.x, sensor.y, world_bearings)
        walls = self._walls(sensor).ranges[::LOW_EVERY]
        with np.errstate(invalid="ignore"):
            fall_to_top = (robot.CAMERA_Z_M - low.heights)[:, None]
            fall = fall_to_top / enter
            depth = enter * np.cos(bearings)
            hidden = (enter > walls) | (enter > LOW_FAR_M) | (depth < robot.SCAN_RANGE_MIN_M)
            hidden |= fall_to_top > HIDDEN_SLOPE * depth
            over = fall_to_top / leave
        for other in range(len(low)):
            with np.errstate(invalid="ignore"):
                hidden |= (leave[other] <= enter) & (fall >= over[other])
        return np.where(hidden, np.inf, enter), cosines
