"""Plays the golden recording to perception nodes in one or more namespaces, set by set, and collects the metadata."""

from __future__ import annotations

import threading
import time
from typing import Callable, Dict, List, Sequence

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Bool, Int8
from tf2_msgs.msg import TFMessage
from yarm.msg import MapMetaData, ObjectRegistry, TransformStampedVector

from support import golden
from yarm.ros.common import names
from yarm.ros.simulation.clouds import RawCloud

LIMIT_S = 60.0


def wait_for(condition: Callable[[], bool], what: str) -> None:
    """Wait on wall time until something holds, or raise an AssertionError."""
    end = time.monotonic() + LIMIT_S
    while not condition():
        if time.monotonic() > end or rospy.is_shutdown():
            raise AssertionError(f"{what}: not within {LIMIT_S:.0f} s")
        time.sleep(0.002)


class Listener:
    """Publishers to, and metadata from, the perception nodes of one namespace."""

    def __init__(self, space: str) -> None:
        self.space = space
        prefix = f"{space}/" if space else ""
        self.registry = rospy.Publisher(prefix + names.OBJECT_REGISTRY, ObjectRegistry, queue_size=10, latch=True)
        self.switch = rospy.Publisher(prefix + names.STATIC_ASSOCIATION_SWITCH, Int8, queue_size=10, latch=True)
        self._prefix, self._hands = prefix, {}
        self.clouds = [
            rospy.Publisher(prefix + names.camera_points(c), PointCloud2, queue_size=10) for c in golden.CAMERAS
        ]
        self._lock = threading.Lock()
        self._metadata: Dict[int, MapMetaData] = {}
        self._seeds = 0
        self._association: Dict[str, str] = {}
        rospy.Subscriber(prefix + names.PLANNING_METADATA, MapMetaData, self._on_metadata, queue_size=100)
        rospy.Subscriber(prefix + names.SEED_TRANSFORMS, TransformStampedVector, self._on_seeds, queue_size=100)
        rospy.Subscriber(names.DIAGNOSTICS, DiagnosticArray, self._on_diagnostics, queue_size=100)

    def ready(self) -> bool:
        """Whether everybody who must listen does."""
        return all(p.get_num_connections() > 0 for p in [self.registry, self.switch, *self.clouds])

    def tell(self, registry: ObjectRegistry, calibrating: bool) -> None:
        """Publish registry and switch, and wait until the association says that it has them."""
        self.registry.publish(registry)
        self.switch.publish(Int8(0 if calibrating else 1))
        wanted = {"calibrating": "yes" if calibrating else "no", "registered objects": f"{len(registry.entries):.3f}"}
        wait_for(lambda: wanted.items() <= self._association.items(), f"{wanted} in '{self.space}'")

    def tell_hand(self, robot: str, grasping: bool) -> None:
        """Say whether something hangs on a robot's hand, and wait until the association says that it has heard."""
        if robot not in self._hands:
            topic = self._prefix + names.gripper(robot, "grasping")
            self._hands[robot] = rospy.Publisher(topic, Bool, queue_size=10, latch=True)
        self._hands[robot].publish(Bool(grasping))
        told = f"{float(grasping):.3f}"
        wait_for(
            lambda: self._association.get("hands that hold something") == told, f"{robot}'s hand in '{self.space}'"
        )

    def metadata(self, stamp_ns: int) -> MapMetaData:
        """The metadata of a capture time, waited for."""
        wait_for(lambda: stamp_ns in self._metadata, f"metadata of {stamp_ns} in '{self.space}'")
        with self._lock:
            return self._metadata[stamp_ns]

    def wait_for_seeds(self, stamp_ns: int, count: int) -> None:
        """Until the seed publisher has placed so many objects at a capture time."""
        wait_for(lambda: self._seeds >= stamp_ns * 1000 + count, f"{count} seeds of {stamp_ns} in '{self.space}'")

    def _on_metadata(self, message: MapMetaData) -> None:
        with self._lock:
            self._metadata[message.header.stamp.to_nsec()] = message

    def _on_seeds(self, message: TransformStampedVector) -> None:
        with self._lock:
            self._seeds = message.header.stamp.to_nsec() * 1000 + len(message.frame)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        if not message._connection_header["callerid"].startswith(f"/{self.space}/"):
            return
        for status in message.status:
            if status.name == "cluster_assoc: inputs":
                self._association = {pair.key: pair.value for pair in status.values}


class Player:
    """Plays a recording in lock-step: one set after the other has been answered everywhere."""

    def __init__(self, recording: golden.Golden, spaces: Sequence[str]) -> None:
        self._recording = recording
        self._clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self._tf = rospy.Publisher("/tf", TFMessage, queue_size=10)
        self._tf_static = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        self._listeners = [Listener(space) for space in spaces]
        height, width = recording.sets[0].depth.shape[1:]
        self._raw = [RawCloud(names.camera_optical_frame(c), height, width, 16) for c in golden.CAMERAS]

    def play(self, before: Callable[[int, Listener], None] = lambda number, listener: None) -> List[List[MapMetaData]]:
        """Metadata of every set, by namespace; ``before`` is called with each set's number and each listener."""
        self._tf_static.publish(golden.from_bytes(TFMessage, self._recording.fixed_frames))
        for listener in self._listeners:
            wait_for(listener.ready, f"perception in '{listener.space}'")
        wait_for(lambda: self._tf.get_num_connections() >= 2 * len(self._listeners), "listeners to /tf")
        found = []
        for number, golden_set in enumerate(self._recording.sets):
            for listener in self._listeners:
                listener.tell(golden.from_bytes(ObjectRegistry, golden_set.registry), golden_set.calibrating)
                before(number, listener)
            found.append(self._step(golden_set))
        return [list(row) for row in zip(*found)]

    def _step(self, golden_set: golden.GoldenSet) -> List[MapMetaData]:
        stamp = rospy.Time(golden_set.stamp_ns // 10**9, golden_set.stamp_ns % 10**9)
        registry = golden.from_bytes(ObjectRegistry, golden_set.registry)
        frames = golden.from_bytes(TFMessage, golden_set.frames)
        self._clock.publish(Clock(stamp))
        self._tf.publish(TFMessage([self._at(stamp, t) for t in frames.transforms]))
        for listener in self._listeners:
            listener.wait_for_seeds(golden_set.stamp_ns, len(registry.entries))
            for publisher, raw, depth in zip(listener.clouds, self._raw, golden_set.depth):
                publisher.publish(raw.fill(stamp, golden.points_of(self._recording, depth)))
        return [listener.metadata(golden_set.stamp_ns) for listener in self._listeners]

    @staticmethod
    def _at(stamp: rospy.Time, transform: TransformStamped) -> TransformStamped:
        transform.header.stamp = stamp
        return transform
