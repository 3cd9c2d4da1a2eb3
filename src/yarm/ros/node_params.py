"""Parameter class of each Python node, by the node's name: for docs/parameters.md and the comparison with config/."""

from __future__ import annotations

from typing import Any, Dict, Type

from yarm.commander.params import CommanderParams
from yarm.console.params import ConsoleParams
from yarm.control.mux import MuxParams
from yarm.exploration.report.params import ReportParams
from yarm.ros.calibration.params import CameraWatchParams
from yarm.ros.controls.params import ControlsServerParams
from yarm.ros.experiment.params import ExperimentParams, KeeperParams
from yarm.ros.exploration.experiment_params import ExplorationRunParams
from yarm.ros.exploration.params import ExplorerParams, GateParams
from yarm.ros.inspection.experiment_params import InspectionRunParams
from yarm.ros.inspection.params import InspectorParams, InspectorReportParams
from yarm.ros.inspection.recogniser_params import TagRecogniserParams
from yarm.ros.navigation.params import MapServerParams, MoveBaseNodeParams
from yarm.ros.registry.params import CellRegistryParams
from yarm.ros.rooms.params import RoomSimulationParams
from yarm.ros.sander.params import SanderNodeParams
from yarm.ros.seeds.params import SeedTfPublisherParams
from yarm.ros.simulation.params import SimulationParams
from yarm.safety.params import SafetyParams

NODE_PARAMS: Dict[str, Type[Any]] = {
    "camera_watch": CameraWatchParams,
    "cell_registry": CellRegistryParams,
    "cmd_vel_mux": MuxParams,
    "commander": CommanderParams,
    "console": ConsoleParams,
    "mission_keeper": KeeperParams,
    "explorer": ExplorerParams,
    "explorer_report": ReportParams,
    "hc10_state_machine": SanderNodeParams,
    "inspector": InspectorParams,
    "inspector_report": InspectorReportParams,
    "map_server": MapServerParams,
    "move_base": MoveBaseNodeParams,
    "multi_robot_controls_server": ControlsServerParams,
    "room_simulation": RoomSimulationParams,
    "run_experiment": ExperimentParams,
    "run_exploration": ExplorationRunParams,
    "run_inspection": InspectionRunParams,
    "safety_monitor": SafetyParams,
    "seed_tf_publisher": SeedTfPublisherParams,
    "simulation": SimulationParams,
    "tag_recogniser": TagRecogniserParams,
    "velocity_gate": GateParams,
}
