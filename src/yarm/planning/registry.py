"""Planners by name, all behind ``FleetPlanner``."""

from __future__ import annotations

import importlib
from typing import Dict, Optional, Tuple, cast

from yarm.planning.params import PlannerParams
from yarm.planning.types import FleetPlanner

_PLANNERS: Dict[str, Tuple[str, str]] = {
    "yarm": ("yarm.planning.yarm_planner", "YarmPlanner"),
    "original": ("yarm.planning.original_planner", "OriginalPlanner"),
    "ma_astar": ("yarm.planning.ma_astar", "MultiAgentAStar"),
    "ompl_rrtconnect": ("yarm.planning.ompl_planners", "RRTConnectPlanner"),
    "ompl_prmstar": ("yarm.planning.ompl_planners", "PRMStarPlanner"),
    "ompl_bitstar": ("yarm.planning.ompl_planners", "BITStarPlanner"),
}
PLANNER_NAMES: Tuple[str, ...] = tuple(_PLANNERS)
"""Every planner there is; those named ``ompl_*`` need the OMPL wheel."""


class PlannerUnavailableError(RuntimeError):
    """A planner cannot be made here; the message says what is missing."""


def make_planner(name: str, params: Optional[PlannerParams] = None) -> FleetPlanner:
    """The planner of that name.

    Args:
        name: one of ``PLANNER_NAMES``.
        params: what can be chosen, its defaults unless given; planners ignore what does not apply to them.

    Raises:
        KeyError: no such planner.
        PlannerUnavailableError: a package that it needs is not installed.
    """
    if name not in _PLANNERS:
        raise KeyError(f"planner {name!r} is none of {', '.join(PLANNER_NAMES)}")
    module, cls = _PLANNERS[name]
    try:
        return cast(FleetPlanner, getattr(importlib.import_module(module), cls)(params or PlannerParams()))
    except ImportError as error:
        raise PlannerUnavailableError(f"planner {name} cannot be made: {error}") from error


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
