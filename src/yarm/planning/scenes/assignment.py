"""Which robot of a scene goes where, when the scene does not say."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Mapping

import numpy as np
from scipy.optimize import linear_sum_assignment

from yarm.planning.model.params import PlannerParams
from yarm.planning.scenes.oracle import Node, Shape, Space
from yarm.planning.scenes.scene import PlanScene


@dataclass(frozen=True)
class Assignment:
    """Goal by robot, and why the others have none.

    Attributes:
        assignments: goal of each robot that has one.
        unserved: reason by goal that no robot is left for or can reach.
    """

    assignments: Mapping[str, str]
    unserved: Mapping[str, str]


def assign_goals(scene: PlanScene, params: PlannerParams) -> Assignment:
    """The scene's own assignments, the goals left over to the robots left over: most goals, then least travel.

    Travel is over every cell and turn, with the robots' present places free: they will have moved.
    """
    assignments: Dict[str, str] = dict(scene.assignments)
    robots = [robot for robot in scene.robots if robot.name not in assignments]
    goals = [goal for goal in scene.goals.values() if goal.name not in assignments.values()]
    unserved: Dict[str, str] = {}
    if not goals:
        return Assignment(assignments, unserved)
    lengths = np.full((len(robots), len(goals)), np.inf)
    for i, robot in enumerate(robots):
        space = Space(Shape(robot, scene.spec, params.turns_deg), scene.occupied())
        distance = space.lengths(Node(0, *robot.start.column))
        lengths[i] = [distance[goal.column] for goal in goals]
    far = 1e6
    rows, columns = linear_sum_assignment(np.where(np.isfinite(lengths), lengths, far))
    for i, j in zip(rows, columns):
        if np.isfinite(lengths[i, j]):
            assignments[robots[i].name] = goals[j].name
    for j, goal in enumerate(goals):
        if goal.name not in assignments.values():
            reachable = len(robots) > 0 and bool(np.isfinite(lengths[:, j]).any())
            reason = (
                "every robot that could reach it has another goal"
                if reachable
                else "no robot without a goal can reach it"
            )
            unserved[goal.name] = f"goal {goal.name} at {goal.column}: {reason}"
    return Assignment(assignments, unserved)
