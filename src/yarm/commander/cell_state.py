"""What the Commander knows of the cell: the newest map, its robots on the grid, servers, holds, goals and tasks."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import Callable, Dict, List, Mapping, Optional, Sequence, Set, Tuple

import numpy as np

from yarm.commander.answers import Answer
from yarm.commander.events import GoalDone, Outcome, Target
from yarm.commander.foreseen import where_they_may_be
from yarm.commander.goals import ActiveGoal, GoalBook
from yarm.commander.params import CommanderParams
from yarm.commander.pieces import Load, Refusal, Sights, bins_of, height_in, shapes_seen
from yarm.control.actions import MobileAction, SearchSpace
from yarm.control.sander.states import SanderState
from yarm.geometry import BoolArray, CellMap, GridSpec, IntArray, MappedObject, Mask, wrap_angle, yaw_of_quaternion
from yarm.geometry.kinds import ObjectKind
from yarm.planning.model.hidden import HiddenSpace
from yarm.planning.model.types import Column, FleetPlan, Goal, GoalKind, PlanRequest, Robot, Waypoint, without_robots
from yarm.planning.tasks.task_queue import TaskQueue
from yarm.planning.why.causes import Circumstances
from yarm.robots.ankurbot import HAND_STROKE_M
from yarm.robots.shapes import PieceShape, RobotShape
from yarm.safety.people import Tracked

SEEN_LOW_M = 0.03
"""The top of a piece may be seen so much too low, metres."""


@dataclass(frozen=True, eq=False)
class TrackedRobot:
    """A mobile robot on the grid.

    Attributes:
        name: its name.
        x: end effector, metres, world.
        y: likewise.
        yaw_rad: heading measured, rad.
        column: column it counts as being in (with hysteresis).
        nominal_yaw_rad: heading it counts as having: the last one commanded while it is near it.
        mask: its cells.
        mask_at: its cells at any heading, rad; None when its drawing is not known.
    """

    name: str
    x: float
    y: float
    yaw_rad: float
    column: Column
    nominal_yaw_rad: float
    mask: Mask
    mask_at: Optional[Callable[[float], Mask]] = None

    @property
    def cells(self) -> IntArray:
        """Absolute cells (n, 3), possibly outside the grid."""
        return self.mask.at(self.column)

    def distance_to(self, spec: GridSpec, column: Column) -> float:
        """Horizontal distance from the end effector to the centre of a column, metres."""
        x, y = spec.column_centre(column)
        return math.hypot(x - self.x, y - self.y)


class CellState:
    """Everything that events bring and work needs; one for each Commander."""

    def __init__(self, params: CommanderParams) -> None:
        """Nothing known yet."""
        self.params = params
        self.goals = GoalBook()
        self.kinds: Dict[str, str] = {}
        self.registry_complete = False
        self.shapes: Dict[str, RobotShape] = {}
        self.pieces: Dict[str, PieceShape] = {}
        self.connected: Set[str] = set()
        self.sander: Dict[str, SanderState] = {}
        self.holds: Dict[str, str] = {}
        self.answers: Dict[str, Answer] = {}
        self.homes: Dict[str, Target] = {}
        self.map: Optional[CellMap] = None
        self.robots: Dict[str, TrackedRobot] = {}
        self.queue = TaskQueue(params.planner_params)
        self.grasping: Dict[str, bool] = {}
        self.loads: Dict[str, Load] = {}
        self.at_work: Set[str] = set()
        self.refused: Dict[str, Refusal] = {}
        self.full_bins: Dict[str, str] = {}
        self.sights = Sights()
        self.hidden = HiddenSpace(params.hidden_params)
        self._goal_columns: Dict[str, Column] = {}
        self._seen_shapes: Dict[str, PieceShape] = {}
        self._foreseen: Dict[str, IntArray] = {}
        self.turns_finer = False

    def forget_poses(self) -> None:
        """The simulator was started again: nothing seen or learnt before is true any more."""
        self.map = None
        self.robots = {}
        self.answers = {}
        self.homes = {}
        self.holds = {}
        self.queue.see(())
        self.grasping, self.loads, self.refused, self.full_bins = {}, {}, {}, {}
        self.at_work = set()
        self.sights = Sights()
        self.hidden.forget()
        self._goal_columns, self._seen_shapes, self._foreseen = {}, {}, {}
        self.turns_finer = False

    @property
    def mobiles(self) -> List[str]:
        """Names of the mobile robots, ordered."""
        return sorted(name for name, kind in self.kinds.items() if kind == ObjectKind.MOBILE)

    @property
    def manipulators(self) -> List[str]:
        """Names of the manipulators, ordered."""
        return sorted(name for name, kind in self.kinds.items() if kind == ObjectKind.MANIPULATOR)

    def of_kind(self, kind: str) -> List[MappedObject]:
        """Objects of a kind on the map, ordered by name."""
        objects = self.map.objects if self.map is not None else {}
        return [objects[name] for name in sorted(objects) if objects[name].kind == kind]

    def note_hand(self, goal: ActiveGoal, event: GoalDone) -> None:
        """Take in the end of a hand's work: it holds the piece, or nothing; when in doubt its own word counts."""
        picks = MobileAction.of(goal.action) is MobileAction.PICK
        done, holds = event.outcome is Outcome.SUCCEEDED, self.grasping.get(goal.robot, False)
        if picks and (done or holds):
            piece = goal.action.split(" ", 1)[1]
            self.loads[goal.robot] = Load(piece, self._piece_shape(piece))
        elif not picks and (done or not holds):
            self.loads.pop(goal.robot, None)

    def _piece_shape(self, name: str) -> Optional[PieceShape]:
        """The shape of a piece: as it is registered; of what nobody registered as it is seen, or was last."""
        return self.pieces.get(name, self._seen_shapes.get(name))

    def take_map(self, cell_map: CellMap, people: Sequence[Tracked] = ()) -> None:
        """Track every robot and goal on a new map, and see where people may be before a robot stands."""
        self.map = cell_map
        ahead_s, now_s = self.params.people_s, cell_map.stamp_s
        people = people if ahead_s > 0.0 else ()
        self._foreseen = where_they_may_be(cell_map.spec, people, cell_map.objects.keys(), now_s, ahead_s)
        self._seen_shapes.update(shapes_seen(cell_map.objects))
        self._see_loads()
        self.robots = {found.name: self._track(found, cell_map.spec) for found in self.of_kind("Mobile")}
        self.hidden.see(cell_map, [robot.cells for robot in self.robots.values()])
        self.queue.see(cell_map.objects)
        self.sights.see(cell_map.objects)
        for name, refusal in list(self.refused.items()):
            found = cell_map.objects.get(name)
            if found is None or not refusal.holds(name, cell_map.objects) or self.bin_of(found):
                del self.refused[name]
        for thing in self.of_kind(GoalKind.DEBRIS) if self.bins else []:
            reason = self._too_low(thing)
            if reason:
                self.refused.setdefault(thing.name, Refusal(reason, (thing.position_m[0], thing.position_m[1])))
        columns = {}
        for thing in self.of_kind(GoalKind.DEBRIS) + self.of_kind(GoalKind.TARGET) + self.bins:
            columns[thing.name] = self._held(cell_map.spec, self.place_of(thing), self._goal_columns.get(thing.name))
        self._goal_columns = columns

    def _see_loads(self) -> None:
        """What the map shows on a hand that holds something is its load, whatever it was told to pick up.

        A load that the map showed and shows no more is lost, and so is one whose hand says that it holds nothing.
        """
        shown = {found.carried.robot: found.name for found in self.of_kind(GoalKind.DEBRIS) if found.carried}
        for robot in sorted({*shown, *self.loads} - self.at_work):
            piece, load, holds = shown.get(robot), self.loads.get(robot), self.grasping.get(robot)
            if piece is not None and holds:
                self.loads[robot] = Load(piece, self._piece_shape(piece), seen=True)
            elif load is not None and (load.seen or holds is False):
                del self.loads[robot]

    def _too_low(self, thing: MappedObject) -> str:
        """Why a piece lies too low for any hand; empty when it does not, is carried, or lies in a bin."""
        if thing.carried or thing.name in self.carried or self.bin_of(thing):
            return ""
        cups = [shape.lowest_at_tip_m for name, shape in self.shapes.items() if name in self.robots]
        reach_m = min(filter(math.isfinite, cups), default=-math.inf) - HAND_STROKE_M
        top_m = self.place_of(thing)[2]
        if top_m > reach_m - SEEN_LOW_M:
            return ""
        return f"its top is {top_m:.2f} m high, and the hands reach down to {reach_m:.2f} m"

    def open_goals(self) -> Dict[str, Goal]:
        """Debris and targets on the map that nobody is done with, by name; and the bins, for each robot with a load."""
        goals, leaving = {}, self.queue.leaving | self.carried | set(self.refused)
        taking = tuple(self._goal_columns[found.name] for found in self.bins if not self.full(found))
        for thing in self.of_kind(GoalKind.DEBRIS) + self.of_kind(GoalKind.TARGET):
            if thing.name not in leaving and not self.bin_of(thing):
                kind, column = GoalKind(thing.kind), self._goal_columns[thing.name]
                onward = taking if kind is GoalKind.DEBRIS else ()
                goals[thing.name] = Goal(thing.name, kind, column, thing.cells, onward=onward)
        for robot in sorted(set(self.loads) - self.at_work):
            for found in self.bins:
                if not self.full(found):
                    name = f"{found.name}/{robot}"
                    goals[name] = Goal(name, GoalKind.BIN, self._goal_columns[found.name], robot=robot)
        return goals

    @property
    def bins(self) -> List[MappedObject]:
        """The bins on the map that debris goes to, ordered by name; none when it is deleted."""
        return bins_of(self.map.objects) if self.map is not None and self.params.bins_used else []

    @property
    def carried(self) -> Set[str]:
        """Names of the pieces that hang on hands."""
        return {load.piece for load in self.loads.values()}

    def bin_of(self, thing: MappedObject) -> str:
        """Name of the bin that something lies in; empty for none."""
        return next((found.name for found in self.bins if not math.isnan(height_in(found, thing))), "")

    def full(self, found: MappedObject) -> str:
        """Why a bin takes nothing more; empty when it does."""
        heights = [height_in(found, thing) for thing in self.of_kind(GoalKind.DEBRIS) if thing.name not in self.carried]
        level = max((height for height in heights if not math.isnan(height)), default=0.0)
        limit = self.params.bin_full_m
        high = f"a piece in it lies {level:.2f} m high, at most {limit:g}" if level > limit else ""
        return self.full_bins.get(found.name, "") or high

    def place_of(self, thing: MappedObject) -> Tuple[float, float, float]:
        """Where an end effector is wanted for something, metres: where a piece is seen when hands take it."""
        if self.params.bins_used and thing.kind == GoalKind.DEBRIS:
            return self.sights.top_of(thing)
        return thing.position_m

    def private_areas(self, margin: int = 0) -> Dict[str, BoolArray]:
        """Columns (gx, gy) of each manipulator's private area, inflated by a margin of columns, by its name."""
        spec = self.spec
        areas = {}
        for name, answer in sorted(self.answers.items()):
            if name in self.kinds and answer.space is SearchSpace.SWITCH:
                areas[name] = _inflated(answer.private_columns(spec), margin)
        return areas

    def private_columns(self, margin: int = 0) -> BoolArray:
        """Columns (gx, gy) of all manipulators' private areas together, inflated by a margin of columns."""
        columns = np.zeros(self.spec.shape[:2], dtype=bool)
        for area in self.private_areas(margin).values():
            columns |= area
        return columns

    def request(
        self,
        goals: Mapping[str, Goal],
        assignments: Mapping[str, str],
        forbidden: Optional[BoolArray] = None,
        places: Optional[Mapping[str, Robot]] = None,
        foreseeing: bool = True,
    ) -> PlanRequest:
        """The planning step for the newest map; robots in ``places`` stand there in it, the map has them nowhere.

        ``foreseeing``: people are wherever they may be before a robot stands, not only where the map shows them.
        """
        objects = self.map.objects if self.map is not None else {}
        apart = {*goals, *self.carried}
        others = {name: o.cells for name, o in objects.items() if o.kind != ObjectKind.MOBILE and name not in apart}
        others.update({name: self.robots[name].cells for name in self.unplanned})
        others.update(self.hidden.by_hider())
        others.update(self._foreseen if foreseeing else {})
        robots = tuple(
            self._keeping_turns(standing_as(robot, carries=self._load_of(name)))
            for name, robot in sorted(self.robots.items())
            if name not in self.unplanned
        )
        standing, elsewhere = self._standing(robots, foreseeing=foreseeing), places or {}
        fleet = tuple(elsewhere.get(robot.name, robot) for robot in robots)
        return PlanRequest(self.spec, standing, fleet, goals, dict(assignments), others, forbidden)

    def circumstances(self, request: PlanRequest, plan: Optional[FleetPlan]) -> Circumstances:
        """A request with what else is known when somebody asks why."""
        bare = {}
        for robot in request.robots:
            shape = self.shapes.get(robot.name)
            if robot.carries and shape is not None:
                bare[robot.name] = partial(shape.mask, self.spec)
        refused = {name: refusal.reason for name, refusal in self.refused.items()}
        return Circumstances(request, plan, self.params.planner_params, bare, refused)

    @property
    def outside(self) -> Tuple[str, ...]:
        """Robots whose end effector is in no column of the grid, ordered; to the planner they are obstacles."""
        gx, gy = self.spec.shape[:2]
        inside = {name for name, r in self.robots.items() if 0 <= r.column[0] < gx and 0 <= r.column[1] < gy}
        return tuple(sorted(set(self.robots) - inside))

    @property
    def unplanned(self) -> Tuple[str, ...]:
        """Robots that are not planned for, ordered: those outside, and those whose hands are at work."""
        return tuple(sorted({*self.outside, *(self.at_work & set(self.robots))}))

    def _load_of(self, robot: str) -> str:
        load = self.loads.get(robot)
        return load.piece if load is not None else ""

    def occupied_but(self, name: str) -> BoolArray:
        """(gx, gy, gz) cells that everything but one robot fills, other robots by their masks."""
        return self._standing((), solid=[other for other in self.robots if other != name])

    def robot_at(self, name: str, place: Waypoint, cells: IntArray) -> Robot:
        """A robot as it will stand at a waypoint, in cells (n, 3) if its drawing is not known."""
        shape, load = self._shape_of(name), self._load_of(name)
        if shape is None:
            mask = Mask.from_cells(cells, place.column, place.yaw_rad)
            return self._keeping_turns(Robot(name, place.column, place.yaw_rad, mask, carries=load))
        mask, mask_at = shape.mask(self.spec, place.yaw_rad), partial(shape.mask, self.spec)
        return self._keeping_turns(Robot(name, place.column, place.yaw_rad, mask, carries=load, mask_at=mask_at))

    def _keeping_turns(self, robot: Robot) -> Robot:
        """A robot that keeps to the turns from the heading it started with, and makes finer ones if all do."""
        home = self.homes.get(robot.name)
        turns_deg = (*self.params.turns_deg, *self.params.finer_turns_deg) if self.turns_finer else None
        return replace(robot, home_yaw_rad=None if home is None else home.yaw_rad, turns_deg=turns_deg)

    def seen_at(self, robot: TrackedRobot, place: Waypoint) -> bool:
        """A robot is seen at a waypoint, within the tolerances."""
        x, y = self.spec.column_centre(place.column)
        turned = abs(wrap_angle(robot.yaw_rad - place.yaw_rad)) <= math.radians(self.params.heading_tolerance_deg)
        return turned and max(abs(robot.x - x), abs(robot.y - y)) <= self.params.arrival_tolerance_m

    def seen_between(self, robot: TrackedRobot, start: Waypoint, end: Waypoint) -> bool:
        """A robot is seen on its step, a turn at the start and a straight way to the end, within the tolerances."""
        ends = np.array([self.spec.column_centre(start.column), self.spec.column_centre(end.column)])
        way, tip = ends[1] - ends[0], np.array([robot.x, robot.y]) - ends[0]
        share = np.clip(tip @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
        beside_m = float(np.linalg.norm(tip - share * way))
        turn = wrap_angle(end.yaw_rad - start.yaw_rad)
        made, left = wrap_angle(robot.yaw_rad - start.yaw_rad), wrap_angle(end.yaw_rad - robot.yaw_rad)
        beyond_rad = abs(made) + abs(left) - abs(turn)
        tolerance = math.radians(self.params.heading_tolerance_deg)
        return beside_m <= self.params.arrival_tolerance_m and beyond_rad <= 2.0 * tolerance

    def at(self, robot: TrackedRobot, goal: Goal) -> bool:
        """A robot is at a goal: in its column, and at its heading where it has one."""
        tolerance = math.radians(self.params.heading_tolerance_deg)
        turned = goal.yaw_rad is None or abs(wrap_angle(robot.yaw_rad - goal.yaw_rad)) <= tolerance
        return turned and robot.column == goal.column

    def waypoint_of(self, target: Target) -> Waypoint:
        """The waypoint that a pose of an end effector lies in."""
        return Waypoint(self.spec.column_of((target.x, target.y)), target.yaw_rad)

    def target_of(self, step: Waypoint) -> Target:
        """Pose of an end effector at a waypoint."""
        x, y = self.spec.column_centre(step.column)
        return Target(x, y, step.yaw_rad)

    @property
    def spec(self) -> GridSpec:
        """The grid of the newest map."""
        return self.map.spec if self.map is not None else GridSpec()

    def _standing(
        self, robots: Sequence[Robot], solid: Optional[Sequence[str]] = None, foreseeing: bool = True
    ) -> BoolArray:
        """The map (gx, gy, gz) without robots: neither the cells the cameras took for theirs nor those of their masks.

        Cells that no camera sees stand in it when they count as occupied. What is being deleted or hangs on a hand is
        gone from it too. Robots named ``solid`` (``unplanned``, when None) stand in it by their masks.
        """
        if self.map is None:
            return np.zeros(self.spec.shape, dtype=np.bool_)
        standing: BoolArray = self.map.grid != 0
        objects, leaving = self.map.objects, self.queue.leaving | self.carried
        gone = [found for name, found in objects.items() if found.kind == ObjectKind.MOBILE or name in leaving]
        there = [found for name, found in objects.items() if found.kind != ObjectKind.MOBILE and name not in leaving]
        for found in gone:
            standing[tuple(found.cells.T)] = False
        for found in there:
            standing[tuple(found.cells.T)] = True
        if self.hidden.occupied is not None:
            standing |= self.hidden.occupied
        for cells in self._foreseen.values() if foreseeing else ():
            standing[tuple(cells.T)] = True
        standing = without_robots(self.map.spec, standing, robots)
        for name in self.unplanned if solid is None else solid:
            cells = self.robots[name].cells
            standing[tuple(cells[self.spec.contains(cells)].T)] = True
        return standing

    def _track(self, found: MappedObject, spec: GridSpec) -> TrackedRobot:
        x, y = found.position_m[:2]
        yaw = yaw_of_quaternion(found.quaternion)
        before = self.robots.get(found.name)
        sent = self.goals.active.get(found.name)
        candidates = [spec.column_of((sent.target.x, sent.target.y))] if sent is not None and sent.target else []
        candidates += [before.column] if before is not None else []
        column = self._held(spec, found.position_m, *candidates)
        nominal = self._nominal_yaw(yaw, before, sent.target if sent is not None else None)
        shape = self._shape_of(found.name)
        if shape is not None:
            mask = shape.mask(spec, nominal)
        elif len(found.cells):
            mask = Mask.from_cells(found.cells, column, nominal)
        else:
            mask = Mask(np.array([[0, 0, spec.shape[2] // 2]], dtype=np.int64), nominal)
        mask_at = None if shape is None else partial(shape.mask, spec)
        return TrackedRobot(found.name, x, y, yaw, column, nominal, mask, mask_at)

    def _shape_of(self, name: str) -> Optional[RobotShape]:
        """What is known of a robot's solids, with what it carries."""
        shape, load = self.shapes.get(name), self.loads.get(name)
        if shape is not None and load is not None and load.shape is not None:
            return shape.with_load(load.shape)
        return shape

    def _nominal_yaw(self, yaw: float, before: Optional[TrackedRobot], target: Optional[Target]) -> float:
        tolerance = math.radians(self.params.heading_tolerance_deg)
        candidates = [target.yaw_rad] if target is not None else []
        candidates += [before.nominal_yaw_rad] if before is not None else []
        return next((c for c in candidates if abs(wrap_angle(yaw - c)) <= tolerance), yaw)

    def _held(self, spec: GridSpec, position: Tuple[float, ...], *candidates: Optional[Column]) -> Column:
        """Column of a point: the first candidate whose centre is near enough, else the one it lies in."""
        for candidate in candidates:
            if candidate is not None:
                x, y = spec.column_centre(candidate)
                if max(abs(position[0] - x), abs(position[1] - y)) <= self.params.arrival_tolerance_m:
                    return candidate
        return spec.column_of(position[:2])


def standing_as(robot: TrackedRobot, position_m: Optional[Tuple[float, float]] = None, carries: str = "") -> Robot:
    """A tracked robot as the planner sees it; arguments as of ``Robot``."""
    return Robot(
        robot.name,
        robot.column,
        robot.nominal_yaw_rad,
        robot.mask,
        position_m,
        carries,
        mask_at=robot.mask_at,
    )


def _inflated(columns: BoolArray, margin: int) -> BoolArray:
    """Columns with their neighbours on four sides, so many times over."""
    for _ in range(margin):
        inflated = columns.copy()
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            inflated |= _moved(columns, dx, dy)
        columns = inflated
    return columns


def _moved(columns: BoolArray, dx: int, dy: int) -> BoolArray:
    result = np.zeros_like(columns)
    gx, gy = columns.shape
    result[max(dx, 0) : gx + min(dx, 0), max(dy, 0) : gy + min(dy, 0)] = columns[
        max(-dx, 0) : gx + min(-dx, 0), max(-dy, 0) : gy + min(-dy, 0)
    ]
    return result
