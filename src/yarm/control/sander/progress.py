"""How much of the raster is done."""

from __future__ import annotations

from typing import Optional

from yarm.control.sander.planner import RasterPlan

ARC_TOLERANCE_M = 1e-3
"""A raster of which less is left counts as done."""


class RasterProgress:
    """The plan, the way of the tip along it, and the share of it that is shown."""

    def __init__(self) -> None:
        """No plan."""
        self.plan: Optional[RasterPlan] = None
        self.arc_m = 0.0
        self.share = 0.0

    def begin(self, plan: Optional[RasterPlan]) -> None:
        """Start at the beginning of a plan; None while there is none yet."""
        self.plan, self.arc_m, self.share = plan, 0.0, 0.0

    def note(self, arc_m: float) -> None:
        """The tip is this far along, metres; it never goes back."""
        self.arc_m = max(self.arc_m, arc_m)
        if self.plan is not None:
            self.share = min(self.arc_m / self.plan.raster.length_m, 1.0)

    @property
    def finished(self) -> bool:
        """Whether nothing is left of the plan."""
        return self.plan is not None and self.arc_m >= self.plan.raster.length_m - ARC_TOLERANCE_M
