"""Every node that listens, made as its program makes it, for tests and benchmarks that send it anything.

``BUILDERS`` has a function a node: it makes the node under ``support.ears`` and gives back what works off what it was
told, where that is another thread's task.
"""

from __future__ import annotations

import threading
import time
from pathlib import Path
from typing import Any, Callable, Mapping, Sequence

import numpy as np
import rospy
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage
from yarm.msg import ObjectRegistry, TransformStampedVector

from support import golden
from support.ears import NOW_S, Ears
from yarm.commander.params import CommanderParams
from yarm.control.mux import MuxParams
from yarm.experiments.run.recorder import Recorder
from yarm.geometry import GridSpec, Pose2
from yarm.navigation.grid_map import GridMap
from yarm.resources import resource
from yarm.ros.calibration.view import CellView, snapshot
from yarm.ros.commander.cli import Session
from yarm.ros.commander.node import CommanderNode
from yarm.ros.common import names
from yarm.ros.console.cell_words import private_areas
from yarm.ros.console.health import HealthWatch
from yarm.ros.console.routes import Feed
from yarm.ros.console.system_book import SystemBook
from yarm.ros.controls.node import ControlsServer
from yarm.ros.controls.params import ControlsServerParams
from yarm.ros.experiment.inputs import ExperimentInputs
from yarm.ros.experiment.lock_step import LockStep
from yarm.ros.exploration.driving import DrivesByMoveBase
from yarm.ros.exploration.experiment import Exploration
from yarm.ros.exploration.experiment_params import ExplorationRunParams
from yarm.ros.exploration.gate import VelocityGate
from yarm.ros.exploration.node import ExplorerNode
from yarm.ros.exploration.params import GateParams, explorer_params
from yarm.ros.inspection.experiment import InspectionRun
from yarm.ros.inspection.experiment_params import InspectionRunParams
from yarm.ros.inspection.node import InspectorNode
from yarm.ros.inspection.params import inspector_params
from yarm.ros.inspection.recogniser_node import TagRecogniserNode
from yarm.ros.inspection.recogniser_params import TagRecogniserParams
from yarm.ros.manipulation.floor import FloorNode
from yarm.ros.manipulation.sweep import CellView as SweptCell
from yarm.ros.mux.node import MuxNode
from yarm.ros.navigation.map_saver import wait_for_map
from yarm.ros.navigation.map_server import MapServer
from yarm.ros.navigation.move_base import MoveBaseNode
from yarm.ros.navigation.params import MapServerParams, MoveBaseNodeParams
from yarm.ros.registry.node import CellRegistry
from yarm.ros.registry.params import CellRegistryParams
from yarm.ros.rooms.node import RoomSimulationNode
from yarm.ros.rooms.params import RoomSimulationParams
from yarm.ros.safety.node import SafetyMonitor
from yarm.ros.sander.node import SanderNode
from yarm.ros.sander.params import SanderNodeParams
from yarm.ros.seeds.node import SeedTfPublisher
from yarm.ros.seeds.params import SeedTfPublisherParams
from yarm.ros.simulation.node import SimulationNode
from yarm.ros.simulation.params import SimulationParams
from yarm.safety.params import SafetyParams

ARM = "hc10_barc"
NAMES = (
    "ankurbot_1",
    "ankurbot_2",
    ARM,
    "debris_1",
    "table",
    "world",
    "map",
    "odom",
    "base_footprint",
    "ankurbot_1_ee_link",
)
"""Names that mean something to one node or another."""
ONCE_S = 5.0
"""Wall time that somebody waits for who wants one message only, s."""
Work = Callable[[], Any]


def primed(ears: Ears, topics: Sequence[str] = (names.OBJECT_REGISTRY, "/tf", "/tf_static")) -> None:
    """Everybody hears who is in a cell and where (the golden recording), so that all robots are listened to."""
    first = golden.load().sets[0]
    for topic, kind, data in (
        (names.OBJECT_REGISTRY, ObjectRegistry, first.registry),
        ("/tf", TFMessage, first.frames),
        ("/tf_static", TFMessage, golden.load().fixed_frames),
    ):
        for ear in ears.by_topic(topic) if topic in topics else []:
            ear.tell(golden.from_bytes(kind, data), _nothing)


def _nothing() -> None:
    """Work of a node whose callbacks do all of it."""


def until_told(ears: Ears, wait: Callable[[], Any]) -> None:
    """Begin to wait for a message, until somebody listens for it."""
    before = len(ears.heard)
    threading.Thread(target=wait, daemon=True).start()
    end_s = time.monotonic() + ONCE_S
    while len(ears.heard) == before:
        if time.monotonic() > end_s:
            raise TimeoutError(f"nobody listened within {ONCE_S:g} s")
        time.sleep(0.001)


def commander(ears: Ears, folder: Path) -> Work:
    """The Commander: its callbacks do all of it."""
    node = CommanderNode(CommanderParams())
    primed(ears)
    return lambda: node


def commander_in_lock_step(ears: Ears, folder: Path) -> Work:
    """The same, which also hears when others are done, and where its robots' frames are."""
    node = CommanderNode(CommanderParams(sync=True))
    primed(ears, (names.OBJECT_REGISTRY,))
    return lambda: node


def controls(ears: Ears, folder: Path) -> Work:
    """The controls server with the cell's robots, and its pass."""
    node = ControlsServer(ControlsServerParams(sync=True, guarded=False))
    primed(ears)
    kinds = {"Mobile": ("ankurbot_1", "ankurbot_2"), "Manipulator": (ARM,)}
    told = TransformStampedVector()
    for kind, names_of in kinds.items():
        for name in names_of:
            told.frame.append(name)
            told.object.append(kind)
            told.type.append("dynamic")
            told.transforms.append(TransformStamped())
            told.transforms[-1].transform.rotation.w = 1.0
    node._tick(told)
    for robot in kinds["Mobile"]:
        node._robots[robot].unit._note_hand(0.0, 0.0)

    def work() -> None:
        while node._seeds and node._ready(node._seeds[0]):
            node._tick(node._seeds.popleft())
        node._watch()

    return work


def sander(ears: Ears, folder: Path) -> Work:
    """The sander, its scanner listened to, and its pass."""
    node = SanderNode(SanderNodeParams())
    node._scan.listen(True)

    def work() -> None:
        while node._joints:
            node._tick(node._joints.popleft())

    return work


def sander_in_lock_step(ears: Ears, folder: Path) -> Work:
    """The same, which also hears when its arm has its commands."""
    node = SanderNode(SanderNodeParams(sync=True))
    return lambda: node


def safety(ears: Ears, folder: Path) -> Work:
    """The safety monitor with the cell's robots."""
    node = SafetyMonitor(SafetyParams())
    primed(ears)
    return lambda: node


def seeds(ears: Ears, folder: Path) -> Work:
    """The seed publisher."""
    node = SeedTfPublisher(SeedTfPublisherParams())
    primed(ears)
    return lambda: node


def registry(ears: Ears, folder: Path) -> Work:
    """The registry of a real cell."""
    node = CellRegistry(CellRegistryParams(cell=str(resource("scenes", "cell", "1m1ma.yaml"))))
    primed(ears)
    return lambda: node


def simulation(ears: Ears, folder: Path) -> Work:
    """The cell's simulation in lock-step, and its ticks."""
    scene = str(resource("scenes", "cell", "1m1ma_bin.yaml"))
    node = SimulationNode(SimulationParams(scene=scene, sync=True, hands=True), threading.Event())

    def work() -> None:
        node._inbox.work_until(0.0)
        node._world.tick()

    return work


def explorer(ears: Ears, folder: Path) -> Work:
    """The explorer, which drives by itself and by move_base, and its pass."""
    params, make = explorer_params({"map_path": str(folder / "map")}, "explorer")
    node = ExplorerNode(params, make, threading.Event())
    relay = DrivesByMoveBase(params.map_frame)
    return lambda: (node._pass(NOW_S), relay)


def run_exploration(ears: Ears, folder: Path) -> Work:
    """Who follows an exploration."""
    params, _ = explorer_params({}, "explorer")
    node = Exploration(ExplorationRunParams(), params)
    return lambda: node


def gate(ears: Ears, folder: Path) -> Work:
    """The velocity gate of a room."""
    node = VelocityGate(GateParams())
    return lambda: node


def inspector(ears: Ears, folder: Path) -> Work:
    """The inspector, and its pass."""
    given = inspector_params(
        {"result": str(folder / "result.txt")}, resource("scenes", "inspection", "practice_boxes.yaml"), "i"
    )
    node = InspectorNode(given, threading.Event())
    return lambda: node._pass(NOW_S)


def run_inspection(ears: Ears, folder: Path) -> Work:
    """Who follows an inspection."""
    given = inspector_params(
        {"result": str(folder / "result.txt")}, resource("scenes", "inspection", "practice_boxes.yaml"), "i"
    )
    node = InspectionRun(InspectionRunParams(), given)
    return lambda: node


def recogniser(ears: Ears, folder: Path) -> Work:
    """The tag recogniser."""
    node = TagRecogniserNode(TagRecogniserParams(), {})
    return lambda: node


def room(ears: Ears, folder: Path) -> Work:
    """A room's simulation in lock-step, and its ticks."""
    node = RoomSimulationNode(RoomSimulationParams(sync=True), threading.Event())

    def work() -> None:
        node._inbox.work_until(0.0)
        node._world.tick()

    return work


def move_base(ears: Ears, folder: Path) -> Work:
    """The node that drives over a known map, with its depth camera, and its pass."""
    node = MoveBaseNode(MoveBaseNodeParams(low_obstacles=True), threading.Event())
    return lambda: node._pass(rospy.Time.from_sec(NOW_S))


def move_base_in_lock_step(ears: Ears, folder: Path) -> Work:
    """The same, which also hears when others are done."""
    node = MoveBaseNode(MoveBaseNodeParams(sync=True), threading.Event())
    return lambda: node


def map_files(ears: Ears, folder: Path) -> Work:
    """What offers a map file, and what saves a map."""
    node = MapServer(GridMap(np.zeros((4, 5), np.int8), 0.05, Pose2(0.0, 0.0)), MapServerParams())
    until_told(ears, lambda: wait_for_map(ONCE_S))
    return lambda: node


def mux(ears: Ears, folder: Path) -> Work:
    """The choice among velocities."""
    node = MuxNode(MuxParams())
    return lambda: node


def console(ears: Ears, folder: Path) -> Work:
    """The operator's page: every topic it shows, and what it makes of them."""
    book = SystemBook(private_areas, lambda _: None)
    node = Feed(book), HealthWatch(1e9, dict)
    primed(ears)
    return lambda: node


def experiment(ears: Ears, folder: Path) -> Work:
    """Who follows a mission."""
    node = ExperimentInputs(Recorder(GridSpec(), [], 0.0, 0.1)), LockStep()
    primed(ears)
    return lambda: node


def camera_watch(ears: Ears, folder: Path) -> Work:
    """Who looks at one cloud of a camera."""
    until_told(ears, lambda: snapshot(names.camera_points(1), ONCE_S))
    return lambda: None


def commands(ears: Ears, folder: Path) -> Work:
    """What the commands hear that ask and watch for a person."""
    session = Session(10.0)
    session.follow_every_raster()
    session.follow_raster(ARM)
    node = session, CellView(), SweptCell("ankurbot_1")
    return lambda: node


def floor(ears: Ears, folder: Path) -> Work:
    """The youBot's simulation, and its ticks."""
    node = FloorNode(resource("scenes", "manipulation", "youbot_floor.yaml"), 0, 0.0)
    return node.tick


BUILDERS: Mapping[str, Callable[[Ears, Path], Work]] = {
    made.__name__: made
    for made in (
        commander,
        commander_in_lock_step,
        controls,
        sander,
        sander_in_lock_step,
        safety,
        seeds,
        registry,
        simulation,
        explorer,
        run_exploration,
        gate,
        inspector,
        run_inspection,
        recogniser,
        room,
        move_base,
        move_base_in_lock_step,
        map_files,
        mux,
        console,
        experiment,
        camera_watch,
        commands,
        floor,
    )
}
