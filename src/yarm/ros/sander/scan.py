"""Gathers the part's scan from the wrist camera's clouds."""

from __future__ import annotations

import threading
from collections import deque
from typing import Callable, Deque, List, Optional, Tuple

import numpy as np
import rospy
from sensor_msgs.msg import PointCloud2

from yarm.control.arm.model import ArmKinematics
from yarm.geometry.grid import FloatArray
from yarm.geometry.poses import transform_points
from yarm.ros.common import names
from yarm.ros.common.checks import Doorkeeper, cloud_fault, stamp_fault
from yarm.ros.sander.params import SanderNodeParams

NEAREST_M, FURTHEST_M = 0.2, 2.0
CLOUD_PERIOD_S = 1.0 / 15.0
HISTORY_S = 2.0
HALF_TICK_S = 1.0 / 120.0


class ScanCollector:
    """Listens to the wrist camera while wanted; clouds are placed by the joints measured at their stamp."""

    def __init__(
        self,
        params: SanderNodeParams,
        kinematics: ArmKinematics,
        wake: Callable[[], None],
        now_s: Callable[[], float],
    ) -> None:
        """Not listening yet.

        Args:
            params: volume and strides.
            kinematics: an instance of its own.
            wake: called when a cloud has come.
            now_s: the present, s, against which stamps are held; 0 when it is unknown.
        """
        self._params = params
        self._kinematics = kinematics
        self._wake = wake
        self._now_s = now_s
        self._lock = threading.Lock()
        self._clouds: Deque[PointCloud2] = deque(maxlen=60)
        self._newest_s = -1.0
        self._history: Deque[Tuple[float, FloatArray]] = deque()
        self._pieces: List[FloatArray] = []
        self._seen = 0
        self._door = Doorkeeper(names.wrist_points(params.arm))
        self._subscriber: Optional[rospy.Subscriber] = None

    def points(self) -> FloatArray:
        """Everything gathered, (n, 3), metres, world."""
        return np.concatenate(self._pieces) if self._pieces else np.zeros((0, 3))

    def listen(self, wanted: bool) -> None:
        """Subscribe or unsubscribe: the camera works only while somebody listens.

        In lock-step it is listened to before the sweep begins, so that no cloud depends on how fast one connects.
        """
        if wanted and self._subscriber is None:
            self._subscriber = rospy.Subscriber(
                names.wrist_points(self._params.arm), PointCloud2, self._on_cloud, queue_size=10, buff_size=1 << 23
            )
        elif not wanted and self._subscriber is not None:
            self._subscriber.unregister()
            self._subscriber = None
            self._newest_s = -1.0

    def complete(self, stamp_s: float) -> bool:
        """Lock-step: whether no cloud up to a time can still be missing."""
        return self._newest_s < 0.0 or self._newest_s > stamp_s - CLOUD_PERIOD_S + HALF_TICK_S

    def step(self, stamp_s: float, q: FloatArray, gather: bool, begin: bool) -> None:
        """One reading of the joints: place the clouds taken up to now.

        Args:
            stamp_s: time of the reading.
            q: joints (6,), rad.
            gather: whether clouds are wanted now.
            begin: whether a new scan begins now.
        """
        self._history.append((stamp_s, q))
        while stamp_s - self._history[0][0] > HISTORY_S:
            self._history.popleft()
        if begin:
            self._pieces, self._seen = [], 0
        with self._lock:
            due = [cloud for cloud in self._clouds if cloud.header.stamp.to_sec() <= stamp_s + HALF_TICK_S]
            for _ in due:
                self._clouds.popleft()
        if gather and not begin:
            for cloud in due:
                self._add(cloud)

    def reset(self) -> None:
        """Forget stamps and what was gathered."""
        with self._lock:
            self._clouds.clear()
            self._newest_s = -1.0
        self._history.clear()
        self._pieces = []

    def _on_cloud(self, cloud: PointCloud2) -> None:
        fault = cloud_fault(cloud) or stamp_fault(cloud.header.stamp.to_sec(), self._now_s())
        if self._door.refuses(cloud, fault):
            return
        with self._lock:
            self._clouds.append(cloud)
            self._newest_s = cloud.header.stamp.to_sec()
        self._wake()

    def _add(self, cloud: PointCloud2) -> None:
        self._seen += 1
        stamp_s = cloud.header.stamp.to_sec()
        taken_at, q = min(self._history, key=lambda reading: abs(reading[0] - stamp_s))
        if (self._seen - 1) % self._params.scan_every or abs(taken_at - stamp_s) > 2.0 * HALF_TICK_S:
            return
        points = _xyz(cloud, self._params.scan_stride)
        depth = points[:, 2]
        points = points[np.isfinite(depth) & (depth > NEAREST_M) & (depth < FURTHEST_M)]
        world = transform_points(self._kinematics.camera(q), points)
        off = np.abs(world[:, :2] - np.array(self._params.part_centre_m))
        self._pieces.append(
            world[np.all(off < self._params.scan_volume_m, axis=1) & (world[:, 2] > self._params.scan_lowest_m)]
        )


def _xyz(cloud: PointCloud2, stride: int) -> FloatArray:
    """Every stride-th point of an organised cloud, (n, 3), metres, camera frame."""
    floats = np.frombuffer(cloud.data, dtype=np.float32).reshape(cloud.height, cloud.width, cloud.point_step // 4)
    first = next(field.offset for field in cloud.fields if field.name == "x") // 4
    xyz: FloatArray = floats[::stride, ::stride, first : first + 3].reshape(-1, 3).astype(float)
    return xyz
