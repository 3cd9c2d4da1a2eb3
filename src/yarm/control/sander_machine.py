"""The sander's state machine: buttons and switches in, motions out; one call of ``step`` per joint reading.

What a state does is written as a script, a generator that yields ``Compute``, ``Follow`` and ``Wait``; the machine
carries them out and sends the result back in. It owns no clock and no threads: long computations are handed to
``run_job``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Dict, Generator, List, Optional, Protocol, Sequence, Tuple, Union

import numpy as np

from yarm.control.arm_errors import ArmError
from yarm.control.arm_motion import REST_TOLERANCE_RAD, ArmMotion
from yarm.control.sander_params import SanderParams
from yarm.control.sander_planner import RasterPlan, SanderPlanner
from yarm.control.sander_states import Button, SanderReport, SanderState
from yarm.control.teleoperation import Teleoperation
from yarm.geometry.grid import FloatArray

FOLLOW_GRACE_S = 3.0
ARC_TOLERANCE_M = 1e-3


class Job(Protocol):
    """A computation under way; ``concurrent.futures.Future`` is one."""

    def done(self) -> bool:
        """Whether it has ended."""

    def result(self) -> Any:
        """Its result; raises what it raised."""


class DoneJob:
    """A computation carried out on the spot."""

    def __init__(self, function: Callable[[], Any]) -> None:
        """Call the function now; what it raises is kept for ``result``."""
        self._error: Optional[ArmError] = None
        self._result: Any = None
        try:
            self._result = function()
        except ArmError as error:
            self._error = error

    def done(self) -> bool:
        """Always."""
        return True

    def result(self) -> Any:
        """The function's result, or its error raised."""
        if self._error is not None:
            raise self._error
        return self._result


@dataclass(frozen=True)
class Compute:
    """Compute something; its result is sent back."""

    function: Callable[[], Any]


@dataclass(frozen=True)
class Follow:
    """Follow a motion; it is braked when ``until`` becomes true. True is sent back when it ran to its end."""

    motion: ArmMotion
    until: Callable[[], bool] = lambda: False
    sanding: bool = False


@dataclass(frozen=True)
class Wait:
    """Wait until something is true."""

    until: Callable[[], bool]


Step = Union[Compute, Follow, Wait]
Script = Generator[Step, Any, None]


@dataclass(frozen=True, eq=False)
class ArmInputs:
    """What has come since the last reading.

    Attributes:
        q: measured joints (6,), rad.
        stamp_s: time of the reading.
        presses: buttons pressed, in order.
        axes: joystick axes (4,), -1 to 1: x, y, z, turn; None when nothing new has come.
        switches: values of ``motion_start_stop``, in order.
    """

    q: FloatArray
    stamp_s: float
    presses: Sequence[Button] = ()
    axes: Optional[Tuple[float, float, float, float]] = None
    switches: Sequence[bool] = ()


class SanderMachine:
    """State, motion and progress of the sander."""

    def __init__(
        self,
        planner: SanderPlanner,
        params: SanderParams,
        run_job: Callable[[Callable[[], Any]], Job] = DoneJob,
        scan: Callable[[], FloatArray] = lambda: np.zeros((0, 3)),
    ) -> None:
        """Machine in storage.

        Args:
            planner: computes motions.
            params: times and speeds.
            run_job: starts a computation.
            scan: points (n, 3), metres, world, gathered while ``scanning`` was true.
        """
        self._planner = planner
        self._params = params
        self._run_job = run_job
        self._scan = scan
        self._teleoperation = Teleoperation(planner, params)
        self._accepted: Dict[Tuple[SanderState, Button], Callable[[], Script]] = {
            (SanderState.STORAGE, Button.ADVANCE): self._scan_script,
            (SanderState.SCANNING, Button.ADVANCE): self._scan_script,
            (SanderState.MOVE_TO_PART, Button.ADVANCE): self._part_script,
            (SanderState.TELEOPERATION, Button.START): self._sand_script,
            (SanderState.SCAN_TO_PATH, Button.START): self._sand_script,
        }
        self.reset()

    def reset(self) -> None:
        """Back to storage with nothing going on (time went backwards)."""
        self.state = SanderState.STORAGE
        self.enabled = True
        self.lifted = False
        self.scanning = False
        self.sanding = False
        self.progress = 0.0
        self.reason = ""
        self.plan: Optional[RasterPlan] = None
        self._counts = [0, 0]
        self._failed_sanding = False
        self._script: Optional[Script] = None
        self._step: Optional[Step] = None
        self._job: Optional[Job] = None
        self._motion: Optional[ArmMotion] = None
        self._motion_start_s = 0.0
        self._braking = False
        self._q: FloatArray = self._planner.arm.storage
        self._now_s = 0.0
        self._out: List[ArmMotion] = []
        self._arc_m = 0.0

    @property
    def moving(self) -> bool:
        """Whether a motion is being followed or computed."""
        return self._motion is not None or self._job is not None

    @property
    def report(self) -> SanderReport:
        """What it says of itself."""
        return SanderReport(
            self.state,
            self.enabled,
            self.moving,
            self.lifted,
            self.progress,
            self.reason,
            self._counts[0],
            self._counts[1],
        )

    def step(self, inputs: ArmInputs) -> List[ArmMotion]:
        """Motions to send, in order; each replaces the one before."""
        self._q, self._now_s, self._out = inputs.q, inputs.stamp_s, []
        for value in inputs.switches:
            self._counts[1] += 1
            self.enabled = value
            if value and self._failed_sanding and self.plan is not None:
                self._begin(self._resume_script(self.plan))
        for button in inputs.presses:
            self._counts[0] += 1
            self._press(button)
        self._advance()
        if self.state is SanderState.TELEOPERATION and self._script is None and self._motion is None:
            self._teleoperate(inputs)
        return self._out

    # Buttons.

    def _press(self, button: Button) -> None:
        if button is Button.HOLD:
            self._abandon()
            self._teleoperation.start(self._q)
            self._failed_sanding = False
            self.reason = "held: press advance, start or store to go on"
            return
        resting = self._script is None
        if button is Button.STORE and (
            self.state in (SanderState.TELEOPERATION, SanderState.SCAN_TO_PATH)
            or (resting and self.state is not SanderState.STORAGE)
        ):
            self._begin(self._store_script())
            return
        script = self._accepted.get((self.state, button))
        busy = not resting and self.state in (SanderState.SCANNING, SanderState.MOVE_TO_PART)
        if script is None or busy:
            self.reason = f"button {button.name.lower()} does nothing in state {self.state.value} ({self.state.words})"
            return
        self._begin(script())

    def _begin(self, script: Script) -> None:
        self._abandon()
        self.reason = ""
        self._failed_sanding = False
        self._script = script

    def _abandon(self) -> None:
        """Brake what moves, and drop the script."""
        if self._motion is not None and not self._braking:
            self._brake()
        self._script, self._step, self._job = None, None, None
        self.scanning = self.sanding = self.lifted = False

    # Carrying out a script.

    def _advance(self) -> None:
        """Go on with motion, computation and script as far as they get now."""
        for _ in range(100):
            try:
                if self._motion is not None and not self._motion_done():
                    return
                if self._script is None:
                    return
                value = self._outcome()
                if value is None:
                    return
                self._take(self._script.send(value[0]) if self._step is not None else next(self._script))
            except StopIteration:
                self._script, self._step = None, None
            except ArmError as error:
                self._abandon()
                self.reason = f"stays where it is: {error}"
                self._failed_sanding = self.state is SanderState.SCAN_TO_PATH and self.plan is not None
        raise RuntimeError("a sander script goes round without ever waiting")

    def _outcome(self) -> Optional[Tuple[Any]]:
        """Result of the step under way; None while it is not done."""
        if isinstance(self._step, Compute):
            assert self._job is not None
            if not self._job.done():
                return None
            job, self._job = self._job, None
            return (job.result(),)
        if isinstance(self._step, Wait) and not self._step.until():
            return None
        ran_out, self._braking = not self._braking, False
        return (ran_out,)

    def _take(self, step: Step) -> None:
        self._step, self._braking = step, False
        if isinstance(step, Compute):
            self._job = self._run_job(step.function)
        elif isinstance(step, Follow):
            self.sanding = step.sanding
            self._send(step.motion)

    def _send(self, motion: ArmMotion) -> None:
        self._motion, self._motion_start_s = motion, self._now_s
        if motion.duration_s > 0.0:
            self._out.append(motion)

    def _motion_done(self) -> bool:
        """Watch the motion: note where on the path the tip is, brake when told to."""
        assert self._motion is not None
        elapsed = self._now_s - self._motion_start_s
        if self.sanding:
            phase = self._motion.nearest_time(self._q, elapsed - 0.5, elapsed + 0.05)
            self._note_arc(self._motion.arc_at(phase))
        step = self._step
        if isinstance(step, Follow) and not self._braking and step.until():
            self._brake()
            return False
        errors = np.abs(self._q - self._motion.positions[-1])
        away = float(np.max(errors))
        if elapsed >= self._motion.duration_s and away <= REST_TOLERANCE_RAD:
            self._motion, self.sanding = None, False
            return True
        if elapsed > self._motion.duration_s + FOLLOW_GRACE_S:
            self._motion, self.sanding = None, False
            raise ArmError(
                f"the arm does not follow: joint {int(np.argmax(errors)) + 1} is {away:.3f} rad away "
                f"{FOLLOW_GRACE_S:g} s after the motion's end, allowed {REST_TOLERANCE_RAD:g}; does something block it?"
            )
        return False

    def _brake(self) -> None:
        assert self._motion is not None
        elapsed = self._now_s - self._motion_start_s
        phase = self._motion.nearest_time(self._q, elapsed - 0.5, elapsed + 0.05)
        self._send(self._motion.braked(phase, self._params.stop_s))
        self._braking = True

    def _note_arc(self, arc_m: float) -> None:
        self._arc_m = max(self._arc_m, arc_m)
        if self.plan is not None:
            self.progress = min(self._arc_m / self.plan.raster.length_m, 1.0)

    # Scripts, one a state.

    def _scan_script(self) -> Script:
        self._enter(SanderState.SCANNING)
        yield Follow((yield Compute(self._from_here(self._planner.to_scan))))
        sweep = yield Compute(self._from_here(self._planner.sweep))
        self.scanning = True
        yield Follow(sweep)
        self.scanning = False
        yield from self._part_script()

    def _part_script(self) -> Script:
        self._enter(SanderState.MOVE_TO_PART)
        yield Follow((yield Compute(self._from_here(self._planner.to_hover))))
        self._teleoperation.start(self._q)
        self._enter(SanderState.TELEOPERATION)

    def _store_script(self) -> Script:
        if self.state is SanderState.SCAN_TO_PATH:
            yield Follow((yield Compute(self._from_here(self._planner.lift))))
        self._enter(SanderState.MOVE_TO_STORAGE)
        yield Follow((yield Compute(self._from_here(self._planner.to_storage))))
        self.progress = 0.0
        self._enter(SanderState.STORAGE)

    def _sand_script(self) -> Script:
        """Raster from the start; paused it lifts, enabled it comes back to where it stopped."""
        self._enter(SanderState.SCAN_TO_PATH)
        self._arc_m, self.progress, self.plan = 0.0, 0.0, None
        scan = self._scan()
        lift = yield Compute(self._from_here(self._planner.lift))
        yield Follow(lift)
        self.plan = plan = yield Compute(lambda: self._planner.raster(scan))
        yield from self._sand(plan)

    def _resume_script(self, plan: RasterPlan) -> Script:
        """After a failure on the raster (something blocked the arm): lift, then go on where it stopped."""
        yield Follow((yield Compute(self._from_here(self._planner.lift))))
        yield from self._sand(plan)

    def _sand(self, plan: RasterPlan) -> Script:
        while self._arc_m < plan.raster.length_m - ARC_TOLERANCE_M:
            self.lifted = True
            yield Wait(lambda: self.enabled)
            self.lifted = False
            yield from self._sand_until_paused(plan)
            yield from self._lift_until_enabled()
        self.progress = 1.0
        self.lifted = True

    def _sand_until_paused(self, plan: RasterPlan) -> Script:
        down = yield Compute(self._from_here(lambda q: self._planner.come_down(q, plan, self._arc_m)))
        on_part = yield Follow(down, until=lambda: not self.enabled)
        while on_part and self.enabled and self._arc_m < plan.raster.length_m - ARC_TOLERANCE_M:
            stroke = self._planner.stroke_from(plan, self._arc_m)
            ended = yield Follow(stroke, until=lambda: not self.enabled, sanding=True)
            if ended:
                self._note_arc(float(stroke.arc_m[-1]))

    def _lift_until_enabled(self) -> Script:
        """Lift; done with the raster it lifts to the end, else it turns round as soon as it may go on."""
        plan = self.plan
        assert plan is not None
        finished = self._arc_m >= plan.raster.length_m - ARC_TOLERANCE_M
        lift = yield Compute(self._from_here(self._planner.lift))
        yield Follow(lift, until=lambda: self.enabled and not finished)

    def _from_here(self, function: Callable[[FloatArray], Any]) -> Callable[[], Any]:
        q = self._q.copy()
        return lambda: function(q)

    def _enter(self, state: SanderState) -> None:
        self.state = state
        self.lifted = False

    def _teleoperate(self, inputs: ArmInputs) -> None:
        motion = self._teleoperation.step(inputs.q, inputs.axes, inputs.stamp_s)
        self.reason = self._teleoperation.reason or self.reason
        if motion is not None:
            self._out.append(motion)
