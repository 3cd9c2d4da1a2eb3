"""One run of the explorer from the start to the saved map: states, requests, sick sensors, the end of the time.

A pure step function around a controller. It never waits and knows no clock but the observation's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum
from typing import Callable, Dict, List, Optional, Tuple

from yarm.exploration.deadline import SETTLE_S, Lease, faded
from yarm.exploration.map_keeper import MapKeeper, SaveOrder
from yarm.exploration.model import Command, Controller, Detail, Event, Intent, Observation, Step
from yarm.exploration.params import ExploreParams
from yarm.exploration.surroundings import Surroundings
from yarm.exploration.watch import Complaint, SensorWatch
from yarm.exploration.way_home import WayHome
from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap

OUTSIDE_S = 1.0
"""A robot that is farther from its own map than it can have driven since, for so long, is outside it, s."""
MAP_AGE_S = 10.0
"""A map has come by then, s."""
STARTED_M = 0.3
"""A controller that has nothing left to map before the robot has driven this far is enclosed."""
OVER = "the time is over"


class State(str, Enum):
    """What the explorer is doing; the values are those of ExplorerStatus.state."""

    IDLE = "idle"
    EXPLORING = "exploring"
    PAUSED = "paused"
    RETURNING = "returning"
    DONE = "done"
    FAILED = "failed"


MOVING = (State.EXPLORING, State.RETURNING)
RUNNING = (*MOVING, State.PAUSED)
ENDED = (State.DONE, State.FAILED)


class Request(str, Enum):
    """What a person may ask for; the values are the names of the services."""

    START = "start"
    STOP = "stop"
    PAUSE = "pause"
    RESUME = "resume"
    SAVE_MAP = "save_map"
    RETURN_TO_START = "return_to_start"


ALLOWED: Dict[Request, Tuple[State, ...]] = {
    Request.START: (State.IDLE, State.DONE, State.FAILED),
    Request.STOP: RUNNING,
    Request.PAUSE: MOVING,
    Request.RESUME: (State.PAUSED,),
    Request.SAVE_MAP: tuple(State),
    Request.RETURN_TO_START: (State.EXPLORING, State.PAUSED),
}


@dataclass(frozen=True)
class Answer:
    """To a request.

    Attributes:
        success: it is done, or will be at the next pass.
        message: a sentence.
    """

    success: bool
    message: str


@dataclass(frozen=True, eq=False)
class SessionStep:
    """One pass.

    Attributes:
        command: what the base is told.
        state: what the session is doing.
        behaviour: of the controller, or "hold" while a sensor is sick.
        reason: why it stands or ended; empty when all is well.
        elapsed_s: since the start of the run; of the whole run once it has ended.
        left_s: until the deadline.
        known_m2: area that the map knows.
        bumps: how often the bumper was pressed.
        travelled_m: way that odometry says.
        events: what happened.
        complaints: sensors that cannot be trusted.
        intent: of the controller, for pictures.
        saves: maps to write now.
    """

    command: Command
    state: State
    behaviour: str
    reason: str
    elapsed_s: float
    left_s: float
    known_m2: float
    bumps: int
    travelled_m: float
    events: Tuple[Event, ...]
    complaints: Tuple[Complaint, ...]
    intent: Intent
    saves: Tuple[SaveOrder, ...]


class Session:
    """Not thread-safe; all times on the observation's clock, but the controller's count from the start of the run."""

    def __init__(self, params: ExploreParams, make: Callable[[], Controller], autostart: bool) -> None:
        """Idle.

        Args:
            params: limits.
            make: makes a controller for a run.
            autostart: the first run begins by itself as soon as every sensor is there.
        """
        self._params = params
        self._make = make
        self._autostart = autostart
        self.restart()

    def restart(self) -> None:
        """Start afresh: simulated time went backwards, or this is the beginning."""
        self._watch = SensorWatch()
        self._surroundings = Surroundings()
        self.keeper = MapKeeper()
        self._now_s = 0.0
        self._wanted: Optional[Request] = Request.START if self._autostart else None
        self._state = State.IDLE
        self._reason = "" if self._autostart else "waits for ~start"
        self._begin(0.0)

    def ask(self, request: Request) -> Answer:
        """Take in a request; it is acted on at the next pass."""
        if self._state not in ALLOWED[request]:
            states = ", ".join(state.value for state in ALLOWED[request])
            return Answer(False, f"{request.value} needs one of the states {states}; it is {self._state.value}")
        if request is Request.START and self._over:
            return Answer(False, f"{OVER}: another run needs the nodes started again")
        if request is Request.SAVE_MAP and self.keeper.newest is None:
            return Answer(False, "there is no map yet")
        self._wanted = request
        return Answer(True, f"{request.value}: taken up")

    def lease(self) -> Lease:
        """What the gate may let through until the next pass."""
        if self._state in RUNNING or self._over:
            return Lease(self._now_s, self._started_s, self._deadline_s, self._state in MOVING)
        return Lease(self._now_s, self._now_s, self._now_s + self._params.time_limit_s, False)

    def last_order(self, now_s: float) -> Optional[SaveOrder]:
        """The newest map, for a node that ends; none after the run's end, when its map has been saved."""
        return None if self._state in ENDED else self.keeper.order(now_s, "the node ends")

    def step(self, seen: Observation) -> SessionStep:
        """One pass of the loop.

        Args:
            seen: all that is known now, stamps on one clock.
        """
        self._now_s = seen.now_s
        self._events: List[Event] = []
        self._saves: List[Optional[SaveOrder]] = []
        seen, was_moving = self._look(seen), self._state in MOVING
        self._act_on_request(seen)
        command = self._drive(seen) if self._state in MOVING else Command()
        if not was_moving:
            command = Command()  # the gate must have heard first that the robot may move
        if self._state in RUNNING and seen.now_s >= self._deadline_s - SETTLE_S:
            self._over = True
            self._end(State.DONE, OVER)
        self._told = faded(self._limited(command), seen.now_s, self._deadline_s) if self._state in MOVING else Command()
        if self._state in RUNNING:
            self._saves.append(self.keeper.due(seen.now_s))
        return self._report()

    def _begin(self, now_s: float) -> None:
        self._controller: Optional[Controller] = None
        self._home = WayHome(self._params)
        self._started_s, self._ended_s = now_s, now_s
        self._deadline_s = now_s + self._params.time_limit_s
        self._over = False
        self._told, self._behaviour, self._intent = Command(), "stand", Intent()
        self._start: Optional[Pose2] = None
        self._here: Optional[Pose2] = None
        self._map_from_odom: Optional[Pose2] = None
        self._travelled_m, self._bumps = 0.0, 0
        self._outside_s: Optional[float] = None
        self._map_count, self._map_came_s = -1, 0.0
        self._complaints: Tuple[Complaint, ...] = ()
        self._before_pause = State.EXPLORING

    def _look(self, seen: Observation) -> Observation:
        """Sensors, way, bumps and map, whatever the state; what can be believed, marks in the map."""
        before = {complaint.sensor for complaint in self._complaints}
        self._complaints = self._watch.step(seen, self._told)
        for complaint in self._complaints:
            if complaint.sensor not in before:
                self._note(
                    "sensor", ("which", complaint.sensor), ("what", complaint.what), ("remedy", complaint.remedy)
                )
                if complaint.stands and self._state in MOVING:
                    self._saves.append(self.keeper.order(seen.now_s, f"{complaint.sensor} lost"))
        for sensor in sorted(before - {complaint.sensor for complaint in self._complaints}):
            self._note("sensor", ("which", sensor), ("what", "is back"))
        if seen.odometry is not None:
            here = seen.odometry.pose
            self._travelled_m += 0.0 if self._here is None or self._jumping else here.distance(self._here)
            self._here = here
        believed = self._watch.bumps(seen.bumps)
        self._count_bumps(seen)
        if any(complaint.sensor == "pose" for complaint in self._complaints):
            self.keeper.doubt()
        if self.keeper.is_lost(seen.map):
            self._surroundings.forget()
        seen = replace(self._surroundings.update(seen, believed), bumps=believed)
        self._saves.append(self.keeper.take(seen.map, seen.map_count, seen.now_s))
        return seen

    def _count_bumps(self, seen: Observation) -> None:
        for event in seen.bumps:
            if event.pressed and self._state in RUNNING:
                self._bumps += 1
                pose = seen.pose or Pose2(math.nan, math.nan)
                self._note("bump", ("sector", event.bumper.name), ("x", pose.x), ("y", pose.y), ("v", self._told.v_mps))

    @property
    def _jumping(self) -> bool:
        return any(complaint.sensor == "odometry" for complaint in self._complaints)

    @property
    def _blocked(self) -> str:
        """Why the robot may not move now; empty when it may."""
        return "; ".join(complaint.text for complaint in self._complaints if complaint.stands)

    def _act_on_request(self, seen: Observation) -> None:
        wanted = self._wanted
        if wanted is Request.START:
            self._reason = self._blocked and f"waits to start: {self._blocked}"
            if self._blocked:
                return
            complaints = self._complaints
            self._begin(seen.now_s)
            self._complaints = complaints
            self._controller = self._make()
            self._start, self._here = seen.pose, None
            self._turn_to(State.EXPLORING, "")
        elif wanted is Request.STOP:
            self._end(State.DONE, "stopped on request")
        elif wanted is Request.PAUSE:
            self._before_pause = self._state
            self._turn_to(State.PAUSED, "paused on request; ~resume goes on, and the time runs meanwhile")
        elif wanted is Request.RESUME:
            self._turn_to(self._before_pause, "")
        elif wanted is Request.RETURN_TO_START:
            self._return("asked to return to the start")
        elif wanted is Request.SAVE_MAP:
            self._saves.append(self.keeper.order(seen.now_s, "asked for"))
        self._wanted = None

    def _drive(self, seen: Observation) -> Command:
        if self._blocked:
            self._behaviour, self._reason = "hold", self._blocked
            return Command()
        fault = self._out_of_map(seen)
        if fault:
            self._end(State.FAILED, fault)
            return Command()
        jumped = self._watch.take_jump()
        self._follow_frame(seen, jumped)
        if self._state is State.RETURNING:
            return self._drive_home(replace(seen, jumped=jumped))
        assert self._controller is not None
        step = self._controller.step(self._relative(seen, jumped))
        self._events.extend(step.events)
        self._behaviour, self._reason, self._intent = step.behaviour, step.reason, step.intent
        if step.done:
            self._finish(step)
        elif self._params.return_to_start and self._home.must_leave(seen, self._start, self._left_s):
            self._return("the time left is what the way back needs")
        return step.command if self._state is State.EXPLORING else Command()

    def _relative(self, seen: Observation, jumped: bool) -> Observation:
        """The observation on the run's own clock."""
        began_s = self._started_s
        return replace(
            seen,
            now_s=seen.now_s - began_s,
            odometry=seen.odometry and replace(seen.odometry, stamp_s=seen.odometry.stamp_s - began_s),
            scan=seen.scan and replace(seen.scan, stamp_s=seen.scan.stamp_s - began_s),
            low=seen.low and replace(seen.low, stamp_s=seen.low.stamp_s - began_s),
            jumped=jumped,
        )

    def _follow_frame(self, seen: Observation, jumped: bool) -> None:
        """A mapping that began anew has another map frame: the start moves with it."""
        before, self._map_from_odom = self._map_from_odom, seen.map_from_odom
        if jumped and before is not None and seen.map_from_odom is not None and self._start is not None:
            self._start = seen.map_from_odom.compose(before.inverse()).compose(self._start)

    def _drive_home(self, seen: Observation) -> Command:
        assert self._start is not None
        step = self._home.step(seen, self._start)
        self._events.extend(step.events)
        self._behaviour, self._reason, self._intent = "return", step.reason, step.intent
        if step.done:
            self._end(State.DONE, f"{step.reason or 'back at the start'}; {self._why_home}")
        return step.command

    def _finish(self, step: Step) -> None:
        """The controller has nothing left to do."""
        if self._travelled_m < STARTED_M:
            self._end(State.FAILED, f"enclosed at the start: {step.reason}")
        elif self._params.return_to_start:
            self._return(step.reason)
        else:
            self._end(State.DONE, step.reason)

    def _return(self, why: str) -> None:
        self._why_home = why
        self._turn_to(State.RETURNING, why)

    def _out_of_map(self, seen: Observation) -> str:
        pose, grid = seen.pose, seen.map
        if seen.map_count != self._map_count:
            self._map_count, self._map_came_s = seen.map_count, seen.now_s
        since_s = min(seen.now_s - self._map_came_s, MAP_AGE_S)
        if pose is None or grid is None or _beside(grid, pose) <= self._params.max_speed * since_s:
            self._outside_s = None
            return ""
        self._outside_s = seen.now_s if self._outside_s is None else self._outside_s
        if seen.now_s - self._outside_s < OUTSIDE_S:
            return ""
        low, high = grid.centre_of(0, 0), grid.centre_of(grid.rows - 1, grid.columns - 1)
        return (
            f"the robot at ({pose.x:.2f}, {pose.y:.2f}) is outside its map, ({low[0]:.2f}, {low[1]:.2f}) to "
            f"({high[0]:.2f}, {high[1]:.2f}); look at the mapping"
        )

    def _limited(self, command: Command) -> Command:
        most = self._params.max_speed
        return Command(min(most, max(-most, command.v_mps)), command.w_radps)

    def _end(self, state: State, reason: str) -> None:
        self._ended_s = self._now_s
        self._turn_to(state, reason)
        self._behaviour = "stand"
        self._saves.append(self.keeper.order(self._now_s, "stop" if reason.startswith("stopped") else "end"))

    def _turn_to(self, state: State, reason: str) -> None:
        self._note("state", ("from", self._state.value), ("to", state.value), ("reason", reason))
        self._state, self._reason = state, reason

    def _note(self, kind: str, *details: Tuple[str, Detail]) -> None:
        self._events.append(Event(self._now_s - self._started_s, kind, details))

    @property
    def _left_s(self) -> float:
        end_s = self._now_s if self._state in RUNNING else self._ended_s
        return max(0.0, self._deadline_s - end_s)

    def _report(self) -> SessionStep:
        return SessionStep(
            self._told,
            self._state,
            self._behaviour,
            self._reason,
            self._params.time_limit_s - self._left_s,
            self._left_s,
            self.keeper.known_m2,
            self._bumps,
            self._travelled_m,
            tuple(self._events),
            self._complaints,
            self._intent,
            tuple(order for order in self._saves if order is not None),
        )


def _beside(grid: GridMap, pose: Pose2) -> float:
    """How far a pose lies outside a map, metres; 0 inside."""
    row, column = grid.cell_of(pose.x, pose.y)
    rows, columns = max(-row, row - grid.rows + 1, 0), max(-column, column - grid.columns + 1, 0)
    return math.hypot(rows, columns) * grid.resolution_m
