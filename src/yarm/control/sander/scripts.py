"""What the sander does in each state, one script a button."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import Any, Callable

import numpy as np

from yarm.control.sander.planner import RasterPlan, SanderPlanner
from yarm.control.sander.progress import RasterProgress
from yarm.control.sander.states import SanderState
from yarm.control.sander.steps import Compute, Follow, Script, Wait
from yarm.geometry.grid import FloatArray

CLOSE_BY_M = 0.1
"""To a piece that begins as near as this the tool goes without lifting."""
WAITS = "waits: all that is left of the raster is too near to debris or a robot"


@dataclass
class Situation:
    """How the sander stands, shared by the machine, which knows what comes in, and the scripts, which change it.

    Attributes:
        q: joints measured last, (6,) rad.
        state: as published.
        enabled: it may sand.
        lifted: it hovers over the part and would come down again.
        scanning: the wrist camera's clouds are wanted.
        scan_lost: what the camera saw of the part is gone with the sander that had it.
        waits_for: why it hovers although it may sand; empty when it does not.
        progress: of the raster.
    """

    q: FloatArray
    state: SanderState = SanderState.STORAGE
    enabled: bool = True
    lifted: bool = False
    scanning: bool = False
    scan_lost: bool = False
    waits_for: str = ""
    progress: RasterProgress = field(default_factory=RasterProgress)

    def enter(self, state: SanderState) -> None:
        """Change state; nobody hovers, or waits, on the way."""
        self.state, self.lifted, self.waits_for = state, False, ""


class SanderScripts:
    """Makes scripts; what they do shows in the situation."""

    def __init__(
        self,
        situation: Situation,
        planner: SanderPlanner,
        scan: Callable[[], FloatArray],
        hovering: Callable[[], None],
    ) -> None:
        """Bind to a situation.

        Args:
            situation: read and changed.
            planner: computes motions.
            scan: the points (n, 3), metres, gathered while ``scanning`` was true.
            hovering: called when it has come to its hover over the part, before state TELEOPERATION.
        """
        self._now = situation
        self._planner = planner
        self._scan = scan
        self._hovering = hovering

    def scan(self) -> Script:
        """Sweep over the part, then hover over it."""
        self._now.enter(SanderState.SCANNING)
        yield Follow((yield self._from_here(self._planner.to_scan)))
        sweep = yield self._from_here(self._planner.sweep)
        self._now.scanning = True
        yield Follow(sweep)
        self._now.scanning = self._now.scan_lost = False
        yield from self.to_part()

    def _scan_again(self) -> Script:
        yield Follow((yield self._from_here(self._planner.lift)))
        yield from self.scan()

    def to_part(self) -> Script:
        """Hover over the part."""
        self._now.enter(SanderState.MOVE_TO_PART)
        yield Follow((yield self._from_here(self._planner.to_hover)))
        self._hovering()
        self._now.enter(SanderState.TELEOPERATION)

    def store(self) -> Script:
        """Home, from the raster by way of a lift."""
        if self._now.state is SanderState.SCAN_TO_PATH:
            yield Follow((yield self._from_here(self._planner.lift)))
        self._now.enter(SanderState.MOVE_TO_STORAGE)
        yield Follow((yield self._from_here(self._planner.to_storage)))
        self._now.progress.share = 0.0
        self._now.enter(SanderState.STORAGE)

    def sand(self) -> Script:
        """Raster from the start; paused it lifts, enabled it comes back to where it stopped."""
        if self._now.scan_lost:
            yield from self._scan_again()
        self._now.enter(SanderState.SCAN_TO_PATH)
        self._now.progress.begin(None)
        points = self._scan()
        yield Follow((yield self._from_here(self._planner.lift)))
        self._now.progress.begin((yield Compute(lambda: self._planner.raster(points))))
        yield from self._raster()

    def resume(self) -> Script:
        """After a failure on the raster (something blocked the arm): lift, then go on where it stopped."""
        yield Follow((yield self._from_here(self._planner.lift)))
        yield from self._raster()

    def again(self, storing: bool) -> Script:
        """What was stopped on its way, from wherever the arm is; ``storing`` when it was on its way to storage."""
        now = self._now
        if storing:
            return self.store()
        if now.state is SanderState.SCAN_TO_PATH:
            return self.sand() if now.progress.plan is None else self.resume()
        return self.to_part() if now.state is SanderState.MOVE_TO_PART else self.scan()

    def _raster(self) -> Script:
        now = self._now
        while not now.progress.finished:
            now.lifted = True
            yield Wait(lambda: self._may_sand() or self._should_be_elsewhere())
            now.lifted = False
            if now.enabled:
                yield from self._until_paused()
                yield from self._lift_until_enabled()
            else:
                yield from self._go_over()
        now.progress.share = 1.0
        now.lifted = True

    def _may_sand(self) -> bool:
        """It is enabled, and something of what is left may be done now."""
        now = self._now
        now.waits_for = "" if now.progress.next_piece() is not None else WAITS
        return now.enabled and not now.waits_for

    def _should_be_elsewhere(self) -> bool:
        """It is paused where nothing may be done now, and could go on elsewhere: from there it may be enabled."""
        piece = self._now.progress.next_piece()
        return not self._now.enabled and piece is not None and not self._now.progress.begins_here(piece)

    def _go_over(self) -> Script:
        """Hover over the beginning of the next piece."""
        progress = self._now.progress
        plan, piece = progress.plan, progress.next_piece()
        if plan is not None and piece is not None:
            progress.go_to(piece)
            yield Follow((yield self._from_here(lambda q: self._planner.hover_over(q, plan, piece[0]))))

    def _until_paused(self) -> Script:
        """Sand piece after piece, as long as the next one begins here or close by."""
        now, progress = self._now, self._now.progress
        plan, piece = progress.plan, progress.next_piece()
        assert plan is not None
        while piece is not None and now.enabled:
            progress.go_to(piece)
            down = yield self._from_here(lambda q: self._planner.come_down(q, plan, progress.arc_m))
            if not (yield Follow(down, until=lambda: not now.enabled)):
                return
            yield from self._sand_on(plan)
            piece = progress.next_piece()
            if piece is not None and plan.apart_m(progress.arc_m, piece[0]) > CLOSE_BY_M:
                return

    def _sand_on(self, plan: RasterPlan) -> Script:
        """From where the tip is to the end of the piece, or of what of it may still be done."""
        now, progress = self._now, self._now.progress
        piece = progress.next_piece()
        while piece is not None and progress.begins_here(piece) and now.enabled:
            stroke = self._planner.stroke_from(plan, progress.arc_m, piece[1])
            end_m = float(stroke.arc_m[-1])
            until = partial(self._must_stop_before, end_m)
            if (yield Follow(stroke, until=until, note=progress.note)):
                progress.note(end_m)
            piece = progress.next_piece()

    def _must_stop_before(self, arc_m: float) -> bool:
        return not self._now.enabled or not self._now.progress.may_go_to(arc_m)

    def _lift_until_enabled(self) -> Script:
        """Lift; it turns round as soon as it may go on, but not when it is done, or goes on elsewhere."""
        piece = self._now.progress.next_piece()
        goes_on = piece is not None and self._now.progress.begins_here(piece)
        lift = yield self._from_here(self._planner.lift)
        yield Follow(lift, until=lambda: self._now.enabled and goes_on)

    def _from_here(self, function: Callable[[FloatArray], Any]) -> Compute:
        q = np.array(self._now.q)
        return Compute(lambda: function(q))
