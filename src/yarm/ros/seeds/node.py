"""Node ``seed_tf_publisher``: for each tick of ``/tf``, where the seed of every registered object is.

Event-driven: a message of ``/tf`` whose newest stamp is new gives one message of ``seed_transforms``, so the seeds
come as often as the simulator or the robots' drivers report poses (60 Hz), each with its own true stamp. A fixed seed
carries the stamp of the tick.
"""

from __future__ import annotations

import math
import threading
import time
from typing import Dict, List, Set, Tuple

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

from yarm.msg import ObjectRegistry, TransformStampedVector
from yarm.ros.common import names
from yarm.ros.common.checks import Doorkeeper, registry_fault, transform_fault
from yarm.ros.common.clock import JUMP_BACK_S, ClockWatch
from yarm.ros.common.params import load_params
from yarm.ros.common.start import init_node
from yarm.ros.seeds.params import SeedTfPublisherParams
from yarm.ros.seeds.tracker import STATIC_STAMP, Link, RegisteredSeed, Seed, SeedTracker
from yarm.safety.pulse import beat_in_background

JUMP_BACK_NS = int(JUMP_BACK_S * 1e9)
CLOCK_LAG_S = 5.0
"""In lock-step ``/clock`` may come so much later than what it times, s; this node does not know whether it is in it."""


class SeedTfPublisher:
    """Subscribes to ``object_registry``, ``/tf`` and ``/tf_static``; publishes ``seed_transforms``."""

    def __init__(self, params: SeedTfPublisherParams) -> None:
        """Start at once; callbacks come on rospy's threads."""
        self._params = params
        self._lock = threading.Lock()
        self._tracker = SeedTracker(names.WORLD_FRAME)
        self._heard: Dict[str, float] = {}
        self._started = time.monotonic()
        self._tf_door, self._registry_door = Doorkeeper("/tf"), Doorkeeper(names.OBJECT_REGISTRY)
        self._missing: List[RegisteredSeed] = []
        self._warned: Set[str] = set()
        self._publisher = rospy.Publisher(names.SEED_TRANSFORMS, TransformStampedVector, queue_size=10)
        self._diagnostics = rospy.Publisher(names.DIAGNOSTICS, DiagnosticArray, queue_size=10)
        self._clock = ClockWatch()
        self._clock.on_reset(self._on_clock_reset)
        self._subscribers = [
            rospy.Subscriber(names.OBJECT_REGISTRY, ObjectRegistry, self._on_registry, queue_size=10),
            rospy.Subscriber("/tf_static", TFMessage, self._on_tf_static, queue_size=100, tcp_nodelay=True),
            rospy.Subscriber("/tf", TFMessage, self._on_tf, queue_size=100, tcp_nodelay=True),
        ]

    def spin(self) -> None:
        """Report health on wall time until the node is shut down."""
        beat_in_background(self._lock)
        while not rospy.is_shutdown():
            time.sleep(self._params.diagnostics_period_s)
            if not rospy.is_shutdown():
                self._report()

    def _on_registry(self, message: ObjectRegistry) -> None:
        if self._registry_door.refuses(message, registry_fault(message)):
            return
        registered = [RegisteredSeed(e.name, e.object, e.type, e.seed_frame) for e in message.entries]
        with self._lock:
            self._heard[names.OBJECT_REGISTRY] = time.monotonic()
            self._tracker.set_registry(registered)

    def _on_tf_static(self, message: TFMessage) -> None:
        with self._lock:
            for transform in message.transforms:
                if self._tf_door.refuses(message, transform_fault(transform, math.inf)):
                    continue
                child, link = _link(transform)
                self._tracker.add_fixed(child, Link(link.parent, link.translation, link.rotation, STATIC_STAMP))

    def _on_tf(self, message: TFMessage) -> None:
        now_s, door = rospy.get_time(), self._tf_door
        now_s += CLOCK_LAG_S if now_s > 0.0 else 0.0
        good = [t for t in message.transforms if not door.refuses(message, transform_fault(t, now_s))]
        links = [_link(transform) for transform in good]
        if not links:
            return
        with self._lock:
            self._heard["/tf"] = time.monotonic()
            newest = max(link.stamp_ns for _, link in links)
            if self._tracker.went_back(newest, JUMP_BACK_NS):
                self._tracker.forget_after(newest)
            tick = self._tracker.add_moving(links)
            if tick is None:
                return
            seeds, self._missing = self._tracker.seeds()
            self._publisher.publish(seed_message(seeds, tick))

    def _on_clock_reset(self) -> None:
        now_ns = rospy.Time.now().to_nsec()
        with self._lock:
            self._tracker.forget_after(now_ns)

    def _report(self) -> None:
        now = time.monotonic()
        with self._lock:
            silent = {
                name: now - self._heard.get(name, self._started)
                for name in ("/tf", names.OBJECT_REGISTRY)
                if name == "/tf" or name not in self._heard
            }
            missing = [f"{seed.name} ({seed.seed_frame})" for seed in self._missing]
            count = len(self._tracker.registered)
        faults = {name: f"nothing on {name}" for name, s in silent.items() if s > self._params.warn_after_s}
        faults.update({name: f"no transform for {name}" for name in missing})
        for name in set(faults) - self._warned:
            rospy.logwarn(faults[name])
        self._warned = set(faults)
        status = DiagnosticStatus(
            level=DiagnosticStatus.WARN if faults else DiagnosticStatus.OK,
            name="seed_tf_publisher: inputs",
            message="; ".join(faults.values()) if faults else f"{count} objects",
            hardware_id="perception",
            values=[KeyValue(f"{n} silent for, s", f"{s:.1f}") for n, s in silent.items()],
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = rospy.Time.now()
        self._diagnostics.publish(array)


def seed_message(seeds: List[Seed], tick_ns: int) -> TransformStampedVector:
    """The message for one tick; stamp: the tick's, ns."""
    message = TransformStampedVector()
    message.header.stamp = _time(tick_ns)
    message.header.frame_id = names.WORLD_FRAME
    for seed in seeds:
        stamped = TransformStamped()
        stamped.header.stamp = message.header.stamp if seed.stamp_ns == STATIC_STAMP else _time(seed.stamp_ns)
        stamped.header.frame_id = names.WORLD_FRAME
        stamped.child_frame_id = seed.registered.seed_frame
        t, q = stamped.transform.translation, stamped.transform.rotation
        t.x, t.y, t.z = seed.translation
        q.x, q.y, q.z, q.w = seed.rotation
        message.transforms.append(stamped)
        message.type.append(seed.registered.label)
        message.frame.append(seed.registered.name)
        message.object.append(seed.registered.kind)
    return message


def _time(stamp_ns: int) -> rospy.Time:
    return rospy.Time(stamp_ns // 1_000_000_000, stamp_ns % 1_000_000_000)


def _link(transform: TransformStamped) -> Tuple[str, Link]:
    t, q = transform.transform.translation, transform.transform.rotation
    parent = transform.header.frame_id.lstrip("/")
    link = Link(parent, (t.x, t.y, t.z), (q.x, q.y, q.z, q.w), transform.header.stamp.to_nsec())
    return transform.child_frame_id.lstrip("/"), link


def main() -> None:
    """Run the node until it is shut down."""
    init_node("seed_tf_publisher")
    SeedTfPublisher(load_params(SeedTfPublisherParams)).spin()
