"""A planning request turned into sets of columns, and why a robot has no way in it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import wrap_angle
from yarm.planning.cspace.cell_sets import CellSet, Layout, difference, dilated, intersection, union
from yarm.planning.cspace.footprint import border_for
from yarm.planning.cspace.robot_space import (
    SAME_HEADING_RAD,
    Pose,
    RobotSpace,
    ShapeCache,
    Turns,
    headings_from,
    shape_of,
    with_margin,
)
from yarm.planning.fleet.fleet import Fleet
from yarm.planning.fleet.replanning import GoalKey
from yarm.planning.model import request_check as check
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import PlanRequest, PlanStatus, Robot
from yarm.planning.roadmap.search import Target, reachable
from yarm.robots.turns import FINER_TURNS_DEG

CENTRED_M = 1e-6
"""An end effector nearer to its column's centre, m, is on it."""


class PlanningProblem:
    """A request as sets of columns: the robots that can be planned for, their spaces and their targets."""

    def __init__(self, request: PlanRequest, robots: Sequence[Robot], layout: Layout, obstacles: CellSet) -> None:
        """See ``of``."""
        self.request = request
        self.robots = tuple(robots)
        self.layout = layout
        self.obstacles = obstacles
        self.spaces: List[RobotSpace] = []
        self.targets: List[Optional[Target]] = []

    @staticmethod
    def of(
        request: PlanRequest, turns: Turns, cache: ShapeCache, only: Optional[str] = None, margin: bool = True
    ) -> Optional[PlanningProblem]:
        """The problem that a request poses.

        Args:
            request: map, robots and assignments.
            turns: allowed turns, of robots that have none of their own.
            cache: kept shapes.
            only: name of the one robot to plan for, all the others taken away; None for all.
            margin: keep the margin to what does not move; without it a plan is no safe one, but says what it costs.

        Returns:
            None when there is no robot that can be planned for.
        """
        robots = [robot for robot in request.robots if check.robot_fault(robot, request) is None]
        if not any(only in (None, robot.name) for robot in robots):
            return None
        layout = Layout(request.spec.shape, 8 * math.ceil(border_for([robot.mask for robot in robots]) / 8))
        chosen = [robot for robot in robots if only in (None, robot.name)]
        problem = PlanningProblem(request, chosen, layout, layout.set_of_grid(check.robotless_grid(request, robots)))
        for robot in chosen:
            problem._add(robot, turns, cache, margin)
        return problem

    def _add(self, robot: Robot, turns: Turns, cache: ShapeCache, margin: bool) -> None:
        if robot.turns_deg is not None:
            turns = replace(turns, angles_rad=turns_of(robot.turns_deg).angles_rad)
        goal = check.assigned_goal(robot, self.request)
        usable = goal if goal is not None and check.goal_fault(robot, self.request) is None else None
        wanted_yaw = None if usable is None else usable.yaw_rad
        headings = headings_from(robot.yaw_rad, turns, wanted_yaw, robot.home_yaw_rad)
        wanted = None
        if wanted_yaw is not None:
            wanted = min(range(len(headings)), key=lambda h: abs(wrap_angle(headings[h] - wanted_yaw)))
        present = shape_of(robot.mask, self.layout, cache).at((int(robot.column[0]), int(robot.column[1])))
        stride = self.layout.stride
        obstacles = with_margin(self.obstacles, present, stride) if margin else difference(self.obstacles, present)
        forbidden = self.forbidden(present)
        if forbidden:
            obstacles = tuple(layer | forbidden for layer in obstacles)
        start: Pose = (int(robot.column[0]), int(robot.column[1]), 0)
        resolution = self.request.spec.resolution
        self.spaces.append(
            RobotSpace(
                robot.mask,
                start,
                headings,
                turns,
                obstacles,
                self.layout,
                resolution,
                cache,
                wanted,
                robot.home_yaw_rad,
                robot.mask_at,
            )
        )
        column = None if usable is None else (int(usable.column[0]), int(usable.column[1]))
        self.targets.append(None if column is None else Target(column, wanted))

    def forbidden(self, present: CellSet) -> int:
        """Set of the columns no cell may enter, but those the robot stands in."""
        if self.request.forbidden is None:
            return 0
        column_set = self.layout.set_of_image(np.asarray(self.request.forbidden, dtype=np.bool_))
        for layer in present:
            column_set &= ~layer
        return column_set

    def off_centre(self) -> List[int]:
        """Robots whose end effector is known not to be on the centre of its column."""
        spec = self.request.spec
        return [
            i
            for i, robot in enumerate(self.robots)
            if robot.position_m is not None
            and math.dist(robot.position_m, spec.column_centre(robot.column)) > CENTRED_M
        ]

    def under_way(self) -> Dict[int, CellSet]:
        """What the moves being made now sweep, by the index of the robot."""
        swept = self.request.under_way or {}
        inside = {name: cells[self.request.spec.contains(cells)] for name, cells in swept.items()}
        return {i: self.layout.set_of_cells(inside[r.name]) for i, r in enumerate(self.robots) if r.name in inside}

    def goal_key(self, i: int) -> GoalKey:
        """What identifies the goal of a robot."""
        target = self.targets[i]
        assert target is not None
        return target.column, None if target.heading is None else self.spaces[i].headings[target.heading]


def turns_of(turns_deg: Sequence[float], deg_per_cell: float = PlannerParams.turn_deg_per_cell) -> Turns:
    """Allowed turns from angles in degrees; no turn at all is always allowed."""
    angles = tuple(math.radians(angle) for angle in turns_deg if abs(angle) > math.degrees(SAME_HEADING_RAD))
    return Turns(angles, math.radians(deg_per_cell))


def explain_failure(problem: PlanningProblem, fleet: Fleet, i: int) -> Tuple[PlanStatus, str]:
    """Status and reason of a robot that has no way to its target even with no other robot there."""
    robot, target, space = problem.robots[i], problem.targets[i], fleet.spaces[i]
    assert target is not None
    goal = problem.request.assignments[robot.name]
    headings = range(len(space.headings)) if target.heading is None else [target.heading]
    view = fleet.view(i, fleet.starts, range(len(fleet.spaces)))
    if not any(view.stands((*target.column, h)) for h in headings):
        return PlanStatus.INVALID_GOAL, (
            f"{robot.name} cannot stand with its end effector at {goal} {target.column} at any allowed heading: "
            f"{_what_prevents(problem, i, headings)}{_what_would_do(problem, i)}"
        )
    reached = reachable(view, fleet.starts[i])
    closest = min(
        ((math.dist(column, target.column), column, h) for h in reached for column in _columns(problem, reached[h])),
        default=(0.0, space.start[:2], 0),
    )
    toward = _towards(closest[1], target.column)
    return PlanStatus.INFEASIBLE, (
        f"{robot.name} has no way to {goal} {target.column} through any cell at any allowed heading; it gets as far as "
        f"{closest[1]}, stopped by {_owners(problem, i, (*toward, closest[2]))}"
    )


def _what_prevents(problem: PlanningProblem, i: int, headings: Sequence[int]) -> str:
    """Who is in a robot's way on its target at some headings, and at which it would reach out of the volume."""
    target, space = problem.targets[i], problem.spaces[i]
    assert target is not None
    touched: CellSet = (0,) * problem.layout.shape[2]
    outside = []
    forbidden = problem.forbidden(problem.layout.set_of_cells(problem.robots[i].cells))
    entered = False
    for h in headings:
        entered = entered or any(layer & forbidden for layer in space.shape(h).at(target.column))
        touched = union(touched, _touched(problem, i, (*target.column, h)))
        x0, x1, y0, y1 = space.shape(h).bounds
        (x, y), (gx, gy, _) = target.column, problem.layout.shape
        if x + x0 < 0 or x + x1 >= gx or y + y0 < 0 or y + y1 >= gy:
            outside.append(round(math.degrees(space.headings[h])))
    reasons = []
    if any(touched):
        cells = problem.layout.cells_of_set(touched)
        reasons.append(f"{check.objects_at(cells, problem.request)} within its margin")
    if outside:
        reasons.append(f"it would reach out of the mapped volume at {', '.join(map(str, sorted(outside)))} deg")
    if entered:
        reasons.append("it would enter forbidden columns")
    return ", and ".join(reasons)


def _what_would_do(problem: PlanningProblem, i: int) -> str:
    """Headings at which a robot could stand on its target if it might make finer turns; empty when there are none."""
    robot, target = problem.robots[i], problem.targets[i]
    assert target is not None
    if target.heading is not None:
        return ""
    finer = PlanningProblem.of(problem.request, turns_of(FINER_TURNS_DEG), ShapeCache(), robot.name)
    assert finer is not None
    space = finer.spaces[0]
    bit = finer.layout.bit(*target.column)
    free = [round(math.degrees(yaw)) for h, yaw in enumerate(space.headings) if not space.blocked(h) >> bit & 1]
    if not free:
        return ""
    turns = " or ".join(f"{angle:g}" for angle in FINER_TURNS_DEG if angle > 0.0)
    return f"; with turns of {turns} deg (turns_deg) it could stand there at {', '.join(map(str, sorted(free)))} deg"


def _columns(problem: PlanningProblem, column_set: int) -> List[Tuple[int, int]]:
    return [(int(x), int(y)) for x, y in np.argwhere(problem.layout.image_of_set(column_set))]


def _towards(a: Tuple[int, int], b: Tuple[int, int]) -> Tuple[int, int]:
    return a[0] + int(np.sign(b[0] - a[0])), a[1] + int(np.sign(b[1] - a[1]))


def _owners(problem: PlanningProblem, i: int, pose: Pose) -> str:
    """Who occupies cells that a robot at a pose would overlap or come too near to."""
    return check.objects_at(problem.layout.cells_of_set(_touched(problem, i, pose)), problem.request)


def _touched(problem: PlanningProblem, i: int, pose: Pose) -> CellSet:
    """What stands within the margin of a robot at a pose."""
    cells = problem.spaces[i].shape(pose[2]).at(pose[:2])
    return intersection(dilated(cells, problem.layout.stride), problem.obstacles)
