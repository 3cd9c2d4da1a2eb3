"""What a camera is judged by: known bodies where they are now, where it is told to be, and its clouds."""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass
from typing import Dict, List, Optional, Tuple

import numpy as np
import rospy
from sensor_msgs.msg import PointCloud2
from tf2_msgs.msg import TFMessage

from yarm.geometry import FloatArray
from yarm.geometry.kinds import ObjectKind
from yarm.geometry.solids import Solid
from yarm.msg import ObjectRegistry, RegisteredObject
from yarm.ros.common import names
from yarm.ros.common.checks import Doorkeeper, cloud_fault, registry_fault, transform_fault
from yarm.ros.common.conversions import matrix_of_transform
from yarm.ros.common.solids import solids_of

MAX_DEPTH = 64
"""Longest chain of parents followed; a longer one is a loop."""


@dataclass(frozen=True, eq=False)
class KnownSolids:
    """Known solids with their poses in the world: those that never move, and those that do."""

    static: Tuple[Solid, ...]
    moving: Tuple[Solid, ...]


class CellView:
    """The newest registry and transforms. Thread-safe."""

    def __init__(self) -> None:
        """Subscribe."""
        self._lock = threading.Lock()
        self._entries: List[RegisteredObject] = []
        self._links: Dict[str, Tuple[str, FloatArray]] = {}
        self._door, self._tf_door = Doorkeeper(names.OBJECT_REGISTRY), Doorkeeper("/tf")
        self._subscribers = [
            rospy.Subscriber(names.OBJECT_REGISTRY, ObjectRegistry, self._on_registry, queue_size=10),
            rospy.Subscriber("/tf", TFMessage, self._on_tf, queue_size=10),
            rospy.Subscriber("/tf_static", TFMessage, self._on_tf, queue_size=100),
        ]

    @property
    def heard(self) -> bool:
        """Whether anybody has told who is in the cell."""
        with self._lock:
            return bool(self._entries)

    def pose_of(self, frame: str) -> Optional[FloatArray]:
        """T_world_frame (4, 4), the newest; None while no chain of transforms leads there."""
        with self._lock:
            return self._pose_of(frame)

    def top_of(self, frame: str) -> Optional[Tuple[str, FloatArray]]:
        """The child of the world above a frame, and T_top_frame (4, 4): what tells where a camera's whole tree is."""
        pose: FloatArray = np.eye(4)
        with self._lock:
            for _ in range(MAX_DEPTH):
                link = self._links.get(frame)
                if link is None:
                    return None
                if link[0] == names.WORLD_FRAME:
                    return frame, pose
                frame, pose = link[0], link[1] @ pose
        return None

    def solids(self) -> KnownSolids:
        """The known solids; those of debris and of what has no transform are left out."""
        static: List[Solid] = []
        moving: List[Solid] = []
        with self._lock:
            for entry in self._entries:
                fixed = entry.type == "static" and entry.object == ObjectKind.OBSTACLE
                for frame, solid in solids_of(entry):
                    pose = self._pose_of(frame)
                    if pose is not None:
                        (static if fixed else moving).append(solid.seen_from(pose))
        return KnownSolids(tuple(static), tuple(moving))

    def _pose_of(self, frame: str) -> Optional[FloatArray]:
        pose: FloatArray = np.eye(4)
        for _ in range(MAX_DEPTH):
            if frame == names.WORLD_FRAME:
                return pose
            link = self._links.get(frame)
            if link is None:
                return None
            frame, pose = link[0], link[1] @ pose
        return None

    def _on_registry(self, message: ObjectRegistry) -> None:
        if not self._door.refuses(message, registry_fault(message)):
            with self._lock:
                self._entries = list(message.entries)

    def _on_tf(self, message: TFMessage) -> None:
        for transform in message.transforms:
            if not self._tf_door.refuses(message, transform_fault(transform, math.inf)):
                link = transform.header.frame_id.lstrip("/"), matrix_of_transform(transform.transform)
                with self._lock:
                    self._links[transform.child_frame_id.lstrip("/")] = link


@dataclass(frozen=True, eq=False)
class Snapshot:
    """One cloud: its points (n, 3), optical frame, metres, frame and stamp, s; or why there is none."""

    points: FloatArray
    frame: str = ""
    stamp_s: float = 0.0
    fault: str = ""


def snapshot(topic: str, limit_s: float) -> Snapshot:
    """The next cloud of a topic, listened to only so long; ``limit_s`` of wall time.

    A camera's clouds are a hundred times what is looked at of them: a standing subscription would copy them all.
    """
    nothing = np.zeros((0, 3))
    got: List[PointCloud2] = []
    arrived = threading.Event()

    def take(message: PointCloud2) -> None:
        got.append(message)
        arrived.set()

    subscriber = rospy.Subscriber(topic, PointCloud2, take, queue_size=1, buff_size=1 << 22)
    arrived.wait(limit_s)
    subscriber.unregister()
    if not got:
        return Snapshot(nothing, fault=f"no cloud within {limit_s:g} s")
    fault = cloud_fault(got[0])
    if fault:
        return Snapshot(nothing, fault=fault)
    message = got[0]
    start = next(field.offset for field in message.fields if field.name == "x") // 4
    floats = np.frombuffer(message.data, np.float32).reshape(-1, message.point_step // 4)
    points = floats[:, start : start + 3].astype(float)
    return Snapshot(points, message.header.frame_id.lstrip("/"), message.header.stamp.to_sec())
