"""The object registry for the Commander: kinds, and the known shape of each mobile robot about its end effector."""

from __future__ import annotations

import threading
from typing import Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np
import rospy
from geometry_msgs.msg import Pose, Transform
from shape_msgs.msg import SolidPrimitive
from tf2_msgs.msg import TFMessage

from yarm.commander.messages import RegistryUpdate
from yarm.commander.shapes import RobotShape, Solid, robot_shape
from yarm.geometry import FloatArray, transform_matrix
from yarm.msg import ObjectRegistry, RegisteredObject
from yarm.ros import names

KINDS: Dict[int, str] = {
    SolidPrimitive.BOX: "box",
    SolidPrimitive.SPHERE: "sphere",
    SolidPrimitive.CYLINDER: "cylinder",
}


def matrix_of_pose(pose: Pose) -> FloatArray:
    """Homogeneous matrix (4, 4) of a pose message."""
    p, q = pose.position, pose.orientation
    return transform_matrix((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))


def matrix_of_transform(transform: Transform) -> FloatArray:
    """Homogeneous matrix (4, 4) of a transform message."""
    t, q = transform.translation, transform.rotation
    return transform_matrix((t.x, t.y, t.z), (q.x, q.y, q.z, q.w))


def solids_of(entry: RegisteredObject) -> List[Tuple[str, Solid]]:
    """The known solids of an object, each with the tf frame it is fixed to."""
    solids = []
    for shape, pose, frame in zip(entry.shapes, entry.shape_poses, entry.shape_frames):
        if shape.type in KINDS:
            solids.append((frame, Solid(KINDS[shape.type], tuple(shape.dimensions), matrix_of_pose(pose))))
    return solids


class RegistryWatch:
    """Hands on each registry once the frames of the robots in it are known. Thread-safe."""

    def __init__(
        self,
        on_update: Callable[[RegistryUpdate], None],
        on_entries: Callable[[Sequence[RegisteredObject]], None] = lambda entries: None,
    ) -> None:
        """Subscribe to the registry, and to ``/tf`` only while a robot's frames are missing."""
        self._on_update = on_update
        self._on_entries = on_entries
        self._lock = threading.Lock()
        self._entries: List[RegisteredObject] = []
        self._shapes: Dict[str, RobotShape] = {}
        self._tf: Optional[rospy.Subscriber] = None
        self._registry = rospy.Subscriber(names.OBJECT_REGISTRY, ObjectRegistry, self._on_registry, queue_size=10)

    def _on_registry(self, message: ObjectRegistry) -> None:
        with self._lock:
            self._entries = list(message.entries)
            missing = self._missing()
            if missing and self._tf is None:
                self._tf = rospy.Subscriber("/tf", TFMessage, self._on_tf, queue_size=10)
        self._on_entries(message.entries)
        self._hand_on()

    def _missing(self) -> List[RegisteredObject]:
        return [e for e in self._entries if e.object == "Mobile" and e.shapes and e.name not in self._shapes]

    def _on_tf(self, message: TFMessage) -> None:
        poses = {t.child_frame_id.lstrip("/"): matrix_of_transform(t.transform) for t in message.transforms}
        with self._lock:
            before = len(self._shapes)
            for entry in self._missing():
                self._learn(entry, poses)
            done = not self._missing()
            if done and self._tf is not None:
                self._tf.unregister()
                self._tf = None
            learnt = len(self._shapes) > before
        if learnt:
            self._hand_on()

    def _learn(self, entry: RegisteredObject, poses: Dict[str, FloatArray]) -> None:
        frames = {frame for frame, _ in solids_of(entry)} | {entry.seed_frame}
        if not frames <= set(poses):
            return
        T_ee_world = np.linalg.inv(poses[entry.seed_frame])
        solids = [
            Solid(solid.kind, solid.size, T_ee_world @ poses[frame] @ solid.pose) for frame, solid in solids_of(entry)
        ]
        self._shapes[entry.name] = robot_shape(solids, float(poses[entry.seed_frame][2, 3]))

    def _hand_on(self) -> None:
        with self._lock:
            kinds = {entry.name: entry.object for entry in self._entries}
            shapes = {name: shape for name, shape in self._shapes.items() if name in kinds}
        self._on_update(RegistryUpdate(kinds, shapes))
