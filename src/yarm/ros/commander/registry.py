"""The object registry for the Commander: kinds, and the known shape of each mobile robot about its end effector."""

from __future__ import annotations

import threading
from typing import Callable, Dict, List, Optional, Sequence

import rospy
from tf2_msgs.msg import TFMessage

from yarm.commander.events import RegistryUpdate
from yarm.geometry import FloatArray
from yarm.geometry.kinds import ObjectKind
from yarm.msg import ObjectRegistry, RegisteredObject
from yarm.robots.shapes import PieceShape, RobotShape, piece_shape, robot_shape
from yarm.ros.common import names
from yarm.ros.common.checks import Doorkeeper, registry_fault, transform_fault
from yarm.ros.common.conversions import matrix_of_transform
from yarm.ros.common.solids import solids_at_tip, solids_of


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
        self._door, self._tf_door = Doorkeeper(names.OBJECT_REGISTRY), Doorkeeper("/tf")
        self._registry = rospy.Subscriber(names.OBJECT_REGISTRY, ObjectRegistry, self._on_registry, queue_size=10)

    def _on_registry(self, message: ObjectRegistry) -> None:
        if self._door.refuses(message, registry_fault(message)):
            return
        with self._lock:
            self._entries = list(message.entries)
            missing = self._missing()
            if missing and self._tf is None:
                self._tf = rospy.Subscriber("/tf", TFMessage, self._on_tf, queue_size=10)
        self._on_entries(message.entries)
        self._hand_on()

    def _missing(self) -> List[RegisteredObject]:
        return [e for e in self._entries if e.object == ObjectKind.MOBILE and e.shapes and e.name not in self._shapes]

    def _on_tf(self, message: TFMessage) -> None:
        now_s = rospy.get_time()
        good = [t for t in message.transforms if not self._tf_door.refuses(message, transform_fault(t, now_s))]
        poses = {t.child_frame_id.lstrip("/"): matrix_of_transform(t.transform) for t in good}
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
        solids = solids_at_tip(entry, poses)
        if solids is not None:
            self._shapes[entry.name] = robot_shape(solids, float(poses[entry.seed_frame][2, 3]))

    def _hand_on(self) -> None:
        with self._lock:
            kinds = {entry.name: entry.object for entry in self._entries}
            shapes = {name: shape for name, shape in self._shapes.items() if name in kinds}
            pieces, complete = pieces_of(self._entries), not self._missing()
        self._on_update(RegistryUpdate(kinds, shapes, pieces, complete))


def pieces_of(entries: Sequence[RegisteredObject]) -> Dict[str, PieceShape]:
    """The known shapes of the debris in the registry, by name."""
    solids = {e.name: [s for _, s in solids_of(e)] for e in entries if e.object == ObjectKind.DEBRIS}
    return {name: piece_shape(own) for name, own in solids.items() if own}
