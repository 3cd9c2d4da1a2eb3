"""A world without physics for many trials: the real control law on a kinematic base, exact shapes, no cameras, no ROS.

Robots move by ``yarm.control``'s base controller on its kinematic model. What a camera would see is made from the
solids themselves. A robot that runs into something that does not move stops there; a robot that touches a moving arm
goes on, and the touch is counted.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Dict, FrozenSet, Mapping, Optional, Protocol, Tuple

import numpy as np

from yarm.control.base.controller import BaseController, BaseGoal, Outcome
from yarm.control.base.model import BaseModel
from yarm.control.base.params import BaseParams
from yarm.experiments.study.clearance import ANKURBOT, Cloud, Upright, box, cloud_of, fleet_distance, points_distance
from yarm.geometry import BoolArray, FloatArray, GridSpec, IntArray, Pose2
from yarm.geometry.kinds import GOAL_KINDS, ObjectKind
from yarm.planning.model.types import Goal, GoalKind, PlanRequest, Robot, Waypoint, without_robots
from yarm.robots.ankurbot import ARM_REACH_M, ankurbot_mask
from yarm.sim.scenes.scene import Scene

TICK_S = 1.0 / 60.0
CHECK_TICKS = 3
TOUCH_M = 0.0
BLOCK_DEPTH_M = 0.002
FIXTURES: Mapping[str, Tuple[Upright, ...]] = {
    "table": (box(0.0, 0.0, 0.0, (0.90, 1.20, 0.70), 0.0), box(-0.25, 0.0, 0.0, (0.40, 0.60, 0.03), 0.70)),
    "stand": (box(-1.10, 0.0, 0.0, (0.40, 0.40, 0.70), 0.0),),
    "bin": (
        box(0.0, 0.0, 0.0, (0.40, 0.40, 0.02), 0.0),
        box(0.19, 0.0, 0.0, (0.02, 0.40, 0.60), 0.0),
        box(-0.19, 0.0, 0.0, (0.02, 0.40, 0.60), 0.0),
        box(0.0, 0.19, 0.0, (0.36, 0.02, 0.60), 0.0),
        box(0.0, -0.19, 0.0, (0.36, 0.02, 0.60), 0.0),
    ),
}
"""What is bolted to the floor, as in urdf/cell/cell.urdf.xacro (a test compares)."""


class Arm(Protocol):
    """A manipulator at work."""

    def step(self, dt_s: float, enabled: bool) -> None:
        """Go on by dt; sand when enabled, else lift off and wait."""

    def points(self) -> FloatArray:
        """Points (n, 3) on its links, metres, world."""

    def tip(self) -> Tuple[float, float, float]:
        """Its tool's tip, metres, world."""


@dataclass
class Touches:
    """What a robot has touched, and how near it came.

    Attributes:
        stationary: things that do not move, by name.
        moving: arms and robots, by name.
        least_m: least distance to anything so far, metres.
    """

    stationary: FrozenSet[str] = frozenset()
    moving: FrozenSet[str] = frozenset()
    least_m: float = math.inf


@dataclass
class KinematicRobot:
    """One mobile robot: its controller, its base, what it touched and how far its end effector went."""

    name: str
    controller: BaseController
    base: BaseModel
    touches: Touches = field(default_factory=Touches)
    outcome: Outcome = Outcome.SUCCEEDED
    path_m: float = 0.0
    blocked: bool = False
    free_pose: Pose2 = field(default_factory=lambda: Pose2(0.0, 0.0))
    drawn: Tuple[Upright, ...] = ANKURBOT

    @property
    def pose(self) -> Pose2:
        """Of the end effector, world."""
        return self.base.pose

    @property
    def solids(self) -> Tuple[Upright, ...]:
        """Its solids, world."""
        return tuple(solid.at(self.base.pose) for solid in self.drawn)

    def send(self, target: Pose2, via: Tuple[Pose2, ...] = ()) -> None:
        """Go to a pose, by others when some are given: turn about the end effector, then translate."""
        self.blocked = False
        self.outcome = Outcome.ACTIVE
        self.controller.start(BaseGoal(target, via=via))

    def stop(self) -> None:
        """Give up where it is sent; it stands once it has braked."""
        self.controller.stop("stopped")

    def step(self, now_s: float) -> None:
        """One tick of the control law."""
        before = self.base.pose
        command = self.controller.step(before, self.base.casters, now_s)
        if self.outcome is Outcome.ACTIVE and command.outcome is not Outcome.ACTIVE:
            self.outcome = command.outcome
        self.base.step(command, TICK_S)
        if self.blocked:
            self.base.pose = before
        self.path_m += before.distance(self.base.pose)


class KinematicWorld:
    """Everything in the cell, in step with one clock."""

    def __init__(self, scene: Scene, spec: GridSpec, arm: Optional[Arm] = None, params: Optional[BaseParams] = None):
        """The scene at time 0.

        Args:
            scene: robots, fixtures, targets and obstacles; debris and events are not used.
            spec: the grid.
            arm: the manipulator, already at work; None for none.
            params: of the base controller.
        """
        self.spec = spec
        self.now_s = 0.0
        self.arm = arm
        self.arm_enabled = True
        self.statics: Dict[str, Tuple[Upright, ...]] = {}
        for fixture in scene.placed_fixtures:
            pose = Pose2(fixture.station.x, fixture.station.y, fixture.station.yaw_rad)
            self.statics[fixture.name] = tuple(solid.at(pose) for solid in FIXTURES[fixture.type])
        for thing in scene.things_of(ObjectKind.OBSTACLE):
            if thing.model:
                raise ValueError(f"obstacle {thing.name}: the kinematic world knows boxes only, not {thing.model}")
            self.statics[thing.name] = (
                box(thing.x, thing.y, thing.yaw_rad, thing.size, thing.z - thing.size[2] / 2.0),
            )
        self.static_cells = {name: solid_cells(spec, solids) for name, solids in self.statics.items()}
        self.robots: Dict[str, KinematicRobot] = {}
        for robot in scene.robots:
            pose = Pose2(robot.x, robot.y, robot.heading_rad).compose(Pose2(ARM_REACH_M, 0.0))
            base = BaseModel(pose=pose, reach_m=ARM_REACH_M)
            controller = BaseController(params or BaseParams())
            self.robots[robot.name] = KinematicRobot(robot.name, controller, base, free_pose=pose)
        self.goals = {
            thing.name: Goal(thing.name, GoalKind(thing.kind), spec.column_of((thing.x, thing.y)))
            for thing in scene.things
            if thing.kind in GOAL_KINDS
        }
        self._ticks = 0

    def advance(self) -> None:
        """One tick."""
        self.now_s += TICK_S
        self._ticks += 1
        if self.arm is not None:
            self.arm.step(TICK_S, self.arm_enabled)
        for robot in self.robots.values():
            robot.step(self.now_s)
        if self.check_due:
            arm = cloud_of(np.zeros((0, 3)) if self.arm is None else self.arm.points())
            for robot in self.robots.values():
                self._check(robot, arm)

    @property
    def check_due(self) -> bool:
        """Whether touches are looked for in this tick."""
        return self._ticks % CHECK_TICKS == 0

    def request(self, assignments: Mapping[str, str]) -> PlanRequest:
        """What the planner would be given now."""
        occupied = np.zeros(self.spec.shape, dtype=np.bool_)
        objects: Dict[str, IntArray] = dict(self.static_cells)
        if self.arm is not None:
            objects["hc10_barc"] = self.spec.cells_inside(self.arm.points())
        robots = tuple(self.seen(robot) for robot in self.robots.values())
        for cells in objects.values():
            inside = cells[self.spec.contains(cells)]
            occupied[inside[:, 0], inside[:, 1], inside[:, 2]] = True
        standing = without_robots(self.spec, occupied, robots)
        return PlanRequest(self.spec, standing, robots, self.goals, assignments, objects)

    def pose_of(self, waypoint: Waypoint) -> Pose2:
        """Pose of an end effector sent to a waypoint."""
        x, y = self.spec.column_centre(waypoint.column)
        return Pose2(x, y, waypoint.yaw_rad)

    def free_at(self, pose: Pose2, besides: str = "") -> bool:
        """Whether a robot with its end effector there would touch nothing now; ``besides`` is not looked at."""
        solids = tuple(solid.at(pose) for solid in ANKURBOT)
        if any(fleet_distance(solids, other) <= TOUCH_M for other in self.statics.values()):
            return False
        others = (robot.solids for name, robot in self.robots.items() if name != besides)
        if any(fleet_distance(solids, other) <= TOUCH_M for other in others):
            return False
        return self.arm is None or points_distance(solids, cloud_of(self.arm.points())) > TOUCH_M

    def seen(self, robot: KinematicRobot) -> Robot:
        """A robot as the planner is shown it."""
        pose = robot.pose
        column = self.spec.column_of((pose.x, pose.y))
        x, y = self.spec.column_centre(column)
        mask = ankurbot_mask(self.spec, pose.yaw_rad, (pose.x - x, pose.y - y))
        return Robot(robot.name, column, pose.yaw_rad, mask, (pose.x, pose.y))

    def _check(self, robot: KinematicRobot, arm: Cloud) -> None:
        solids, touches = robot.solids, robot.touches
        blocked = False
        for name, others in self.statics.items():
            distance = fleet_distance(solids, others)
            touches.least_m = min(touches.least_m, distance)
            if distance < TOUCH_M:
                touches.stationary |= {name}
                blocked = blocked or distance < -BLOCK_DEPTH_M
        moving = [(name, fleet_distance(solids, o.solids)) for name, o in self.robots.items() if name != robot.name]
        moving.append(("hc10_barc", points_distance(solids, arm)))
        for name, distance in moving:
            touches.least_m = min(touches.least_m, distance)
            if distance < TOUCH_M:
                touches.moving |= {name}
        if blocked:
            robot.blocked = True
            robot.base.pose = robot.free_pose
        else:
            robot.free_pose = robot.pose


def solid_cells(spec: GridSpec, solids: Tuple[Upright, ...]) -> IntArray:
    """Cells (n, 3) inside the grid that upright boxes enter."""
    marked: BoolArray = np.zeros(spec.shape, dtype=bool)
    step = float(spec.resolution.min()) / 4.0
    for solid in solids:
        spans = [*solid.half, (solid.z[1] - solid.z[0]) / 2.0]
        axes = [np.linspace(-h + 1e-6, h - 1e-6, max(2, math.ceil(2 * h / step) + 1)) for h in spans]
        x, y, z = (a.ravel() for a in np.meshgrid(*axes, indexing="ij"))
        c, s = math.cos(solid.centre.yaw_rad), math.sin(solid.centre.yaw_rad)
        middle = (solid.z[0] + solid.z[1]) / 2.0
        points = np.column_stack([solid.centre.x + c * x - s * y, solid.centre.y + s * x + c * y, middle + z])
        cells, inside = spec.cells_of(points)
        own = cells[inside]
        marked[own[:, 0], own[:, 1], own[:, 2]] = True
    return np.argwhere(marked).astype(np.int64)
