"""A planner that thinks in a thread of its own, so that maps, holds and heartbeats go on meanwhile."""

from __future__ import annotations

import threading
from typing import List, Optional

import numpy as np

from yarm.commander.mission import Answer, Planning
from yarm.planning.model.types import FleetPlan, FleetPlanner, PlanRequest


class OneAtATime:
    """A planner that may be used by several threads: they wait for each other, a reset too."""

    def __init__(self, planner: FleetPlanner) -> None:
        """Nobody uses it yet."""
        self._planner = planner
        self._lock = threading.Lock()

    def plan(self, request: PlanRequest, rng: np.random.Generator) -> FleetPlan:
        """See ``FleetPlanner``."""
        with self._lock:
            return self._planner.plan(request, rng)

    def reset(self) -> None:
        """See ``FleetPlanner``."""
        with self._lock:
            self._planner.reset()


def in_background(planning: Planning) -> Answer:
    """Begin to plan; asked for the plan, what was raised meanwhile is raised."""
    plans: List[FleetPlan] = []
    faults: List[BaseException] = []

    def work() -> None:
        try:
            plans.append(planning())
        except BaseException as fault:
            faults.append(fault)

    threading.Thread(target=work, name="planning", daemon=True).start()

    def answer() -> Optional[FleetPlan]:
        if faults:
            raise faults[0]
        return plans[0] if plans else None

    return answer
