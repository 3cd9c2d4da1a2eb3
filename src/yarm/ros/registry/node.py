"""Node ``cell_registry``: tells who is in a cell, from a scene file and tf, with or without a simulation.

In a real cell nobody knows everything: drivers tell the frames of cameras, robots and arms, the scene file says what
they are and what else stands there, and a person says what lies there (``spawn_obstacles``) and what does not any more
(``delete_obstacles``, which the Commander calls for debris that was reached).
"""

from __future__ import annotations

import math
import threading
import time
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Callable, List, Optional, Set, Tuple

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from tf2_msgs.msg import TFMessage

from yarm.calibration.poses_file import read_poses
from yarm.geometry import STRAY, CellMap
from yarm.geometry.kinds import ObjectKind
from yarm.msg import ObjectRegistry
from yarm.ros.common import names
from yarm.ros.common.bodies import registry_message, transform_message
from yarm.ros.common.checks import Doorkeeper, sender_of, transform_fault
from yarm.ros.common.clock import ClockWatch
from yarm.ros.common.conversions import MapSubscriber, matrix_of_transform
from yarm.ros.common.params import load_params
from yarm.ros.common.requests import UNREGISTERED, UNREGISTERED_DEBRIS, spawn_spec
from yarm.ros.common.start import init_node
from yarm.ros.registry.params import CellRegistryParams
from yarm.ros.registry.pieces import NamedPieces, named_piece
from yarm.ros.registry.roster import HeardFrame, Roster
from yarm.safety.pulse import beat_in_background
from yarm.sim.scenes.bodies import Body, SpawnError, scene_bodies, thing_body
from yarm.sim.scenes.scene import Scene, load_scene, scene_path, without_shapes
from yarm.sim.scenes.specs import NOT_DRAWN, ThingSpec
from yarm.srv import SpawnObstacles, SpawnObstaclesResponse
from yarm.yaml_fields import SceneError

LOOK_PERIOD_S = 0.1
"""Wall time between two looks at who is there, s."""


class CellRegistry:
    """Publishes ``object_registry`` and the frames that nobody else tells."""

    def __init__(self, params: CellRegistryParams) -> None:
        """Read the scene and listen.

        Raises:
            SceneError: the scene file, or that of the cameras' poses, is faulty.
            SpawnError: the description of one of its things is.
        """
        self._params = params
        self._folder = scene_path(params.cell).resolve().parent
        scene = load_scene(params.cell)
        cameras = read_poses(Path(params.extrinsics)) if params.extrinsics else {}
        self._roster = Roster(names.WORLD_FRAME, cell_bodies(scene, params), params.silent_after, cameras)
        self._pieces = NamedPieces()
        self._maps: Optional[MapSubscriber] = None
        self._lock = threading.Lock()
        self._told: Optional[Tuple[Body, ...]] = None
        self._told_frames: Set[str] = set()
        self._warned: Set[str] = set()
        self._wait_until = time.monotonic() + params.frame_wait
        self._door = Doorkeeper("/tf")
        self._registry = rospy.Publisher(names.OBJECT_REGISTRY, ObjectRegistry, queue_size=10, latch=True)
        self._frames = rospy.Publisher("/tf_static", TFMessage, queue_size=10, latch=True)
        self._diagnostics = rospy.Publisher(names.DIAGNOSTICS, DiagnosticArray, queue_size=10)
        self._clock = ClockWatch()
        self._clock.on_reset(self._on_clock_reset)
        self._subscribers = [
            rospy.Subscriber("/tf_static", TFMessage, partial(self._on_tf, True), queue_size=100, tcp_nodelay=True),
            rospy.Subscriber("/tf", TFMessage, partial(self._on_tf, False), queue_size=100, tcp_nodelay=True),
        ]
        self._services = [
            rospy.Service(names.SPAWN_OBSTACLES, SpawnObstacles, partial(self._serve, self._put_in)),
            rospy.Service(names.DELETE_OBSTACLES, SpawnObstacles, partial(self._serve, self._take_out)),
        ]
        if scene.events:
            rospy.loginfo("the %d events of %s are the simulation's: nothing here makes them happen", *_events(scene))

    def spin(self) -> None:
        """Look who is there, and report, on wall time until the node is shut down."""
        beat_in_background(self._lock)
        report_s = time.monotonic()
        while not rospy.is_shutdown():
            self._look()
            if time.monotonic() >= report_s and not rospy.is_shutdown():
                self._report()
                report_s = time.monotonic() + self._params.diagnostics_period
            time.sleep(LOOK_PERIOD_S)

    def _on_tf(self, fixed: bool, message: TFMessage) -> None:
        if sender_of(message) == rospy.get_name().strip("/"):
            return
        limit_s = math.inf if fixed else rospy.get_time()
        for transform in message.transforms:
            if self._door.refuses(message, transform_fault(transform, limit_s)):
                continue
            stamp_s = math.inf if fixed else transform.header.stamp.to_sec()
            parent = transform.header.frame_id.lstrip("/")
            heard = HeardFrame(parent, stamp_s, matrix_of_transform(transform.transform))
            with self._lock:
                self._roster.hear(transform.child_frame_id.lstrip("/"), heard)

    def _on_clock_reset(self) -> None:
        with self._lock:
            self._roster.forget()

    def _on_map(self, cell_map: CellMap) -> None:
        with self._lock:
            for name, place in self._pieces.see(cell_map):
                self._roster.follow(name, place)

    def _look(self) -> None:
        """Tell of what has changed."""
        if time.monotonic() < self._wait_until:
            return
        now = rospy.Time.now()
        with self._lock:
            present = self._roster.present(now.to_sec())
            if self._told is not None and _same(present, self._told):
                return
            self._frames.publish(transform_message(now, self._roster.own_frames()))
            if self._told is None or _entries(present) != _entries(self._told):
                self._registry.publish(registry_message(now, present))
            self._told = present
            self._pieces.keep(self._roster.named, now.to_sec())
        if self._roster.named and self._maps is None:
            self._maps = MapSubscriber(self._on_map)

    def _put_in(self, request: Any) -> str:
        if request.type in (UNREGISTERED, UNREGISTERED_DEBRIS):
            raise SpawnError(
                f"type {request.type!r}: this is the registry; only a simulation makes what nobody tells of"
            )
        spec = spawn_spec(request, self._folder)
        self._roster.add(_body_of(spec))
        return f"{spec.kind} {spec.name} is told to be at ({spec.x:.3f}, {spec.y:.3f}, {spec.z:.3f})"

    def _take_out(self, request: Any) -> str:
        if request.name.startswith(STRAY):
            return f"{request.name} was never told of here: it is gone once its place is seen empty"
        self._roster.remove(request.name)
        return f"{request.name} is no longer told of"

    def _serve(self, work: Callable[[Any], str], request: Any) -> SpawnObstaclesResponse:
        try:
            with self._lock:
                done = work(request)
        except SpawnError as error:
            return SpawnObstaclesResponse(False, str(error))
        self._look()
        return SpawnObstaclesResponse(True, done)

    def _report(self) -> None:
        now_s = rospy.get_time()
        with self._lock:
            faults = [f"{absence.name} is not there: {absence.reason}" for absence in self._roster.absent(now_s)]
            faults += self._roster.told_elsewhere()
            unseen = self._pieces.unseen(now_s, self._params.unseen_after)
            count = len(self._told or ())
        faults += [f"{name} was named, but nothing is seen of it for {s:.1f} s: is it there?" for name, s in unseen]
        for fault in faults:
            subject = fault.split(" ", 1)[0]
            if subject not in self._warned:
                rospy.logwarn(fault)
        self._warned = {fault.split(" ", 1)[0] for fault in faults}
        status = DiagnosticStatus(
            level=DiagnosticStatus.WARN if faults else DiagnosticStatus.OK,
            name="cell_registry: the cell",
            message="; ".join(faults) or f"{count} objects",
            hardware_id="cell",
            values=[KeyValue("objects", str(count)), KeyValue("scene", self._params.cell)],
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = rospy.Time.now()
        self._diagnostics.publish(array)


def cell_bodies(scene: Scene, params: CellRegistryParams) -> List[Body]:
    """The bodies of a scene as a real cell's registry has them: debris is where a person says it lies.

    Raises:
        SpawnError: the description of one of its things is faulty.
    """
    drawn = without_shapes(scene) if params.shapes == NOT_DRAWN else scene
    loose = drawn.things_of(ObjectKind.DEBRIS)
    rest = tuple(thing for thing in drawn.things if thing not in loose)
    return [*scene_bodies(replace(drawn, things=rest), params.hands), *(named_piece(spec) for spec in loose)]


def _body_of(spec: ThingSpec) -> Body:
    return named_piece(spec) if spec.kind == ObjectKind.DEBRIS else thing_body(spec)


def _same(one: Tuple[Body, ...], other: Tuple[Body, ...]) -> bool:
    """Whether these are the same bodies in the same places: a piece that was followed is another Body."""
    return len(one) == len(other) and all(a is b for a, b in zip(one, other))


def _entries(bodies: Tuple[Body, ...]) -> Tuple[str, ...]:
    return tuple(body.name for body in bodies)


def _events(scene: Scene) -> Tuple[int, str]:
    return len(scene.events), scene.name


def main() -> None:
    """Run the node until it is shut down; a faulty scene ends it with its faults and exit code 1."""
    init_node("cell_registry")
    try:
        registry = CellRegistry(load_params(CellRegistryParams))
    except (SceneError, SpawnError) as error:
        rospy.logfatal("%s", error)
        raise SystemExit(1) from error
    registry.spin()
