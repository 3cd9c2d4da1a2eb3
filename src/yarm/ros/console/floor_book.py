"""What is known of the youBot on its floor from its messages."""

from __future__ import annotations

import math
from typing import Callable, Dict, List, Optional

import numpy as np
from nav_msgs.msg import Path

from yarm.console.cell import Part
from yarm.console.floor_film import LOW_M, floor_facts
from yarm.console.picture import Line, Scene, state_message
from yarm.console.reel import HAND, HandTrace, words_of
from yarm.console.room import Marks
from yarm.console.trails import Trails
from yarm.msg import ObjectRegistry, SafetyStatus, YoubotStatus
from yarm.robots.youbot import NAME
from yarm.ros.common import names
from yarm.ros.common.checks import registry_fault
from yarm.ros.common.clock import JUMP_BACK_S
from yarm.ros.console.cell_words import drawing_of, finite, safety_words
from yarm.ros.console.newest import Newest
from yarm.ros.console.routes import Route
from yarm.ros.console.transforms import PoseBook
from yarm.sim.scenes.youbot_floor import BASE_FRAME, CUP_FRAME

FIRST_VERSION = 2_000_000
"""Of its scenes: not those of a cell or a room, which the same page may have seen before."""
STATUS, WAY = names.youbot("status"), names.youbot("hand_path")


class FloorBook:
    """Takes in the youBot's messages and draws what was heard last. Not thread-safe."""

    def __init__(self, poses: PoseBook, warn: Callable[[str], None]) -> None:
        """Nothing is known yet.

        Args:
            poses: of all frames.
            warn: takes a line about a message that cannot be used.
        """
        self._poses, self._warn = poses, warn
        self._newest = Newest()
        self._trails, self._trace, self._last_s = Trails(), HandTrace(), -math.inf
        self._version, self._scene = FIRST_VERSION, Scene()
        self._parts = self._drawn()
        kinds = {STATUS: YoubotStatus, WAY: Path, names.SAFETY_STATUS: SafetyStatus}
        self._routes = self._newest.routes(kinds)
        self._routes[names.OBJECT_REGISTRY] = Route(ObjectRegistry, self._on_registry)

    @property
    def active(self) -> bool:
        """The youBot has been heard."""
        return self._newest.get(STATUS) is not None

    def routes(self) -> Dict[str, Route]:
        """What it listens to."""
        return self._routes

    def heard(self, topic: str, now_s: float, wall_s: float) -> None:
        """A message of a topic came, at a simulated time and at one of a clock on the wall, s."""
        self._newest.came(topic, now_s, wall_s)

    def parts(self) -> Dict[str, Part]:
        """Bodies; marks there are none, nor any that another task has left."""
        return self._parts

    def state(self, now_s: float, wall_s: float) -> bytes:
        """Everything else, at a simulated time and at one of a clock on the wall, s."""
        if now_s < self._last_s - JUMP_BACK_S:
            self._trails, self._trace = Trails(), HandTrace()
        self._last_s = now_s
        poses = self._poses.newest()
        if BASE_FRAME in poses:
            self._trails.follow(NAME, poses[BASE_FRAME][0], poses[BASE_FRAME][1])
        if CUP_FRAME in poses:
            self._trace.follow(np.array(poses[CUP_FRAME][:3]))
        silence = self._newest.silence(STATUS, f"on {STATUS}", now_s, wall_s)
        status: YoubotStatus = self._newest.get(STATUS, YoubotStatus())
        words = {
            **words_of(
                round(now_s, 3), f"youBot: {'clears its floor' if status.clearing else 'commanded'}", facts_of(status)
            ),
            **safety_words(self._newest.get(names.SAFETY_STATUS)),
            "silent": [silence] if silence else [],
            "real_time_factor": finite(status.real_time_factor) if status.real_time_factor > 0.0 else None,
        }
        lines = [*self._trails.lines(LOW_M), *self._trace.lines(), *self._ahead(status)]
        return state_message(words, self._scene, self._version, poses, None, lines)

    def _on_registry(self, message: ObjectRegistry) -> None:
        if registry_fault(message):
            return  # the cell's book, which hears the same, says so
        self._version += 1
        self._scene = Scene([drawing_of(entry) for entry in message.entries])
        self._parts = self._drawn()

    def _drawn(self) -> Dict[str, Part]:
        version = self._version
        return {
            "scene": Part(version, self._scene.message(version)),
            "marks": Part(FIRST_VERSION, Marks().message(FIRST_VERSION)),
        }

    def _ahead(self, status: YoubotStatus) -> List[Line]:
        """The hand's way in the motion that is under way."""
        message: Optional[Path] = self._newest.get(WAY)
        if message is None or status.left <= 0.0 or len(message.poses) < 2:
            return []
        at = [pose.pose.position for pose in message.poses]
        points = np.array([(p.x, p.y, p.z) for p in at])
        return [Line("path", HAND, points)] if np.all(np.isfinite(points)) else []


def facts_of(status: YoubotStatus) -> List[List[str]]:
    """What the youBot says of itself, as names and values."""
    joints = np.array(status.joints)
    facts = [
        ["does", status.doing],
        ["motion", f"{status.left:.1f} s left" if status.left > 0.0 else "stands"],
        *floor_facts(status.in_bin, status.held, status.press, joints if np.all(np.isfinite(joints)) else np.zeros(0)),
        ["refused", status.refused],
        ["touched", "; ".join(status.touches)],
    ]
    return [fact for fact in facts if fact[1]]
