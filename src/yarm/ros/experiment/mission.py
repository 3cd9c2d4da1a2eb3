"""Drives the Commander through one mission by its service, with a limit on every wait."""

from __future__ import annotations

import math
import time
from typing import Callable, FrozenSet, Optional, Set, Tuple

import rospy

from yarm.commander.activity import Ending
from yarm.experiments.run.writers import CUT_SHORT
from yarm.msg import CommanderStatus
from yarm.ros.common import names
from yarm.ros.common.status_age import LOST_S, entered_since, silence
from yarm.ros.experiment.inputs import ExperimentInputs
from yarm.ros.experiment.lock_step import LockStep
from yarm.ros.experiment.params import ExperimentParams
from yarm.ros.experiment.watchdog import ask_commander, who_waits
from yarm.srv import StateChange, StateChangeRequest

POLL_S = 0.05
ASK_AGAIN_S = 1.0
MOMENT_LIMIT_S = 0.5
SETTLED_S = 0.1
"""In lock-step only what the Commander said this long ago counts, s: whatever is younger may still be under way."""
NOTICED_S = 2.0
"""Simulated time in which the Commander notices that the cell has begun anew, s."""
OFF_STATES = (CommanderStatus.IDLE, CommanderStatus.STARTED)
MODES = {"bounded": CommanderStatus.BOUNDED, "boundless": CommanderStatus.BOUNDLESS}


class MissionError(RuntimeError):
    """The mission cannot go on; the message says what was waited for and how long."""


class StoppedError(MissionError):
    """Time stands still where it was to."""


class BegunAgainError(MissionError):
    """The cell has begun anew, its time with it: so must the mission."""


class MissionDriver:
    """Calls ``commander_state`` and waits for what follows."""

    def __init__(
        self,
        inputs: ExperimentInputs,
        params: ExperimentParams,
        on_wait: Callable[[str], None],
        lock_step: Optional[LockStep] = None,
    ) -> None:
        """Nothing is called yet.

        Args:
            inputs: what the experiment hears.
            params: limits.
            on_wait: called again and again while waiting, with what is waited for (progress lines).
            lock_step: holds simulated time while this looks and asks; None when time just goes on.
        """
        self._inputs = inputs
        self._params = params
        self._on_wait = on_wait
        self._lock_step = lock_step
        self._asked_s = 0.0
        self._begun_again = inputs.begun_again
        self._service = rospy.ServiceProxy(names.COMMANDER_STATE, StateChange)

    def await_start(self) -> None:
        """Wait until the Commander answers and simulated time runs; in a cell that has begun anew, as well."""
        self._begun_again, self._asked_s = self._inputs.begun_again, 0.0
        limit_s = self._params.start_limit_s
        began = time.monotonic()
        while True:
            missing = self._missing()
            if not missing and self._may_act():
                return
            if time.monotonic() - began > limit_s:
                raise MissionError(f"after {limit_s:.0f} s of wall time still missing: {missing}")
            self.pause(f"waiting for {missing or 'a moment to begin'}")

    def switch_on_and_calibrate(self) -> bool:
        """From wherever it starts to the menu, through CALIBRATION, which is redone once when it fails.

        Returns:
            whether the Commander is in the mode already: the cell began anew in the midst of its work, or this process.
        """
        state = self._settled_state()
        if state in (CommanderStatus.MENU, MODES[self._params.mode]):
            return bool(state != CommanderStatus.MENU)
        if state == CommanderStatus.IDLE:
            self._request("switch on", next_state=True)
        if state in OFF_STATES:
            self._request("calibrate", next_state=True)
        for attempt in range(2):
            self._wait_for(self._calibrated, self._params.calibration_limit_s, "the calibration")
            if self._in_mode():
                return True
            outcome, reason = self.outcome()
            if outcome == Ending.SUCCEEDED:
                self._request("open the menu", next_state=True)
                return False
            if attempt == 0:
                self._request("calibrate once more", current_state=True)
        raise MissionError(f"calibration ended {outcome!r}: {reason}")

    def await_raster(self, share: float, limit_s: float) -> None:
        """Wait until a manipulator has done so much of its raster, 0 to 1."""

        def done() -> bool:
            with self._inputs.lock:
                return any(arm.progress >= share for arm in self._inputs.state.manipulators.values())

        if share > 0.0:
            self._wait_for(done, limit_s, f"raster at {100 * share:.0f} %")

    def enter_mode(self) -> None:
        """Enter the mode that was asked for."""
        self._request(f"enter mode {self._params.mode}", jump_state=MODES[self._params.mode])

    def idle(self) -> bool:
        """The mode's work is done."""
        return self._idle_in(MODES[self._params.mode])

    def ask_for_more(self, required: bool = True) -> None:
        """Within the mode and idle: look for more tasks; at most once a second unless required."""
        if self.idle() and (required or self.now_s() - self._asked_s >= ASK_AGAIN_S):
            self._request("look for more tasks", current_state=True)

    def run_mode(self, expected: FrozenSet[str], limit_s: float) -> None:
        """In the mode wait until every expected goal has ended, asking for more work when there was none.

        Args:
            expected: names of the goals that are there or will come.
            limit_s: simulated time this may take, s.
        """
        mode = MODES[self._params.mode]
        end_s = self.now_s() + limit_s
        while self.now_s() < end_s:
            left_s = max(0.0, end_s - self.now_s())
            self._await_idle(mode, left_s, f"the mission (limit {limit_s:.0f} s in all)")
            left = expected - self.ended_goals()
            if not left:
                return
            asked_s = self.now_s()
            self._wait_for(lambda at=asked_s: self.now_s() > at + ASK_AGAIN_S, 10.0, "more work")  # type: ignore[misc]
            self.ask_for_more()
        left = expected - self.ended_goals()
        named = ", ".join(sorted(left)) or "the mode"
        raise MissionError(f"after {limit_s:.0f} s of simulated time not done: {named}: {self.who_waits()}")

    def clean_up(self) -> None:
        """Send everybody home."""
        if not self.cleans_up():
            self._request("clean up", next_state=True)
        self._await_idle(CommanderStatus.CLEANUP, self._params.cleanup_limit_s, "the way home")

    def cleans_up(self) -> bool:
        """The Commander is at it already."""
        status = self._newest()
        return status is not None and bool(status.state == CommanderStatus.CLEANUP)

    def outcome(self) -> Tuple[str, str]:
        """How the last work ended, and why."""
        with self._inputs.lock:
            status = self._status()
            return ("", "") if status is None else (status.outcome, status.reason)

    def now_s(self) -> float:
        """Simulated time, s."""
        moment_s = None if self._lock_step is None else self._lock_step.moment_s
        if moment_s is not None:
            return moment_s
        with self._inputs.lock:
            return self._inputs.state.now_s

    def ended_goals(self) -> Set[str]:
        """Goals the Commander is done with, well or not."""
        with self._inputs.lock:
            return {goal for goal, ended_s in self._inputs.state.ended_s.items() if ended_s <= self._settled_s()}

    def pause(self, what: str) -> None:
        """Wait a little, in lock-step for the next moment to act at.

        Raises:
            MissionError: ROS shuts down.
            BegunAgainError: the cell has begun anew.
            StoppedError: time stands still where it was to.
        """
        if self._lock_step is not None and self._lock_step.stopped:
            raise StoppedError("time stands still where it was to")
        if rospy.is_shutdown():
            raise MissionError(CUT_SHORT)
        if self._inputs.begun_again != self._begun_again:
            raise BegunAgainError(f"{what}: the simulation was started again, and the cell has begun anew")
        self._on_wait(what)
        if self._lock_step is None:
            time.sleep(POLL_S)
        else:
            self._lock_step.next_moment(MOMENT_LIMIT_S)

    def who_waits(self) -> str:
        """What the Commander does, and why it goes on with none of the tasks that are left."""
        return who_waits(self._newest(), ask_commander)

    def release(self) -> None:
        """Nothing more will be asked: in lock-step, let time go on."""
        if self._lock_step is not None:
            self._lock_step.release()

    def _may_act(self) -> bool:
        return self._lock_step is None or self._lock_step.moment_s is not None

    def _settled_s(self) -> float:
        """What is stamped later than this may not be acted on yet, s of simulated time."""
        if self._lock_step is None:
            return math.inf
        moment_s = self._lock_step.moment_s
        return -math.inf if moment_s is None else moment_s - SETTLED_S

    def _status(self) -> Optional[CommanderStatus]:
        """The newest that may be acted on; the inputs' lock must be held."""
        return self._inputs.status_at(self._settled_s())

    def _missing(self) -> str:
        if self.now_s() <= 0.0:
            return "simulated time (is the simulation running?)"
        with self._inputs.lock:
            if self._inputs.state.sim is None:
                return f"{names.SIM_STATUS}: the cell is not live yet"
            if self._inputs.state.status is None:
                return f"{names.COMMANDER_STATUS} (is the commander running?)"
            if not self._inputs.state.robots:
                return f"robots in {names.OBJECT_REGISTRY}"
        try:
            rospy.wait_for_service(names.COMMANDER_STATE, timeout=0.2)
        except rospy.ROSException:
            return f"service {names.COMMANDER_STATE}"
        return ""

    def _request(self, what: str, **fields: object) -> None:
        """Ask the Commander; one that is dead for a moment is waited for, and asked again unless it has done it."""
        self._on_wait(what)
        before = self._newest()
        while True:
            try:
                answer = self._service(StateChangeRequest(**fields))
                break
            except rospy.ServiceException as error:
                if self._lock_step is not None or before is None:  # in lock-step nobody starts it again
                    raise MissionError(f"{what}: the Commander did not answer: {error}") from error
                self._await_word(f"{what}: the Commander did not answer ({error}); a word of the next one")
            newest = self._newest()
            if newest is not None and entered_since(newest, before):
                self._asked_s = newest.header.stamp.to_sec() - newest.elapsed_s
                return
        if not answer.success:
            raise MissionError(f"{what} was refused: {answer.message}")
        self._asked_s = self.now_s()

    def _await_word(self, what: str) -> None:
        """Until the Commander has said something new."""
        asked_s = self.now_s()

        def heard() -> bool:
            newest = self._newest()
            return newest is not None and bool(newest.header.stamp.to_sec() > asked_s)

        self._wait_for(heard, LOST_S, what)

    def _newest(self) -> Optional[CommanderStatus]:
        with self._inputs.lock:
            return self._inputs.state.status

    def _settled_state(self) -> int:
        """The Commander's state; when the cell has begun anew, once it has had time to notice."""

        def settled() -> bool:
            status = self._newest()
            off = status is not None and status.state in OFF_STATES
            return status is not None and (not self._begun_again or not off or self.now_s() > NOTICED_S)

        self._wait_for(settled, self._params.start_limit_s, "a word of the Commander")
        status = self._newest()
        assert status is not None
        return int(status.state)

    def _calibrated(self) -> bool:
        return self._in_mode() or self._idle_in(CommanderStatus.CALIBRATION)

    def _in_mode(self) -> bool:
        status = self._newest()
        return status is not None and bool(status.state == MODES[self._params.mode])

    def _await_idle(self, state: int, limit_s: float, what: str) -> None:
        self._wait_for(lambda: self._idle_in(state), limit_s, what)

    def _idle_in(self, state: int) -> bool:
        with self._inputs.lock:
            status = self._status()
            if status is None or status.header.stamp.to_sec() <= self._asked_s:
                return False
            return status.state == state and not status.busy and status.outcome != ""

    def _wait_for(self, done: Callable[[], bool], limit_s: float, what: str) -> None:
        began_s = moved_s = self.now_s()
        moved_wall = time.monotonic()
        while not (self._may_act() and done()):
            self.pause(what)
            now_s = self.now_s()
            if now_s > moved_s:
                moved_s, moved_wall = now_s, time.monotonic()
            silent = self._silence(now_s)
            if silent:
                raise MissionError(f"{what}: {silent}")
            if now_s - began_s > limit_s:
                limit = f"{what} did not end within {limit_s:.0f} s of simulated time"
                raise MissionError(f"{limit}: {self.who_waits()}")
            if time.monotonic() - moved_wall > self._params.stall_limit_s:
                raise MissionError(
                    f"{what}: simulated time has stood still at {now_s:.2f} s for {self._params.stall_limit_s:.0f} s"
                )

    def _silence(self, now_s: float) -> str:
        """Why the Commander counts as lost; empty when it does not. In lock-step time itself waits for it."""
        status = self._newest()
        return "" if status is None or self._lock_step is not None else silence(status, now_s, LOST_S)
