"""The arm's motions at one stand: to a piece and down on it, up and away with it, over a bin, and back."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from functools import lru_cache
from typing import List, Optional, Sequence, Tuple

import numpy as np

from yarm.control.arm.errors import ArmError
from yarm.control.arm.planner import ArmPlanner
from yarm.geometry import FloatArray, Pose2, quaternion_from_rpy, transform_matrix, transform_points
from yarm.geometry.solids import Shape, Solid
from yarm.manipulation.clearing.reachability import CLEAR_M, T_BASE_ARM, base_solids, cup_poses, own_body, quality
from yarm.manipulation.kinematics.forward import forward_many
from yarm.manipulation.kinematics.inverse import inverse
from yarm.manipulation.motion.checkpoints import Obstacle
from yarm.manipulation.motion.tour import LineStatus, straight_line
from yarm.manipulation.motion.trajectory import Trajectory, arm_limits, stretched, through_waypoints
from yarm.manipulation.obstacles.collision import YoubotCollision, link_poses
from yarm.manipulation.obstacles.ways import joint_limits, timed_path
from yarm.robots.youbot import N_JOINTS, Joints

GRIP_M = (-0.015, 0.0, 0.02)
"""Where the cup takes a piece: on the flat middle of its grip, in the piece's frame."""
GRIP_UNDER_M = (0.0, 0.0, -0.02)
"""The same when it lies upside down: the middle of its plate."""
FLAT = 0.9
"""Least cosine between a piece's z axis and the vertical at which it counts as lying flat."""
PIECE_M = (0.15, 0.06, 0.04)
LOAD_M = (0.064, 0.18, 0.05)
"""What a piece takes up under the cup, its long axis across the arm's plane, whichever way round it was taken."""
LIFT_M = 0.08
"""The cup waits so far over a piece, and lifts it so far straight up."""
FEEL_M = 0.010
"""So far over a piece's seen top the cup goes on slowly, feeling for it."""
DEEPER_M = 0.008
"""How far under the seen top the cup looks for a piece before it gives up."""
DESCENT_MPS, FEEL_MPS = 0.10, 0.006
"""Speeds of the cup down to there, and when it may touch: what is met is pushed with about 2 N for each mm/s."""
CARRY_SHARE = 0.5
"""Of the arm's limits, while a piece hangs on the cup."""
DROP_TILTS = tuple(math.radians(tilt) for tilt in (180.0, 165.0, 150.0, 135.0, 120.0))
OVER_RIM_M = 0.02
"""A piece passes so far over a rim."""
PLAN_S = 5.0
"""Processor time for one way of the arm."""
CUP_OVER_LINK_5_M = 0.055
CHECK_RAD = 0.02


class WorkError(ValueError):
    """The arm cannot do it from here; the message says why."""


@dataclass(frozen=True, eq=False)
class PickPlan:
    """Motions of a pick; the way back up is planned from where the cup stopped.

    Attributes:
        reach: to over the piece.
        descend: down to where the cup begins to feel.
        feel: slowly on, to where there is nothing to be found.
        above: joints (5,), rad, over the piece.
        quality: of the configuration on the piece, 0 to 1.
    """

    reach: Tuple[Trajectory, ...]
    descend: Trajectory
    feel: Trajectory
    above: FloatArray
    quality: float


def held_solid() -> Solid:
    """What a piece on the cup takes up, arm_link_5's frame."""
    middle = (0.0, 0.0, CUP_OVER_LINK_5_M + 0.5 * LOAD_M[2] + 0.001)
    return Solid(Shape.BOX, LOAD_M, transform_matrix(middle, (0.0, 0.0, 0.0, 1.0)))


def load_bottom_m(q: FloatArray) -> float:
    """Height over the floor of the lowest point of a held piece, metres, at joints (5,), rad."""
    rotations, origins = link_poses(q)
    solid = held_solid()
    half = solid.half_extent
    corners = [(x, y, z) for x in (-half[0], half[0]) for y in (-half[1], half[1]) for z in (-half[2], half[2])]
    placed = transform_points(solid.pose, corners) @ rotations[N_JOINTS].T + origins[N_JOINTS]
    return float(placed[:, 2].min() + T_BASE_ARM[2, 3])


@lru_cache(maxsize=None)
def carry_joints(rim_m: float) -> Joints:
    """The arm ahead and drawn in, a held piece over a rim: how it goes about, with a piece and without.

    Raises:
        WorkError: no configuration holds a piece so high.
    """
    collision = YoubotCollision(own_body(), load=held_solid())
    best: Optional[Tuple[float, Joints]] = None
    for tilt in DROP_TILTS:
        for out in np.arange(0.12, 0.36, 0.02):
            for up in np.arange(0.10, 0.36, 0.02):
                (pose,) = cup_poses(np.array((out, 0.0, up)), (tilt,))
                for q in inverse(pose).solutions:
                    joints = np.array(q)
                    if abs(q[0]) > 0.1 or abs(q[4]) > 0.1 or load_bottom_m(joints) < rim_m + OVER_RIM_M:
                        continue
                    if quality(q) < 0.3 or not collision.free(joints, CLEAR_M):
                        continue
                    score = float(out) + 0.1 * (math.pi - tilt)
                    best = min(best or (math.inf, q), (score, q))
    if best is None:
        raise WorkError(f"no configuration carries a piece over a rim of {rim_m:.2f} m")
    return best[1]


def grip_point(piece: FloatArray) -> FloatArray:
    """Where the cup takes a piece (4, 4) that lies flat, either side up, in the same frame, (3,).

    Raises:
        WorkError: it lies on its side.
    """
    up = float(piece[2, 2])
    if abs(up) < FLAT:
        raise WorkError(f"the piece lies on its side, {math.degrees(math.acos(up)):.0f} deg from flat")
    return np.asarray(transform_points(piece, [GRIP_M if up > 0.0 else GRIP_UNDER_M])[0])


class ArmWork:
    """Plans the arm's motions with the base at one pose. Not thread-safe."""

    def __init__(self, base: Pose2, things: Sequence[Tuple[str, Solid]], seed: int) -> None:
        """Look about.

        Args:
            base: where its middle stands, world.
            things: solids that must not be touched, world, with their names.
            seed: of the planner.
        """
        T_world_base = transform_matrix((base.x, base.y, 0.0), quaternion_from_rpy(0.0, 0.0, base.yaw_rad))
        self._T_arm_world = np.linalg.inv(T_world_base @ T_BASE_ARM)
        seen = [Obstacle(name, solid.seen_from(self._T_arm_world)) for name, solid in things]
        self._obstacles = [*own_body(), *seen]
        self._empty = YoubotCollision(self._obstacles)
        self._loaded = YoubotCollision(self._obstacles, load=held_solid())
        self._seed = seed

    def pick(self, here: FloatArray, piece: FloatArray) -> PickPlan:
        """Motions to a piece.

        Args:
            here: joints (5,), rad.
            piece: T_world_piece (4, 4) as it is seen.

        Raises:
            WorkError: it cannot be reached from here.
        """
        grip = self._T_arm_world @ piece
        top = grip_point(grip)
        along = math.atan2(grip[1, 0], grip[0, 0])
        faults: List[str] = []
        for above, touch in self._ends(top, along, here):
            try:
                return self._descent(here, above, touch)
            except WorkError as error:
                faults.append(str(error))
        raise WorkError(faults[0] if faults else "the piece is out of the arm's reach")

    def lift(self, here: FloatArray, above: FloatArray) -> Trajectory:
        """From where the cup is straight up to over the piece, or joint by joint where that cannot be."""
        return through_waypoints(straight_line(here, above).joints, arm_limits(CARRY_SHARE))

    def carry(self, here: FloatArray, goal: FloatArray, loaded: bool) -> Tuple[Trajectory, ...]:
        """From one configuration to another, with a piece on the cup or without.

        Raises:
            WorkError: there is no way.
        """
        return self._way(here, goal, self._loaded if loaded else self._empty, CARRY_SHARE if loaded else 1.0)

    def drop(self, here: FloatArray, points: FloatArray) -> Tuple[Trajectory, ...]:
        """To the best configuration that holds the piece at one of the points (n, 3), world.

        Raises:
            WorkError: none can be reached.
        """
        goals = []
        for point in transform_points(self._T_arm_world, points):
            for pose in cup_poses(point, DROP_TILTS):
                for q in inverse(pose).solutions:
                    if abs(q[4]) < 0.1 and self._loaded.free(np.array(q), CLEAR_M):
                        goals.append(q)
        faults = []
        for goal in sorted(goals, key=quality, reverse=True)[:5]:
            try:
                return self.carry(here, np.array(goal), True)
            except WorkError as error:
                faults.append(str(error))
        raise WorkError(faults[0] if faults else f"none of {len(points)} places over the bin can be reached")

    def _ends(self, top: FloatArray, along: float, here: FloatArray) -> List[Tuple[FloatArray, FloatArray]]:
        """Configurations over the piece and on it, the easiest first; the piece's long axis across the arm's plane."""
        found = []
        for spin in (along - 0.5 * math.pi, along + 0.5 * math.pi):
            down = quaternion_from_rpy(0.0, math.pi, spin)
            for q in inverse(transform_matrix(top, down)).solutions:
                touch = np.array(q)
                over = inverse(transform_matrix(top + np.array((0.0, 0.0, LIFT_M)), down)).solutions
                if not over or not self._empty.free(touch, 0.5 * CLEAR_M):
                    continue
                above = min((np.array(one) for one in over), key=lambda one: float(np.max(np.abs(one - touch))))
                if self._empty.free(above, CLEAR_M) and self._loaded.free(above, CLEAR_M):
                    found.append((quality(q), above, touch))
        found.sort(key=lambda item: (-round(item[0], 1), float(np.linalg.norm(item[1] - here))))
        return [(above, touch) for _, above, touch in found]

    def _descent(self, here: FloatArray, above: FloatArray, touch: FloatArray) -> PickPlan:
        line = straight_line(above, touch)
        if line.status is not LineStatus.STRAIGHT:
            raise WorkError(f"the cup cannot go straight down: {line.reason}")
        if not all(self._empty.free(q, 0.5 * CLEAR_M) for q in line.joints):
            raise WorkError("something is in the way of the cup going down")
        feel, deepest = (self._lowered(touch, up) for up in (FEEL_M, -DEEPER_M))
        return PickPlan(
            self._way(here, above, self._empty, 1.0),
            slow_line(above, feel, DESCENT_MPS),
            slow_line(feel, deepest, FEEL_MPS),
            above,
            quality(tuple(touch.tolist())),
        )

    def _lowered(self, touch: FloatArray, up_m: float) -> FloatArray:
        """The configuration whose cup is so much higher than that on the piece, in the same branch."""
        pose = forward_many(touch[None])[0]
        pose[2, 3] += up_m
        found = inverse(pose).solutions
        if not found:
            raise WorkError(f"the cup cannot be held {up_m:+.3f} m from the piece's top")
        return min((np.array(q) for q in found), key=lambda q: float(np.max(np.abs(q - touch))))

    def _way(
        self, here: FloatArray, goal: FloatArray, collision: YoubotCollision, share: float
    ) -> Tuple[Trajectory, ...]:
        if np.max(np.abs(goal - here)) < 1e-4:
            return ()
        planner = ArmPlanner(collision, joint_limits(), CLEAR_M, self._seed, time.thread_time)
        try:
            return timed_path(planner.plan(here, goal, PLAN_S), collision, arm_limits(share))
        except ArmError as error:
            raise WorkError(str(error)) from error


def slow_line(start: FloatArray, goal: FloatArray, speed_mps: float) -> Trajectory:
    """The cup straight from one configuration to another, never faster than a speed.

    Raises:
        WorkError: it cannot go straight.
    """
    line = straight_line(start, goal)
    if line.status is not LineStatus.STRAIGHT:
        raise WorkError(f"the cup cannot go straight: {line.reason}")
    motion = through_waypoints(line.joints, arm_limits())
    times, q, _, _ = motion.sampled(0.005)
    ways = np.linalg.norm(np.diff(forward_many(q)[:, :3, 3], axis=0), axis=1)
    fastest = float(np.max(ways / np.diff(times)))
    return stretched(motion, max(1.0, fastest / speed_mps))


def base_outline() -> Tuple[Tuple[float, float], Tuple[float, float]]:
    """Least and greatest x and y of the base's solids, metres, base frame."""
    corners = []
    for solid in base_solids():
        half = solid.half_extent
        at = [(x, y, z) for x in (-half[0], half[0]) for y in (-half[1], half[1]) for z in (-half[2], half[2])]
        corners.append(transform_points(solid.pose, at))
    low, high = np.vstack(corners).min(axis=0), np.vstack(corners).max(axis=0)
    return (float(low[0]), float(high[0])), (float(low[1]), float(high[1]))
