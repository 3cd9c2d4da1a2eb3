"""A film of the youBot clearing its floor, taken in the simulation: a page plays it as any other run."""

from __future__ import annotations

from pathlib import Path
from typing import Dict, List, Optional, Tuple

import numpy as np

from yarm.console.cell import Part
from yarm.console.film import Film
from yarm.console.picture import BodyDrawing, Line, Pose, Scene, state_message
from yarm.console.results import FILM
from yarm.console.trails import Trails
from yarm.geometry import FloatArray, quaternion_from_rpy, transform_matrix, transform_points
from yarm.geometry.solids import Solid
from yarm.manipulation.clearing.mission import Command
from yarm.manipulation.clearing.reachability import T_BASE_ARM
from yarm.manipulation.kinematics.forward import forward_many
from yarm.manipulation.motion.trajectory import Trajectory
from yarm.sim.engine.bodies import description
from yarm.sim.engine.youbot_floor import YoubotFloor

PERIOD_S = 0.1
"""Simulated time between two pictures, s."""
FLOOR, ROBOT, HAND, CUP = "floor", "youbot", "hand", "suction_cup"
SCENE_VERSION = 1
LOW_M = 0.02
"""Height at which the base's way is drawn, metres."""
WAY_POINTS = 40
"""Points of the hand's way in one motion."""
TRACE_M, TRACE_POINTS = 0.02, 3000
"""The hand's way behind: distance of two points, metres, and points at most; the oldest go."""


class FloorFilm:
    """Takes pictures of a floor while a mission is played on it: pass it as what watches, then write it."""

    def __init__(self, title: str) -> None:
        """Nothing has been seen yet.

        Args:
            title: of the film, for people.
        """
        self.film = Film(title)
        self._scene: Optional[Scene] = None
        self._parts: Dict[str, Part] = {}
        self._next_s = 0.0
        self._trails = Trails()
        self._hand: List[FloatArray] = []
        self._ahead = np.empty((0, 3))

    def __call__(self, world: YoubotFloor, command: Command) -> None:
        """A tick has passed in a world, in which the robot did as it was told."""
        if self._scene is None:
            self._scene = scene_of(world)
            self._parts = {"scene": Part(SCENE_VERSION, self._scene.message(SCENE_VERSION))}
        if command.motion is not None:
            self._ahead = hand_way(command.motion)
        if world.time_s >= self._next_s:
            self._next_s = world.time_s + PERIOD_S
            self.film.add(world.time_s, self._parts, self._state(world, self._scene))

    def write(self, folder: Path) -> Path:
        """The film as a file of a run's folder.

        Raises:
            OSError: it cannot be written.
        """
        self.film.write(folder / FILM)
        return folder / FILM

    def _state(self, world: YoubotFloor, scene: Scene) -> bytes:
        poses = poses_of(world)
        base, hand = world.robot.pose(), np.array(poses[CUP][:3])
        self._trails.follow(ROBOT, base.x, base.y)
        if not self._hand or np.linalg.norm(hand - self._hand[-1]) >= TRACE_M:
            self._hand = [*self._hand[1 - TRACE_POINTS :], hand]
        lines = self._trails.lines(LOW_M)
        if len(self._hand) > 1:
            lines.append(Line("driven", HAND, np.array(self._hand)))
        if len(self._ahead):
            T_world_base = transform_matrix((base.x, base.y, 0.0), quaternion_from_rpy(0.0, 0.0, base.yaw_rad))
            lines.append(Line("path", HAND, transform_points(T_world_base @ T_BASE_ARM, self._ahead)))
        words = {
            "time_s": round(world.time_s, 3),
            "silent": [],
            "commander": None,
            "buttons": [],
            "tasks": [],
            "stop": None,
            "robots": [],
            "arms": [],
            "real_time_factor": None,
            "room": {"title": "youBot's arm", "facts": facts_of(world), "verdicts": []},
        }
        return state_message(words, scene, SCENE_VERSION, poses, None, lines)


def scene_of(world: YoubotFloor) -> Scene:
    """Robot, debris and whatever stands firm, each of the solids that the physics knows."""
    _, robot = description("youbot.urdf.xacro", system="manipulation")
    _, debris = description("debris.urdf.xacro")
    firm: Dict[str, List[Tuple[str, Solid]]] = {}
    for name, solid in world.scene.boxes():
        firm.setdefault(name, []).append((FLOOR, solid))
    return Scene(
        [
            BodyDrawing(ROBOT, "Mobile", "dynamic", "base_link", [(solid.link, solid) for solid in robot.solids]),
            *(
                BodyDrawing(piece.name, "Debris", "dynamic", piece.name, [(piece.name, s) for s in debris.solids])
                for piece in world.scene.debris
            ),
            *(BodyDrawing(name, "Obstacle", "static", FLOOR, solids) for name, solids in firm.items()),
        ]
    )


def poses_of(world: YoubotFloor) -> Dict[str, Pose]:
    """Of every frame of the scene, world."""
    pieces = {piece.name: world.piece_pose(piece.name) for piece in world.scene.debris}
    return {FLOOR: (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0), **world.robot.link_frames(), **pieces}


def facts_of(world: YoubotFloor) -> List[List[str]]:
    """How far it has come, as names and values."""
    pieces = [piece.name for piece in world.scene.debris]
    force_n = max(world.robot.cup.press_n().values(), default=0.0)
    joints = ", ".join(f"{round(float(np.degrees(angle)))}\u00b0" for angle in world.robot.joints())
    return [
        ["in the bin", f"{sum(map(world.in_bin, pieces))} of {len(pieces)} pieces"],
        ["on the cup", world.held() or "nothing"],
        ["push of the cup", f"{force_n:.0f} N"],
        ["joints", joints],
    ]


def hand_way(motion: Trajectory) -> FloatArray:
    """The hand's way in a motion, (n, 3), metres, the arm's frame."""
    q, _, _ = motion.evaluate(np.linspace(0.0, motion.duration_s, WAY_POINTS))
    return np.asarray(forward_many(q)[:, :3, 3])
