"""Small requests for planner and checker tests."""

from __future__ import annotations

from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np
import pytest

from yarm.geometry import GridSpec, Mask
from yarm.planning.model.types import (
    FleetPlan,
    Goal,
    PlanRequest,
    PlanStatus,
    Robot,
    RobotPlan,
    Waypoint,
    without_robots,
)

RobotSpec = Tuple[Tuple[int, int], Sequence[Tuple[int, int, int]]]


def grid_spec(gx: int, gy: int, gz: int = 2) -> GridSpec:
    """A grid of 0.1 m cells with its lower corner at the origin."""
    return GridSpec((gx, gy, gz), (0.0, 0.0, 0.0), (gx / 10.0, gy / 10.0, gz / 10.0))


def make_request(
    shape: Tuple[int, int, int],
    robots: Mapping[str, RobotSpec],
    goals: Optional[Mapping[str, Tuple[int, int]]] = None,
    boxes: Optional[Mapping[str, Sequence[Tuple[int, int, int]]]] = None,
    yaw_rad: float = 0.0,
    **more: Any,
) -> PlanRequest:
    """A request: robots as column and cells relative to it, the goal column of each, and objects as cells."""
    spec = grid_spec(*shape)
    occupied = np.zeros(shape, dtype=bool)
    objects = {name: np.array(cells, dtype=np.int64).reshape(-1, 3) for name, cells in (boxes or {}).items()}
    fleet: List[Robot] = []
    for name, (column, cells) in robots.items():
        fleet.append(Robot(name, column, yaw_rad, Mask.from_cells(np.array(cells), (0, 0), yaw_rad)))
    for cells in objects.values():
        occupied[tuple(cells[spec.contains(cells)].T)] = True
    standing = without_robots(spec, occupied, fleet)
    wanted: Dict[str, Goal] = {f"goal_{n}": Goal(f"goal_{n}", "Target", column) for n, column in (goals or {}).items()}
    assigned = {name: f"goal_{name}" for name in (goals or {})}
    return PlanRequest(spec, standing, tuple(fleet), wanted, assigned, objects, **more)


def step_plan(**steps: Optional[Tuple[Tuple[int, int], float]]) -> FleetPlan:
    """A plan that sends the named robots to (column, yaw_rad); None lets one stay."""
    plans = {}
    for name, step in steps.items():
        waypoint = None if step is None else Waypoint(*step)
        plans[name] = RobotPlan(name, "", PlanStatus.SOLVED, step=waypoint)
    return FleetPlan(PlanStatus.SOLVED, "", plans)


@pytest.fixture(name="request_of")
def request_of_fixture() -> Callable[..., PlanRequest]:
    """``make_request``."""
    return make_request


@pytest.fixture(name="plan_of")
def plan_of_fixture() -> Callable[..., FleetPlan]:
    """``step_plan``."""
    return step_plan
