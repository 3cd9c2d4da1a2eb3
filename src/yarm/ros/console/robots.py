"""What each robot and arm is about: moves that were released, and how the sanders stand."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Any, Dict, List, Mapping, Sequence, Tuple

import numpy as np
from actionlib_msgs.msg import GoalStatusArray
from geometry_msgs.msg import Pose as GeometryPose
from visualization_msgs.msg import Marker

from yarm.console.picture import BodyDrawing, Line, Pose
from yarm.console.sweeps import Place, outlines, place_of
from yarm.control.actions import MobileAction
from yarm.control.sander.states import SanderState
from yarm.geometry import FloatArray
from yarm.msg import MoveRobotActionGoal, MoveRobotActionResult, SanderStatus
from yarm.ros.common import names
from yarm.ros.common.checks import pose_fault
from yarm.ros.console.routes import Route


@dataclass(frozen=True)
class Move:
    """A move that was released: its goal's number, the places it leads to, and whether the body's centre stays."""

    goal: str
    places: Tuple[Place, ...]
    about_body: bool


class RobotBook:
    """What the robots and arms of the registry say. Not thread-safe."""

    def __init__(self) -> None:
        """Nobody is known yet."""
        self._mobiles: Sequence[str] = ()
        self._arms: Sequence[str] = ()
        self._moves: Dict[str, Move] = {}
        self._sanders: Dict[str, SanderStatus] = {}
        self._rasters: Dict[str, FloatArray] = {}

    def follow(self, mobiles: Sequence[str], arms: Sequence[str]) -> None:
        """These are there, and no others."""
        self._mobiles, self._arms = mobiles, arms
        for known in (self._moves, self._sanders, self._rasters):
            for name in [name for name in known if name not in (*mobiles, *arms)]:
                del known[name]

    def routes(self) -> Dict[str, Route]:
        """What it listens to."""
        found = {}
        for name in self._mobiles:
            action = names.move_robot(name)
            found[f"{action}/goal"] = Route(MoveRobotActionGoal, partial(self._on_goal, name))
            found[f"{action}/result"] = Route(MoveRobotActionResult, partial(self._on_result, name))
        for name in (*self._mobiles, *self._arms):
            found[self.server_topic(name)] = Route(GoalStatusArray, lambda _: None, raw=True)
        for name in self._arms:
            found[names.sander_status(name)] = Route(SanderStatus, partial(self._on_sander, name))
            found[names.sander_raster(name)] = Route(Marker, partial(self._on_raster, name))
        return found

    def servers(self) -> Dict[str, str]:
        """Of each robot and arm the topic on which its action server says several times a second that it is there."""
        return {name: self.server_topic(name) for name in (*self._mobiles, *self._arms)}

    @staticmethod
    def server_topic(name: str) -> str:
        """Of a robot or an arm."""
        return f"{names.move_robot(name)}/status"

    def clear(self) -> None:
        """Time went backwards: no move is under way."""
        self._moves.clear()

    def arms(self) -> List[Dict[str, Any]]:
        """How each sander stands, by name."""
        return [
            {
                "name": name,
                "state": said.state_name,
                "sands": said.state == SanderState.SCAN_TO_PATH,
                "moving": said.moving,
                "enabled": said.enabled,
                "lifted": said.lifted,
                "progress": round(float(said.progress), 4),
                "reason": said.reason,
            }
            for name, said in sorted(self._sanders.items())
        ]

    def lines(self, poses: Mapping[str, Pose], bodies: Sequence[BodyDrawing]) -> List[Line]:
        """Moves under way, the way from where the robot is and an outline around what it sweeps; the rasters."""
        found = [Line("raster", name, points) for name, points in sorted(self._rasters.items())]
        for body in sorted((body for body in bodies if body.name in self._moves), key=lambda body: body.name):
            at, move = poses.get(names.ee_frame(body.name)), self._moves[body.name]
            if at is None:
                continue
            way = [at[:3], *((x, y, at[2]) for x, y, _ in move.places)]
            found.append(Line("move", body.name, np.array(way)))
            base = poses.get(names.base_frame(body.name)) if move.about_body else None
            pivot = at if base is None else base
            found += [Line("move", body.name, outline) for outline in outlines(body, poses, at, move.places, pivot)]
        return found

    def _on_goal(self, name: str, message: MoveRobotActionGoal) -> None:
        goal = message.goal
        action = MobileAction.of(goal.action)
        if action is MobileAction.CALIBRATE or any(pose_fault(pose) for pose in (goal.target, *goal.via)):
            return
        at = place_of(_pose(goal.target))
        places = (*((pose.position.x, pose.position.y, at[2]) for pose in goal.via), at)
        self._moves[name] = Move(message.goal_id.id, places, action is MobileAction.ABOUT_BODY)

    def _on_result(self, name: str, message: MoveRobotActionResult) -> None:
        if name in self._moves and self._moves[name].goal == message.status.goal_id.id:
            del self._moves[name]

    def _on_sander(self, name: str, message: SanderStatus) -> None:
        if math.isfinite(message.progress):
            self._sanders[name] = message

    def _on_raster(self, name: str, message: Marker) -> None:
        points = np.array([(p.x, p.y, p.z) for p in message.points]).reshape(-1, 3)
        if message.action == Marker.ADD and np.isfinite(points).all():
            self._rasters[name] = points
        else:
            self._rasters.pop(name, None)


def _pose(pose: GeometryPose) -> Pose:
    at, turn = pose.position, pose.orientation
    return at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w
