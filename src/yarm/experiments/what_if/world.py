"""A kinematic cell around the real Commander: robots by their own control law, the real raster, maps of exact solids.

Everything that decides is what decides in the live cell: the Commander with its planner, task queue, checker and
supervision. There is no physics and no camera: a map shows robots and fixtures as they are and debris as it is seen,
with noise; what a robot touches does not stop it. A hand takes and lets go after the time it takes in physics.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Callable, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from yarm.commander.events import (
    Action,
    CancelGoal,
    Decision,
    DecisionKind,
    DeleteDone,
    DeleteObject,
    Event,
    GoalDone,
    Grasp,
    MapUpdate,
    Outcome,
    RegistryUpdate,
    SanderChange,
    SendGoal,
    ServerUpdate,
    ShowPlan,
    TaskState,
    TaskView,
)
from yarm.commander.machine import Commander
from yarm.commander.params import CommanderParams
from yarm.commander.requests import Request
from yarm.commander.states import State
from yarm.commander.tools import Tools
from yarm.control.actions import ArmAction, MobileAction
from yarm.control.base.controller import BaseController
from yarm.control.base.controller import Outcome as Drive
from yarm.control.base.model import BaseModel
from yarm.control.base.params import BaseParams
from yarm.control.sander.states import SanderState
from yarm.experiments.study.arm_track import arm_of, folded_points
from yarm.experiments.study.clearance import (
    ANKURBOT,
    Cloud,
    Upright,
    box,
    cloud_of,
    fleet_distance,
    points_distance,
    uprights,
)
from yarm.experiments.study.kinematic import FIXTURES, TICK_S, KinematicRobot, solid_cells
from yarm.experiments.what_if.cell import TUCKED, Cell, Placed
from yarm.geometry import (
    CarriedPiece,
    CellMap,
    FloatArray,
    GridSpec,
    IntArray,
    MappedObject,
    Pose2,
    SeenPiece,
    quaternion_from_rpy,
    transform_points,
)
from yarm.geometry.kinds import ObjectKind
from yarm.planning.registry import make_planner
from yarm.robots import bin as bins
from yarm.robots.ankurbot import (
    ANKURBOT_BEAMS,
    ANKURBOT_DISCS,
    ARM_REACH_M,
    EE_HEIGHT_M,
    HAND_BEAMS,
    HAND_DISCS,
    HAND_EE_HEIGHT_M,
)
from yarm.robots.hc10 import PRIVATE_AREA, Station, area_text
from yarm.robots.shapes import PieceShape, RobotShape

MAP_TICKS = 6
"""Ticks from one map to the next: 10 Hz, and as often clearances are looked at."""
SEEN_M = 0.005
"""Standard deviation of where debris is seen, metres."""
PIECE = PieceShape(0.09, 0.04)
"""Debris however it lies, as it is drawn."""
HAND_S = 2.0
"""Time a hand takes to pick up or let go, s, once the base stands over the place. (In physics
PICK 2.2 s and DROP 2.5 s with the base's last centimetre: ``run_experiment --case 1m1ma --seed 3 --sync``.)"""
LANDED_M = 0.05
"""How high a piece's middle lies in a bin, metres."""
MET_M = 0.03
"""A hand meets a piece whose middle is so near, metres."""
NO_CELLS: IntArray = np.zeros((0, 3), dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Drawing:
    """What the mobile robots look like.

    Attributes:
        shape: for the Commander.
        solids: about the end effector.
        height_m: of the end effector over the floor.
    """

    shape: RobotShape
    solids: Tuple[Upright, ...]
    height_m: float

    @property
    def held_below_m(self) -> float:
        """How far under the tip the middle of a piece on the hand is, metres."""
        return self.height_m - self.shape.lowest_at_tip_m + PIECE.height_m / 2.0


HANDLESS = Drawing(RobotShape(ANKURBOT_DISCS, ANKURBOT_BEAMS), ANKURBOT, EE_HEIGHT_M)
WITH_HANDS = Drawing(RobotShape(HAND_DISCS, HAND_BEAMS), uprights(HAND_DISCS, HAND_BEAMS), HAND_EE_HEIGHT_M)


@dataclass
class Mobile:
    """One mobile robot: its base, and the goal it works on."""

    body: KinematicRobot
    goal: Optional[SendGoal] = None
    hand_s: float = 0.0
    holds: str = ""


class ArmAtWork:
    """A manipulator on its raster, at its station, and its pauses."""

    def __init__(self, placed: Placed, share: float) -> None:
        """At work; so much of the raster is done, 0 to 1."""
        self.name = placed.name
        self.enabled = True
        self.pauses = 0
        self.paused_s = 0.0
        self._pose = Station(placed.x, placed.y, placed.yaw_rad).pose
        self._player = arm_of(share)
        self._joints = self._player.joints()
        self._cloud: Optional[Cloud] = None
        self._cells: Optional[IntArray] = None

    @property
    def area(self) -> str:
        """Its answer to CALIBRATION."""
        station = Station(float(self._pose[0, 3]), float(self._pose[1, 3]), math.atan2(*self._pose[1::-1, 0]))
        return f"SPACE=SWITCH/AREA={area_text(station.moved_area(GridSpec(), PRIVATE_AREA))}"

    def switch(self, enabled: bool) -> None:
        """Told to sand, or to pause."""
        self.pauses += self.enabled and not enabled
        self.enabled = enabled

    def step(self) -> None:
        """One tick."""
        self._player.step(TICK_S, self.enabled)
        self.paused_s += 0.0 if self.enabled else TICK_S
        joints = self._player.joints()
        if not np.array_equal(joints, self._joints):
            self._joints, self._cloud, self._cells = joints, None, None

    def cloud(self) -> Cloud:
        """Points on its links, metres, world."""
        if self._cloud is None:
            self._cloud = cloud_of(transform_points(self._pose, self._player.points()))
        return self._cloud

    def cells(self, spec: GridSpec) -> IntArray:
        """Cells (n, 3) that its links are in."""
        if self._cells is None:
            self._cells = spec.cells_inside(self.cloud().points)
        return self._cells

    def tip(self) -> FloatArray:
        """Its tool's tip, (3,) metres, world."""
        tip: FloatArray = transform_points(self._pose, np.array([self._player.tip()]))[0]
        return tip


class Fork:
    """One run of a forked cell."""

    def __init__(self, cell: Cell, params: CommanderParams, share: float, rng: np.random.Generator) -> None:
        """At the moment of the fork; nothing is commanded yet.

        Args:
            cell: as it is.
            params: of its Commander.
            share: of the raster that is done, 0 to 1.
            rng: of what debris is seen with.
        """
        self.now_s, self.done_s, self.least_m, self.refusals = 0.0, math.nan, math.inf, 0
        self.reasons: List[str] = []
        self.on_plan: Callable[[ShowPlan], None] = lambda shown: None
        self._spec, self._rng, self._ticks = GridSpec(), rng, 0
        tools = Tools(make_planner(params.planner, params.planner_params), np.random.default_rng(params.seed))
        self.commander = Commander(params, tools)
        self.arms = [ArmAtWork(arm, share) for arm in cell.arms if arm.kind != TUCKED]
        self._folded = {arm.name: cloud_of(_folded(arm)) for arm in cell.arms if arm.kind == TUCKED}
        self._drawing = WITH_HANDS if params.bins_used else HANDLESS
        self.robots = {robot.name: Mobile(_body(robot, self._drawing)) for robot in cell.robots}
        self._statics: Dict[str, Tuple[Upright, ...]] = {
            fixture.name: tuple(
                solid.at(Pose2(fixture.x, fixture.y, fixture.yaw_rad)) for solid in FIXTURES[fixture.kind]
            )
            for fixture in cell.fixtures
        }
        for thing in cell.obstacles:
            solid = box(thing.x, thing.y, thing.yaw_rad, thing.size, thing.z - thing.size[2] / 2.0)
            self._statics[thing.name] = (solid,)
        self._bins = {fixture.name: fixture for fixture in cell.bins}
        self._goals: Dict[str, Placed] = {thing.name: thing for thing in cell.goals}
        self._fixed = [self._fixed_object(name, solids) for name, solids in self._statics.items()]
        for name, cloud in self._folded.items():
            points = cloud.points
            middle = (float(points[0, 0]), float(points[0, 1]), float(points[0, 2]))
            cells = self._spec.cells_inside(points)
            self._fixed.append(_mapped(name, ObjectKind.OBSTACLE, middle, 0.0, cells))
        self._standing = _counted(self._spec, self._fixed)
        self._events: List[Event] = []
        self._looked: Tuple[Dict[str, Pose2], List[Cloud]] = ({}, [])
        self._seen: Dict[str, Tuple[Pose2, MappedObject]] = {}
        self._registered: Mapping[str, str] = {}
        self._do_of: Dict[type, Callable[..., None]] = {
            SendGoal: self._take,
            CancelGoal: self._cancel,
            DeleteObject: self._delete,
            ShowPlan: self._note_plan,
            Decision: self._note_decision,
        }

    def run(self, state: State, limit_s: float, observe: Callable[[], None] = lambda: None) -> str:
        """One mission from here; ``observe`` is called with each of its maps.

        Returns:
            why it did not clear within the limit, s, or "" when it did.
        """
        for request in (Request(current_state=True), Request(next_state=True)):
            self._do(self.commander.request(request, self.now_s)[1])
        self._until_idle(limit_s)
        if self.commander.status(self.now_s).outcome != "succeeded":
            return f"calibration: {self.commander.status(self.now_s).reason}"
        began_s = self.now_s
        self.least_m, self.done_s, self._looked = math.inf, 0.0, ({}, [])
        for arm in self.arms:
            arm.pauses, arm.paused_s = int(not arm.enabled), 0.0
        self._do(self.commander.request(Request(jump_state=int(state)), self.now_s)[1])
        self._until_idle(limit_s, observe)
        status = self.commander.status(self.now_s)
        self.done_s = max(0.0, self.done_s - began_s)
        if status.outcome == "succeeded":
            return ""
        return status.reason or f"not done within {limit_s:.0f} s: {_open(status.tasks)}"

    def _until_idle(self, limit_s: float, observe: Callable[[], None] = lambda: None) -> None:
        end_s = self.now_s + limit_s
        while self.commander.busy and self.now_s < end_s:
            self._tick()
            if self._ticks % MAP_TICKS == 0:
                observe()

    def _tick(self) -> None:
        self.now_s += TICK_S
        self._ticks += 1
        for arm in self.arms:
            arm.step()
        for name, robot in self.robots.items():
            self._move(name, robot)
        if self._ticks % MAP_TICKS == 0:
            self._register()
            events, self._events = self._events, []
            for event in events:
                self._step(event)
            self._look_around()
            self._step(MapUpdate(self._map()))

    def _move(self, name: str, robot: Mobile) -> None:
        robot.body.step(self.now_s)
        if robot.goal is None or robot.body.outcome is Drive.ACTIVE:
            return
        if robot.body.outcome is not Drive.SUCCEEDED:
            self._end(name, Outcome.ABORTED, f"the drive ended {robot.body.outcome.value}")
        elif MobileAction.of(robot.goal.action) in (MobileAction.PICK, MobileAction.DROP):
            self._handle(name, robot)
        else:
            self._end(name, Outcome.SUCCEEDED)

    def _handle(self, name: str, robot: Mobile) -> None:
        """A hand over its place works for a while."""
        robot.hand_s += TICK_S
        if robot.goal is None or robot.hand_s < HAND_S:
            return
        robot.hand_s, pose = 0.0, robot.body.pose
        if MobileAction.of(robot.goal.action) is MobileAction.DROP:
            if robot.holds:
                self._goals[robot.holds] = replace(self._goals[robot.holds], x=pose.x, y=pose.y, z=LANDED_M)
            robot.holds = ""
        else:
            free = set(self._goals) - {other.holds for other in self.robots.values()}
            places = {name: math.hypot(self._goals[name].x - pose.x, self._goals[name].y - pose.y) for name in free}
            near = [name for name, away_m in sorted(places.items()) if away_m < MET_M]
            if not near:
                self._end(name, Outcome.ABORTED, "nothing met")
                return
            robot.holds = near[0]
        self._events.append(Grasp(name, bool(robot.holds)))
        self._end(name, Outcome.SUCCEEDED)

    def _look_around(self) -> None:
        """The least distance of a robot to anything it must not touch."""
        poses = {name: robot.body.pose for name, robot in self.robots.items()}
        moving = [arm.cloud() for arm in self.arms]
        if poses == self._looked[0] and all(a is b for a, b in zip(moving, self._looked[1])):
            return
        self._looked = poses, moving
        bodies = {name: robot.body.solids for name, robot in self.robots.items()}
        for name, solids in bodies.items():
            for others in (*self._statics.values(), *(bodies[other] for other in bodies if other > name)):
                self.least_m = fleet_distance(solids, others, self.least_m)
            for cloud in (*moving, *self._folded.values()):
                self.least_m = points_distance(solids, cloud, self.least_m)

    # What the Commander is told.

    def _register(self) -> None:
        kinds = {name: thing.kind for name, thing in self._goals.items()}
        kinds.update(dict.fromkeys(self.robots, str(ObjectKind.MOBILE)))
        kinds.update({arm.name: str(ObjectKind.MANIPULATOR) for arm in self.arms})
        if kinds == self._registered:
            return
        first, self._registered = not self._registered, kinds
        pieces = {name: PIECE for name, kind in kinds.items() if kind == ObjectKind.DEBRIS}
        self._step(RegistryUpdate(kinds, dict.fromkeys(self.robots, self._drawing.shape), pieces))
        for name in [*self.robots, *(arm.name for arm in self.arms)] if first else []:
            self._step(ServerUpdate(name, True))

    def _map(self) -> CellMap:
        """What the cameras would show now."""
        objects = {found.name: found for found in self._fixed}
        holders = {robot.holds: name for name, robot in self.robots.items() if robot.holds}
        for name, thing in self._goals.items():
            objects[name] = self._goal(thing, holders.get(name))
        for name, robot in self.robots.items():
            known = self._seen.get(name)
            if known is None or known[0] != robot.body.pose:
                known = self._seen[name] = robot.body.pose, self._robot(name, robot.body.pose)
            objects[name] = known[1]
        for arm in self.arms:
            x, y, z = arm.tip().tolist()
            cells = arm.cells(self._spec)
            objects[arm.name] = _mapped(arm.name, ObjectKind.MANIPULATOR, (x, y, z), 0.0, cells)
        moving = list(objects.values())[len(self._fixed) :]
        grid = self._standing + _counted(self._spec, moving)
        return CellMap(self.now_s, self._spec, np.minimum(grid, 2), objects)

    def _robot(self, name: str, pose: Pose2) -> MappedObject:
        cells = self._drawing.shape.mask(self._spec, pose.yaw_rad).at(self._spec.column_of((pose.x, pose.y)))
        inside = cells[self._spec.contains(cells)]
        return _mapped(name, ObjectKind.MOBILE, (pose.x, pose.y, self._drawing.height_m), pose.yaw_rad, inside)

    def _goal(self, thing: Placed, holder: Optional[str]) -> MappedObject:
        name, kind, x, y, z = thing.name, thing.kind, thing.x, thing.y, thing.z
        if kind != ObjectKind.DEBRIS:
            return _mapped(name, kind, (x, y, z), 0.0, NO_CELLS)
        if holder is not None:
            pose = self.robots[holder].body.pose
            below_m = self._drawing.held_below_m
            carried = CarriedPiece(holder, (0.0, 0.0, -below_m), (0.0, 0.0, 0.0, 1.0))
            place = (pose.x, pose.y, self._drawing.height_m - below_m)
            return MappedObject(name, kind, 0, place, (0.0, 0.0, 0.0, 1.0), NO_CELLS, None, carried)
        dx, dy = self._rng.normal(0.0, SEEN_M, 2).tolist()
        spots = [(x + dx + i, y + dy + j, z) for i in (-0.05, 0.0, 0.05) for j in (-0.02, 0.02)]
        seen = SeenPiece(12, (x + dx, y + dy, z + PIECE.height_m / 2.0), 0.0, 0.15, 0.06)
        cells = self._spec.cells_inside(np.array(spots))
        return MappedObject(name, kind, 0, (x, y, z), (0.0, 0.0, 0.0, 1.0), cells, seen)

    def _fixed_object(self, name: str, solids: Tuple[Upright, ...]) -> MappedObject:
        middle = solids[0].centre
        height = bins.RIM_M if name in self._bins else solids[0].z[1]
        cells = solid_cells(self._spec, solids)
        place = self._bins[name] if name in self._bins else Placed(name, "", middle.x, middle.y)
        return _mapped(name, ObjectKind.OBSTACLE, (place.x, place.y, height), place.yaw_rad, cells)

    # What the Commander wants.

    def _step(self, event: Event) -> None:
        self._do(self.commander.step(event, self.now_s))

    def _do(self, actions: Tuple[Action, ...]) -> None:
        for action in actions:
            if type(action) in self._do_of:
                self._do_of[type(action)](action)

    def _take(self, goal: SendGoal) -> None:
        arm = next((arm for arm in self.arms if arm.name == goal.robot), None)
        if arm is not None:
            self._tell(arm, goal)
        elif MobileAction.of(goal.action) is MobileAction.CALIBRATE or goal.target is None:
            self._events.append(GoalDone(goal.robot, goal.serial, Outcome.SUCCEEDED, "SPACE=XY/AREA=17,7,15"))
        else:
            robot = self.robots[goal.robot]
            robot.goal, robot.hand_s = goal, 0.0
            *via, target = (Pose2(place.x, place.y, place.yaw_rad) for place in (*goal.via, goal.target))
            robot.body.send(target, tuple(via))

    def _tell(self, arm: ArmAtWork, goal: SendGoal) -> None:
        if goal.action in (ArmAction.ON.value, ArmAction.OFF.value):
            arm.switch(goal.action == ArmAction.ON.value)
            answer = ""
        else:
            answer = arm.area
            self._events.append(SanderChange(arm.name, SanderState.SCAN_TO_PATH))
        self._events.append(GoalDone(goal.robot, goal.serial, Outcome.SUCCEEDED, answer))

    def _cancel(self, action: CancelGoal) -> None:
        robot = self.robots.get(action.robot)
        if robot is not None and robot.goal is not None and robot.goal.serial == action.serial:
            robot.body.stop()
            self._end(action.robot, Outcome.PREEMPTED)

    def _end(self, name: str, outcome: Outcome, message: str = "") -> None:
        robot = self.robots[name]
        if robot.goal is not None:
            self._events.append(GoalDone(name, robot.goal.serial, outcome, message))
        robot.goal = None

    def _delete(self, action: DeleteObject) -> None:
        self._goals.pop(action.name, None)
        self._events.append(DeleteDone(action.name, True))

    def _note_plan(self, shown: ShowPlan) -> None:
        self.on_plan(shown)
        self.refusals = max(self.refusals, shown.refusals)
        if shown.refused and shown.refused not in self.reasons:
            self.reasons.append(shown.refused)

    def _note_decision(self, decision: Decision) -> None:
        if decision.kind in (DecisionKind.REACHED, DecisionKind.ENDED) and self.commander.busy:
            self.done_s = self.now_s


def _counted(spec: GridSpec, objects: Sequence[MappedObject]) -> npt.NDArray[np.int8]:
    """How many of the objects each cell of the grid is in."""
    grid = np.zeros(spec.shape, dtype=np.int8)
    for found in objects:
        grid[tuple(found.cells.T)] += 1
    return grid


def _folded(arm: Placed) -> FloatArray:
    """Points (n, 3) of an arm that stays folded, metres, world."""
    return transform_points(Station(arm.x, arm.y, arm.yaw_rad).pose, folded_points(arm.size))


def _body(robot: Placed, drawing: Drawing) -> KinematicRobot:
    pose = Pose2(robot.x, robot.y, robot.yaw_rad)
    base = BaseModel(pose=pose, reach_m=ARM_REACH_M)
    return KinematicRobot(robot.name, BaseController(BaseParams()), base, free_pose=pose, drawn=drawing.solids)


def _mapped(name: str, kind: str, place: Tuple[float, float, float], yaw_rad: float, cells: IntArray) -> MappedObject:
    x, y, z, w = quaternion_from_rpy(0.0, 0.0, yaw_rad)
    return MappedObject(name, str(kind), 0, place, (float(x), float(y), float(z), float(w)), cells)


def _open(tasks: Sequence[TaskView]) -> str:
    """The tasks that are left, in words."""
    left = [f"{task.goal} {task.status.value}" for task in tasks if task.status is not TaskState.REACHED]
    return ", ".join(left) or "nothing open"
