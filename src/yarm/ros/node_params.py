"""Parameter class of each Python node, by the node's name: for docs/parameters.md and the comparison with config/."""

from __future__ import annotations

from typing import Any, Dict, Type

from yarm.commander.params import CommanderParams
from yarm.commander.safety_params import SafetyParams
from yarm.ros.controls_server_params import ControlsServerParams
from yarm.ros.experiment_params import ExperimentParams
from yarm.ros.sander_params import SanderNodeParams
from yarm.ros.seed_tf_publisher_params import SeedTfPublisherParams
from yarm.ros.simulation_params import SimulationParams

NODE_PARAMS: Dict[str, Type[Any]] = {
    "commander": CommanderParams,
    "hc10_state_machine": SanderNodeParams,
    "multi_robot_controls_server": ControlsServerParams,
    "run_experiment": ExperimentParams,
    "safety_monitor": SafetyParams,
    "seed_tf_publisher": SeedTfPublisherParams,
    "simulation": SimulationParams,
}
