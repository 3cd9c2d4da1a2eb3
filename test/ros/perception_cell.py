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
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import PointCloud2, PointField
from shape_msgs.msg import SolidPrimitive
from std_msgs.msg import Int8
from tf2_msgs.msg import TFMessage
from yarm.msg import MapMetaData, ObjectRegistry, RegisteredObject

from yarm.ros.common import names

SET_S = 1.0 / 30.0
LIMIT_S = 60.0
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
    return Rotation.from_matrix(rotation).as_quat()


def box_points(centre: Sequence[float], size: Sequence[float], pitch: float = 0.05) -> np.ndarray:
    """Points (n, 3) on the top and the sides of an upright box, at most ``pitch`` apart, metres."""
    lo, hi = np.array(centre) - np.array(size) / 2, np.array(centre) + np.array(size) / 2
    axes = [np.linspace(a, b, 1 + int(np.ceil((b - a) / pitch - 1e-9))) for a, b in zip(lo, hi)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    skin = (grid[:, 2] == hi[2]) | np.any((grid[:, :2] == lo[:2]) | (grid[:, :2] == hi[:2]), axis=1)
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
        self.seen_by: Dict[int, np.ndarray] = {}
        self.tf_on = True
        self.metadata: List[MapMetaData] = []
        self.health: Dict[str, str] = {}
        self.levels: Dict[str, int] = {}
        self.values: Dict[str, Dict[str, str]] = {}
        self.said_s: Dict[str, float] = {}
        self.said: Dict[str, List[str]] = {}
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

    def forget_health(self) -> None:
        """Only what is said from now on counts."""
        with self._lock:
            self.health.clear()
            self.said.clear()

    def said_that(self, node: str, condition: Callable[[str], bool]) -> Optional[str]:
        """What a node's health was that meets a condition, since it was forgotten: by now it may be another."""
        with self._lock:
            return next((text for text in self.said.get(node, ()) if condition(text)), None)

    def has_said(self, node: str, *parts: str) -> bool:
        """Whether a node's health has had all these parts at once since it was forgotten."""
        return self.said_that(node, lambda text: all(part in text for part in parts)) is not None

    def wait_for_nodes(self) -> None:
        """Until perception and the seed publisher, which hears of frames and objects too, have joined."""
        joined = {self._tf: 2, self._registry: 2, self._switch: 1, **dict.fromkeys(self._clouds.values(), 1)}
        for publisher, count in joined.items():
            wait_for(
                lambda p=publisher, n=count: p.get_num_connections() >= n, f"{count} subscribers to {publisher.name}"
            )

    def place_cameras(self, cameras: Sequence[int], told: Optional[Dict[int, np.ndarray]] = None) -> None:
        """Publish the fixed frames of these cameras. ``told``: poses (4, 4) by camera that are not where it is."""
        poses = {**self.poses, **(told or {})}
        frames = [stamped(names.camera_optical_frame(c), poses[c], rospy.Time(0)) for c in cameras]
        self._tf_static.publish(TFMessage(frames))

    def register(self, *things: Thing) -> None:
        """Publish who is in the cell."""
        self.things = {thing.name: thing for thing in things}
        self._registry.publish(ObjectRegistry(entries=[thing.entry() for thing in things]))

    def switch(self, running: bool) -> None:
        """Calibrating or running."""
        self._switch.publish(Int8(int(running)))

    def cloud(self, camera: int, stamp: rospy.Time) -> PointCloud2:
        """What a camera sees: every camera sees every point, but those that ``seen_by`` gives to it alone."""
        parts = [box_points(thing.centre, thing.size) for thing in self.things.values() if thing.kind != "Target"]
        points = np.concatenate([*parts, self.extra, self.seen_by.get(camera, np.empty((0, 3)))])
        pose = self.poses[camera]
        return cloud_message((points - pose[:3, 3]) @ pose[:3, :3], names.camera_optical_frame(camera), stamp)

    def tick(self) -> rospy.Time:
        """Time goes on by one camera set."""
        return self.tick_to(self.now_s + SET_S)

    def tick_to(self, now_s: float) -> rospy.Time:
        """Time goes on to a moment: clock and frames."""
        self.now_s = now_s
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
        stamp = self.send_set(only, **spoil)
        wait_for(lambda: self.find(stamp) is not None, f"metadata of {stamp.to_sec():.3f}")
        found = self.find(stamp)
        assert found is not None
        return found

    def step_until(self, condition: Callable[[MapMetaData], bool], what: str) -> MapMetaData:
        """Camera sets until the metadata are as wanted; these."""
        found: List[MapMetaData] = []

        def as_wanted() -> bool:
            found[:] = [self.step()]
            return condition(found[0])

        wait_for(as_wanted, what)
        return found[0]

    def send_set(self, only: Sequence[int] = CAMERAS, **spoil: Callable[[PointCloud2], None]) -> rospy.Time:
        """One camera set, not waiting for what it gives; its stamp."""
        stamp = self.tick()
        messages = {camera: self.cloud(camera, stamp) for camera in only}
        for camera, message in messages.items():
            spoil.get(f"camera_{camera}", lambda _: None)(message)
        for camera, message in messages.items():  # a set waits for its cameras on wall time: one right after the other
            self.send(camera, message)
        return stamp

    def find(self, stamp: rospy.Time) -> Optional[MapMetaData]:
        """The metadata of a stamp, if it has come."""
        with self._lock:
            return next((m for m in reversed(self.metadata) if m.header.stamp == stamp), None)

    def wait_for_health(self, condition: Callable[[str], bool], node: str, what: str, keep_going: bool = True) -> str:
        """Step on until a node's diagnostics say something; gives the message."""
        self.forget_health()
        end = time.monotonic() + LIMIT_S
        while (found := self.said_that(node, condition)) is None:
            if time.monotonic() > end:
                raise AssertionError(f"{node} never said {what}; last: {self.health.get(node)!r}")
            if keep_going:
                self.step()
            time.sleep(0.01)
        return found

    def metadata_since(self, count: int) -> List[MapMetaData]:
        """The metadata that came after the first ``count``."""
        with self._lock:
            return self.metadata[count:]

    def _on_metadata(self, message: MapMetaData) -> None:
        with self._lock:
            self.metadata.append(message)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        with self._lock:
            for status in message.status:
                self.health[status.name] = status.message
                self.levels[status.name] = status.level
                self.values[status.name] = {pair.key: pair.value for pair in status.values}
                self.said_s[status.name] = message.header.stamp.to_sec()
                self.said.setdefault(status.name, []).append(status.message)
