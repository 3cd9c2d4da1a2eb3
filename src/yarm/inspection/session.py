"""One inspection after the other: when a round begins and ends, what it is told, and what people ask of it; pure."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from enum import Enum
from typing import Callable, Optional, Tuple

from yarm.geometry import Pose2
from yarm.geometry.scans import Scan
from yarm.inspection.executor import Action, Executor
from yarm.inspection.flow import RoundFlow
from yarm.inspection.model import ENDS, Event, Observation, Outcome, Spin, Step, Verdict
from yarm.inspection.readers import Reader
from yarm.inspection.senses import STANDS, Complaint, Senses, SensesWatch

LOOP_S = 0.1
"""Between two passes."""
HOME_CHECK_S = 1.0
"""Between two looks at how long the way home takes."""
OVERTIME_S = 30.0
"""So long after the time limit everything that still waits has failed."""
NUMBER = re.compile(r"\d+(\.\d+)?")
"""How long, how far, how old: what changes in a sentence about the same trouble."""
IDLE, STOPPED = "idle", "stopped"
"""Words for stages that no round has: before one begins, and after it was broken off."""


class Request(str, Enum):
    """What can be asked; the services' names."""

    START = "start"
    STOP = "stop"
    RETURN_HOME = "return_home"
    RELOCALISE = "relocalise"


DONE_WORDS = {
    Request.STOP: "stands, and writes the result so far",
    Request.RETURN_HOME: "drives home; boxes that are left have no verdict",
    Request.RELOCALISE: "turns once, then goes on",
}


@dataclass(frozen=True)
class Answer:
    """Whether a request is met, and what was done, or why not."""

    success: bool
    message: str


@dataclass(frozen=True)
class SessionParams:
    """What a session needs to know beside its round.

    Attributes:
        time_limit_s: home by then.
        turn_rate: of turns to localise, rad/s.
        autostart: the first round begins as soon as everything is there.
    """

    time_limit_s: float
    turn_rate: float
    autostart: bool


@dataclass(frozen=True, eq=False)
class SessionStep:
    """One pass.

    Attributes:
        stage: where the round stands, or IDLE, STOPPED.
        box: that it is about; 0 for none.
        elapsed_s: since the start of the round; of the whole round once it has ended.
        left_s: until the robot has to be home.
        time_home_s: what the way home hardly ever exceeds; 0 while home is not known.
        reason: why it stands or failed, or what it waits for.
        complaints: about inputs.
        action: what is done now.
        events: what happened.
        step: of the round; None while there is none.
        observation: what the round was told for it.
    """

    stage: str
    box: int
    elapsed_s: float
    left_s: float
    time_home_s: float
    reason: str
    complaints: Tuple[Complaint, ...]
    action: Action
    events: Tuple[Event, ...] = ()
    step: Optional[Step] = None
    observation: Optional[Observation] = None


class InspectionSession:
    """Owns the round of the moment. Not thread-safe."""

    def __init__(
        self,
        params: SessionParams,
        make: Callable[[], Tuple[RoundFlow, Reader]],
        fit: Callable[[Pose2, Scan], Pose2] = lambda guess, _: guess,
    ) -> None:
        """Idle.

        Args:
            params: of the session.
            make: makes a round and the reader that goes with it, when everything is there.
            fit: lays a scan on the map, near a guess of its pose.
        """
        self._params, self._make, self._fit = params, make, fit
        self._wanted = params.autostart
        self._why = ""
        self.restart()

    def restart(self, why: str = "") -> None:
        """Begin afresh: whatever was going on is forgotten, for instance since time went backwards."""
        self._watch = SensesWatch()
        self._round: Optional[RoundFlow] = None
        self._executor: Optional[Executor] = None
        self._spin: Optional[Spin] = None
        self._stopping = False
        self._wanted, self._why = self._params.autostart, why
        self._begin(0.0)

    def _begin(self, now_s: float) -> None:
        self._started_s = now_s
        self._seen = Observation(0.0)
        self._ended: Optional[SessionStep] = None
        self._home_s, self._home_at_s = 0.0, -math.inf
        self._said = ""
        self._start_odom: Optional[Pose2] = None
        self._start_scan: Optional[Scan] = None

    @property
    def verdicts(self) -> Tuple[Verdict, ...]:
        """Of the round of the moment, or of the last one."""
        return () if self._round is None else tuple(self._round.verdicts)

    @property
    def home(self) -> Optional[Pose2]:
        """Where the round began."""
        return None if self._round is None else self._round.home

    @property
    def running(self) -> bool:
        """A round goes on."""
        return self._round is not None and self._ended is None

    def ask(self, request: Request) -> Answer:
        """What somebody wants; it is done from the next pass on."""
        if request == Request.START:
            return self._ask_start()
        if not self.running or self._round is None:
            if request == Request.STOP and self._wanted:
                self._wanted = False
                return Answer(True, "does not begin")
            return Answer(False, "no round goes on; ~start begins one")
        if request == Request.RETURN_HOME and self._round.home is None:
            return Answer(False, "home is not known yet: the place is not certain")
        if request == Request.STOP:
            self._stopping = True
        elif request == Request.RETURN_HOME:
            self._round.call_home("sent home on request")
        else:
            self._spin = Spin(2.0 * math.pi, self._params.turn_rate)
        return Answer(True, DONE_WORDS[request])

    def _ask_start(self) -> Answer:
        if self.running or self._wanted:
            return Answer(False, "a round goes on already; ~stop ends it")
        self._wanted, self._round, self._ended = True, None, None
        return Answer(True, "begins as soon as every input is there")

    def step(self, seen: Senses) -> SessionStep:
        """One pass."""
        complaints = self._watch.step(seen)
        if self._ended is not None:
            return replace(self._ended, action=Action(), events=(), complaints=complaints, step=None, observation=None)
        if self._round is None or self._executor is None:
            waits = self._waits(seen, complaints)
            if waits:
                return self._idle(waits, complaints)
            self._round, reader = self._make()
            self._executor = Executor(reader)
            self._wanted, self._why = False, ""
            self._begin(seen.now_s)
            self._start_odom = None if seen.odometry is None else seen.odometry.pose
            self._start_scan = seen.scan
        if self._stopping:
            return self._stop(seen, complaints)
        return self._go_on(self._round, self._executor, seen, complaints)

    def _waits(self, seen: Senses, complaints: Tuple[Complaint, ...]) -> str:
        """Why a round cannot begin now; empty when it can."""
        if not self._wanted:
            return self._why or "waits for ~start"
        if complaints:
            return "waits: " + "; ".join(complaint.text for complaint in complaints)
        missing = [
            name
            for name, there in (
                ("scan", seen.scan is not None),
                ("odometry", seen.odometry is not None),
                ("transform of the place", not seen.localised or seen.map_from_odom is not None),
                ("map", not seen.map_fault),
                ("camera", not seen.camera),
                ("navigation", not seen.navigation),
            )
            if not there
        ]
        return f"waits for {', '.join(missing)}" if missing else ""

    def _idle(self, reason: str, complaints: Tuple[Complaint, ...]) -> SessionStep:
        limit_s = self._params.time_limit_s
        return SessionStep(IDLE, 0, 0.0, limit_s, 0.0, reason, complaints, Action())

    def _go_on(
        self, tour: RoundFlow, executor: Executor, seen: Senses, complaints: Tuple[Complaint, ...]
    ) -> SessionStep:
        elapsed_s = seen.now_s - self._started_s
        observation = replace(
            self._seen, now_s=elapsed_s, pose=seen.pose, localised=seen.localised, start=self._start(tour, seen)
        )
        step = tour.step(observation)
        hold = "; ".join(complaint.text for complaint in complaints if complaint.sensor in STANDS)
        action = executor.stop() if step.stage in ENDS else self._carry_out(executor, step, seen, hold)
        if action.outcome == Outcome.BUSY and elapsed_s > self._params.time_limit_s + OVERTIME_S:
            why = f"the time is over: {action.reason or hold or 'still under way'}"
            action = replace(executor.stop(), outcome=Outcome.FAILED, reason=why)
        self._seen = Observation(0.0, outcome=action.outcome, reason=action.reason, reading=action.reading)
        said = self._told(elapsed_s, self._watch.jump or action.reason)
        made = SessionStep(
            str(step.stage),
            step.box,
            elapsed_s,
            self._params.time_limit_s - elapsed_s,
            self._time_home(tour, seen),
            step.reason or action.reason,
            complaints,
            action,
            (*step.events, *said),
            step,
            observation,
        )
        if step.stage in ENDS:
            self._ended = made
        return made

    def _start(self, tour: RoundFlow, seen: Senses) -> Optional[Pose2]:
        """Where the round began: by the place that is known now, odometry since then, and the first scan."""
        if tour.home is not None or not seen.localised or seen.map_from_odom is None or self._start_odom is None:
            return None
        guess = seen.map_from_odom.compose(self._start_odom)
        return guess if self._start_scan is None else self._fit(guess, self._start_scan)

    def _carry_out(self, executor: Executor, step: Step, seen: Senses, hold: str) -> Action:
        """The round's order, or first the turn that somebody asked for."""
        if self._spin is None:
            executor.take(step.order, seen.now_s)
            return executor.step(seen, hold, self._watch.jump)
        executor.take(self._spin, seen.now_s)
        action = executor.step(seen, hold, self._watch.jump)
        if action.outcome != Outcome.BUSY:
            self._spin = None
        return replace(action, outcome=Outcome.BUSY)

    def _stop(self, seen: Senses, complaints: Tuple[Complaint, ...]) -> SessionStep:
        assert self._executor is not None
        self._stopping = False
        elapsed_s = seen.now_s - self._started_s
        left_s = self._params.time_limit_s - elapsed_s
        events = (Event(elapsed_s, "stopped"),)
        self._ended = SessionStep(
            STOPPED, 0, elapsed_s, left_s, 0.0, "stopped on request", complaints, self._executor.stop(), events
        )
        return self._ended

    def _told(self, elapsed_s: float, trouble: str) -> Tuple[Event, ...]:
        """Trouble as an event, once each time it changes; that it lasts longer is no change."""
        before, self._said = self._said, NUMBER.sub("", trouble)
        return (Event(elapsed_s, "trouble", (("what", trouble),)),) if trouble and self._said != before else ()

    def _time_home(self, tour: RoundFlow, seen: Senses) -> float:
        if seen.now_s >= self._home_at_s + HOME_CHECK_S:
            self._home_at_s = seen.now_s
            self._home_s = tour.home_s(seen.pose)
        return self._home_s
