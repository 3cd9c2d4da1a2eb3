"""The remembered plan of the fleet, carried on where the robots are now (docs/planning.md, "Re-planning")."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Dict, List, Optional, Sequence, Tuple

from yarm.geometry import wrap_angle
from yarm.planning.cspace.robot_space import Pose, RobotSpace
from yarm.planning.fleet.fleet import Fleet, Move
from yarm.planning.model.types import Column, Waypoint

SAME_YAW_RAD = math.radians(2.5)
"""Headings this close are taken as the same one, imprecisely reached."""

GoalKey = Tuple[Column, Optional[float]]
"""Column and heading wanted, rad."""

RememberedMove = Tuple[str, Waypoint, Waypoint]


@dataclass
class Memory:
    """What the planner keeps between two steps.

    Attributes:
        moves: the joint plan: robot, from, to; in order.
        goals: goal column and heading of each robot the plan was made for.
    """

    moves: List[RememberedMove] = field(default_factory=list)
    goals: Dict[str, GoalKey] = field(default_factory=dict)

    def recall(self, fleet: Fleet, names: Sequence[str]) -> Optional[List[Move]]:
        """The remembered moves still to be made from where the robots stand; None when they no longer lead there.

        A robot that has reached the end of its first move, or of a later one, goes on with the next; one that is
        elsewhere makes its first move from where it is. Whether the moves are still free is for ``joint_plan.valid``.
        """
        index = {name: i for i, name in enumerate(names)}
        at: Dict[str, Pose] = {name: fleet.starts[i] for name, i in index.items()}
        made = {name: self._made(name, at[name], fleet.spaces[i]) for name, i in index.items()}
        seen = set()
        moves: List[Move] = []
        for name, start, end in self.moves:
            if name not in index:
                return None
            space = fleet.spaces[index[name]]
            goal_pose, start_pose = pose_of(end, space), pose_of(start, space)
            if goal_pose is None:
                return None
            if made[name]:
                made[name] -= 1
                continue
            first = name not in seen
            seen.add(name)
            if not first and at[name] != start_pose:
                return None
            moves.append(Move(index[name], at[name], goal_pose))
            at[name] = goal_pose
        return moves

    def _made(self, robot: str, at: Pose, space: RobotSpace) -> int:
        """How many of its remembered moves a robot has made that is at a pose."""
        own = [(start, end) for name, start, end in self.moves if name == robot]
        if not own or (pose_of(own[0][0], space) == at and pose_of(own[0][1], space) != at):
            return 0
        return next((k for k, (_, end) in enumerate(own, 1) if pose_of(end, space) == at), 0)

    def keep(self, fleet: Fleet, names: Sequence[str], moves: Sequence[Move]) -> None:
        """Remember a joint plan."""
        self.moves = []
        for move in moves:
            space = fleet.spaces[move.robot]
            self.moves.append((names[move.robot], waypoint(move.start, space), waypoint(move.end, space)))


def waypoint(pose: Pose, space: RobotSpace) -> Waypoint:
    """A pose as a waypoint."""
    return Waypoint((pose[0], pose[1]), space.headings[pose[2]])


def pose_of(point: Waypoint, space: RobotSpace) -> Optional[Pose]:
    """A waypoint as a pose among a robot's headings; None when it has no such heading."""
    errors = [abs(wrap_angle(point.yaw_rad - heading)) for heading in space.headings]
    best = min(range(len(errors)), key=errors.__getitem__)
    return (*point.column, best) if errors[best] <= SAME_YAW_RAD else None
