"""Goals that somebody who is busy serves sooner than anybody who is idle: they are left to him."""

from __future__ import annotations

import math
from typing import Container, Iterable, List, Mapping, Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray
from yarm.planning.model.types import Goal
from yarm.planning.tasks.task import BODIES, Task
from yarm.planning.tasks.travel import Travel


def soon_free(tasks: Iterable[Task]) -> List[Task]:
    """Those of some tasks whose robots come on unhindered, and go on from where the goal is."""
    return [task for task in tasks if task.robot and not task.reason and task.kind in BODIES and not task.goal.onward]


def ways_after(
    travel: Travel,
    goals: Sequence[Goal],
    busy: Sequence[Task],
    left: Mapping[str, float],
    refused: Container[Tuple[str, str]] = (),
) -> FloatArray:
    """Ways of busy robots to their goals and from there to others, (goals, busy), cells; infinite where there is none.

    Args:
        travel: distances from where the robots will stand when their moves under way have ended.
        goals: what waits.
        busy: tasks of those who may serve it next.
        left: what each robot has left of its move under way, cells; one that is not named has none.
        refused: pairs of a robot and a goal that the planner has found impossible.
    """
    ways: FloatArray = np.full((len(goals), len(busy)), math.inf)
    for j, task in enumerate(busy):
        first = left.get(task.robot, 0.0) + travel.distance(task.robot, task.goal)[0]
        for i, goal in enumerate(goals):
            its = goal.robot in ("", task.robot) and (task.robot, goal.name) not in refused
            if its and math.isfinite(first):
                ways[i, j] = first + travel.distance_after(task.robot, task.goal, goal)
    return ways
