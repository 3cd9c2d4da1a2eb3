"""What each robot and arm is about: moves that were released, and how the sanders stand."""

from __future__ import annotations

import math
from functools import partial
from typing import Any, Dict, List, Mapping, Sequence, Tuple

import numpy as np
from visualization_msgs.msg import Marker

from yarm.console.picture import Line, Pose
from yarm.control.actions import MobileAction
from yarm.geometry import FloatArray
from yarm.msg import MoveRobotActionGoal, MoveRobotActionResult, SanderStatus
from yarm.ros.common import names
from yarm.ros.common.checks import pose_fault
from yarm.ros.console.routes import Route


class RobotBook:
    """What the robots and arms of the registry say. Not thread-safe."""

    def __init__(self) -> None:
        """Nobody is known yet."""
        self._mobiles: Sequence[str] = ()
        self._arms: Sequence[str] = ()
        self._moves: Dict[str, Tuple[str, FloatArray]] = {}
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
        for name in self._arms:
            found[names.sander_status(name)] = Route(SanderStatus, partial(self._on_sander, name))
            found[names.sander_raster(name)] = Route(Marker, partial(self._on_raster, name))
        return found

    def clear(self) -> None:
        """Time went backwards: no move is under way."""
        self._moves.clear()

    def arms(self) -> List[Dict[str, Any]]:
        """How each sander stands, by name."""
        return [
            {
                "name": name,
                "state": said.state_name,
                "moving": said.moving,
                "enabled": said.enabled,
                "lifted": said.lifted,
                "progress": round(float(said.progress), 4),
                "reason": said.reason,
            }
            for name, said in sorted(self._sanders.items())
        ]

    def lines(self, poses: Mapping[str, Pose]) -> List[Line]:
        """Moves that are under way, each from where the robot is, and the rasters."""
        found = [Line("raster", name, points) for name, points in sorted(self._rasters.items())]
        for name, (_, target) in sorted(self._moves.items()):
            at = poses.get(names.ee_frame(name))
            if at is not None:
                found.append(Line("move", name, np.array([at[:3], (target[0], target[1], at[2])])))
        return found

    def _on_goal(self, name: str, message: MoveRobotActionGoal) -> None:
        if MobileAction.of(message.goal.action) is MobileAction.CALIBRATE or pose_fault(message.goal.target):
            return
        at = message.goal.target.position
        self._moves[name] = (message.goal_id.id, np.array([at.x, at.y]))

    def _on_result(self, name: str, message: MoveRobotActionResult) -> None:
        if name in self._moves and self._moves[name][0] == message.status.goal_id.id:
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
