"""A kinematic cell for the Commander's core: robots obey, debris lies, maps come 30 times a simulated second."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field, replace

import numpy as np

from yarm.commander.events import (
    CancelGoal,
    ClockReset,
    DeleteDone,
    DeleteObject,
    GoalDone,
    Grasp,
    Log,
    MapUpdate,
    Outcome,
    RegistryUpdate,
    SanderChange,
    SendGoal,
    ServerUpdate,
    SetAssociation,
    ShowPlan,
    Tick,
)
from yarm.commander.machine import Commander
from yarm.commander.memory import Memory
from yarm.commander.params import CommanderParams
from yarm.commander.requests import Request
from yarm.commander.tools import Tools
from yarm.control.sander.states import SanderState
from yarm.geometry import CarriedPiece, CellMap, GridSpec, MappedObject, SeenPiece, quaternion_from_rpy, wrap_angle
from yarm.planning.registry import make_planner
from yarm.records import plain, read
from yarm.robots import bin as bins
from yarm.robots.ankurbot import ANKURBOT_BEAMS, ANKURBOT_DISCS
from yarm.robots.shapes import PieceShape, RobotShape

SPEC = GridSpec()
PERIOD_S = 1.0 / 30.0
SPEED_MPS = 1.0
TURN_RADPS = 0.8
SHAPE = RobotShape(ANKURBOT_DISCS, ANKURBOT_BEAMS)
AREA = "SPACE=SWITCH/AREA=11,29,17,32,0,10"
NO_CELLS = np.zeros((0, 3), dtype=np.int64)
PIECE = PieceShape(0.09, 0.04)
ON_PART_M, HELD_M, LANDED_M = 0.75, 0.83, 0.05
"""Height of a piece's middle on the part, under a hand and in a bin, metres."""
HAND_S = 2.0
"""Time a hand takes to pick up or let go, once over the place."""
REACH_M = 0.02
"""A hand meets a piece whose middle is so near."""


def box_cells(low, high):
    """Cells of a box between two corners, metres."""
    axes = [np.arange(a + 0.01, b, 0.03) for a, b in zip(low, high)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return SPEC.cells_inside(points)


def _codes(cells):
    """One number for each cell (n, 3), also of those outside the grid."""
    x, y, z = np.asarray(cells, dtype=np.int64).T + 4096
    return frozenset(((x << 40) + (y << 20) + z).tolist())


TABLE = box_cells((-0.45, -0.60, 0.0), (0.45, 0.60, 0.70))
STAND = box_cells((-1.30, -0.20, 0.0), (-0.90, 0.20, 0.70))


@dataclass
class FakeRobot:
    """A mobile robot that turns, then drives straight."""

    x: float
    y: float
    yaw: float
    goal: SendGoal | None = None
    stuck: bool = False
    holds: str = ""
    hand_s: float = 0.0
    passed: int = 0
    coasts: SendGoal | None = None
    coast_s: float = 0.0

    def step(self) -> bool:
        """Move for one period; true when the goal is reached."""
        if self.coasts is not None:
            self._coast()
            return False
        if self.goal is None or self.goal.target is None or self.stuck:
            return False
        target = self.goal.via[self.passed] if self.passed < len(self.goal.via) else self.goal.target
        left = wrap_angle(target.yaw_rad - self.yaw)
        if abs(left) > 1e-9:
            self.yaw = wrap_angle(self.yaw + math.copysign(min(abs(left), TURN_RADPS * PERIOD_S), left))
            return False
        way = math.hypot(target.x - self.x, target.y - self.y)
        share = 1.0 if way < 1e-9 else min(1.0, SPEED_MPS * PERIOD_S / way)
        self.x += share * (target.x - self.x)
        self.y += share * (target.y - self.y)
        if share >= 1.0 and target is not self.goal.target:
            self.passed += 1
            return False
        return share >= 1.0

    def _coast(self):
        """On towards where it was sent, for a while after it was told to stop."""
        target = self.coasts.via[self.passed] if self.passed < len(self.coasts.via) else self.coasts.target
        way = math.hypot(target.x - self.x, target.y - self.y)
        share = 0.0 if way < 1e-9 else min(1.0, SPEED_MPS * PERIOD_S / way)
        self.x += share * (target.x - self.x)
        self.y += share * (target.y - self.y)
        self.coast_s -= PERIOD_S
        if self.coast_s <= 0.0:
            self.coasts = None


@dataclass
class FakeArm:
    """A manipulator: a tip that stands still, cells (n, 3) of its body if it has one, and what it was told."""

    tip: tuple = (-0.25, 0.0, 0.75)
    area: str = AREA
    state: SanderState = SanderState.STORAGE
    on: bool = False
    told: list = field(default_factory=list)
    body: np.ndarray | None = None

    @property
    def cells(self):
        """Where it is."""
        points = [(*self.tip[:2], self.height_m), (*self.tip[:2], self.height_m + 0.05)]
        return SPEC.cells_inside(points) if self.body is None else self.body

    @property
    def height_m(self):
        """How high its tip is."""
        return self.tip[2] if self.on else 1.2


class FakeCell:
    """The world around a Commander; ``execution`` of all of them is a test's to choose."""

    execution = CommanderParams.execution

    def __init__(self, params=None, planner="yarm", **robots):
        """Robots by name: (x, y, yaw) of the end effector."""
        self.params = replace(params or CommanderParams(), execution=self.execution)
        self._planner = planner
        self.commander = self._new_commander()
        self.robots = {name: FakeRobot(*pose) for name, pose in robots.items()}
        self.arms = {}
        self.debris = {}
        self.heights = {}
        self.bins = {}
        self.targets = {}
        self.statics = {"table": TABLE, "stand": STAND}
        self.obstacles = {}
        self.now = 0.0
        self.silent = False
        self.lost = set()
        self.fail_next = {}
        self.deletes = True
        self.leaky = set()
        self.seen_off = (0.0, 0.0)
        self.handless = set()
        self.blocked_bins = set()
        self.said = []
        self.shown = []
        self.sent = []
        self.cancelled = []
        self.orders = []
        self.coast_s = 0.0
        self.association = []
        self.touches = []
        self._events = []
        self._registered = None
        self._looked_at, self._taken = {}, {}

    def request(self, **fields):
        """Ask for a change of state."""
        reply, actions = self.commander.request(Request(**fields), self.now)
        self._do(actions)
        return reply

    def run(self, until, limit_s=300.0):
        """Let time run until a condition holds.

        Raises:
            TimeoutError: it did not within the limit.
        """
        end = self.now + limit_s
        while not until():
            if self.now > end:
                status = self.commander.status(self.now)
                raise TimeoutError(f"not within {limit_s} s: {status}; last said: {self.said[-8:]}")
            self.tick()

    def run_for(self, seconds):
        """Let time run."""
        end = self.now + seconds
        self.run(lambda: self.now >= end, seconds + 1.0)

    def idle(self):
        """The Commander is not busy."""
        return not self.commander.busy

    @property
    def status(self):
        """What the Commander shows."""
        return self.commander.status(self.now)

    def calibrate(self):
        """From IDLE to CALIBRATION, done."""
        assert self.request(current_state=True).success
        assert self.request(next_state=True).success
        self.run(self.idle, 60.0)
        assert self.status.outcome == "succeeded", self.status

    def restart(self):
        """The simulator starts again."""
        self.now = 0.0
        for robot in self.robots.values():
            robot.goal = None
        self._step(ClockReset())

    def start_commander_again(self, taken_up=False):
        """The Commander dies and a new one takes over, with its memory or without; what is latched reaches it."""
        for robot in self.robots.values():
            robot.goal = None
        written = json.dumps(plain(self.commander.memory(self.now)))
        self.commander, self._registered, self._events = self._new_commander(), None, []
        if taken_up:
            self._do(self.commander.take_up(read(Memory, json.loads(written)), self.now))
        self._events += [Grasp(name, bool(robot.holds)) for name, robot in sorted(self.robots.items())]
        self._events += [SanderChange(name, arm.state) for name, arm in sorted(self.arms.items())]

    def _new_commander(self):
        tools = Tools(make_planner(self._planner, self.params.planner_params), np.random.default_rng(self.params.seed))
        return Commander(self.params, tools)

    def tick(self):
        """One camera set."""
        self.now += PERIOD_S
        self._register()
        for name, robot in self.robots.items():
            moves = robot.goal is not None or robot.coasts is not None
            if moves and name not in self.lost and robot.step():
                self._arrive(name, robot)
            if robot.holds:
                self.debris[robot.holds] = (robot.x, robot.y)
        self._note_touches()
        events, self._events = self._events, []
        for event in events:
            self._step(event)
        self._step(Tick() if self.silent else MapUpdate(self.map(), self.people()))

    def lose(self, name):
        """A robot's action server dies."""
        self.lost.add(name)
        self._events.append(ServerUpdate(name, False))

    def find(self, name):
        """A robot's action server is back, without memory."""
        self.lost.discard(name)
        if name in self.robots:
            self.robots[name].goal = None
        self._events.append(ServerUpdate(name, True))

    def people(self):
        """What is followed that nobody registered."""
        return ()

    def map(self):
        """The occupancy map of now."""
        grid = np.zeros(SPEC.shape, dtype=np.int8)
        objects = {}
        for name, cells in {**self.statics, **self.obstacles}.items():
            objects[name] = MappedObject(
                name, "Obstacle", 1, tuple(SPEC.centres(cells).mean(axis=0)), (0, 0, 0, 1), cells
            )
        for name, (x, y) in self.bins.items():
            walls = [(-0.19, 0.0), (0.19, 0.0), (0.0, -0.19), (0.0, 0.19)]
            cells = SPEC.cells_inside([(x + dx, y + dy, z) for dx, dy in walls for z in np.arange(0.02, 0.6, 0.03)])
            objects[name] = MappedObject(name, "Obstacle", 6, (x, y, bins.RIM_M), (0, 0, 0, 1), cells)
        for name, (x, y) in self.debris.items():
            z = self.heights.get(name, ON_PART_M)
            cells = SPEC.cells_inside([(x + dx, y + dy, z) for dx in (-0.05, 0.0, 0.05) for dy in (-0.02, 0.02)])
            seen = SeenPiece(12, (x + self.seen_off[0], y + self.seen_off[1], z + 0.02), 0.0, 0.1, 0.04)
            holder = next((robot for robot, body in self.robots.items() if body.holds == name), None)
            on_hand = CarriedPiece(holder, (0.0, 0.0, z - 0.97), (0, 0, 0, 1)) if holder else None
            shown = (NO_CELLS, None, on_hand) if holder else (cells, seen)
            objects[name] = MappedObject(name, "Debris", 2, (x, y, z), (0, 0, 0, 1), *shown)
        for name, (x, y) in self.targets.items():
            objects[name] = MappedObject(name, "Target", 3, (x, y, 0.89), (0, 0, 0, 1), NO_CELLS)
        for name, robot in self.robots.items():
            cells = SHAPE.mask(SPEC, robot.yaw).at(SPEC.column_of((robot.x, robot.y)))
            quaternion = tuple(quaternion_from_rpy(0, 0, robot.yaw))
            inside = cells[SPEC.contains(cells)]
            objects[name] = MappedObject(name, "Mobile", 4, (robot.x, robot.y, 0.89), quaternion, inside)
        for name, arm in self.arms.items():
            place = (*arm.tip[:2], arm.height_m)
            objects[name] = MappedObject(name, "Manipulator", 5, place, (0, 0, 0, 1), arm.cells)
        for thing in objects.values():
            grid[tuple(thing.cells.T)] += 1
        return CellMap(self.now, SPEC, np.minimum(grid, 2), objects)

    def _note_touches(self):
        """Who overlaps whom, when a robot has moved or something stands elsewhere."""
        standing = {**self.statics, **self.obstacles}
        standing.update({name: arm.body for name, arm in self.arms.items() if arm.body is not None})
        seen = {name: (id(cells), len(cells)) for name, cells in standing.items()}
        seen.update({name: (robot.x, robot.y, robot.yaw) for name, robot in self.robots.items()})
        if seen == self._looked_at:
            return
        for name, cells in standing.items():
            if seen[name] != self._looked_at.get(name):
                self._taken[name] = _codes(cells)
        self._looked_at = seen
        own = {
            name: _codes(SHAPE.mask(SPEC, robot.yaw).at(SPEC.column_of((robot.x, robot.y))))
            for name, robot in self.robots.items()
        }
        for name, codes in own.items():
            touched = [other for other in standing if not codes.isdisjoint(self._taken[other])]
            touched += [other for other in own if other > name and not codes.isdisjoint(own[other])]
            self.touches += [(self.now, name, other) for other in touched]

    def _register(self):
        kinds = dict.fromkeys(self.robots, "Mobile")
        kinds.update(dict.fromkeys(self.arms, "Manipulator"))
        kinds.update(dict.fromkeys(self.debris, "Debris"))
        kinds.update(dict.fromkeys(self.targets, "Target"))
        if kinds != self._registered:
            known = set(self._registered or {})
            self._registered = kinds
            pieces = dict.fromkeys(self.debris, PIECE)
            self._step(RegistryUpdate(kinds, dict.fromkeys(self.robots, SHAPE), pieces))
            for name in sorted((set(self.robots) | set(self.arms)) - known - self.lost):
                self._step(ServerUpdate(name, True))

    def _step(self, event):
        self._do(self.commander.step(event, self.now))

    def _do(self, actions):
        for action in actions:
            if isinstance(action, SendGoal):
                self.sent.append((self.now, action))
                self._take(action)
            elif isinstance(action, CancelGoal):
                self._cancel(action)
            elif isinstance(action, SetAssociation):
                self.association.append((self.now, action.on))
            elif isinstance(action, DeleteObject):
                self._delete(action.name)
            elif isinstance(action, ShowPlan):
                self.shown.append(action)
            elif isinstance(action, Log):
                self.said.append(action.text)

    def _take(self, goal):
        self.orders.append(goal)
        failure = self.fail_next.pop(goal.robot, None)
        if failure is not None:
            self._events.append(GoalDone(goal.robot, goal.serial, *failure))
        elif goal.robot in self.arms:
            self._tell(self.arms[goal.robot], goal)
        elif goal.robot in self.handless and " " in goal.action:
            said = f"{goal.action}: {goal.robot} has no hand"
            self._events.append(GoalDone(goal.robot, goal.serial, Outcome.REJECTED, said))
        elif goal.action == "CALIBRATION":
            self._events.append(GoalDone(goal.robot, goal.serial, Outcome.SUCCEEDED, "SPACE=XY/AREA=17,7,15"))
        else:
            self.robots[goal.robot].goal, self.robots[goal.robot].passed = goal, 0

    def _tell(self, arm, goal):
        arm.told.append((self.now, goal.action))
        answer = arm.area if goal.action == "CALIBRATION" else ""
        if goal.action in ("ON", "OFF"):
            arm.on = goal.action == "ON"
        else:
            calibrated = goal.action == "CALIBRATION"
            arm.state = SanderState.SCAN_TO_PATH if calibrated else SanderState.STORAGE
            arm.on = False
            self._events.append(SanderChange(goal.robot, arm.state))
        self._events.append(GoalDone(goal.robot, goal.serial, Outcome.SUCCEEDED, answer))

    def _cancel(self, action):
        robot = self.robots.get(action.robot)
        self.cancelled.append((self.now, action.robot))
        if robot is not None and robot.goal is not None and robot.goal.serial == action.serial:
            if self.coast_s > 0.0 and robot.goal.target is not None:
                robot.coasts, robot.coast_s = robot.goal, self.coast_s
            self._end(action.robot, Outcome.PREEMPTED)

    def _arrive(self, name, robot):
        """At the target of a goal; a hand begins there, and is done a while later."""
        word = robot.goal.action.split(" ")[0]
        if word not in ("PICK", "DROP"):
            self._end(name, Outcome.SUCCEEDED)
            return
        robot.hand_s += PERIOD_S
        if robot.hand_s < HAND_S:
            return
        robot.hand_s = 0.0
        fault = self._pick(name, robot) if word == "PICK" else self._drop(name, robot)
        self._end(name, Outcome.ABORTED if fault else Outcome.SUCCEEDED, fault)

    def _pick(self, name, robot):
        """What lies under a hand hangs on it; why nothing does."""
        if robot.holds:
            return "something hangs on the cup already"
        free = set(self.debris) - {other.holds for other in self.robots.values()}
        near = [n for n in sorted(free) if math.dist(self.debris[n], (robot.x, robot.y)) < REACH_M]
        if not near or self.heights.get(near[0], ON_PART_M) < ON_PART_M or name in self.leaky:
            return "nothing met down to 0.200 m, where the lift ends"
        robot.holds, self.heights[near[0]] = near[0], HELD_M
        self._events.append(Grasp(name, True))
        return ""

    def _drop(self, name, robot):
        """What hangs on a hand falls into the bin below, or onto the floor; why it does not."""
        if not robot.holds:
            return "nothing hangs on the cup"
        below = [n for n, at in self.bins.items() if math.dist(at, (robot.x, robot.y)) < 0.18]
        if below and below[0] in self.blocked_bins:
            return "met something 0.100 m down; is the bin full?"
        self.release(name)
        return ""

    def release(self, name):
        """A hand lets go of what it holds, which falls down."""
        robot = self.robots[name]
        self.heights[robot.holds] = LANDED_M
        robot.holds = ""
        self._events.append(Grasp(name, False))

    def binned(self, piece):
        """Whether a piece lies in a bin, held by nobody: ground truth."""
        x, y = self.debris[piece]
        held = any(robot.holds == piece for robot in self.robots.values())
        spots = [(x - bx, y - by, self.heights.get(piece, ON_PART_M)) for bx, by in self.bins.values()]
        return not held and any(bins.inside(np.array(spot)) for spot in spots)

    def _end(self, name, outcome, message=""):
        robot = self.robots[name]
        text = message or ("done" if outcome is Outcome.SUCCEEDED else "")
        self._events.append(GoalDone(name, robot.goal.serial, outcome, text))
        robot.goal = None

    def _delete(self, name):
        if self.deletes:
            self.debris.pop(name, None)
            self.targets.pop(name, None)
        self._events.append(DeleteDone(name, self.deletes, "gone" if self.deletes else "refused"))
