"""A planning request turned into boards, and why a robot has no way in it."""

from __future__ import annotations

import math
from typing import List, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import wrap_angle
from yarm.planning import request_check as check
from yarm.planning.bitboard import Layers, Layout, dilated
from yarm.planning.cspace import SAME_HEADING_RAD, Pose, RobotSpace, ShapeCache, Turns, headings_from, with_margin
from yarm.planning.fleet import Fleet
from yarm.planning.replanning import GoalKey
from yarm.planning.search import Target, reachable
from yarm.planning.types import PlanRequest, PlanStatus, Robot

CENTERED_M = 1e-6
"""An end effector nearer to its column's centre, m, is on it."""


class World:
    """A request as boards: the robots that can be planned for, their spaces and their targets."""

    def __init__(self, request: PlanRequest, robots: Sequence[Robot], layout: Layout, obstacles: Layers) -> None:
        """See ``of``."""
        self.request = request
        self.robots = tuple(robots)
        self.layout = layout
        self.obstacles = obstacles
        self.spaces: List[RobotSpace] = []
        self.targets: List[Optional[Target]] = []

    @staticmethod
    def of(request: PlanRequest, turns: Turns, cache: ShapeCache, only: Optional[str] = None) -> Optional[World]:
        """The world of a request.

        Args:
            request: map, robots and assignments.
            turns: allowed turns.
            cache: kept shapes.
            only: name of the one robot to plan for, all the others taken away; None for all.

        Returns:
            None when there is no robot that can be planned for.
        """
        robots = [robot for robot in request.robots if check.robot_fault(robot, request) is None]
        if not any(only in (None, robot.name) for robot in robots):
            return None
        layout = Layout(request.spec.shape, 8 * math.ceil(_border(robots) / 8))
        chosen = [robot for robot in robots if only in (None, robot.name)]
        world = World(request, chosen, layout, layout.layers_of_grid(check.robotless_grid(request, robots)))
        for robot in chosen:
            world._add(robot, turns, cache)
        return world

    def _add(self, robot: Robot, turns: Turns, cache: ShapeCache) -> None:
        goal = check.assigned_goal(robot, self.request)
        usable = goal if goal is not None and check.goal_fault(robot, self.request) is None else None
        wanted_yaw = None if usable is None else usable.yaw_rad
        headings = headings_from(robot.yaw_rad, turns, wanted_yaw)
        wanted = None
        if wanted_yaw is not None:
            wanted = min(range(len(headings)), key=lambda h: abs(wrap_angle(headings[h] - wanted_yaw)))
        present = self.layout.layers_of_cells(robot.cells)
        obstacles = with_margin(self.obstacles, present, self.layout.stride)
        forbidden = self._forbidden(present)
        if forbidden:
            obstacles = tuple(layer | forbidden for layer in obstacles)
        start: Pose = (int(robot.column[0]), int(robot.column[1]), 0)
        resolution = self.request.spec.resolution
        self.spaces.append(
            RobotSpace(robot.mask, start, headings, turns, obstacles, self.layout, resolution, cache, wanted)
        )
        column = None if usable is None else (int(usable.column[0]), int(usable.column[1]))
        self.targets.append(None if column is None else Target(column, wanted))

    def _forbidden(self, present: Layers) -> int:
        """Board of the columns no cell may enter, but those the robot stands in."""
        if self.request.forbidden is None:
            return 0
        board = self.layout.board_of_image(np.asarray(self.request.forbidden, dtype=np.bool_))
        for layer in present:
            board &= ~layer
        return board

    def off_center(self) -> List[int]:
        """Robots whose end effector is known not to be on the centre of its column."""
        spec = self.request.spec
        return [
            i
            for i, robot in enumerate(self.robots)
            if robot.position_m is not None
            and math.dist(robot.position_m, spec.column_center(robot.column)) > CENTERED_M
        ]

    def goal_key(self, i: int) -> GoalKey:
        """What identifies the goal of a robot."""
        target = self.targets[i]
        assert target is not None
        return target.column, None if target.heading is None else self.spaces[i].headings[target.heading]


def turns_of(turns_deg: Sequence[float], deg_per_cell: float = 10.0) -> Turns:
    """Allowed turns from angles in degrees; no turn at all is always allowed."""
    angles = tuple(math.radians(angle) for angle in turns_deg if abs(angle) > math.degrees(SAME_HEADING_RAD))
    return Turns(angles, math.radians(deg_per_cell))


def _border(robots: Sequence[Robot]) -> int:
    reach = max(float(np.hypot(r.mask.cells[:, 0], r.mask.cells[:, 1]).max()) for r in robots)
    return math.ceil(reach) + 3


def why_not(world: World, fleet: Fleet, i: int) -> Tuple[PlanStatus, str]:
    """Status and reason of a robot that has no way to its target even with no other robot there."""
    robot, target, space = world.robots[i], world.targets[i], fleet.spaces[i]
    assert target is not None
    goal = world.request.assignments[robot.name]
    headings = range(len(space.headings)) if target.heading is None else [target.heading]
    view = fleet.view(i, fleet.starts, range(len(fleet.spaces)))
    if not any(view.stands((*target.column, h)) for h in headings):
        owners = _owners(world, i, (*target.column, headings[0]))
        return PlanStatus.INVALID_GOAL, (
            f"{robot.name} cannot stand with its end effector at {goal} {target.column} at any allowed heading: "
            f"{owners} within its margin"
        )
    reached = reachable(view, fleet.starts[i])
    closest = min(
        ((math.dist(column, target.column), column, h) for h in reached for column in _columns(world, reached[h])),
        default=(0.0, space.start[:2], 0),
    )
    toward = _towards(closest[1], target.column)
    return PlanStatus.INFEASIBLE, (
        f"{robot.name} has no way to {goal} {target.column} through any cell at any allowed heading; it gets as far as "
        f"{closest[1]}, stopped by {_owners(world, i, (*toward, closest[2]))}"
    )


def _columns(world: World, board: int) -> List[Tuple[int, int]]:
    return [(int(x), int(y)) for x, y in np.argwhere(world.layout.image_of_board(board))]


def _towards(a: Tuple[int, int], b: Tuple[int, int]) -> Tuple[int, int]:
    return a[0] + int(np.sign(b[0] - a[0])), a[1] + int(np.sign(b[1] - a[1]))


def _owners(world: World, i: int, pose: Pose) -> str:
    """Who occupies cells that a robot at a pose would overlap or come too near to."""
    cells = world.spaces[i].shape(pose[2]).at(pose[:2])
    touched = tuple(a & b for a, b in zip(dilated(cells, world.layout.stride), world.obstacles))
    return check.objects_at(world.layout.cells_of_layers(touched), world.request)
