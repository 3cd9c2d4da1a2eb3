"""A film of the youBot at its tasks, taken in the simulation: a page plays it as any other run."""

from __future__ import annotations

from pathlib import Path
from typing import Dict, List, Optional, Sequence

import numpy as np

from yarm.console.arm_film import ArmTake
from yarm.console.cell import Part
from yarm.console.picture import BodyDrawing, Line, Pose, Scene, state_message
from yarm.console.reel import HAND, HandTrace, Reel, hand_way, in_degrees, words_of
from yarm.console.room import Marks
from yarm.console.trails import Trails
from yarm.geometry import FloatArray, quaternion_from_rpy, transform_matrix, transform_points
from yarm.geometry.poses import quaternions_of
from yarm.geometry.solids import Solid
from yarm.manipulation.clearing.mission import Command
from yarm.manipulation.clearing.reachability import T_BASE_ARM
from yarm.manipulation.motion.checkpoints import ArmScene
from yarm.robots.youbot import NAME
from yarm.sim.engine.youbot_floor import YoubotFloor
from yarm.sim.scenes.bodies import Body
from yarm.sim.scenes.youbot_floor import CUP_FRAME, floor_bodies

LOW_M = 0.02
"""Height at which the base's way is drawn, metres."""


class FloorFilm:
    """Takes pictures of the youBot's tasks while they are played: of the arm's, and of the floor's, when called."""

    def __init__(self, title: str) -> None:
        """Nothing has been seen yet.

        Args:
            title: of the film, for people.
        """
        self.reel = Reel(title)
        self._scene: Optional[Scene] = None
        self._parts: Dict[str, Part] = {}
        self._still: Dict[str, Pose] = {}
        self._trails, self._trace = Trails(), HandTrace()
        self._ahead = np.empty((0, 3))

    def arm(self, title: str, scene: ArmScene) -> ArmTake:
        """What looks on while the arm plays a task of its own."""
        return ArmTake(self.reel, title, scene)

    def __call__(self, world: YoubotFloor, command: Command) -> None:
        """A tick has passed in a world, in which the robot did as it was told."""
        if self._scene is None:
            task = self.reel.begin("the floor")
            bodies = floor_bodies(world.scene)
            self._scene, self._still = scene_of(bodies), still_poses(bodies)
            self._parts = {"scene": Part(task, self._scene.message(task)), "marks": Part(-task, Marks().message(-task))}
        if command.motion is not None:
            self._ahead = hand_way(command.motion)
        if self.reel.due(world.time_s):
            self.reel.add(world.time_s, self._parts, self._state(world, self._scene))

    def write(self, folder: Path) -> Path:
        """The film as a file of a run's folder.

        Raises:
            OSError: it cannot be written.
        """
        return self.reel.write(folder)

    def _state(self, world: YoubotFloor, scene: Scene) -> bytes:
        poses = {**self._still, **moving_poses(world)}
        base = world.robot.pose()
        self._trails.follow(NAME, base.x, base.y)
        self._trace.follow(np.array(poses[CUP_FRAME][:3]))
        lines = [*self._trails.lines(LOW_M), *self._trace.lines()]
        if len(self._ahead):
            T_world_base = transform_matrix((base.x, base.y, 0.0), quaternion_from_rpy(0.0, 0.0, base.yaw_rad))
            lines.append(Line("path", HAND, transform_points(T_world_base @ T_BASE_ARM, self._ahead)))
        words = words_of(self.reel.at_s(world.time_s), "youBot's arm: the floor", facts_of(world))
        return state_message(words, scene, self._parts["scene"].version, poses, None, lines)


def scene_of(bodies: Sequence[Body]) -> Scene:
    """Bodies of the solids that the physics knows."""
    return Scene([_drawing(body) for body in bodies])


def _drawing(body: Body) -> BodyDrawing:
    solids = [(i.frame, Solid(i.solid.shape, i.solid.size, i.T_frame_solid)) for i in body.solids]
    return BodyDrawing(body.name, body.kind, "dynamic" if body.dynamic else "static", body.seed_frame, solids)


def still_poses(bodies: Sequence[Body]) -> Dict[str, Pose]:
    """Of every frame that never moves, world."""
    fixed = {frame: pose for body in bodies for frame, pose in body.static_frames.items()}
    turns = quaternions_of(np.array([pose[:3, :3] for pose in fixed.values()]).reshape(-1, 3, 3))
    return {frame: (*pose[:3, 3].tolist(), *turn.tolist()) for (frame, pose), turn in zip(fixed.items(), turns)}


def moving_poses(world: YoubotFloor) -> Dict[str, Pose]:
    """Of every frame of robot and debris, world."""
    return {**world.robot.link_frames(), **{piece.name: world.piece_pose(piece.name) for piece in world.scene.debris}}


def facts_of(world: YoubotFloor) -> List[List[str]]:
    """How far it has come, as names and values."""
    there = [world.in_bin(piece.name) for piece in world.scene.debris]
    force_n = max(world.robot.cup.press_n().values(), default=0.0)
    return floor_facts(there, world.held(), force_n, world.robot.joints())


def floor_facts(in_bin: Sequence[bool], held: str, press_n: float, joints: FloatArray) -> List[List[str]]:
    """The same from what is known: of each piece whether it is in the bin, and of the robot its joints (5,), rad."""
    return [
        ["in the bin", f"{sum(in_bin)} of {len(in_bin)} pieces"],
        ["on the cup", held or "nothing"],
        ["push of the cup", f"{press_n:.0f} N"],
        ["joints", in_degrees(joints)],
    ]
