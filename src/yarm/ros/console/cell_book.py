"""What is known of a cell from its messages, live or recorded; only the newest of each is kept."""

from __future__ import annotations

import math
from typing import Callable, Dict, List, Mapping, Optional, Sequence, Tuple

import rospy
from visualization_msgs.msg import MarkerArray

from yarm.console.cell import Part
from yarm.console.foresight import Foresight
from yarm.console.picture import Area, Scene, state_message
from yarm.console.trails import Trails
from yarm.geometry import CellMap
from yarm.geometry.kinds import ObjectKind
from yarm.msg import CommanderStatus, MapMetaData, ObjectRegistry, PlanReport, SafetyStatus, SimStatus
from yarm.ros.common import names
from yarm.ros.common.checks import registry_fault
from yarm.ros.common.clock import JUMP_BACK_S
from yarm.ros.common.conversions import parse_map_metadata
from yarm.ros.common.status_age import STALE_S
from yarm.ros.console.cell_words import (
    cameras,
    commander_words,
    drawing_of,
    people_discs,
    safety_words,
    server_words,
    speed_words,
    ways_ahead,
)
from yarm.ros.console.newest import Newest
from yarm.ros.console.robots import RobotBook
from yarm.ros.console.routes import Route
from yarm.ros.console.transforms import PoseBook

DRIVEN_M = 0.02
"""Height at which ways behind are drawn, metres."""
SENDERS = {
    names.COMMANDER_STATUS: names.COMMANDER_NODE,
    names.SAFETY_STATUS: names.SAFETY_NODE,
    names.PLANNING_METADATA: "perception",
    names.SIM_STATUS: "simulation",
}
"""Topics that are missed when nothing comes, and whose they are."""
OF_ROOMS_TOO = (names.SIM_STATUS, names.SAFETY_STATUS)
KEPT = {
    names.COMMANDER_STATUS: CommanderStatus,
    names.SAFETY_STATUS: SafetyStatus,
    names.SIM_STATUS: SimStatus,
    names.PLAN_REPORT: PlanReport,
    names.PLANNING_METADATA: MapMetaData,
    names.SAFETY_PEOPLE: MarkerArray,
}


class CellBook:
    """Takes in a cell's messages and draws what was heard last. Not thread-safe."""

    def __init__(
        self, poses: PoseBook, areas: Callable[[Sequence[str]], List[Area]], warn: Callable[[str], None]
    ) -> None:
        """Nothing is known yet.

        Args:
            poses: of all frames.
            areas: the private areas of manipulators, by their names.
            warn: takes a line about a message that cannot be used.
        """
        self._poses, self._areas, self._warn = poses, areas, warn
        self._newest = Newest()
        self._clock: Optional[Tuple[float, float]] = None
        self._scene, self._version = Scene(), 0
        self._scene_part = Part(0, self._scene.message(0))
        self._map: Tuple[Optional[bytes], Optional[CellMap]] = (None, None)
        self._trails, self._last_s = Trails(), -math.inf
        self._robots, self._foresight = RobotBook(), Foresight()
        self._mobiles: List[str] = []
        self._routes: Mapping[str, Route] = {}
        self._route()

    @property
    def active(self) -> bool:
        """Something has been heard that only a cell has."""
        return self._version > 0 or any(self._newest.has_come(topic) for topic in SENDERS if topic not in OF_ROOMS_TOO)

    def routes(self) -> Mapping[str, Route]:
        """What it wants to hear now, by topic."""
        return self._routes

    def heard(self, topic: str, now_s: float, wall_s: float) -> None:
        """A message of a topic came, at a simulated time and at one of a clock on the wall, s."""
        self._newest.came(topic, now_s, wall_s)

    def parts(self) -> Dict[str, Part]:
        """Bodies and cameras."""
        return {"scene": self._scene_part}

    def state(self, now_s: float, wall_s: float) -> bytes:
        """Everything else.

        Args:
            now_s: simulated time, s.
            wall_s: a clock on the wall that never goes backwards, s.
        """
        poses = self._poses.newest()
        silent = self._silences(now_s, wall_s)
        if now_s < self._last_s - JUMP_BACK_S:
            self._trails.clear()
            self._robots.clear()
            self._foresight.clear()
        self._last_s = now_s
        for name in self._mobiles:
            at = poses.get(names.ee_frame(name))
            if at is not None:
                self._trails.follow(name, at[0], at[1])
        cell_map = self._read_map(self._newest.get(names.PLANNING_METADATA))
        lines = self._trails.lines(DRIVEN_M) + self._robots.lines(poses, self._scene.bodies)
        lines += people_discs(self._people(now_s))
        if cell_map is not None:
            lines += self._foresight.lines(cell_map)
            lines += ways_ahead(self._newest.get(names.PLAN_REPORT), cell_map.spec)
        servers = {name: self._newest.last(topic) for name, topic in self._robots.servers().items()}
        words = {
            "time_s": round(now_s, 3),
            "silent": silent,
            "arms": self._robots.arms(),
            "servers": server_words(servers, wall_s, now_s),
            **commander_words(self._newest.get(names.COMMANDER_STATUS)),
            **safety_words(self._newest.get(names.SAFETY_STATUS)),
            **speed_words(self._newest.get(names.SIM_STATUS)),
        }
        return state_message(words, self._scene, self._version, poses, cell_map, lines)

    def _people(self, now_s: float) -> Optional[MarkerArray]:
        """What was said of people, unless that is old."""
        _, said_s = self._newest.last(names.SAFETY_PEOPLE)
        return self._newest.get(names.SAFETY_PEOPLE) if abs(now_s - said_s) <= STALE_S else None

    def _route(self) -> None:
        self._routes = {
            **self._newest.routes(KEPT, raw=[MapMetaData]),
            names.OBJECT_REGISTRY: Route(ObjectRegistry, self._on_registry),
            **self._robots.routes(),
        }

    def _silences(self, now_s: float, wall_s: float) -> List[str]:
        """Who is not heard at a simulated time, s, and for how long: of a slow simulator's time, not of ours."""
        said = []
        if self._clock is None or now_s != self._clock[1]:
            self._clock = (wall_s, now_s)
        stands_s = wall_s - self._clock[0]
        if stands_s > STALE_S:
            said.append(f"simulated time stands still for {stands_s:.0f} s: what is shown is old")
        for topic, sender in SENDERS.items():
            if not self._newest.has_come(topic):
                said.append(f"nothing heard from {sender} yet ({topic}); is it running?")
                continue
            silence = self._newest.silence(topic, f"from {sender} ({topic})", now_s, wall_s)
            if silence:
                said.append(silence)
        return said

    def _read_map(self, message: Optional[rospy.AnyMsg]) -> Optional[CellMap]:
        """The newest map, read when it is drawn; of a faulty one the picture before stays."""
        if message is not None and message._buff is not self._map[0]:
            try:
                self._map = (message._buff, parse_map_metadata(message._buff))
            except ValueError as error:
                self._map = (message._buff, self._map[1])
                self._warn(str(error))
        return self._map[1]

    def _on_registry(self, message: ObjectRegistry) -> None:
        fault = registry_fault(message)
        if fault:
            self._warn(f"{names.OBJECT_REGISTRY} is left out: {fault}")
            return
        self._mobiles = [entry.name for entry in message.entries if entry.object == ObjectKind.MOBILE]
        arms = [entry.name for entry in message.entries if entry.object == ObjectKind.MANIPULATOR]
        self._scene, self._version = (
            Scene([drawing_of(entry) for entry in message.entries], cameras(), self._areas(arms)),
            self._version + 1,
        )
        self._scene_part = Part(self._version, self._scene.message(self._version))
        self._robots.follow(self._mobiles, arms)
        self._route()
