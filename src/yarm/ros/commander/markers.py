"""Markers of the Commander: particles, waypoints, ways driven, masks, areas, seeds and the state as text.

Every picture is sent whole; markers of the last one that are not in the new one are deleted.
"""

from __future__ import annotations

import math
from typing import Dict, List, Mapping, Sequence, Tuple

import numpy as np
from visualization_msgs.msg import Marker

from yarm.commander.cell_state import CellState
from yarm.commander.events import ShowPlan
from yarm.commander.machine import Status
from yarm.geometry import FloatArray, GridSpec
from yarm.geometry.solids import Shape
from yarm.msg import RegisteredObject
from yarm.ros.common import names
from yarm.ros.common.pictures import WHITE, Color, Picture, marker, points, text
from yarm.ros.common.solids import solid_of

GREEN: Color = (0.1, 0.8, 0.1, 0.7)
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
SOLID_MARKERS: Mapping[Shape, int] = {
    Shape.BOX: Marker.CUBE,
    Shape.SPHERE: Marker.SPHERE,
    Shape.CYLINDER: Marker.CYLINDER,
}
"""A marker of that type is scaled by the full size of its bounding box."""
FLOOR_M = 0.02
WAYPOINT_M = 0.95
WORLD_PERIOD_S = 0.2
TRAIL_STEP_M = 0.05
TRAIL_LENGTH = 2000


def robot_color(robot: str, robots: Sequence[str]) -> Color:
    """The colour of one of several robots."""
    index = sorted(robots).index(robot) if robot in robots else 0
    return ROBOT_COLORS[index % len(ROBOT_COLORS)]


class MarkerBoard:
    """Draws ``particles_and_waypoints`` after each plan and ``maps_and_masks`` five times a second."""

    def __init__(self) -> None:
        """Advertise both topics."""
        self._plans = Picture(names.PARTICLES_AND_WAYPOINTS)
        self._cell = Picture(names.MAPS_AND_MASKS)
        self._trails: Dict[str, List[Tuple[float, float]]] = {}
        self._drawn_s = -math.inf
        self._bodies: List[Marker] = []

    def show_bodies(self, entries: Sequence[RegisteredObject]) -> None:
        """Draw the known solids of everything in the registry from now on, each in its own tf frame."""
        self._bodies = [made for entry in entries for made in solid_markers(entry)]

    def show_plan(self, shown: ShowPlan, cell: CellState) -> None:
        """Particles, graph and each robot's way ahead."""
        spec = shown.request.spec
        robots = sorted(cell.robots)
        made = self._particles(shown, spec)
        for name, plan in sorted(shown.plan.robots.items()):
            columns = np.array([w.column for w in plan.path], dtype=float).reshape(-1, 2)
            if len(columns):
                made += _way(f"{name}/waypoints", column_points(spec, columns, WAYPOINT_M), robot_color(name, robots))
        self._plans.send(made, cell.map.stamp_s if cell.map is not None else 0.0)

    def show_world(self, cell: CellState, status: Status, now_s: float) -> None:
        """Masks, seeds with names, areas, ways driven, the Commander's state; nothing to do when nobody looks."""
        self._follow(cell)
        if 0.0 <= now_s - self._drawn_s < WORLD_PERIOD_S or cell.map is None:
            return
        self._drawn_s = now_s
        if self._cell.publisher.get_num_connections() == 0:
            return
        made = [state_marker(status), *self._bodies]
        made += self._masks(cell) + self._seeds(cell) + self._private(cell) + self._driven(cell)
        self._cell.send(made, now_s)

    @staticmethod
    def _particles(shown: ShowPlan, spec: GridSpec) -> List[Marker]:
        particles = shown.plan.graph.particles
        if len(particles) == 0:
            return []
        at = column_points(spec, particles.astype(float), FLOOR_M)
        dots = marker("particles", Marker.SPHERE_LIST, GREEN, (0.04, 0.04, 0.04))
        dots.points = points(at)
        graph = marker("graph", Marker.LINE_LIST, (0.3, 0.6, 0.3, 0.25), (0.005, 0.0, 0.0))
        graph.points = points(at[shown.plan.graph.edges.astype(np.int64).ravel()])
        return [dots, graph] if graph.points else [dots]

    def _follow(self, cell: CellState) -> None:
        for name in [name for name in self._trails if name not in cell.robots]:
            del self._trails[name]
        for name, robot in cell.robots.items():
            trail = self._trails.setdefault(name, [])
            if not trail or math.hypot(robot.x - trail[-1][0], robot.y - trail[-1][1]) > TRAIL_STEP_M:
                trail.append((robot.x, robot.y))
                del trail[:-TRAIL_LENGTH]

    @staticmethod
    def _masks(cell: CellState) -> List[Marker]:
        assert cell.map is not None
        spec = cell.map.spec
        res = spec.resolution
        made = []
        for name, robot in sorted(cell.robots.items()):
            red, green, blue, _ = robot_color(name, list(cell.robots))
            cubes = marker(f"{name}/mask", Marker.CUBE_LIST, (red, green, blue, 0.25), (res[0], res[1], res[2]))
            cubes.points = points(spec.centres(robot.cells))
            made.append(cubes)
        return made

    @staticmethod
    def _seeds(cell: CellState) -> List[Marker]:
        assert cell.map is not None
        made = []
        for name, found in sorted(cell.map.objects.items()):
            dot = marker("seeds", Marker.SPHERE, (1.0, 1.0, 0.2, 0.9), (0.06, 0.06, 0.06))
            dot.pose.position.x, dot.pose.position.y, dot.pose.position.z = found.position_m
            x, y, z = found.position_m
            made += [dot, text("names", name, (x, y, z + 0.15), 0.1)]
        return made

    @staticmethod
    def _private(cell: CellState) -> List[Marker]:
        assert cell.map is not None
        spec = cell.map.spec
        columns = np.argwhere(cell.private_columns()).astype(float)
        if len(columns) == 0:
            return []
        area = marker("private_area", Marker.CUBE_LIST, PRIVATE, (spec.resolution[0], spec.resolution[1], 0.01))
        area.points = points(column_points(spec, columns, FLOOR_M / 2))
        return [area]

    def _driven(self, cell: CellState) -> List[Marker]:
        made = []
        for name, trail in sorted(self._trails.items()):
            if len(trail) > 1:
                line = marker(
                    f"{name}/driven", Marker.LINE_STRIP, robot_color(name, list(cell.robots)), (0.02, 0.0, 0.0)
                )
                line.points = points(np.column_stack([np.array(trail), np.full(len(trail), FLOOR_M)]))
                made.append(line)
        return made


def state_marker(status: Status) -> Marker:
    """Beside the cell: the Commander's state and its tasks, in the words of its message."""
    words = f"{int(status.state)} {status.state.name}{' busy' if status.busy else ''} {status.outcome.value}".rstrip()
    lines = [words] + ([status.reason] if status.reason else [])
    lines += [f"{t.robot or '-'} > {t.goal}: {t.status.value}" for t in status.tasks]
    return text("state", "\n".join(lines), (-2.3, -1.2, 1.9), 0.14)


def solid_markers(entry: RegisteredObject) -> List[Marker]:
    """An object's solids, moved by RViz itself with the frames they are fixed to."""
    color = BODY_COLORS.get(entry.object, WHITE)
    made = []
    for shape, pose, frame in zip(entry.shapes, entry.shape_poses, entry.shape_frames):
        solid = solid_of(shape, pose)
        if solid is None:
            continue
        x, y, z = (2.0 * float(half) for half in solid.half_extent)
        body = marker(f"bodies/{entry.name}", SOLID_MARKERS[solid.shape], color, (x, y, z))
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
