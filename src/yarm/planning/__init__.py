"""Task assignment and planning; NumPy and SciPy only."""

from yarm.planning.params import PlannerParams, TaskParams
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
    "FleetPlan",
    "FleetPlanner",
    "Goal",
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
]
