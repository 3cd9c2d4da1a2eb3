"""What is wrong with a message from elsewhere, in one sentence; whoever sent it is named, and it is left out.

One function a message: the answer is empty when the message can be used. Nothing here raises.
"""

from __future__ import annotations

import math
import time
from typing import Any, Dict, Optional, Sequence, Tuple

import rosgraph
import rospy
from geometry_msgs.msg import Pose, TransformStamped
from sensor_msgs.msg import JointState, PointCloud2
from shape_msgs.msg import SolidPrimitive

from yarm.control.sander.states import SanderState
from yarm.geometry import CellMap
from yarm.geometry.kinds import ROBOT_KINDS, ObjectKind
from yarm.msg import (
    KeepOff,
    ObjectRegistry,
    PlanReport,
    SafetyStatus,
    SanderStatus,
    SimStatus,
    StepAck,
    TrackedObjects,
    TransformStampedVector,
)
from yarm.safety.heartbeat import AHEAD_S

FARTHEST_M = 1e3
"""Nothing in the cell is farther from the origin, metres."""
UNIT_TOLERANCE = 0.05
"""Length of a quaternion that still counts as 1, plus or minus."""
SAY_AGAIN_S = 5.0
"""Wall time between two warnings about the same sender, s."""
MOST_PLACES = 10000
"""Places that a manipulator's tip can be told to keep off."""
DIMENSIONS: Dict[int, int] = {SolidPrimitive.BOX: 3, SolidPrimitive.SPHERE: 1, SolidPrimitive.CYLINDER: 2}


def sender_of(message: Any) -> str:
    """Name of the node that published a message, without its slash; empty when it is not known."""
    header: Dict[str, str] = getattr(message, "_connection_header", None) or {}
    return header.get("callerid", "").strip("/")


class Doorkeeper:
    """Leaves out faulty messages of one topic and says so, with their sender, not more often than SAY_AGAIN_S."""

    def __init__(self, topic: str) -> None:
        """Nothing refused yet."""
        self._topic = topic
        self._said_s: Dict[str, float] = {}

    def refuses(self, message: Any, fault: str) -> bool:
        """Whether a message is left out; true exactly when there is a fault."""
        if fault:
            sender, now_s = sender_of(message), time.monotonic()
            if now_s - self._said_s.get(sender, -math.inf) >= SAY_AGAIN_S:
                self._said_s[sender] = now_s
                rospy.logwarn("%s of %s refused: %s", self._topic, sender or "an unknown node", fault)
        return bool(fault)


def present_s(lock_step: bool) -> float:
    """Simulated time for the check of a stamp, s; unknown (0) in lock-step, where nothing may be left out.

    There ``/clock`` reaches a node on a way of its own and may lag many ticks behind what it times.
    """
    return 0.0 if lock_step else float(rospy.get_time())


def stamp_fault(stamp_s: float, now_s: float) -> str:
    """A stamp, s, that lies in the future would stop everything newer from being taken; unknown time (0) allows any."""
    if 0.0 < now_s < stamp_s - AHEAD_S:
        return f"its stamp {stamp_s:.3f} s is in the future; it is {now_s:.3f} s, allowed {AHEAD_S:g} s more"
    return ""


def numbers_fault(position: Sequence[float], quaternion: Sequence[float]) -> str:
    """A place, metres, and a quaternion x, y, z, w that can be a pose in the cell."""
    if not all(math.isfinite(value) and abs(value) <= FARTHEST_M for value in position):
        return f"position {tuple(position)} must be finite and within {FARTHEST_M:g} m"
    length = math.sqrt(sum(value * value for value in quaternion))
    if not abs(length - 1.0) <= UNIT_TOLERANCE:
        return f"quaternion {tuple(quaternion)} must have length 1, it has {length:.3f}"
    return ""


def pose_fault(pose: Pose) -> str:
    """Numbers of a pose message."""
    p, q = pose.position, pose.orientation
    return numbers_fault((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))


def transform_fault(transform: TransformStamped, now_s: float) -> str:
    """Numbers and stamp of a transform, with its frame."""
    t, q = transform.transform.translation, transform.transform.rotation
    fault = numbers_fault((t.x, t.y, t.z), (q.x, q.y, q.z, q.w))
    fault = fault or stamp_fault(transform.header.stamp.to_sec(), now_s)
    return f"frame {transform.child_frame_id!r}: {fault}" if fault else ""


def map_fault(cell_map: CellMap, now_s: float, before: Optional[CellMap]) -> str:
    """A map against the present and the newest one taken: stamp, grid, poses.

    Args:
        cell_map: in itself consistent (``parse_map_metadata``).
        now_s: simulated time, s.
        before: the newest map taken while its sender still speaks; None when any grid will do.
    """
    fault = stamp_fault(cell_map.stamp_s, now_s)
    if fault:
        return fault
    for found in cell_map.objects.values():
        quaternion = found.quaternion if found.kind in ROBOT_KINDS else (0.0, 0.0, 0.0, 1.0)
        fault = numbers_fault(found.position_m, quaternion)
        if fault:
            return f"{found.name}: {fault}"
    if before is None:
        return ""
    if cell_map.spec != before.spec:
        return f"its grid {cell_map.spec} is not the one in use, {before.spec}"
    if cell_map.stamp_s < before.stamp_s:
        return f"its stamp {cell_map.stamp_s:.3f} s is older than that of the newest map, {before.stamp_s:.3f} s"
    return ""


def registry_fault(message: ObjectRegistry) -> str:
    """Names, kinds and solids of a registry."""
    names = [entry.name for entry in message.entries]
    doubled = sorted({name for name in names if names.count(name) > 1})
    if doubled:
        return f"more than one object is called {', '.join(doubled)}"
    for entry in message.entries:
        if not entry.name or entry.object not in tuple(ObjectKind):
            return f"object {entry.name!r} is a {entry.object!r}, expected one of {', '.join(ObjectKind)}"
        if entry.object in ROBOT_KINDS and not rosgraph.names.is_legal_base_name(entry.name):
            return f"robot {entry.name!r}: topics are called after it: letters, digits and _, a letter first"
        if not len(entry.shapes) == len(entry.shape_poses) == len(entry.shape_frames):
            lengths = (len(entry.shapes), len(entry.shape_poses), len(entry.shape_frames))
            return f"{entry.name}: shapes, shape_poses and shape_frames differ in length: {lengths}"
        for shape, pose in zip(entry.shapes, entry.shape_poses):
            fault = _solid_fault(shape) or pose_fault(pose)
            if fault:
                return f"{entry.name}: {fault}"
    return ""


def _solid_fault(shape: SolidPrimitive) -> str:
    wanted = DIMENSIONS.get(shape.type)
    if wanted is None:
        return ""
    sizes = tuple(shape.dimensions)
    if len(sizes) < wanted or not all(math.isfinite(size) and 0.0 < size <= FARTHEST_M for size in sizes):
        return f"a solid of type {shape.type} has dimensions {sizes}, expected {wanted} sizes above 0 m"
    return ""


def safety_fault(message: SafetyStatus, now_s: float) -> str:
    """Lengths and stamp of the safety monitor's word."""
    lengths = (len(message.robots), len(message.clearance_m), len(message.nearest), len(message.stopped))
    if len(set(lengths)) != 1:
        return f"robots, clearance_m, nearest and stopped differ in length: {lengths}"
    return stamp_fault(message.header.stamp.to_sec(), now_s)


def plan_fault(message: PlanReport) -> str:
    """Lengths of what a plan's report says of each robot."""
    per_robot = (message.goals, message.statuses, message.robot_ms, message.length_cells, message.paths)
    lengths = tuple(map(len, per_robot))
    if set(lengths) != {len(message.robots)}:
        return f"{len(message.robots)} robots, but goals, statuses, robot_ms, length_cells, paths: {lengths}"
    return ""


def sim_fault(message: SimStatus) -> str:
    """Lengths and pairs of what the simulator knows of its bodies."""
    if len(message.debris) != len(message.bins):
        return f"{len(message.debris)} pieces of debris, but {len(message.bins)} bins"
    for pair in message.touched:
        if len(pair.split()) != 2:
            return f"touched must be pairs of bodies, 'a b'; there is {pair!r}"
    return ""


def tracks_fault(message: TrackedObjects, now_s: float) -> str:
    """Numbers, identities and stamp of what is followed."""
    numbers = [one.id for one in message.objects]
    if len(set(numbers)) != len(numbers):
        return f"ids must be unique: {numbers}"
    for one in message.objects:
        p, v, e = one.position, one.velocity, one.extent
        values = (p.x, p.y, p.z, v.x, v.y, v.z, e.x, e.y, e.z, *one.covariance)
        if not all(math.isfinite(value) and abs(value) <= FARTHEST_M for value in values):
            return f"object {one.id}: position, velocity, extent and covariance must be within {FARTHEST_M:g}"
        if not one.age_s >= 0.0:
            return f"object {one.id}: age_s must be at least 0, it is {one.age_s:g}"
    return stamp_fault(message.header.stamp.to_sec(), now_s)


def seeds_fault(message: TransformStampedVector, now_s: float) -> str:
    """Lengths, names and stamp of the seeds; each seed's numbers are for ``transform_fault``."""
    lengths = (len(message.transforms), len(message.type), len(message.frame), len(message.object))
    if len(set(lengths)) != 1:
        return f"transforms, type, frame and object differ in length: {lengths}"
    if len(set(message.frame)) != len(message.frame):
        return f"names must be unique: {', '.join(message.frame)}"
    return stamp_fault(message.header.stamp.to_sec(), now_s)


def ack_fault(message: StepAck) -> str:
    """An acknowledgement counts only from the node whose name it bears."""
    sender = sender_of(message).rsplit("/", 1)[-1]
    return "" if sender == message.node.rsplit("/", 1)[-1] else f"it speaks for {message.node!r}"


def joints_fault(message: JointState, now_s: float) -> str:
    """Numbers and stamp of joint readings."""
    if len(message.position) != len(message.name):
        return f"{len(message.name)} names but {len(message.position)} positions"
    if not all(math.isfinite(value) for value in message.position):
        bad = [name for name, value in zip(message.name, message.position) if not math.isfinite(value)]
        return f"positions of {', '.join(bad)} are not finite"
    return stamp_fault(message.header.stamp.to_sec(), now_s)


def sander_fault(message: SanderStatus, now_s: float) -> str:
    """State and stamp of a sander's word."""
    if message.state not in tuple(SanderState):
        return f"state {message.state} must be one of {[int(state) for state in SanderState]}"
    return stamp_fault(message.header.stamp.to_sec(), now_s)


def keep_off_fault(message: KeepOff) -> str:
    """Numbers of what a tip is to keep off."""
    if len(message.points) > MOST_PLACES:
        return f"{len(message.points)} points to keep off, at most {MOST_PLACES} are taken"
    values = [value for point in message.points for value in (point.x, point.y)]
    if not all(abs(value) <= FARTHEST_M for value in values) or not 0.0 <= message.distance <= FARTHEST_M:
        return f"points and distance ({message.distance:g} m) must be finite, and within {FARTHEST_M:g} m"
    return ""


def cloud_fault(message: PointCloud2) -> str:
    """Layout of an organised cloud of floats with x, y and z in a row."""
    expected = message.width * message.height * message.point_step
    if len(message.data) != expected or message.point_step % 4:
        return f"{len(message.data)} bytes for {message.width} x {message.height} points of {message.point_step} bytes"
    offsets = {field.name: field.offset for field in message.fields}
    start = offsets.get("x", -1)
    if start < 0 or start % 4 or (offsets.get("y"), offsets.get("z")) != (start + 4, start + 8):
        return f"fields {sorted(offsets)} must hold x, y, z as floats in a row"
    return (
        "" if start + 12 <= message.point_step else f"x, y, z at byte {start} reach beyond {message.point_step} bytes"
    )


__all__: Tuple[str, ...] = (
    "Doorkeeper",
    "ack_fault",
    "cloud_fault",
    "joints_fault",
    "keep_off_fault",
    "map_fault",
    "numbers_fault",
    "plan_fault",
    "pose_fault",
    "present_s",
    "registry_fault",
    "safety_fault",
    "sander_fault",
    "seeds_fault",
    "sender_of",
    "sim_fault",
    "stamp_fault",
    "transform_fault",
)
