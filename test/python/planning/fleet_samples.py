"""Small fleets on one grid for the tests of the joint plan."""

from __future__ import annotations

from typing import List, Sequence, Tuple

import numpy as np

from python.planning.samples import block, request, robot, walls
from yarm.geometry import GridSpec
from yarm.planning.cspace.robot_space import ShapeCache
from yarm.planning.fleet.fleet import Fleet
from yarm.planning.fleet.problem import PlanningProblem, turns_of
from yarm.planning.model.types import Goal, GoalKind, Robot
from yarm.planning.roadmap.particles import cell_order
from yarm.planning.roadmap.roadmap import Roadmap

SPEC = GridSpec((30, 24, 4), (0.0, 0.0, 0.0), (3.0, 2.4, 0.4))
OPEN = np.zeros(SPEC.shape, dtype=bool)
CORRIDOR_WITH_BAY = walls(SPEC, [(5, 25, 0, 10), (5, 13, 13, 24), (18, 25, 13, 24), (13, 18, 17, 24)])
"""A corridor y 10 to 12 between two halls, with a bay x 13 to 17, y 13 to 16."""


def fleet_of(robots: Sequence[Robot], goals: Sequence[Goal], occupied: np.ndarray = OPEN) -> Fleet:
    """A fleet with quarter turns; the goals go to the robots in order."""
    problem = PlanningProblem.of(request(SPEC, occupied, robots, goals), turns_of((0.0, 90.0, -90.0)), ShapeCache())
    assert problem is not None
    return Fleet(problem.spaces, problem.targets, Roadmap.of(cell_order((30, 24))[:80].astype(np.int64)))


def blocks(*columns: Tuple[int, int]) -> List[Robot]:
    return [robot(f"r{i}", column, block(2, 2)) for i, column in enumerate(columns)]


def goals(*columns: Tuple[int, int]) -> List[Goal]:
    return [Goal(f"g{i}", GoalKind.TARGET, column) for i, column in enumerate(columns)]


def head_on() -> Fleet:
    """Two robots of one column that meet in the corridor."""
    robots = [robot("a", (2, 11), block(1, 1)), robot("b", (27, 11), block(1, 1))]
    return fleet_of(robots, goals((27, 11), (2, 11)), CORRIDOR_WITH_BAY)


FLEETS = {
    "crossing": fleet_of(blocks((2, 12), (14, 2)), goals((26, 12), (14, 20))),
    "swap": fleet_of(blocks((2, 12), (26, 12)), goals((26, 12), (2, 12))),
    "ring": fleet_of(blocks((2, 2), (26, 2), (26, 20)), goals((26, 2), (26, 20), (2, 2))),
    "head_on": head_on(),
}
