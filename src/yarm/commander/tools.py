"""What a mission works with: a planner, and how it is asked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Optional

import numpy as np

from yarm.planning.model.types import FleetPlan, FleetPlanner, PlanRequest

Planning = Callable[[], FleetPlan]
Answer = Callable[[], Optional[FleetPlan]]
"""The plan that was asked for; None while it is being made."""


def at_once(planning: Planning) -> Answer:
    """Plan now, and have the answer."""
    plan = planning()
    return lambda: plan


@dataclass(frozen=True)
class Tools:
    """What a mission works with.

    Attributes:
        planner: plans a step for the fleet.
        rng: its random generator.
        stopwatch_s: wall time for reports; decides nothing.
        begin: begins to plan, and gives what to ask for the plan.
    """

    planner: FleetPlanner
    rng: np.random.Generator
    stopwatch_s: Callable[[], float] = lambda: 0.0
    begin: Callable[[Planning], Answer] = at_once

    def ask(self, request: PlanRequest) -> Answer:
        """Begin to plan a request."""
        return self.begin(lambda: self.planner.plan(request, self.rng))
