"""A cell made of sampled boxes that publishes what perception listens to, one camera set at a time and on demand."""

from __future__ import annotations

import threading
import time
from typing import Callable, Dict, List, Optional, Sequence

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Pose, TransformStamped
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2, PointField
from shape_msgs.msg import SolidPrimitive
from std_msgs.msg import Int8
from tf2_msgs.msg import TFMessage
from yarm.msg import MapMetaData, ObjectRegistry, RegisteredObject

from yarm.ros import names

SET_S = 1.0 / 30.0
LIMIT_S = 20.0
SIDE_PX = 72
PLACES = {1: (3.0, 0.0, 2.0), 2: (0.0, 3.0, 2.0), 3: (0.0, -3.0, 2.0), 4: (-3.0, 0.0, 2.0)}
CAMERAS = tuple(PLACES)


def wait_for(condition: Callable[[], bool], what: str, limit_s: float = LIMIT_S) -> None:
    """Wait on wall time until something holds.

    Raises:
        AssertionError: it does not within the limit.
    """
    end = time.monotonic() + limit_s
    while not condition():
        if time.monotonic() > end or rospy.is_shutdown():
            raise AssertionError(f"{what}: not within {limit_s:.0f} s")
        time.sleep(0.002)


def optical_pose(place: Sequence[float]) -> np.ndarray:
    """Matrix (4, 4) world <- optical frame of a camera that looks at the cell's middle."""
    forward = np.array([0.0, 0.0, 0.3]) - place
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([right, np.cross(forward, right), forward], axis=1)
    matrix[:3, 3] = place
    return matrix


def quaternion(rotation: np.ndarray) -> np.ndarray:
    """Quaternion (x, y, z, w) of a rotation matrix."""
    k = np.array(
        [
            rotation[2, 1] - rotation[1, 2],
            rotation[0, 2] - rotation[2, 0],
            rotation[1, 0] - rotation[0, 1],
            1.0 + np.trace(rotation),
        ]
    )
    if k[3] < 1e-6:
        axis = np.sqrt(np.maximum((np.diag(rotation) + 1.0) / 2.0, 0.0))
        k = np.append(axis, 0.0)
    return k / np.linalg.norm(k)


def box_points(centre: Sequence[float], size: Sequence[float], pitch: float = 0.05) -> np.ndarray:
    """Points (n, 3) on the top and the sides of an upright box, metres."""
    lo, hi = np.array(centre) - np.array(size) / 2, np.array(centre) + np.array(size) / 2
    axes = [np.arange(a, b + pitch / 2, pitch) for a, b in zip(lo, hi)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    skin = (grid[:, 2] > hi[2] - pitch) | np.any((grid[:, :2] < lo[:2] + 1e-6) | (grid[:, :2] > hi[:2] - pitch), axis=1)
    return grid[skin & (grid[:, 2] > 0.15)]


def stamped(frame: str, matrix: np.ndarray, stamp: rospy.Time) -> TransformStamped:
    """Transform world <- frame as a message."""
    message = TransformStamped()
    message.header.stamp, message.header.frame_id, message.child_frame_id = stamp, names.WORLD_FRAME, frame
    t, q = message.transform.translation, message.transform.rotation
    t.x, t.y, t.z = matrix[:3, 3]
    q.x, q.y, q.z, q.w = quaternion(matrix[:3, :3])
    return message


def cloud_message(points: np.ndarray, frame: str, stamp: rospy.Time) -> PointCloud2:
    """Points (n, 3) in a frame as an organised cloud, the rest of it NaN."""
    image = np.full((SIDE_PX * SIDE_PX, 4), np.nan, dtype=np.float32)
    image[: len(points), :3] = points
    message = PointCloud2(height=SIDE_PX, width=SIDE_PX, point_step=16, row_step=16 * SIDE_PX, data=image.tobytes())
    message.header.stamp, message.header.frame_id = stamp, frame
    message.fields = [PointField(n, 4 * i, PointField.FLOAT32, 1) for i, n in enumerate(("x", "y", "z", "rgb"))]
    return message


class Thing:
    """A registered box: name, kind, type, size in metres, centre in metres; its seed is the centre of its top."""

    def __init__(self, name: str, kind: str, label: str, size: Sequence[float], centre: Sequence[float]) -> None:
        self.name, self.kind, self.label = name, kind, label
        self.size, self.centre = np.array(size, dtype=float), np.array(centre, dtype=float)

    def entry(self) -> RegisteredObject:
        """The registry's entry."""
        pose = Pose()
        pose.position.z = -self.size[2] / 2
        pose.orientation.w = 1.0
        return RegisteredObject(
            name=self.name,
            object=self.kind,
            type=self.label,
            seed_frame=self.name,
            link_frames=[self.name],
            shapes=[SolidPrimitive(type=SolidPrimitive.BOX, dimensions=list(self.size))],
            shape_poses=[pose],
            shape_frames=[self.name],
        )

    def seed(self) -> np.ndarray:
        """Matrix (4, 4) world <- seed."""
        matrix = np.eye(4)
        matrix[:3, 3] = self.centre + np.array([0.0, 0.0, self.size[2] / 2])
        return matrix


class Cell:
    """Publishes clock, frames, registry and clouds; collects metadata and diagnostics."""

    def __init__(self) -> None:
        self.now_s = 10.0
        self.things: Dict[str, Thing] = {}
        self.extra = np.empty((0, 3))
        self.tf_on = True
        self.metadata: List[MapMetaData] = []
        self.health: Dict[str, str] = {}
        self._lock = threading.Lock()
        self.poses = {camera: optical_pose(np.array(place)) for camera, place in PLACES.items()}
        self._clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self._tf = rospy.Publisher("/tf", TFMessage, queue_size=10)
        self._tf_static = rospy.Publisher("/tf_static", TFMessage, queue_size=10, latch=True)
        self._registry = rospy.Publisher(names.OBJECT_REGISTRY, ObjectRegistry, queue_size=10, latch=True)
        self._switch = rospy.Publisher(names.STATIC_ASSOCIATION_SWITCH, Int8, queue_size=10, latch=True)
        self._clouds = {c: rospy.Publisher(names.camera_points(c), PointCloud2, queue_size=10) for c in CAMERAS}
        rospy.Subscriber(names.PLANNING_METADATA, MapMetaData, self._on_metadata, queue_size=100)
        rospy.Subscriber(names.DIAGNOSTICS, DiagnosticArray, self._on_diagnostics, queue_size=100)

    def wait_for_nodes(self) -> None:
        """Until perception and the seed publisher have joined."""
        for publisher in [self._tf, self._registry, self._switch, *self._clouds.values()]:
            wait_for(lambda p=publisher: p.get_num_connections() > 0, f"a subscriber to {publisher.name}", 60.0)

    def place_cameras(self, cameras: Sequence[int]) -> None:
        """Publish the fixed frames of these cameras."""
        frames = [stamped(names.camera_optical_frame(c), self.poses[c], rospy.Time(0)) for c in cameras]
        self._tf_static.publish(TFMessage(frames))

    def register(self, *things: Thing) -> None:
        """Publish who is in the cell."""
        self.things = {thing.name: thing for thing in things}
        self._registry.publish(ObjectRegistry(entries=[thing.entry() for thing in things]))

    def switch(self, running: bool) -> None:
        """Calibrating or running."""
        self._switch.publish(Int8(int(running)))

    def cloud(self, camera: int, stamp: rospy.Time) -> PointCloud2:
        """What a camera sees: every camera sees every point."""
        parts = [box_points(thing.centre, thing.size) for thing in self.things.values() if thing.kind != "Target"]
        points = np.concatenate([*parts, self.extra]) if parts else self.extra
        pose = self.poses[camera]
        return cloud_message((points - pose[:3, 3]) @ pose[:3, :3], names.camera_optical_frame(camera), stamp)

    def tick(self) -> rospy.Time:
        """Time goes on by one camera set: clock and frames."""
        self.now_s += SET_S
        stamp = rospy.Time.from_sec(self.now_s)
        self._clock.publish(Clock(stamp))
        if self.tf_on and self.things:
            self._tf.publish(TFMessage([stamped(t.name, t.seed(), stamp) for t in self.things.values()]))
        return stamp

    def send(self, camera: int, message: PointCloud2) -> None:
        """Publish one cloud."""
        self._clouds[camera].publish(message)

    def step(self, only: Sequence[int] = CAMERAS, **spoil: Callable[[PointCloud2], None]) -> MapMetaData:
        """One camera set and the metadata it gives. ``spoil``: camera_<n> = what to do to that camera's message."""
        stamp = self.tick()
        for camera in only:
            message = self.cloud(camera, stamp)
            spoil.get(f"camera_{camera}", lambda _: None)(message)
            self.send(camera, message)
        wait_for(lambda: self.find(stamp) is not None, f"metadata of {stamp.to_sec():.3f}")
        found = self.find(stamp)
        assert found is not None
        return found

    def find(self, stamp: rospy.Time) -> Optional[MapMetaData]:
        """The metadata of a stamp, if it has come."""
        with self._lock:
            return next((m for m in reversed(self.metadata) if m.header.stamp == stamp), None)

    def wait_for_health(self, condition: Callable[[str], bool], node: str, what: str, keep_going: bool = True) -> str:
        """Step on until a node's diagnostics say something; gives the message."""
        with self._lock:
            self.health.clear()
        end = time.monotonic() + LIMIT_S
        while not condition(self.health.get(node, "")):
            if time.monotonic() > end:
                raise AssertionError(f"{node} never said {what}; last: {self.health.get(node)!r}")
            if keep_going:
                self.step()
            time.sleep(0.01)
        return self.health[node]

    def _on_metadata(self, message: MapMetaData) -> None:
        with self._lock:
            self.metadata.append(message)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        with self._lock:
            for status in message.status:
                self.health[status.name] = status.message
