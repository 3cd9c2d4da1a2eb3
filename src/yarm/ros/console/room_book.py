"""What is known of a robot in a room from its messages: map, place, particles, ways, boxes with verdicts."""

from __future__ import annotations

import math
from typing import Any, Callable, Dict, List, Optional, Tuple

import numpy as np
from geometry_msgs.msg import PoseArray
from nav_msgs.msg import OccupancyGrid, Path
from sensor_msgs.msg import LaserScan
from visualization_msgs.msg import Marker, MarkerArray

from yarm.console.cell import Part
from yarm.console.picture import BodyDrawing, Line, Scene, state_message
from yarm.console.room import Marks, RoomMap
from yarm.console.trails import Trails
from yarm.geometry import FloatArray, quaternion_from_rpy, transform_matrix, transform_points, yaw_of_quaternion
from yarm.geometry.solids import Shape, Solid
from yarm.msg import ExplorerStatus, InspectionStatus, SafetyStatus, SimStatus, TagVerdict
from yarm.robots.turtlebot import BODY_BOTTOM_M, BODY_TOP_M, HEIGHT_M, RADIUS_M, TYPE
from yarm.ros.common import names
from yarm.ros.console.cell_words import finite, safety_words, speed_words
from yarm.ros.console.newest import Newest
from yarm.ros.console.routes import Route
from yarm.ros.console.transforms import PoseBook

LOW_M = 0.02
"""Height at which ways, particles and scans are drawn, metres."""
LARGEST_MAP = 4_000_000
"""Cells of a map that is drawn, at most."""
MOST_PARTICLES = 2000
BEAMS = 2
"""Of the beams of a scan that met something every so many-th is drawn."""
MARKED = (names.explorer("frontiers"), names.explorer("bumps"), names.explorer("view"), names.inspector("markers"))
WAYS = (names.explorer("plan"), names.move_base("NavfnROS/plan"))
STATUSES = {names.explorer("status"): ExplorerStatus, names.inspector("status"): InspectionStatus}
SHAPES = {Marker.CUBE: Shape.BOX, Marker.SPHERE: Shape.SPHERE, Marker.CYLINDER: Shape.CYLINDER}
TAGS = {TagVerdict.BLANK: "blank", TagVerdict.UNKNOWN: "unknown", TagVerdict.NONE: "no verdict"}
FIRST_VERSION = 1_000_000
"""Of its scene: not one of a cell's, which the same page may have seen before."""


class RoomBook:
    """Takes in a room's messages and draws what was heard last. Not thread-safe."""

    def __init__(self, poses: PoseBook, warn: Callable[[str], None]) -> None:
        """Nothing is known yet.

        Args:
            poses: of all frames.
            warn: takes a line about a message that cannot be used.
        """
        self._poses, self._warn = poses, warn
        self._newest = Newest()
        self._markers: Dict[str, Dict[Tuple[str, int], Marker]] = {topic: {} for topic in MARKED}
        self._maps: Dict[str, RoomMap] = {}
        self._trails = Trails()
        self._versions = {"map": 0, "marks": 0}
        self._parts: Dict[str, Part] = {}
        self._scene = Scene([turtlebot()])
        self._scene_part = Part(FIRST_VERSION, self._scene.message(FIRST_VERSION))
        self._last_s = -math.inf
        kept: Dict[str, Any] = {
            names.SCAN: LaserScan,
            names.PARTICLE_CLOUD: PoseArray,
            names.SIM_STATUS: SimStatus,
            names.SAFETY_STATUS: SafetyStatus,
            **dict.fromkeys(WAYS, Path),
            **STATUSES,
        }
        self._routes = self._newest.routes(kept)
        self._routes.update({topic: Route(MarkerArray, self._marker(topic)) for topic in MARKED})
        for topic in (names.MAP, names.explorer("map")):
            self._routes[topic] = Route(OccupancyGrid, self._mapped(topic))

    @property
    def active(self) -> bool:
        """Something has been heard that only a room has."""
        return bool(self._maps) or any(self._newest.get(topic) is not None for topic in STATUSES)

    def routes(self) -> Dict[str, Route]:
        """What it listens to."""
        return self._routes

    def heard(self, topic: str, now_s: float, wall_s: float) -> None:
        """A message of a topic came, at a simulated time and at one of a clock on the wall, s."""
        self._newest.came(topic, now_s, wall_s)

    def parts(self) -> Dict[str, Part]:
        """Robot, map, marks."""
        for name, make in (("map", self._map_part), ("marks", self._marks_part)):
            known = self._parts.get(name)
            if known is None or known.version != self._versions[name]:
                made = make(self._versions[name])
                if made is not None:
                    self._parts[name] = Part(self._versions[name], made)
        return {"scene": self._scene_part, **self._parts}

    def state(self, now_s: float, wall_s: float) -> bytes:
        """Everything else, at a simulated time and at one of a clock on the wall, s."""
        if now_s < self._last_s:
            self._trails.clear()
        self._last_s = now_s
        at = self._poses.matrix(names.MAP_FRAME, names.BASE_FOOTPRINT)
        poses = {}
        if at is not None:
            yaw = math.atan2(at[1, 0], at[0, 0])
            poses[names.BASE_FOOTPRINT] = (*at[:3, 3].tolist(), *quaternion_from_rpy(0.0, 0.0, yaw).tolist())
            self._trails.follow(TYPE, float(at[0, 3]), float(at[1, 3]))
        words = {
            "time_s": round(now_s, 3),
            "silent": self._silences(now_s, wall_s),
            "commander": None,
            "buttons": [],
            "tasks": [],
            **safety_words(self._newest.get(names.SAFETY_STATUS)),
            "arms": [],
            "room": self._words(),
            **speed_words(self._newest.get(names.SIM_STATUS)),
        }
        lines = [*self._trails.lines(LOW_M), *self._ways(), *self._particles(), *self._scan()]
        return state_message(words, self._scene, FIRST_VERSION, poses, None, lines)

    def _marker(self, topic: str) -> Callable[[MarkerArray], None]:
        """Of each name space and number the newest marker, until it is deleted."""

        def take(message: MarkerArray) -> None:
            known = self._markers[topic]
            for each in message.markers:
                if each.action == Marker.DELETEALL:
                    known.clear()
                elif each.action == Marker.DELETE:
                    known.pop((each.ns, each.id), None)
                else:
                    known[each.ns, each.id] = each
            self._versions["marks"] += 1

        return take

    def _mapped(self, topic: str) -> Callable[[OccupancyGrid], None]:
        def take(message: OccupancyGrid) -> None:
            height, width = message.info.height, message.info.width
            if not 0 < height * width == len(message.data) <= LARGEST_MAP:
                self._warn(
                    f"{topic} is left out: {width} x {height} cells, {len(message.data)} values; at most {LARGEST_MAP}"
                )
                return
            at, turn = message.info.origin.position, message.info.origin.orientation
            cells = np.array(message.data, np.int8).reshape(height, width)
            origin = (at.x, at.y, yaw_of_quaternion((turn.x, turn.y, turn.z, turn.w)))
            self._maps[topic] = RoomMap(cells, float(message.info.resolution), origin)
            self._versions["map"] += 1

        return take

    def _map_part(self, version: int) -> Optional[bytes]:
        """The explorer's map has what is too low for the scan; without one the other."""
        found = self._maps.get(names.explorer("map"), self._maps.get(names.MAP))
        return None if found is None else found.message(version)

    def _marks_part(self, version: int) -> bytes:
        marks = Marks()
        for topic in MARKED:
            for each in self._markers[topic].values():
                if each.header.frame_id.lstrip("/") == names.MAP_FRAME:
                    draw(marks, each)
        return marks.message(version)

    def _ways(self) -> List[Line]:
        found = []
        for topic in WAYS:
            message = self._newest.get(topic)
            points = [] if message is None else [(p.pose.position.x, p.pose.position.y, LOW_M) for p in message.poses]
            if len(points) > 1:
                found.append(Line("path", TYPE, np.array(points)))
        return found

    def _particles(self) -> List[Line]:
        message = self._newest.get(names.PARTICLE_CLOUD)
        if message is None or not message.poses:
            return []
        step = max(1, len(message.poses) // MOST_PARTICLES)
        return [Line("particles", TYPE, np.array([(p.position.x, p.position.y, LOW_M) for p in message.poses[::step]]))]

    def _scan(self) -> List[Line]:
        message = self._newest.get(names.SCAN)
        at = None if message is None else self._poses.matrix(names.MAP_FRAME, message.header.frame_id.lstrip("/"))
        if message is None or at is None:
            return []
        ranges = np.array(message.ranges)
        angles = message.angle_min + message.angle_increment * np.arange(len(ranges))
        hit = np.isfinite(ranges) & (ranges >= message.range_min) & (ranges <= message.range_max)
        flat = np.column_stack([ranges * np.cos(angles), ranges * np.sin(angles), np.zeros(len(ranges))])[hit][::BEAMS]
        return [Line("scan", TYPE, transform_points(at, flat))] if len(flat) else []

    def _words(self) -> Dict[str, Any]:
        """What the mission says of itself, as names and values, and the verdicts on boxes."""
        explorer: Optional[ExplorerStatus] = self._newest.get(names.explorer("status"))
        inspector: Optional[InspectionStatus] = self._newest.get(names.inspector("status"))
        if inspector is not None:
            return inspection_words(inspector)
        return {"title": "Room", "facts": [], "verdicts": []} if explorer is None else exploration_words(explorer)

    def _silences(self, now_s: float, wall_s: float) -> List[str]:
        topics = (*STATUSES, names.SCAN, names.SAFETY_STATUS)
        said = [self._newest.silence(topic, f"on {topic}", now_s, wall_s) for topic in topics]
        return [silence for silence in said if silence]


def turtlebot() -> BodyDrawing:
    """The robot of the rooms: its body and the plates above."""
    body = transform_matrix((0.0, 0.0, 0.5 * (BODY_BOTTOM_M + BODY_TOP_M)), (0.0, 0.0, 0.0, 1.0))
    plates = transform_matrix((0.0, 0.0, 0.5 * (BODY_TOP_M + HEIGHT_M)), (0.0, 0.0, 0.0, 1.0))
    nose = transform_matrix((0.8 * RADIUS_M, 0.0, HEIGHT_M), (0.0, 0.0, 0.0, 1.0))
    solids = (
        Solid(Shape.CYLINDER, (RADIUS_M, BODY_TOP_M - BODY_BOTTOM_M), body),
        Solid(Shape.CYLINDER, (0.8 * RADIUS_M, HEIGHT_M - BODY_TOP_M), plates),
        Solid(Shape.BOX, (0.4 * RADIUS_M, 0.2 * RADIUS_M, 0.1 * RADIUS_M), nose),
    )
    frame = names.BASE_FOOTPRINT
    return BodyDrawing(TYPE, "Mobile", "dynamic", frame, [(frame, solid) for solid in solids])


def draw(marks: Marks, marker: Marker) -> None:
    """A marker as far as a page can show it: solids, lines, arrows, words."""
    at, turn = marker.pose.position, marker.pose.orientation
    quaternion = (turn.x, turn.y, turn.z, turn.w)
    pose = transform_matrix((at.x, at.y, at.z), quaternion if any(quaternion) else (0.0, 0.0, 0.0, 1.0))
    colour = (marker.color.r, marker.color.g, marker.color.b, marker.color.a)
    size = (marker.scale.x, marker.scale.y, marker.scale.z)
    points: FloatArray = np.array([(p.x, p.y, p.z) for p in marker.points], dtype=float).reshape(-1, 3)
    if not all(np.isfinite(part).all() for part in (pose, np.array(colour), np.array(size), points)):
        return
    if marker.type in SHAPES and min(size) > 0.0:
        marks.solid(str(SHAPES[marker.type]), pose, size, colour)
    elif marker.type == Marker.TEXT_VIEW_FACING and marker.text:
        marks.text(marker.text, (at.x, at.y, at.z))
    elif marker.type in (Marker.LINE_STRIP, Marker.ARROW) and len(points) > 1:
        marks.line(transform_points(pose, points), colour)


def exploration_words(said: ExplorerStatus) -> Dict[str, Any]:
    """What an explorer says."""
    facts = [
        ("state", f"{said.state}, {said.behaviour}" if said.behaviour else said.state),
        ("time left", f"{said.left:.0f} s"),
        ("known", f"{said.known_m2:.1f} m\u00b2"),
        ("driven", f"{said.travelled:.1f} m"),
        ("bumps", str(said.bumps)),
        ("reason", said.reason),
        ("sick", "; ".join(said.sensors)),
        ("map saved", said.saved),
    ]
    return {"title": "Exploration", "facts": [list(fact) for fact in facts if fact[1]], "verdicts": []}


def inspection_words(said: InspectionStatus) -> Dict[str, Any]:
    """What an inspector says."""
    facts = [
        ("stage", f"{said.stage}, box {said.box}" if said.box else said.stage),
        ("time left", f"{said.left:.0f} s"),
        ("way home", f"{said.time_home:.0f} s"),
        ("reason", said.reason),
        ("sick", "; ".join(said.sensors)),
        ("results", said.saved),
    ]
    verdicts = [
        {
            "box": each.box,
            "tag": TAGS.get(each.tag, f"tag {each.tag}"),
            "probability": finite(each.probability),
            "finding": each.finding,
            "reason": each.reason,
        }
        for each in said.verdicts
    ]
    return {"title": "Inspection", "facts": [list(fact) for fact in facts if fact[1]], "verdicts": verdicts}
