"""The sander's state machine: buttons and switches in, motions out; one call of ``step`` per joint reading.

A button begins a script (``yarm.control.sander.scripts``), which a runner carries out step by step. It owns no clock
and no threads: long computations are handed to ``run_job``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

from yarm.control.arm.errors import ArmError
from yarm.control.arm.motion import ArmMotion
from yarm.control.sander.follower import MotionFollower
from yarm.control.sander.params import SanderParams
from yarm.control.sander.planner import RasterPlan, SanderPlanner
from yarm.control.sander.runner import ScriptRunner
from yarm.control.sander.scripts import SanderScripts, Situation
from yarm.control.sander.states import Button, SanderReport, SanderState
from yarm.control.sander.steps import Job, Script
from yarm.control.sander.teleoperation import Teleoperation
from yarm.geometry.grid import FloatArray


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
    """

    q: FloatArray
    stamp_s: float
    presses: Sequence[Button] = ()
    axes: Optional[Tuple[float, float, float, float]] = None
    switches: Sequence[bool] = ()
    objection: str = ""


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
        self._follower = MotionFollower(self._params.stop_s)
        self._runner = ScriptRunner(self._follower, self._run_job)
        self._teleoperation = Teleoperation(self._planner, self._params)
        self._scripts = SanderScripts(self._now, self._planner, self._scan, self._start_teleoperation)
        self._accepted: Dict[Tuple[SanderState, Button], Callable[[], Script]] = {
            (SanderState.STORAGE, Button.ADVANCE): self._scripts.scan,
            (SanderState.SCANNING, Button.ADVANCE): self._scripts.scan,
            (SanderState.MOVE_TO_PART, Button.ADVANCE): self._scripts.to_part,
            (SanderState.TELEOPERATION, Button.START): self._scripts.sand,
            (SanderState.SCAN_TO_PATH, Button.START): self._scripts.sand,
        }
        self.reason = ""
        self._presses = self._switches = 0
        self._failed_sanding = False
        self._objection = ""
        self._interrupted = self._storing = False

    @property
    def state(self) -> SanderState:
        """State as published."""
        return self._now.state

    @property
    def scanning(self) -> bool:
        """Whether the wrist camera's clouds are wanted."""
        return self._now.scanning

    @property
    def lifted(self) -> bool:
        """Whether it hovers over the part and would come down again."""
        return self._now.lifted

    @property
    def progress(self) -> float:
        """Share of the raster done, 0 to 1."""
        return self._now.progress.share

    @property
    def plan(self) -> Optional[RasterPlan]:
        """The raster; None before there is one."""
        return self._now.progress.plan

    @property
    def moving(self) -> bool:
        """Whether a motion is being followed or computed."""
        return self._runner.moving

    @property
    def report(self) -> SanderReport:
        """What it says of itself."""
        now, reason = self._now, self._objection or self.reason
        return SanderReport(
            now.state, now.enabled, self.moving, now.lifted, self.progress, reason, self._presses, self._switches
        )

    def step(self, inputs: ArmInputs) -> List[ArmMotion]:
        """Motions to send, in order; each replaces the one before."""
        self._now.q = inputs.q
        for value in inputs.switches:
            self._switches += 1
            self._now.enabled = value
            if value and self._failed_sanding:
                self._begin(self._scripts.resume(), inputs)
        for button in inputs.presses:
            self._presses += 1
            self._press(button, inputs)
        self._take_objection(inputs)
        self._advance(inputs)
        out = self._follower.take()
        if self._objection:
            return out + (self._teleoperation.halt(inputs.q) if self.state is SanderState.TELEOPERATION else [])
        if self.state is SanderState.TELEOPERATION and self._runner.idle and not self._follower.active:
            out += self._teleoperate(inputs)
        return out

    def _take_objection(self, inputs: ArmInputs) -> None:
        """Brake what moves at an objection; without it begin again what was interrupted, from wherever the arm is."""
        self._objection = inputs.objection
        if self._objection and self._follower.active and not self._follower.braking:
            self._follower.brake(inputs.q, inputs.stamp_s)
            self._interrupted = not self._runner.idle
        if not self._objection and self._interrupted:
            storing = self._storing
            self._begin(self._interrupted_script(), inputs)
            self._storing = storing

    def _interrupted_script(self) -> Script:
        if self._storing:
            return self._scripts.store()
        if self.state is SanderState.SCAN_TO_PATH:
            return self._scripts.sand() if self.plan is None else self._scripts.resume()
        return self._accepted[self.state, Button.ADVANCE]()

    def _press(self, button: Button, inputs: ArmInputs) -> None:
        if button is Button.HOLD:
            self._abandon(inputs)
            self._teleoperation.start(inputs.q)
            self._failed_sanding = False
            self.reason = "held: press advance, start or store to go on"
            return
        script = self._scripts.store if button is Button.STORE else self._accepted.get((self.state, button))
        if script is None or not self._may(button):
            self.reason = f"button {button.name.lower()} does nothing in state {self.state.value} ({self.state.words})"
            return
        self._begin(script(), inputs)
        self._storing = button is Button.STORE

    def _may(self, button: Button) -> bool:
        """Whether a button counts although something may be going on."""
        if button is Button.STORE:
            waits = self.state in (SanderState.TELEOPERATION, SanderState.SCAN_TO_PATH)
            return waits or (self._runner.idle and self.state is not SanderState.STORAGE)
        return self._runner.idle or self.state not in (SanderState.SCANNING, SanderState.MOVE_TO_PART)

    def _begin(self, script: Script, inputs: ArmInputs) -> None:
        self._abandon(inputs)
        self.reason = ""
        self._failed_sanding = self._storing = False
        self._runner.begin(script)

    def _abandon(self, inputs: ArmInputs) -> None:
        """Brake what moves, and drop the script."""
        self._follower.brake(inputs.q, inputs.stamp_s)
        self._runner.drop()
        self._interrupted = False
        self._now.scanning = self._now.lifted = False

    def _advance(self, inputs: ArmInputs) -> None:
        try:
            self._runner.advance(inputs.q, inputs.stamp_s, hold=bool(self._objection))
        except ArmError as error:
            self._abandon(inputs)
            self.reason = f"stays where it is: {error}"
            self._failed_sanding = self.state is SanderState.SCAN_TO_PATH and self.plan is not None

    def _start_teleoperation(self) -> None:
        self._teleoperation.start(self._now.q)

    def _teleoperate(self, inputs: ArmInputs) -> List[ArmMotion]:
        motion = self._teleoperation.step(inputs.q, inputs.axes, inputs.stamp_s)
        self.reason = self._teleoperation.reason or self.reason
        return [] if motion is None else [motion]
