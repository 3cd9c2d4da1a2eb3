"""What a sander must still know after its death: its state, the raster, and how far it has come along it.

Where the arm is, is measured. It is written to the journal as it changes, and taken up by the sander that follows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np

from yarm.control.sander.planner import RasterPlan
from yarm.control.sander.progress import Piece
from yarm.control.sander.raster import Raster, Stroke
from yarm.control.sander.states import SanderState
from yarm.control.sander.surface import Surface
from yarm.geometry.grid import FloatArray

ARC_STEP_M = 0.005
"""Progress that is written down, metres."""
Rows = Tuple[Tuple[float, ...], ...]


@dataclass(frozen=True)
class StrokeRecord:
    """A stroke; fields as of ``Stroke``, with the joints at its points."""

    points: Rows
    normals: Rows
    arc_m: Tuple[float, ...]
    joints: Rows


@dataclass(frozen=True)
class PlanRecord:
    """A raster's plan; fields as of ``Surface``, with its strokes."""

    coefficients: Tuple[float, ...]
    lower: Tuple[float, float]
    upper: Tuple[float, float]
    rms_m: float
    strokes: Tuple[StrokeRecord, ...]

    @staticmethod
    def of(plan: RasterPlan) -> PlanRecord:
        """The record of a plan."""
        surface = plan.surface
        strokes = tuple(
            StrokeRecord(_rows(s.points), _rows(s.normals), tuple(s.arc_m.tolist()), _rows(joints))
            for s, joints in zip(plan.raster.strokes, plan.joints)
        )
        lower = (float(surface.lower[0]), float(surface.lower[1]))
        upper = (float(surface.upper[0]), float(surface.upper[1]))
        return PlanRecord(tuple(surface.coefficients.tolist()), lower, upper, float(surface.rms_m), strokes)

    def plan(self) -> RasterPlan:
        """The plan again."""
        surface = Surface(np.array(self.coefficients), self.lower, self.upper, self.rms_m)
        strokes = tuple(Stroke(np.array(s.points), np.array(s.normals), np.array(s.arc_m)) for s in self.strokes)
        return RasterPlan(surface, Raster(strokes), tuple(np.array(s.joints) for s in self.strokes))


@dataclass(frozen=True)
class SanderMemory:
    """How a sander stands.

    Attributes:
        state: as published.
        enabled: it may sand.
        active: it is on its way to something, and goes on with it.
        storing: that is storage.
        blocked: something was in the way of the raster; it goes on with the next ON.
        arc_m: way done along it, metres.
        share: share of it that is shown, 0 to 1.
        done: what of it is done, each from one way along it to another, metres.
    """

    state: SanderState
    enabled: bool
    active: bool
    storing: bool
    blocked: bool
    arc_m: float
    share: float
    done: Tuple[Piece, ...] = ()

    def as_good_as(self, other: Optional[SanderMemory]) -> bool:
        """Whether the other one need not be replaced by this in the journal."""
        if other is None or abs(self.arc_m - other.arc_m) >= ARC_STEP_M or len(self.done) != len(other.done):
            return False
        return self._without_progress() == other._without_progress()

    def _without_progress(self) -> Tuple[object, ...]:
        return self.state, self.enabled, self.active, self.storing, self.blocked


@dataclass(frozen=True)
class SanderRecord:
    """One line of the journal: how it stands, and the raster when that is a new one."""

    now: SanderMemory
    plan: Optional[PlanRecord] = None


def _rows(values: FloatArray) -> Rows:
    return tuple(tuple(row) for row in values.tolist())
