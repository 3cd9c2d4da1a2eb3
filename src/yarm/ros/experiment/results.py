"""What is written of a mission in a running system: tables, proof sheet, pictures, and what all of it ran on."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, Mapping, Optional

import numpy as np
import rosgraph
import rospy

from yarm.experiments.run.plots import plot_run
from yarm.experiments.run.proof import write_proof
from yarm.experiments.run.record import RunRecord
from yarm.experiments.run.versions import package_versions
from yarm.experiments.run.writers import write_run
from yarm.geometry import BoolArray, CellMap, GridSpec
from yarm.geometry.kinds import ObjectKind
from yarm.ros.common import names
from yarm.ros.common.conversions import parse_map_metadata

MAP_LIMIT_S = 20.0


def write_results(record: RunRecord, folder: Path, plots: bool) -> None:
    """Write a mission's results into a folder, drawn over what never moves on the live map.

    Args:
        record: of the mission.
        folder: made when missing.
        plots: draw the pictures, too.
    """
    write_run(record, folder)
    cell_map = newest_map()
    spec = cell_map.spec if cell_map is not None else GridSpec()
    obstacles = None if cell_map is None else static_columns(cell_map)
    write_proof(record, folder / "proof.html", spec, obstacles)
    if plots:
        plot_run(record, folder, spec, obstacles)


def newest_map() -> Optional[CellMap]:
    """The live grid, or None when none comes in time."""
    try:
        message = rospy.wait_for_message(names.PLANNING_METADATA, rospy.AnyMsg, timeout=MAP_LIMIT_S)
        return parse_map_metadata(message._buff)
    except (rospy.ROSException, ValueError):
        return None


def static_columns(cell_map: CellMap) -> BoolArray:
    """Columns (gx, gy) that something of kind Obstacle stands in."""
    columns = np.zeros(cell_map.spec.shape[:2], dtype=bool)
    for thing in cell_map.objects.values():
        if thing.kind == ObjectKind.OBSTACLE:
            columns[thing.cells[:, 0], thing.cells[:, 1]] = True
    return columns


def versions() -> Dict[str, str]:
    """Versions of what the experiment ran on."""
    return {**package_versions(), "ros": str(rospy.get_param("/rosdistro", "")).strip()}


def parameters() -> Mapping[str, Any]:
    """Parameters of every node, without robot descriptions and what ROS keeps for itself."""
    # Not by rospy: once it has logged something its cache takes the one parameter of its logger for the whole tree.
    tree = rosgraph.Master(rospy.get_name()).getParam("/")
    return {
        name: values
        for name, values in sorted(tree.items())
        if isinstance(values, dict) and name not in ("roslaunch", "run_id")
    }
