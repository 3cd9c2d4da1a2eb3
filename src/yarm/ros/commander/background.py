"""A planner that thinks in a thread of its own, so that maps, holds and heartbeats go on meanwhile."""

from __future__ import annotations

import threading
from typing import List, Optional

import numpy as np

from yarm.commander.tools import Answer, Planning
from yarm.planning.model.types import FleetPlan, FleetPlanner, PlanRequest


class OneAtATime:
    """A planner that may be used by several threads: they wait for each other."""

    def __init__(self, planner: FleetPlanner) -> None:
        """Nobody uses it yet."""
        self._planner = planner
        self._lock = threading.Lock()
        self._forgets = False

    def plan(self, request: PlanRequest, rng: np.random.Generator) -> FleetPlan:
        """See ``FleetPlanner``."""
        with self._lock:
            if self._forgets:
                self._forgets = False
                self._planner.reset()
            return self._planner.plan(request, rng)

    def reset(self) -> None:
        """See ``FleetPlanner``; it takes effect before the next plan, so that nobody waits for one under way."""
        self._forgets = True


def in_background(planning: Planning, patience_s: float = 0.0) -> Answer:
    """Begin to plan; asked for the plan, what was raised meanwhile is raised.

    Args:
        planning: makes the plan.
        patience_s: wall time to wait for it at once, s: most plans are there sooner than the next map.
    """
    plans: List[FleetPlan] = []
    faults: List[BaseException] = []

    def work() -> None:
        try:
            plans.append(planning())
        except BaseException as fault:
            faults.append(fault)

    thread = threading.Thread(target=work, name="planning", daemon=True)
    thread.start()
    thread.join(patience_s)

    def answer() -> Optional[FleetPlan]:
        if faults:
            raise faults[0]
        return plans[0] if plans else None

    return answer
