"""Task assignment and planning; NumPy and SciPy only."""

from yarm.planning.baselines.original_planner import OriginalPlanner
from yarm.planning.fleet.yarm_planner import YarmPlanner
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import (
    FleetPlan,
    FleetPlanner,
    Goal,
    GoalKind,
    PlanRequest,
    PlanStatus,
    Robot,
    RobotPlan,
    StepCheck,
    Waypoint,
)
from yarm.planning.registry import PLANNER_NAMES, available_planners, make_planner
from yarm.planning.tasks.task_queue import Task, TaskQueue, TaskStatus

__all__ = [
    "PLANNER_NAMES",
    "FleetPlan",
    "FleetPlanner",
    "Goal",
    "GoalKind",
    "OriginalPlanner",
    "PlanRequest",
    "PlanStatus",
    "PlannerParams",
    "Robot",
    "RobotPlan",
    "StepCheck",
    "Task",
    "TaskQueue",
    "TaskStatus",
    "Waypoint",
    "YarmPlanner",
    "available_planners",
    "make_planner",
]
