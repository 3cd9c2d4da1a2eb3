"""Planners by name, all behind ``FleetPlanner``.

A name with a colon is somebody's own planner: "module:Class", found like any import; see docs/extending.md.
"""

from __future__ import annotations

import importlib
from functools import partial
from typing import Callable, Dict, Optional, Tuple, cast

from yarm.planning.baselines.lacam import LacamPlanner
from yarm.planning.baselines.ma_astar import MultiAgentAStar
from yarm.planning.baselines.original_planner import OriginalPlanner
from yarm.planning.fleet.yarm_planner import YarmPlanner
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import FleetPlanner


def _ompl(planner: str, params: PlannerParams) -> FleetPlanner:
    from yarm.planning.baselines import ompl_joint, ompl_planners  # noqa: PLC0415 (only whoever asks needs the wheel)

    module = ompl_joint if planner == "JointRRTConnectPlanner" else ompl_planners
    return cast(FleetPlanner, getattr(module, planner)(params))


_PLANNERS: Dict[str, Callable[[PlannerParams], FleetPlanner]] = {
    "yarm": YarmPlanner,
    "original": OriginalPlanner,
    "ma_astar": MultiAgentAStar,
    "lacam": LacamPlanner,
    "ompl_rrtconnect": partial(_ompl, "RRTConnectPlanner"),
    "ompl_prmstar": partial(_ompl, "PRMStarPlanner"),
    "ompl_bitstar": partial(_ompl, "BITStarPlanner"),
    "ompl_joint_rrtconnect": partial(_ompl, "JointRRTConnectPlanner"),
}
PLANNER_NAMES: Tuple[str, ...] = tuple(_PLANNERS)
"""Every planner there is; those named ``ompl_*`` need the OMPL wheel."""


class PlannerUnavailableError(RuntimeError):
    """A planner cannot be made here; the message says what is missing."""


def make_planner(name: str, params: Optional[PlannerParams] = None) -> FleetPlanner:
    """The planner of that name.

    Args:
        name: one of ``PLANNER_NAMES``, or "module:Class" of a class that is made with the parameters alone.
        params: what can be chosen, its defaults unless given; planners ignore what does not apply to them.

    Raises:
        KeyError: no such planner.
        PlannerUnavailableError: a package that it needs is not installed, or its module cannot be imported.
    """
    if name not in _PLANNERS and ":" not in name:
        raise KeyError(f"planner {name!r} is none of {', '.join(PLANNER_NAMES)}, nor module:Class")
    try:
        factory = _PLANNERS[name] if name in _PLANNERS else _imported(name)
        return factory(params or PlannerParams())
    except ImportError as error:
        raise PlannerUnavailableError(f"planner {name} cannot be made: {error}") from error


def _imported(name: str) -> Callable[[PlannerParams], FleetPlanner]:
    """The class behind "module:Class"; an ImportError when it is not there or is no planner."""
    module, _, attribute = name.partition(":")
    found = getattr(importlib.import_module(module), attribute, None) if module else None
    lacking = [method for method in ("plan", "reset") if not callable(getattr(found, method, None))]
    if lacking or not callable(found):
        raise ImportError(f"{module!r} has no class {attribute!r} with the methods plan and reset")
    return cast(Callable[[PlannerParams], FleetPlanner], found)


def available_planners() -> Tuple[str, ...]:
    """Names of the planners that can be made here."""
    names = []
    for name in PLANNER_NAMES:
        try:
            make_planner(name)
        except PlannerUnavailableError:
            continue
        names.append(name)
    return tuple(names)
