"""The sander's motions: free moves, the scan's sweep, the raster, lifting and coming down."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Sequence, Tuple

import numpy as np

from yarm.control.arm.collision import ArmCollision
from yarm.control.arm.errors import ArmError
from yarm.control.arm.model import ArmDescription, ArmKinematics, tool_pose
from yarm.control.arm.motion import ArmMotion, along_path, through_corners
from yarm.control.arm.planner import ArmPlanner
from yarm.control.sander.params import SanderParams
from yarm.control.sander.raster import Raster, lay_raster
from yarm.control.sander.surface import Surface, fit_surface
from yarm.geometry.grid import FloatArray

UP = np.array([0.0, 0.0, 1.0])
TOOL_YAW_RAD = 0.0
CAMERA_AHEAD_M = 0.085
LINE_STEP_M = 0.01
JUMP_RAD = 0.4
RASTER_MARGIN_M = 0.01


@dataclass(frozen=True, eq=False)
class RasterPlan:
    """A raster with the joints (n, 6), rad, at each point of each of its strokes."""

    surface: Surface
    raster: Raster
    joints: Tuple[FloatArray, ...]

    def point_at(self, arc_m: float) -> Tuple[FloatArray, FloatArray]:
        """Point (3,) and normal (3,) at a way from the start, metres."""
        stroke = next((s for s in self.raster.strokes if arc_m <= s.arc_m[-1] + 1e-9), self.raster.strokes[-1])
        point = np.array([np.interp(arc_m, stroke.arc_m, column) for column in stroke.points.T])
        normal = np.array([np.interp(arc_m, stroke.arc_m, column) for column in stroke.normals.T])
        return point, normal / np.linalg.norm(normal)

    def apart_m(self, one_m: float, other_m: float) -> float:
        """Straight distance between the points at two ways from the start, metres."""
        return float(np.linalg.norm(self.point_at(one_m)[0] - self.point_at(other_m)[0]))


class SanderPlanner:
    """Computes motions; keeps no state of the arm. Not thread-safe."""

    def __init__(self, arm: ArmDescription, params: SanderParams) -> None:
        """Build kinematics and collision model.

        Args:
            arm: the description.
            params: heights, speeds, margins.
        """
        self.arm = arm
        self.kinematics = ArmKinematics(arm)
        self.collision = ArmCollision(arm)
        self._params = params
        self._moves = ArmPlanner(self.collision, arm.limits, params.margin_m, params.seed)
        self._ready = np.array(params.ready_pose)

    def to_storage(self, q: FloatArray) -> ArmMotion:
        """Free move home."""
        return self.free_move(q, self.arm.storage)

    def to_scan(self, q: FloatArray) -> ArmMotion:
        """Free move to where the sweep begins."""
        return self.free_move(q, self._joints_at(self._scan_ends()[0], UP))

    def to_hover(self, q: FloatArray) -> ArmMotion:
        """Free move to above the part's centre."""
        return self.free_move(q, self._joints_at(self._hover_point(), UP))

    def free_move(self, q: FloatArray, goal: FloatArray) -> ArmMotion:
        """Collision-free move between two configurations."""
        corners = self._moves.plan(q, goal, self._params.planning_limit_s)
        return through_corners(corners, self.arm.limits, self._params.joint_share, self._params.joint_acceleration)

    def sweep(self, q: FloatArray) -> ArmMotion:
        """Straight over the part, the camera looking down."""
        start, end = self._scan_ends()
        return self._line([start, end], [UP, UP], q, self._params.scan_speed_mps)

    def raster(self, scan: FloatArray) -> RasterPlan:
        """Surface, passes and joints from the scan's points (n, 3), metres, world."""
        surface = fit_surface(scan, self._params.part_least_area_m2)
        raster = lay_raster(surface, self._params.spacing_m, self._params.inset_m, self._params.standoff_m)
        guess = self._joints_at(raster.strokes[0].points[0], raster.strokes[0].normals[0])
        joints = []
        for stroke in raster.strokes:
            solved = self._path(stroke.points, stroke.normals, guess, sanding=True)
            guess = solved[-1]
            joints.append(solved)
        return RasterPlan(surface, raster, tuple(joints))

    def stroke_from(self, plan: RasterPlan, arc_m: float, end_m: float = math.inf) -> ArmMotion:
        """Sanding from a way along the raster to the end of the stroke it lies in, or before, from rest to rest."""
        pieces = zip(plan.raster.strokes, plan.joints)
        found = next(((s, q) for s, q in pieces if arc_m < s.arc_m[-1] - 1e-4), None)
        if found is None:
            raise ArmError(f"the raster ends at {plan.raster.length_m:.3f} m, before {arc_m:.3f} m")
        stroke, joints = found
        end_m = min(end_m, float(stroke.arc_m[-1]))
        between = (stroke.arc_m > arc_m + 1e-4) & (stroke.arc_m < end_m - 1e-4)
        arcs = np.concatenate([[arc_m], stroke.arc_m[between], [end_m]])
        return along_path(
            np.column_stack([np.interp(arcs, stroke.arc_m, column) for column in joints.T]),
            arcs,
            self._params.sanding_speed_mps,
            self._params.sanding_acceleration_mps2,
            self.arm.limits,
        )

    def come_down(self, q: FloatArray, plan: RasterPlan, arc_m: float) -> ArmMotion:
        """From a hover to a point of the raster: over it first, then along its normal."""
        point, normal = plan.point_at(arc_m)
        tip = self.kinematics.tip(q)
        above = self._above(point, normal)
        points = [tip[:3, 3], above, point] if tip[2, 3] > point[2] + 0.05 else [tip[:3, 3], point]
        normals = [-tip[:3, 2], normal, normal] if len(points) > 2 else [-tip[:3, 2], normal]
        return self._line(points, normals, q, self._params.approach_speed_mps, sanding=True)

    def hover_over(self, q: FloatArray, plan: RasterPlan, arc_m: float) -> ArmMotion:
        """From a hover to the one over a point of the raster."""
        point, normal = plan.point_at(arc_m)
        tip = self.kinematics.tip(q)
        points, normals = [tip[:3, 3], self._above(point, normal)], [-tip[:3, 2], normal]
        return self._line(points, normals, q, self._params.approach_speed_mps, sanding=True)

    def lift(self, q: FloatArray) -> ArmMotion:
        """Up along the tool's axis to the hover's height; already there, a motion of no length."""
        tip = self.kinematics.tip(q)
        normal = -tip[:3, 2]
        top = self._above(tip[:3, 3], normal)
        return self._line([tip[:3, 3], top], [normal, normal], q, self._params.approach_speed_mps, sanding=True)

    def _above(self, point: FloatArray, normal: FloatArray) -> FloatArray:
        rise = max(self._params.hover_height_m - float(point[2]), 0.0)
        above: FloatArray = point + normal * (rise / max(float(normal[2]), 0.5))
        return above

    def _hover_point(self) -> FloatArray:
        x, y = self._params.part_centre_m
        return np.array([x, y, self._params.hover_height_m])

    def _scan_ends(self) -> Tuple[FloatArray, FloatArray]:
        x, y = self._params.part_centre_m
        half, z = 0.5 * self._params.scan_reach_m, self._params.scan_height_m
        return np.array([x - CAMERA_AHEAD_M, y - half, z]), np.array([x - CAMERA_AHEAD_M, y + half, z])

    def _joints_at(self, point: FloatArray, normal: FloatArray) -> FloatArray:
        q = self.kinematics.solve(tool_pose(point, normal, TOOL_YAW_RAD), self._ready)
        if q is None:
            raise ArmError(f"the tip cannot reach {_words(point)} m with the tool along {_words(-normal)}")
        return q

    def _line(
        self,
        points: Sequence[FloatArray],
        normals: Sequence[FloatArray],
        q: FloatArray,
        speed_mps: float,
        sanding: bool = False,
    ) -> ArmMotion:
        """The tip along straight pieces, from the joints it has now."""
        dense_points, dense_normals = _dense(points, normals)
        arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(dense_points, axis=0), axis=1))])
        if arc[-1] < 1e-3:
            return ArmMotion(np.zeros(1), q[None, :], np.zeros(1))
        joints = self._path(dense_points[1:], dense_normals[1:], q, sanding)
        acceleration = 2.0 * self._params.sanding_acceleration_mps2
        return along_path(np.vstack([q, joints]), arc, speed_mps, acceleration, self.arm.limits)

    def _path(self, points: FloatArray, normals: FloatArray, guess: FloatArray, sanding: bool) -> FloatArray:
        """Joints (n, 6) along points; free, within limits, without jumps.

        Raises:
            ArmError: naming the first pose that fails, and why.
        """
        margin = RASTER_MARGIN_M if sanding else self._params.margin_m
        solved: List[FloatArray] = []
        for point, normal in zip(points, normals):
            q = self.kinematics.solve(tool_pose(point, normal, TOOL_YAW_RAD), guess)
            if q is None:
                raise ArmError(f"the tip cannot reach {_words(point)} m with the tool along {_words(-normal)}")
            if np.max(np.abs(q - guess)) > JUMP_RAD and solved:
                raise ArmError(f"the arm would have to turn over at {_words(point)} m")
            clearance = self.collision.clearance(q, margin, sanding)
            if clearance.distance_m < margin:
                raise ArmError(
                    f"at {_words(point)} m {clearance.between} would be {clearance.distance_m:.3f} m apart, "
                    f"{margin:g} m is kept"
                )
            solved.append(q)
            guess = q
        return np.array(solved)


def _dense(points: Sequence[FloatArray], normals: Sequence[FloatArray]) -> Tuple[FloatArray, FloatArray]:
    """Points along the pieces, at most 1 cm apart, none twice, with normals in between."""
    dense_points, dense_normals = [np.asarray(points[0])], [np.asarray(normals[0])]
    for index in range(len(points) - 1):
        length = float(np.linalg.norm(points[index + 1] - points[index]))
        if length < 1e-6:
            continue
        for share in np.linspace(0.0, 1.0, max(math.ceil(length / LINE_STEP_M), 1) + 1)[1:]:
            dense_points.append(points[index] + share * (points[index + 1] - points[index]))
            normal = normals[index] + share * (normals[index + 1] - normals[index])
            dense_normals.append(normal / np.linalg.norm(normal))
    return np.array(dense_points), np.array(dense_normals)


def _words(vector: FloatArray) -> str:
    return "(" + ", ".join(f"{v:.3f}" for v in vector) + ")"
