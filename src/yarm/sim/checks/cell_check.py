"""Can this scene be done at all? Each check says what holds, or what does not and why."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Dict, List, Optional, Tuple

import numpy as np
import pybullet

from yarm.geometry import (
    BoolArray,
    FloatArray,
    GridSpec,
    quaternion_from_rpy,
    transform_matrix,
    transform_points,
    wrap_angle,
)
from yarm.geometry.kinds import GOAL_KINDS, ObjectKind
from yarm.geometry.solids import Shape
from yarm.geometry.urdf import LinkSolid
from yarm.robots.hc10 import PRIVATE_AREA, Area
from yarm.sim.checks.finding import Finding
from yarm.sim.checks.reachability import (
    ConfigurationSpace,
    RobotShape,
    compatible,
    configurations_at,
    heading_angles,
    nearest_heading,
    pairs,
    solid_points,
)
from yarm.sim.engine.bodies import Body, FramedSolid, description, rigid_solids, set_root_pose
from yarm.sim.engine.things import SpawnError
from yarm.sim.engine.world import SimWorld
from yarm.sim.robots.ankurbot import Ankurbot
from yarm.sim.robots.arm import Arm
from yarm.sim.scenes.scene import Scene, SceneError
from yarm.sim.scenes.specs import ThingSpec

HOVER_TIP_M = 1.15
HOVER_CLEARANCE_M = 0.05
PART_XY_M = tuple((x, y) for x in (-0.42, -0.25, -0.08) for y in (-0.27, 0.0, 0.27))
"""Places over the part, metres, frame of its station."""
LINK_CLEARANCE_M = 0.05
NEIGHBOURS = 2
"""Links this near along the chain (joints apart) touch by construction."""

Configuration = Tuple[int, Tuple[int, int]]


@dataclass(frozen=True)
class GoalPoint:
    """A place for an end effector: name of a goal (with what happened to it) or bin, and x, y, metres, world."""

    name: str
    x: float
    y: float


def check_scene(scene: Scene, hands: bool = False) -> List[Finding]:
    """Every check of a scene.

    Args:
        scene: to check.
        hands: its mobile robots carry a hand, drawn up, with a piece of debris in it while they drive, and take debris
            to the scene's bins.
    """
    try:
        world = SimWorld(scene, hands=hands)
    except SpawnError as error:
        return [Finding(False, str(error))]
    with world:
        return _Checker(world).findings()


def unreachable_goals(scene: Scene) -> Dict[str, str]:
    """Why goals of a scene, those of its events too, cannot be reached as it begins, by name; the others are not in it.

    Raises:
        SceneError: its things overlap at the start, so that there is nothing to check.
    """
    try:
        with SimWorld(scene) as world:
            findings = _Checker(world).findings()
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


def carried_points(cup_m: float) -> FloatArray:
    """Points (n, 3) that fill a piece of debris under a cup at a height, however it is turned; end effector's frame."""
    _, model = description("debris.urdf.xacro")
    own = solid_points((FramedSolid("", solid, np.eye(4)), pose) for solid, pose in rigid_solids(model))
    reach = float(np.hypot(own[:, 0], own[:, 1]).max())
    height = float(np.ptp(own[:, 2]))
    disc = FramedSolid("", LinkSolid(Shape.CYLINDER, (reach, height), np.eye(4), "piece"), np.eye(4))
    pose = transform_matrix((0.0, 0.0, cup_m - 0.5 * height), (0.0, 0.0, 0.0, 1.0))
    return solid_points([(disc, pose)])


class _Checker:
    """The checks of one world at its start."""

    def __init__(self, world: SimWorld) -> None:
        self._world = world
        self._spec = GridSpec()
        self._goals = goal_points(world.scene)
        if world.hands:
            self._goals += [GoalPoint(spec.name, spec.station.x, spec.station.y) for spec in world.scene.bins]
        self._options: Dict[str, List[Configuration]] = {}
        self._shape: Optional[RobotShape] = None

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
        transforms = self._world.transforms()
        first = next(iter(self._world.robots.values()))
        to_ee = np.linalg.inv(transforms[first.body.seed_frame])
        points = transform_points(to_ee, self._points(first.body))
        points[:, 2] += transforms[first.body.seed_frame][2, 3]
        if first.hand is not None:
            points = np.concatenate([points, carried_points(float(first.hand.cup[2, 3]))])
        self._shape = RobotShape.from_points(points, self._spec)
        fixed = [
            self._points(b)
            for b in self._world.bodies.values()
            if b.kind in (ObjectKind.OBSTACLE, ObjectKind.MANIPULATOR)
        ]
        space = ConfigurationSpace(self._shape, np.concatenate([np.zeros((0, 3)), *fixed]), self._spec)
        reached: Dict[str, BoolArray] = {}
        found = []
        for robot in self._world.scene.robots:
            column = self._spec.column_of(transforms[f"{robot.name}/ee"][:3, 3])
            reached[robot.name] = space.reachable(column, nearest_heading(robot.heading_rad))
            if not reached[robot.name].any():
                found.append(Finding(False, f"{robot.name} cannot move: something is within one cell of its start"))
        return found + [self._reach_goal(goal, reached) for goal in self._goals]

    def _reach_goal(self, goal: GoalPoint, reached: Dict[str, BoolArray]) -> Finding:
        column = self._spec.column_of((goal.x, goal.y))
        by = {name: configurations_at(cells, column) for name, cells in reached.items()}
        able = {name: options for name, options in by.items() if options}
        self._options[goal.name] = sorted({option for options in able.values() for option in options})
        if not able:
            text = f"{goal.name}: no robot can get to column {column} at any heading with the margin"
            return Finding(False, text, goal.name)
        degrees = [round(math.degrees(heading_angles()[heading])) for heading, _ in self._options[goal.name]]
        square = [name for name, options in able.items() if any(self._is_square(name, h) for h, _ in options)]
        if not square:
            return Finding(
                False,
                f"{goal.name}: {', '.join(able)} can get to column {column} only at headings {degrees} deg, to which "
                f"quarter turns do not lead; the Commander's turns_deg needs finer ones, such as 45 and -45",
                goal.name,
            )
        return Finding(True, f"{goal.name}: {', '.join(square)} can reach it, headings {degrees} deg", goal.name)

    def _is_square(self, robot: str, heading: int) -> bool:
        """Whether quarter turns lead a robot from its start to a heading."""
        start = next(spec.heading_rad for spec in self._world.scene.robots if spec.name == robot)
        return (heading - nearest_heading(start)) % (len(heading_angles()) // 4) == 0

    def _pairs(self) -> List[Finding]:
        found: List[Finding] = []
        if len(self._world.robots) < 2 or self._shape is None:
            return found
        for one, other in pairs(goal.name for goal in self._goals):
            if one.split(" ")[0] == other.split(" ")[0] or not (self._options[one] and self._options[other]):
                continue
            good = compatible(self._shape, self._spec, self._options[one], self._options[other])
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
        for heading, _ in self._options[goal.name]:
            least = self._clearance_at(arm, robot, goal, float(heading_angles()[heading]), hovers)
            if least > best:
                best, best_degrees = least, round(math.degrees(heading_angles()[heading]))
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
