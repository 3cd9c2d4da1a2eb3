"""Parameters of the node ``explorer``: the controllers' own, and what only the node needs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Callable, List, Mapping, Tuple

from yarm.exploration.model import Controller
from yarm.exploration.params import ExploreParams
from yarm.exploration.registry import CONTROLLERS, make_controller
from yarm.exploration.report.controller import ReportController
from yarm.exploration.report.params import ReportParams
from yarm.navigation.map_file import writing_fault
from yarm.params import ParamError, build_noting, param

REPORT = "report"
"""Namespace of the numbers of the report's method, and the controller that takes them."""
MUX, MOVE_BASE = "mux", "move_base"
"""Who drives the base: the explorer itself through the multiplexer, or the navigation by its goals."""
WITHOUT_GOALS = ("report", "report_printed")
"""Controllers that drive by what the scan shows, to no place."""


@dataclass(frozen=True)
class ExplorerParams(ExploreParams):
    """The explorer: the run, its limits, where the map goes."""

    seed: int = param(3, "", "seed of the controller's draws", 0, 2**31 - 1)
    drive: str = param(MUX, "", "out through the multiplexer, or by goals for move_base", choices=(MUX, MOVE_BASE))
    autostart: bool = param(True, "", "begin as soon as every sensor is there; false: wait for ~start")
    map_path: str = param("map", "", "the map is saved as this with .pgm and .yaml; its folder is made when missing")
    transform_tolerance: float = param(0.3, "s", "an older transform map -> odom counts as missing", 0.05, 10.0)
    visualize: bool = param(False, "", "publish frontiers, view and path for RViz")
    progress: bool = param(True, "", "tell once a simulated second how the run goes")
    low_obstacles: bool = param(True, "", "look for low obstacles in the depth images")
    base_frame: str = param("base_footprint", "", "the robot's frame")
    odom_frame: str = param("odom", "", "odometry's frame")
    map_frame: str = param("map", "", "the map's frame")
    sync: bool = param(False, "", "lock-step: take in all of a pass before it is decided, and acknowledge it")
    sync_wait: float = param(5.0, "s", "lock-step: wall time a pass waits for what was measured at it", 0.01, 60.0)
    waits_for: Tuple[str, ...] = param((), "", "lock-step: nodes that must have answered before the first pass")
    wait_for_map: bool = param(False, "", "lock-step: a pass waits for slam_gmapping's word on its scan, and its map")

    @property
    def saves_as(self) -> Path:
        """The map's files, absolute, without suffix."""
        return Path(self.map_path).expanduser().absolute()


@dataclass(frozen=True)
class GateParams:
    """The velocity gate; how it brakes is in ``yarm.exploration.deadline``."""

    lease: str = param("explorer", "", "node without whose word nobody drives", choices=("explorer", "inspector"))
    sync: bool = param(False, "", "lock-step: acknowledge every tick")


def explorer_params(values: Mapping[str, Any], where: str) -> Tuple[ExplorerParams, Callable[[], Controller]]:
    """The node's parameters, and what makes the controller they name.

    Args:
        values: as the parameter server has them; those of the report's method are under ``report``.
        where: name of the node, for messages.

    Raises:
        ParamError: everything that is wrong, at once: unknown names, values out of range, an unknown controller,
            near_speed above max_speed, a map that could not be written.
    """
    faults: List[str] = []
    plain = {name: value for name, value in values.items() if name != REPORT}
    params = build_noting(ExplorerParams, plain, "", faults)
    numbers = build_noting(ReportParams, values.get(REPORT, {}), f"{REPORT}.", faults)
    if params is not None:
        faults += _faults_between(params)
    if faults or params is None or numbers is None:
        raise ParamError(f"{where}: " + "; ".join(faults))
    if params.controller == REPORT:
        return params, partial(ReportController, params, params.seed, numbers)
    return params, partial(make_controller, params, params.seed)


def _faults_between(params: ExplorerParams) -> List[str]:
    found = [params.faults] if params.faults else []
    if params.controller not in CONTROLLERS:
        found.append(f"controller = {params.controller!r}: must be one of {', '.join(sorted(CONTROLLERS))}")
    if params.drive == MOVE_BASE and params.controller in WITHOUT_GOALS:
        found.append(f"drive = {params.drive!r}: controller {params.controller!r} has no goals that it could send")
    try:
        params.saves_as.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        return [*found, f"map_path = {params.map_path!r}: {params.saves_as.parent} cannot be made: {error.strerror}"]
    fault = writing_fault(params.saves_as)
    return [*found, f"map_path = {params.map_path!r}: {fault}"] if fault else found
