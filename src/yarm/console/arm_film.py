"""The youBot's arm at its checkpoints, as a film shows it: links and obstacles where the physics has them."""

from __future__ import annotations

from typing import Dict, List, Set

import numpy as np

from yarm.console.cell import Part
from yarm.console.picture import BodyDrawing, Line, Pose, Scene, state_message
from yarm.console.reel import HAND, HandTrace, Reel, hand_way, in_degrees, words_of
from yarm.console.room import Colour, Marks
from yarm.geometry import FloatArray
from yarm.manipulation.motion.checkpoints import ArmScene
from yarm.manipulation.obstacles.collision import arm_description
from yarm.manipulation.obstacles.physics import REACHED_M, ArmWorld

ARM = "arm"
FLOOR = "floor"
AROUND = (-0.6, -0.6, 0.6, 0.6)
"""What there is to look at, metres."""
TOOL_M, DOT_M = 0.08, 0.025
"""A checkpoint is drawn as a ball of this diameter with the way its tool looks."""
OPEN: Colour = (0.9, 0.62, 0.0, 1.0)
DONE: Colour = (0.34, 0.71, 0.91, 1.0)
FREE = "nothing"
VERSIONS = 1000
"""Versions of the marks that a task may have."""


class ArmTake:
    """Pictures of the arm at one task: it is called with the world after each tick."""

    def __init__(self, reel: Reel, title: str, scene: ArmScene) -> None:
        """Begin.

        Args:
            reel: takes the pictures.
            title: of the task, for people.
            scene: checkpoints and obstacles.
        """
        self._reel, self._title, self._checkpoints = reel, title, scene.checkpoints
        self._task = reel.begin(title)
        self._scene = scene_of(scene)
        self._drawn = Part(self._task, self._scene.message(self._task))
        self._trace = HandTrace()
        self._reached: Set[str] = set()
        self._touching = ""

    def __call__(self, world: ArmWorld) -> None:
        """A tick has passed."""
        hand = world.hand_pose()[:3, 3]
        self._trace.follow(hand)
        self._note(world, hand)
        if self._reel.due(world.time_s):
            parts = {"scene": self._drawn, "marks": self._marks()}
            self._reel.add(world.time_s, parts, self._state(world, hand))

    def _note(self, world: ArmWorld, hand: FloatArray) -> None:
        """What has happened, for the list of events."""
        for point in self._checkpoints:
            if point.name not in self._reached and np.linalg.norm(point.pose[:3, 3] - hand) < REACHED_M:
                self._reached.add(point.name)
                self._reel.say(world.time_s, f"the hand is at {point.name}")
        touching = "; ".join(sorted(world.touching))
        if touching and touching != self._touching:
            self._reel.say(world.time_s, f"it touches: {touching}")
        self._touching = touching

    def _marks(self) -> Part:
        """The checkpoints, those that were reached in another colour and with a tick."""
        marks = Marks()
        for point in self._checkpoints:
            there = point.name in self._reached
            colour, at = (DONE if there else OPEN), point.pose[:3, 3]
            marks.solid("sphere", point.pose, (DOT_M, DOT_M, DOT_M), colour)
            marks.line(np.array([at - TOOL_M * point.pose[:3, 2], at]), colour)
            marks.text(f"{point.name} \u2713" if there else point.name, at.tolist())
        version = VERSIONS * self._task + len(self._reached)
        return Part(version, marks.message(version))

    def _state(self, world: ArmWorld, hand: FloatArray) -> bytes:
        away = {point.name: float(np.linalg.norm(point.pose[:3, 3] - hand)) for point in self._checkpoints}
        nearest = min(away, key=lambda name: away[name])
        facts = [
            ["reached", f"{len(self._reached)} of {len(self._checkpoints)} checkpoints"],
            ["nearest", f"{nearest}, {away[nearest]:.3f} m away"],
            ["touches", self._touching or FREE],
            ["joints", in_degrees(world.joints())],
        ]
        lines: List[Line] = self._trace.lines()
        if world.motion is not None:
            lines.append(Line("path", HAND, hand_way(world.motion)))
        poses: Dict[str, Pose] = {**world.link_frames(), FLOOR: (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)}
        words = words_of(self._reel.at_s(world.time_s), f"youBot's arm: {self._title}", facts)
        return state_message(words, self._scene, self._task, poses, None, lines)


def scene_of(scene: ArmScene) -> Scene:
    """The arm's links and its obstacles, of the solids that the physics knows."""
    _, model = arm_description()
    root = model.rigid_group("arm_link_0")[0]
    return Scene(
        [
            BodyDrawing(ARM, "Mobile", "dynamic", root, [(solid.link, solid) for solid in model.solids]),
            *(BodyDrawing(o.name, "Obstacle", "static", FLOOR, [(FLOOR, o.solid)]) for o in scene.obstacles),
        ],
        around=AROUND,
    )
