"""Ways of the arm through checkpoints among obstacles: the coursework's two methods, a better field, a planner."""

from __future__ import annotations

import time
from dataclasses import dataclass
from enum import Enum
from typing import Dict, List, Sequence, Tuple

import numpy as np

from yarm.control.arm.errors import ArmError
from yarm.control.arm.model import JointLimits
from yarm.control.arm.planner import ArmPlanner
from yarm.geometry import FloatArray
from yarm.manipulation.kinematics.inverse import inverse
from yarm.manipulation.motion.checkpoints import ArmScene
from yarm.manipulation.motion.tour import Order, TourError, plan_tour
from yarm.manipulation.motion.trajectory import (
    MotionLimits,
    Trajectory,
    TrajectoryError,
    arm_limits,
    jerk_limited,
    through_waypoints,
)
from yarm.manipulation.obstacles.collision import YoubotCollision
from yarm.manipulation.obstacles.fields import FieldStatus, NavigationField, descend, straight_pull
from yarm.robots.youbot import LOWER_RAD, SPEED_RADPS, UPPER_RAD, Joints

MARGIN_M = 0.01
"""Distance that planned ways keep to everything."""
PLANNING_LIMIT_S = 120.0
"""Processor time after which a leg is given up; a leg takes well under a second. Wall time would run on while a busy
machine gives the planner nothing."""
SPACING_RAD = 0.12
"""Waypoints of a timed path are no farther apart."""
FIELD_THINNING = 8
CHECK_S = 0.02
RETRACTED = (-0.52, 1.22, -0.79, 0.0)
"""Joints 2 to 5 of the arm drawn in, rad."""


class Variant(Enum):
    """How the ways are found."""

    POTENTIAL_FIELD = "potential_field"
    TURN_EXTEND_RETRACT = "turn_extend_retract"
    NAVIGATION_FIELD = "navigation_field"
    YARM = "yarm"


FIELDS = (Variant.POTENTIAL_FIELD, Variant.NAVIGATION_FIELD)
"""Those that bring the hand to a position and leave the tool's direction as it comes."""


@dataclass(frozen=True, eq=False)
class Leg:
    """The way to one checkpoint.

    Attributes:
        goal: name of the checkpoint.
        found: whether the method says that it ends there.
        motions: one after the other, each from rest to rest.
        reason: why it does not.
    """

    goal: str
    found: bool
    motions: Tuple[Trajectory, ...]
    reason: str = ""


@dataclass(frozen=True, eq=False)
class Ways:
    """The ways through a scene's checkpoints, in the order they are gone, and those that were refused before."""

    variant: Variant
    legs: Tuple[Leg, ...]
    refused: Dict[str, str]


def plan_ways(scene: ArmScene, variant: Variant, seed: int = 0) -> Ways:
    """Ways from the scene's start through its checkpoints.

    Args:
        scene: checkpoints and obstacles.
        variant: how.
        seed: of the planner's random numbers.
    """
    if variant is Variant.YARM:
        return _planned(scene, seed)
    if variant is Variant.TURN_EXTEND_RETRACT:
        return _turned(scene)
    return _along_field(scene, variant)


def timed_path(corners: FloatArray, collision: YoubotCollision, limits: MotionLimits) -> Tuple[Trajectory, ...]:
    """A planned path in time: one smooth motion where that stays clear, else straight pieces with rests between.

    Args:
        corners: (m, 5), rad, joined by straight pieces that are clear.
        collision: what must not be touched.
        limits: of the joints.
    """
    if len(corners) > 2:
        try:
            smooth = through_waypoints(_dense(corners), limits)
        except TrajectoryError:
            smooth = None
        if smooth is not None and _clear(smooth, collision):
            return (smooth,)
    return tuple(jerk_limited(a, b, limits) for a, b in zip(corners[:-1], corners[1:]))


def _planned(scene: ArmScene, seed: int) -> Ways:
    collision = YoubotCollision(scene.obstacles)
    planner = ArmPlanner(collision, joint_limits(), MARGIN_M, seed, time.thread_time)

    def fault(q: Joints) -> str:
        found = collision.clearance(np.array(q), MARGIN_M)
        return f"{found.between} are {found.distance_m:.3f} m apart, {MARGIN_M:g} m is kept" if found.between else ""

    wrong = fault(scene.start)
    if wrong:
        return Ways(Variant.YARM, (), {point.name: f"at the start {wrong}" for point in scene.checkpoints})
    try:
        tour = plan_tour(scene.start, scene.checkpoints, Order.EXACT, fault)
    except TourError as error:
        return Ways(Variant.YARM, (), {point.name: str(error) for point in scene.checkpoints})
    here, legs = np.array(scene.start), []
    for name, goal in zip(tour.names, tour.joints):
        try:
            corners = planner.plan(here, goal, PLANNING_LIMIT_S)
        except ArmError as error:
            legs.append(Leg(name, False, (), str(error)))
            continue
        legs.append(Leg(name, True, timed_path(corners, collision, arm_limits())))
        here = goal
    return Ways(Variant.YARM, tuple(legs), tour.unreachable)


def _turned(scene: ArmScene) -> Ways:
    """The coursework's way without looking: draw the arm in, turn to the checkpoint, put the arm out."""
    tour = plan_tour(scene.start, scene.checkpoints, Order.GREEDY)
    here, legs = np.array(scene.start), []
    for name, goal in zip(tour.names, tour.joints):
        retracted = [np.array((heading, *RETRACTED)) for heading in (here[0], goal[0])]
        corners = [here, *retracted, goal]
        motions = tuple(jerk_limited(a, b, arm_limits()) for a, b in zip(corners[:-1], corners[1:]))
        legs.append(Leg(name, True, motions))
        here = goal
    return Ways(Variant.TURN_EXTEND_RETRACT, tuple(legs), tour.unreachable)


def _along_field(scene: ArmScene, variant: Variant) -> Ways:
    """Down a field to the checkpoints' positions, in the order of the file; where it is stuck the next one is tried."""
    navigation = NavigationField(scene.obstacles) if variant is Variant.NAVIGATION_FIELD else None
    here, legs = np.array(scene.start), []
    for point in scene.checkpoints:
        goal = point.pose[:3, 3]
        pull = straight_pull(goal) if navigation is None else navigation.pull(goal)
        way = descend(here, goal, pull, scene.obstacles)
        thinned = [*way.joints[:-1:FIELD_THINNING], way.joints[-1]]
        path = _distinct(thinned)
        motions = (through_waypoints(path, arm_limits()),) if len(path) > 1 else ()
        legs.append(Leg(point.name, way.status is FieldStatus.ARRIVED, motions, way.reason))
        here = way.joints[-1]
    refused = {point.name: inverse(point.pose).reason for point in scene.checkpoints}
    return Ways(variant, tuple(legs), {name: reason for name, reason in refused.items() if reason})


def joint_limits() -> JointLimits:
    """The arm's limits as planners take them."""
    return JointLimits(np.array(LOWER_RAD), np.array(UPPER_RAD), np.full(len(LOWER_RAD), SPEED_RADPS))


def _dense(corners: FloatArray) -> FloatArray:
    """The same path with points no farther than ``SPACING_RAD`` apart: a spline through them stays near it."""
    points = [corners[0]]
    for a, b in zip(corners[:-1], corners[1:]):
        pieces = int(np.ceil(np.linalg.norm(b - a) / SPACING_RAD))
        points += [a + (b - a) * share for share in np.linspace(0.0, 1.0, pieces + 1)[1:]]
    return np.array(_distinct(points))


def _distinct(points: Sequence[FloatArray]) -> List[FloatArray]:
    kept = [points[0]]
    for point in points[1:]:
        if np.linalg.norm(point - kept[-1]) > 1e-4:
            kept.append(point)
    return kept


def _clear(motion: Trajectory, collision: YoubotCollision) -> bool:
    """Whether half the margin is kept on the way and no joint leaves its limits: the spline cuts corners."""
    _, q, _, _ = motion.sampled(CHECK_S)
    if np.any(q < np.array(LOWER_RAD) - 1e-6) or np.any(q > np.array(UPPER_RAD) + 1e-6):
        return False
    return all(collision.free(joints, 0.5 * MARGIN_M) for joints in q)
