"""Task assignment and planning; NumPy and SciPy only."""

from yarm.planning.original_planner import OriginalPlanner
from yarm.planning.params import PlannerParams, TaskParams
from yarm.planning.registry import PLANNER_NAMES, available_planners, make_planner
from yarm.planning.task_queue import Task, TaskQueue, TaskStatus, arrived
from yarm.planning.types import (
    FleetPlan,
    FleetPlanner,
    Goal,
    PlanRequest,
    PlanStatus,
    Robot,
    RobotPlan,
    StepCheck,
    Waypoint,
)
from yarm.planning.yarm_planner import YarmPlanner

__all__ = [
    "PLANNER_NAMES",
    "FleetPlan",
    "FleetPlanner",
    "Goal",
    "OriginalPlanner",
    "PlanRequest",
    "PlanStatus",
    "PlannerParams",
    "Robot",
    "RobotPlan",
    "StepCheck",
    "Task",
    "TaskParams",
    "TaskQueue",
    "TaskStatus",
    "Waypoint",
    "YarmPlanner",
    "arrived",
    "available_planners",
    "make_planner",
]
