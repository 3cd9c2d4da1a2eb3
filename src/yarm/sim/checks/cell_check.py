"""Can this scene be done at all? Each check says what holds, or what does not and why."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import partial
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np
import pybullet

from yarm.geometry import (
    FloatArray,
    GridSpec,
    Pose2,
    quaternion_from_rpy,
    transform_points,
    wrap_angle,
)
from yarm.geometry.kinds import GOAL_KINDS, ObjectKind
from yarm.geometry.solids import Solid
from yarm.robots.ankurbot import ARM_REACH_M
from yarm.robots.hc10 import PRIVATE_AREA, Area
from yarm.robots.shapes import PieceShape, RobotShape, piece_shape, robot_shape
from yarm.robots.turns import FINER_TURNS_DEG, QUARTER_TURNS_DEG
from yarm.sim.checks.finding import Finding
from yarm.sim.checks.reachability import Configuration, ConfigurationSpace, Reached, pairs, solid_points
from yarm.sim.engine.bodies import set_root_pose
from yarm.sim.engine.world import SimWorld
from yarm.sim.robots.ankurbot import Ankurbot
from yarm.sim.robots.arm import Arm
from yarm.sim.scenes.bodies import Body, SpawnError, description, rigid_solids
from yarm.sim.scenes.scene import Scene, SceneError
from yarm.sim.scenes.specs import RobotSpec, ThingSpec

HOVER_TIP_M = 1.15
HOVER_CLEARANCE_M = 0.05
PART_XY_M = tuple((x, y) for x in (-0.42, -0.25, -0.08) for y in (-0.27, 0.0, 0.27))
"""Places over the part, metres, frame of its station."""
LINK_CLEARANCE_M = 0.05
NEIGHBOURS = 2
"""Links this near along the chain (joints apart) touch by construction."""

TURNS_DEG = (*QUARTER_TURNS_DEG, *FINER_TURNS_DEG)
"""Turns that a Commander has robots make unless told otherwise, the finer ones where the others lead nobody."""
ANY_TURNS_DEG = (0.0, 10.0, -10.0)
"""Turns with which a robot gets about wherever it can at all, as good as."""


@dataclass(frozen=True)
class GoalPoint:
    """A place for an end effector: name of a goal (with what happened to it) or bin, and x, y, metres, world."""

    name: str
    x: float
    y: float


def check_scene(scene: Scene, hands: bool = False, turns_deg: Sequence[float] = TURNS_DEG) -> List[Finding]:
    """Every check of a scene.

    Args:
        scene: to check.
        turns_deg: turns that mobile robots make, deg.
        hands: its mobile robots carry a hand, drawn up, with a piece of debris in it while they drive, and take debris
            to the scene's bins.
    """
    try:
        world = SimWorld(scene, hands=hands)
    except SpawnError as error:
        return [Finding(False, str(error))]
    with world:
        return _Checker(world, turns_deg).findings()


def unreachable_goals(scene: Scene, turns_deg: Sequence[float] = TURNS_DEG) -> Dict[str, str]:
    """Why goals of a scene, those of its events too, cannot be reached as it begins, by name; the others are not in it.

    Args:
        scene: to check.
        turns_deg: turns that mobile robots make, deg.

    Raises:
        SceneError: its things overlap at the start, so that there is nothing to check.
    """
    try:
        with SimWorld(scene) as world:
            findings = _Checker(world, turns_deg).findings()
    except SpawnError as error:
        raise SceneError(f"{scene.name}: {error}") from error
    reasons: Dict[str, str] = {}
    for finding in findings:
        if finding.goal and not finding.holds:
            reasons.setdefault(finding.goal.split(" ")[0], finding.text)
    return reasons


def goal_points(scene: Scene) -> List[GoalPoint]:
    """Debris and targets, also those that events spawn, and where pushes take them."""
    spawned = [event.spawn for event in scene.events if event.spawn is not None]
    things = {t.name: t for t in (*scene.things, *spawned) if t.kind in GOAL_KINDS}
    points = [GoalPoint(thing.name, thing.x, thing.y) for thing in things.values()]
    for event in scene.events:
        thing: Optional[ThingSpec] = things.get(event.push)
        if thing is not None:
            points.append(GoalPoint(f"{thing.name} (after: {event.name})", thing.x + event.dx_m, thing.y + event.dy_m))
    return points


def debris_shape() -> PieceShape:
    """A piece of debris however it lies or hangs."""
    _, model = description("debris.urdf.xacro")
    return piece_shape([Solid(solid.shape, solid.size, pose) for solid, pose in rigid_solids(model)])


def shape_of(world: SimWorld, robot: Ankurbot) -> RobotShape:
    """What a Commander knows of a robot, with a piece of debris in its hand if it has one."""
    transforms = world.transforms()
    T_world_ee = transforms[robot.body.seed_frame]
    T_ee_world = np.linalg.inv(T_world_ee)
    solids = [
        Solid(item.solid.shape, item.solid.size, T_ee_world @ transforms[item.frame] @ item.T_frame_solid)
        for item in robot.body.solids
    ]
    shape = robot_shape(solids, float(T_world_ee[2, 3]))
    return shape if robot.hand is None else shape.with_load(debris_shape())


class _Checker:
    """The checks of one world at its start."""

    def __init__(self, world: SimWorld, turns_deg: Sequence[float]) -> None:
        self._world = world
        self._turns_deg = turns_deg
        self._spec = GridSpec()
        self._goals = goal_points(world.scene)
        if world.hands:
            self._goals += [GoalPoint(spec.name, spec.station.x, spec.station.y) for spec in world.scene.bins]
        self._options: Dict[str, List[Configuration]] = {}
        self._space: Optional[ConfigurationSpace] = None
        self._anyhow: Dict[str, Reached] = {}

    def findings(self) -> List[Finding]:
        found = self._starts()
        if self._world.robots:
            found += self._reach()
            found += self._pairs()
        found += self._areas()
        for arm in self._world.arms.values():
            found.append(self._storage(arm))
            if self._world.robots and self._goals:
                found += self._hover(arm)
        return found

    def _points(self, body: Body) -> FloatArray:
        transforms = self._world.transforms()
        return solid_points((item, transforms[item.frame] @ item.T_frame_solid) for item in body.solids)

    def _starts(self) -> List[Finding]:
        found = [Finding(True, f"{len(self._world.bodies)} objects, none overlapping")]
        self._world.tick()
        for contact in self._world.failures():
            found.append(Finding(False, f"{contact.a.body} touches {contact.b.body} at the start"))
        for name, robot in self._world.robots.items():
            points = self._points(robot.body)[:, :2]
            inside = bool(np.all(points >= self._spec.lower[:2]) and np.all(points < self._spec.upper[:2]))
            low, high = points.min(axis=0), points.max(axis=0)
            where = f"x {low[0]:.2f} to {high[0]:.2f}, y {low[1]:.2f} to {high[1]:.2f}"
            found.append(Finding(inside, f"{name} starts {'inside' if inside else 'outside'} the volume: {where}"))
        return found

    def _reach(self) -> List[Finding]:
        first = next(iter(self._world.robots.values()))
        fixed = [
            self._points(b)
            for b in self._world.bodies.values()
            if b.kind in (ObjectKind.OBSTACLE, ObjectKind.MANIPULATOR)
        ]
        mask_at = partial(shape_of(self._world, first).mask, self._spec)
        space = ConfigurationSpace(mask_at, np.concatenate([np.zeros((0, 3)), *fixed]), self._spec)
        self._space = space
        reached: Dict[str, Reached] = {}
        found = []
        for robot in self._world.scene.robots:
            reached[robot.name] = self._reached(space, robot, self._turns_deg)
            if not reached[robot.name].columns.any():
                found.append(Finding(False, f"{robot.name} cannot move: something is within one cell of its start"))
        return found + [self._reach_goal(goal, space, reached) for goal in self._goals]

    def _reached(self, space: ConfigurationSpace, robot: RobotSpec, turns_deg: Sequence[float]) -> Reached:
        tip = Pose2(robot.x, robot.y, robot.heading_rad).compose(Pose2(ARM_REACH_M, 0.0))
        return space.reachable(self._spec.column_of((tip.x, tip.y)), robot.heading_rad, turns_deg)

    def _reach_goal(self, goal: GoalPoint, space: ConfigurationSpace, reached: Dict[str, Reached]) -> Finding:
        column = self._spec.column_of((goal.x, goal.y))
        by = {name: cells.at(column) for name, cells in reached.items()}
        able = {name: options for name, options in by.items() if options}
        self._options[goal.name] = sorted({option for options in able.values() for option in options})
        if able:
            text = f"{goal.name}: {', '.join(able)} can reach it, headings {_degrees(self._options[goal.name])} deg"
            return Finding(True, text, goal.name)
        if not self._anyhow:
            robots = self._world.scene.robots
            self._anyhow = {robot.name: self._reached(space, robot, ANY_TURNS_DEG) for robot in robots}
        anyhow = {name: cells.at(column) for name, cells in self._anyhow.items()}
        askew = {name: options for name, options in anyhow.items() if options}
        if not askew:
            text = f"{goal.name}: no robot can get to column {column} at any heading with the margin"
            return Finding(False, text, goal.name)
        turns = ", ".join(f"{angle:g}" for angle in self._turns_deg)
        ways = "; ".join(f"{name} can at headings {_degrees(options)} deg" for name, options in askew.items())
        return Finding(
            False,
            f"{goal.name}: turns of {turns} deg (the Commander's turns_deg and finer_turns_deg) lead no robot to "
            f"column {column}; with any turns {ways}",
            goal.name,
        )

    def _pairs(self) -> List[Finding]:
        found: List[Finding] = []
        if len(self._world.robots) < 2 or self._space is None:
            return found
        for one, other in pairs(goal.name for goal in self._goals):
            if one.split(" ")[0] == other.split(" ")[0] or not (self._options[one] and self._options[other]):
                continue
            good = self._space.compatible(self._options[one], self._options[other])
            text = "can be held together" if good else "cannot be held together at any headings with the margin"
            found.append(Finding(good, f"{one} and {other} {text}"))
        return found

    def _areas(self) -> List[Finding]:
        """No two manipulators share a column of their private areas, so that neither gets in the other's way."""
        areas = {
            name: arm.station.moved_area(self._spec, PRIVATE_AREA) for name, arm in sorted(self._world.arms.items())
        }
        found = []
        for one, other in itertools.combinations(areas, 2):
            a, b = areas[one], areas[other]
            apart = a[1] < b[0] or b[1] < a[0] or a[3] < b[2] or b[3] < a[2]
            text = "do not overlap" if apart else "overlap"
            found.append(Finding(apart, f"private areas of {one} {_columns(a)} and {other} {_columns(b)} {text}"))
        return found

    def _storage(self, arm: Arm) -> Finding:
        distance, pair = link_clearance(self._world.client, arm)
        text = f"{arm.body.name} in storage: nearest links {pair}, {distance:.3f} m apart"
        return Finding(distance >= LINK_CLEARANCE_M, f"{text} (at least {LINK_CLEARANCE_M} m)")

    def _hover(self, arm: Arm) -> List[Finding]:
        """With the tool up at hover anywhere over the part, a robot can stand at each goal on the part."""
        over = transform_points(arm.station.pose, [(x, y, 0.0) for x, y in PART_XY_M])[:, :2].tolist()
        poses = [((x, y), tip_joints(self._world.client, arm, x, y, HOVER_TIP_M)) for x, y in over]
        lost = [xy for xy, joints in poses if joints is None]
        if lost:
            return [Finding(False, f"{arm.body.name} cannot hover at z {HOVER_TIP_M} over {lost}")]
        joints = [angles for _, angles in poses if angles is not None]
        return [self._hover_over(arm, goal, joints) for goal in self._goals]

    def _hover_over(self, arm: Arm, goal: GoalPoint, hovers: List[List[float]]) -> Finding:
        robot = next(iter(self._world.robots.values()))
        best, best_degrees = -1.0, 0
        for yaw_rad, _ in self._options[goal.name]:
            least = self._clearance_at(arm, robot, goal, yaw_rad, hovers)
            if least > best:
                best, best_degrees = least, round(math.degrees(yaw_rad))
        text = f"{goal.name}: robot at {best_degrees} deg stays {best:.2f} m clear of the hovering {arm.body.name}"
        return Finding(best >= HOVER_CLEARANCE_M, f"{text} (at least {HOVER_CLEARANCE_M} m)", goal.name)

    def _clearance_at(
        self, arm: Arm, robot: Ankurbot, goal: GoalPoint, yaw_rad: float, hovers: List[List[float]]
    ) -> float:
        client = self._world.client
        x, y = goal.x - robot.reach_m * math.cos(yaw_rad), goal.y - robot.reach_m * math.sin(yaw_rad)
        set_root_pose(client, robot.uid, (x, y, 0.0), yaw_rad)
        least = 1.0
        for joints in hovers:
            arm.place(joints)
            for point in pybullet.getClosestPoints(arm.uid, robot.uid, 1.0, physicsClientId=client):
                least = min(least, point[8])
        return least


def tip_joints(client: int, arm: Arm, x: float, y: float, z: float, tries: int = 12) -> Optional[List[float]]:
    """Joints, rad, with the sander's tip at (x, y, z), metres, pointing down, within limits; None when not found."""
    station = arm.station
    down = quaternion_from_rpy(math.pi, 0.0, station.yaw_rad).tolist()
    base_x, base_y, _ = station.base_xyz
    towards = wrap_angle(math.atan2(y - base_y, x - base_x) - station.yaw_rad)
    generator = np.random.default_rng(0)
    for attempt in range(tries):
        seed = [towards, 0.5, 1.6, 0.0, 0.5, 0.0] if attempt == 0 else None
        arm.place(
            seed or generator.uniform([-1.0, -0.5, 0.6, -1.0, -2.0, -3.0], [1.0, 1.5, 2.6, 1.0, 2.0, 3.0]).tolist()
        )
        for _ in range(4):
            joints = pybullet.calculateInverseKinematics(
                arm.uid, arm.tip_link, [x, y, z], down, maxNumIterations=100, physicsClientId=client
            )
            arm.place(list(joints))
        tip = arm.transforms()[f"{arm.body.name}/sander_tip"]
        near = np.linalg.norm(tip[:3, 3] - (x, y, z)) < 0.005 and tip[2, 2] < -0.999
        limits = arm.limits
        if near and np.all(np.asarray(joints) >= limits.lower) and np.all(np.asarray(joints) <= limits.upper):
            return list(joints)
    return None


def _degrees(configurations: Sequence[Configuration]) -> List[int]:
    return sorted({round(math.degrees(yaw_rad)) for yaw_rad, _ in configurations})


def _columns(area: Area) -> str:
    return f"(columns x {area[0]}..{area[1]}, y {area[2]}..{area[3]})"


def link_clearance(client: int, arm: Arm) -> Tuple[float, str]:
    """Least distance, metres, between two links of an arm that are not neighbours, and which they are."""
    least, pair = math.inf, ""
    links = arm.chain()
    for i, (one, depth_one) in enumerate(links):
        for other, depth_other in links[i + 1 :]:
            if abs(depth_one - depth_other) < NEIGHBOURS or {depth_one, depth_other} == {0, 2}:
                continue
            points = pybullet.getClosestPoints(
                arm.uid, arm.uid, 1.0, linkIndexA=one, linkIndexB=other, physicsClientId=client
            )
            for point in points:
                if point[8] < least:
                    least, pair = point[8], f"{arm.link_name(one)} and {arm.link_name(other)}"
    return least, pair
