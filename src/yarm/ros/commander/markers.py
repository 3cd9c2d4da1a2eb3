"""Markers of the Commander: particles, waypoints, ways driven, masks, areas, seeds and the state as text.

Every picture is sent whole; markers of the last one that are not in the new one are deleted.
"""

from __future__ import annotations

import math
from typing import Callable, Dict, List, Mapping, Sequence, Set, Tuple

import numpy as np
import rospy
from geometry_msgs.msg import Point
from shape_msgs.msg import SolidPrimitive
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from yarm.commander.machine import Status
from yarm.commander.messages import ShowPlan
from yarm.commander.world import World
from yarm.geometry import FloatArray, GridSpec
from yarm.msg import RegisteredObject
from yarm.ros import names

Color = Tuple[float, float, float, float]
GREEN: Color = (0.1, 0.8, 0.1, 0.7)
WHITE: Color = (1.0, 1.0, 1.0, 1.0)
PRIVATE: Color = (1.0, 0.6, 0.0, 0.15)
ROBOT_COLORS: Tuple[Color, ...] = (
    (0.12, 0.47, 0.71, 0.9),
    (1.0, 0.5, 0.05, 0.9),
    (0.58, 0.4, 0.74, 0.9),
    (0.89, 0.1, 0.6, 0.9),
    (0.55, 0.34, 0.29, 0.9),
    (0.09, 0.75, 0.81, 0.9),
)
BODY_COLORS: Mapping[str, Color] = {
    "Mobile": (0.75, 0.75, 0.8, 0.8),
    "Manipulator": (0.2, 0.45, 0.9, 0.8),
    "Obstacle": (0.55, 0.5, 0.45, 0.8),
    "Debris": (0.9, 0.2, 0.1, 1.0),
}
Size = Tuple[float, float, float]
SOLID_MARKERS: Mapping[int, Tuple[int, Callable[[Sequence[float]], Size]]] = {
    SolidPrimitive.BOX: (Marker.CUBE, lambda d: (d[0], d[1], d[2])),
    SolidPrimitive.SPHERE: (Marker.SPHERE, lambda d: (2 * d[0], 2 * d[0], 2 * d[0])),
    SolidPrimitive.CYLINDER: (Marker.CYLINDER, lambda d: (2 * d[1], 2 * d[1], d[0])),
}
FLOOR_M = 0.02
WAYPOINT_M = 0.95
WORLD_PERIOD_S = 0.2
TRAIL_STEP_M = 0.05
TRAIL_LENGTH = 2000
QUEUE = 2


def robot_color(robot: str, robots: Sequence[str]) -> Color:
    """The colour of one of several robots."""
    index = sorted(robots).index(robot) if robot in robots else 0
    return ROBOT_COLORS[index % len(ROBOT_COLORS)]


def marker(space: str, kind: int, color: Color, scale: Tuple[float, float, float]) -> Marker:
    """A marker at the world's origin; scale in metres."""
    made = Marker(type=kind, action=Marker.ADD, ns=space, color=ColorRGBA(*color))
    made.header.frame_id = names.WORLD_FRAME
    made.pose.orientation.w = 1.0
    made.scale.x, made.scale.y, made.scale.z = scale
    return made


def points(xyz: FloatArray) -> List[Point]:
    """Point messages of (n, 3) metres."""
    return [Point(x=float(x), y=float(y), z=float(z)) for x, y, z in xyz]


def text(space: str, words: str, at: Tuple[float, float, float], size_m: float) -> Marker:
    """White text that faces the camera."""
    made = marker(space, Marker.TEXT_VIEW_FACING, WHITE, (0.0, 0.0, size_m))
    made.text = words
    made.pose.position.x, made.pose.position.y, made.pose.position.z = at
    return made


class Picture:
    """The markers last sent on a topic, so that those no longer true can be deleted."""

    def __init__(self, topic: str) -> None:
        """Advertise, latched."""
        self.publisher = rospy.Publisher(topic, MarkerArray, queue_size=QUEUE, latch=True)
        self._shown: Set[Tuple[str, int]] = set()

    def send(self, markers: List[Marker], stamp_s: float) -> None:
        """Send a whole picture; markers of one namespace are numbered in order."""
        counts: Dict[str, int] = {}
        for made in markers:
            if made.header.frame_id == names.WORLD_FRAME:
                made.header.stamp = rospy.Time.from_sec(max(0.0, stamp_s))
            made.id = counts.get(made.ns, 0)
            counts[made.ns] = made.id + 1
        now = {(made.ns, made.id) for made in markers}
        gone = [Marker(ns=space, id=number, action=Marker.DELETE) for space, number in sorted(self._shown - now)]
        for made in gone:
            made.header.frame_id = names.WORLD_FRAME
        self._shown = now
        self.publisher.publish(MarkerArray(markers=[*gone, *markers]))


class MarkerBoard:
    """Draws ``particles_and_waypoints`` after each plan and ``maps_and_masks`` five times a second."""

    def __init__(self) -> None:
        """Advertise both topics."""
        self._plans = Picture(names.PARTICLES_AND_WAYPOINTS)
        self._world = Picture(names.MAPS_AND_MASKS)
        self._trails: Dict[str, List[Tuple[float, float]]] = {}
        self._drawn_s = -math.inf
        self._bodies: List[Marker] = []

    def show_bodies(self, entries: Sequence[RegisteredObject]) -> None:
        """Draw the known solids of everything in the registry from now on, each in its own tf frame."""
        self._bodies = [made for entry in entries for made in _solids(entry)]

    def show_plan(self, shown: ShowPlan, world: World) -> None:
        """Particles, graph and each robot's way ahead."""
        spec = shown.request.spec
        robots = sorted(world.robots)
        made = self._particles(shown, spec)
        for name, plan in sorted(shown.plan.robots.items()):
            columns = np.array([w.column for w in plan.path], dtype=float).reshape(-1, 2)
            if len(columns):
                made += _way(f"{name}/waypoints", column_points(spec, columns, WAYPOINT_M), robot_color(name, robots))
        self._plans.send(made, world.map.stamp_s if world.map is not None else 0.0)

    def show_world(self, world: World, status: Status, now_s: float) -> None:
        """Masks, seeds with names, areas, ways driven, the Commander's state; nothing to do when nobody looks."""
        self._follow(world)
        if 0.0 <= now_s - self._drawn_s < WORLD_PERIOD_S or world.map is None:
            return
        self._drawn_s = now_s
        if self._world.publisher.get_num_connections() == 0:
            return
        made = [self._state(status), *self._bodies]
        made += self._masks(world) + self._seeds(world) + self._private(world) + self._driven(world)
        self._world.send(made, now_s)

    @staticmethod
    def _particles(shown: ShowPlan, spec: GridSpec) -> List[Marker]:
        particles = shown.plan.particles
        if len(particles) == 0:
            return []
        at = column_points(spec, particles.astype(float), FLOOR_M)
        dots = marker("particles", Marker.SPHERE_LIST, GREEN, (0.04, 0.04, 0.04))
        dots.points = points(at)
        graph = marker("graph", Marker.LINE_LIST, (0.3, 0.6, 0.3, 0.25), (0.005, 0.0, 0.0))
        graph.points = points(at[shown.plan.edges.astype(np.int64).ravel()])
        return [dots, graph] if graph.points else [dots]

    def _follow(self, world: World) -> None:
        for name in [name for name in self._trails if name not in world.robots]:
            del self._trails[name]
        for name, robot in world.robots.items():
            trail = self._trails.setdefault(name, [])
            if not trail or math.hypot(robot.x - trail[-1][0], robot.y - trail[-1][1]) > TRAIL_STEP_M:
                trail.append((robot.x, robot.y))
                del trail[:-TRAIL_LENGTH]

    @staticmethod
    def _state(status: Status) -> Marker:
        words = f"{int(status.state)} {status.state.name}{' busy' if status.busy else ''} {status.outcome}".rstrip()
        lines = [words] + ([status.reason] if status.reason else [])
        lines += [f"{t.robot or '-'} > {t.goal}: {t.status}" for t in status.tasks]
        return text("state", "\n".join(lines), (-2.3, -1.2, 1.9), 0.14)

    @staticmethod
    def _masks(world: World) -> List[Marker]:
        assert world.map is not None
        spec = world.map.spec
        res = spec.resolution
        made = []
        for name, robot in sorted(world.robots.items()):
            red, green, blue, _ = robot_color(name, list(world.robots))
            cubes = marker(f"{name}/mask", Marker.CUBE_LIST, (red, green, blue, 0.25), (res[0], res[1], res[2]))
            cubes.points = points(spec.centers(robot.cells))
            made.append(cubes)
        return made

    @staticmethod
    def _seeds(world: World) -> List[Marker]:
        assert world.map is not None
        made = []
        for name, found in sorted(world.map.objects.items()):
            dot = marker("seeds", Marker.SPHERE, (1.0, 1.0, 0.2, 0.9), (0.06, 0.06, 0.06))
            dot.pose.position.x, dot.pose.position.y, dot.pose.position.z = found.position_m
            x, y, z = found.position_m
            made += [dot, text("names", name, (x, y, z + 0.15), 0.1)]
        return made

    @staticmethod
    def _private(world: World) -> List[Marker]:
        assert world.map is not None
        spec = world.map.spec
        columns = np.argwhere(world.private_columns()).astype(float)
        if len(columns) == 0:
            return []
        area = marker("private_area", Marker.CUBE_LIST, PRIVATE, (spec.resolution[0], spec.resolution[1], 0.01))
        area.points = points(column_points(spec, columns, FLOOR_M / 2))
        return [area]

    def _driven(self, world: World) -> List[Marker]:
        made = []
        for name, trail in sorted(self._trails.items()):
            if len(trail) > 1:
                line = marker(
                    f"{name}/driven", Marker.LINE_STRIP, robot_color(name, list(world.robots)), (0.02, 0.0, 0.0)
                )
                line.points = points(np.column_stack([np.array(trail), np.full(len(trail), FLOOR_M)]))
                made.append(line)
        return made


def _solids(entry: RegisteredObject) -> List[Marker]:
    """An object's solids, moved by RViz itself with the frames they are fixed to."""
    color = BODY_COLORS.get(entry.object, WHITE)
    made = []
    for shape, pose, frame in zip(entry.shapes, entry.shape_poses, entry.shape_frames):
        if shape.type not in SOLID_MARKERS:
            continue
        kind, size_of = SOLID_MARKERS[shape.type]
        body = marker(f"bodies/{entry.name}", kind, color, size_of(shape.dimensions))
        body.header.frame_id, body.pose, body.frame_locked = frame, pose, True
        made.append(body)
    return made


def column_points(spec: GridSpec, columns: FloatArray, height_m: float) -> FloatArray:
    """Points (n, 3) over the centres of columns (n, 2)."""
    xy = np.asarray(spec.lower[:2]) + (columns + 0.5) * spec.resolution[:2]
    return np.column_stack([xy, np.full(len(xy), height_m)])


def _way(space: str, at: FloatArray, color: Color) -> List[Marker]:
    dots = marker(space, Marker.SPHERE_LIST, color, (0.07, 0.07, 0.07))
    dots.points = points(at)
    if len(at) < 2:
        return [dots]
    line = marker(space, Marker.LINE_STRIP, color, (0.02, 0.0, 0.0))
    line.points = dots.points
    return [dots, line]
