"""The sander's state machine: buttons and switches in, motions out; one call of ``step`` per joint reading.

A button (``yarm.control.sander.buttons``) begins a script (``yarm.control.sander.scripts``), which is carried out step
by step (``yarm.control.sander.work``). It owns no clock and no threads: long computations are handed to ``run_job``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, List, Optional, Sequence, Tuple

from yarm.control.arm.motion import ArmMotion
from yarm.control.sander.buttons import ButtonTable
from yarm.control.sander.follower import MotionFollower
from yarm.control.sander.memory import SanderMemory
from yarm.control.sander.params import SanderParams
from yarm.control.sander.planner import RasterPlan, SanderPlanner
from yarm.control.sander.progress import KeepOff
from yarm.control.sander.runner import ScriptRunner
from yarm.control.sander.scripts import SanderScripts, Situation
from yarm.control.sander.states import Button, SanderReport, SanderState
from yarm.control.sander.steps import Job
from yarm.control.sander.teleoperation import Teleoperation
from yarm.control.sander.work import SanderWork
from yarm.geometry.grid import FloatArray

UNWATCHED_S = 0.4
"""After a longer pause between two readings, s, the arm's controller may have stopped it (``arm_timeout``)."""


@dataclass(frozen=True, eq=False)
class ArmInputs:
    """What has come since the last reading.

    Attributes:
        q: measured joints (6,), rad.
        stamp_s: time of the reading.
        presses: buttons pressed, in order.
        axes: joystick axes (4,), -1 to 1: x, y, z, turn; None when nothing new has come.
        switches: values of ``motion_start_stop``, in order.
        objection: why the arm must stand still whatever it is asked; empty when it may move.
        keep_off: what the tip must stay away from, in place of what was told before; None when nothing new has come.
    """

    q: FloatArray
    stamp_s: float
    presses: Sequence[Button] = ()
    axes: Optional[Tuple[float, float, float, float]] = None
    switches: Sequence[bool] = ()
    objection: str = ""
    keep_off: Optional[KeepOff] = None


class SanderMachine:
    """Decides what is done next, and says how it stands."""

    def __init__(
        self,
        planner: SanderPlanner,
        params: SanderParams,
        run_job: Callable[[Callable[[], Any]], Job],
        scan: Callable[[], FloatArray],
    ) -> None:
        """Machine in storage.

        Args:
            planner: computes motions; used from inside jobs only, one at a time, and for teleoperation.
            params: heights, speeds, margins.
            run_job: starts a computation (``DoneJob`` for one carried out on the spot).
            scan: the points (n, 3), metres, gathered while ``scanning`` was true.
        """
        self._planner = planner
        self._params = params
        self._run_job = run_job
        self._scan = scan
        self.reset()

    def reset(self) -> None:
        """Back to storage with nothing going on (time went backwards)."""
        self._now = Situation(self._planner.arm.storage)
        self._teleoperation = Teleoperation(self._planner, self._params)
        scripts = SanderScripts(self._now, self._planner, self._scan, self._hovers)
        follower = MotionFollower(self._params.stop_s)
        self._work = SanderWork(self._now, scripts, follower, ScriptRunner(follower, self._run_job))
        self._buttons = ButtonTable(scripts)
        self._presses = self._switches = 0
        self._objection = ""
        self._last_s: Optional[float] = None
        self._taken_up = False

    @property
    def memory(self) -> SanderMemory:
        """What another one must know to go on from here, besides the plan."""
        now, work = self._now, self._work
        progress = now.progress
        return SanderMemory(
            now.state,
            now.enabled,
            work.active,
            work.storing,
            work.blocked,
            progress.arc_m,
            progress.share,
            progress.done,
        )

    def take_up(self, memory: SanderMemory, plan: Optional[RasterPlan]) -> None:
        """Go on where another one was when it died: with the next reading the arm halts, then it begins again.

        The points of a scan are gone: without a raster over the part it scans once more.
        """
        now = self._now
        now.state, now.enabled, now.scan_lost = memory.state, memory.enabled, True
        now.progress.begin(plan, memory.done, memory.arc_m)
        now.progress.share = memory.share
        self._work.take_up(memory.active, memory.storing, memory.blocked and plan is not None)
        self._taken_up = True

    @property
    def state(self) -> SanderState:
        """State as published."""
        return self._now.state

    @property
    def scanning(self) -> bool:
        """Whether the wrist camera's clouds are wanted."""
        return self._now.scanning

    @property
    def plan(self) -> Optional[RasterPlan]:
        """The raster; None before there is one."""
        return self._now.progress.plan

    @property
    def report(self) -> SanderReport:
        """What it says of itself."""
        return SanderReport(
            state=self._now.state,
            enabled=self._now.enabled,
            moving=self._work.moving,
            lifted=self._now.lifted,
            progress=self._now.progress.share,
            reason=self._objection or self._work.reason or self._now.waits_for,
            presses=self._presses,
            switches=self._switches,
        )

    def step(self, inputs: ArmInputs) -> List[ArmMotion]:
        """Motions to send, in order; each replaces the one before."""
        self._now.q = inputs.q
        if inputs.keep_off is not None:
            self._now.progress.keep_off(inputs.keep_off)
        self._look_after_pause(inputs)
        for value in inputs.switches:
            self._throw(value, inputs)
        for button in inputs.presses:
            self._press(button, inputs)
        self._take_objection(inputs)
        self._work.advance(inputs.q, inputs.stamp_s, hold=bool(self._objection))
        return self._work.take() + self._teleoperate(inputs)

    def _look_after_pause(self, inputs: ArmInputs) -> None:
        """After its own death, or when it has not looked for long, the arm may be anywhere on its way or off it."""
        paused = self._last_s is not None and inputs.stamp_s - self._last_s > UNWATCHED_S
        self._last_s = inputs.stamp_s
        if self._taken_up and self.state is SanderState.TELEOPERATION:
            self._teleoperation.start(inputs.q)
        if self._taken_up or (paused and not self._work.at_rest):
            self._taken_up = False
            self._work.halt(inputs.q, inputs.stamp_s)

    def _throw(self, enabled: bool, inputs: ArmInputs) -> None:
        self._switches += 1
        self._now.enabled = enabled
        if enabled:
            self._work.retry(inputs.q, inputs.stamp_s)

    def _press(self, button: Button, inputs: ArmInputs) -> None:
        self._presses += 1
        if button is Button.HOLD:
            self._work.drop(inputs.q, inputs.stamp_s)
            self._teleoperation.start(inputs.q)
            self._work.reason = "held: press advance, start or store to go on"
            return
        state = self.state
        script = self._buttons.script(button, state, self._work.idle)
        if script is None:
            self._work.reason = f"button {button.name.lower()} does nothing in state {state.value} ({state.words})"
        else:
            self._work.begin(script(), inputs.q, inputs.stamp_s, storing=button is Button.STORE)

    def _take_objection(self, inputs: ArmInputs) -> None:
        """Brake what moves at an objection; without it begin again what was interrupted, from wherever the arm is."""
        self._objection = inputs.objection
        if self._objection:
            self._work.interrupt(inputs.q, inputs.stamp_s)
        else:
            self._work.go_on(inputs.q, inputs.stamp_s)

    def _teleoperate(self, inputs: ArmInputs) -> List[ArmMotion]:
        if self.state is not SanderState.TELEOPERATION:
            return []
        if self._objection:
            return self._teleoperation.halt(inputs.q)
        if not self._work.at_rest:
            return []
        motion = self._teleoperation.step(inputs.q, inputs.axes, inputs.stamp_s)
        self._work.reason = self._teleoperation.reason or self._work.reason
        return [] if motion is None else [motion]

    def _hovers(self) -> None:
        self._teleoperation.start(self._now.q)
