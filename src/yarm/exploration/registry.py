"""The exploration controllers by name."""

from __future__ import annotations

from dataclasses import replace
from typing import Callable, Dict

from yarm.exploration.explore_lite import ExploreLiteController
from yarm.exploration.model import Controller, Event, Observation, Step
from yarm.exploration.nearest import NearestController
from yarm.exploration.params import ExploreParams
from yarm.exploration.report.controller import ReportController
from yarm.exploration.report.printed import PrintedController
from yarm.exploration.yarm import YarmController

Maker = Callable[[ExploreParams, int], Controller]
"""Makes a controller from its parameters and the seed of its draws."""

CONTROLLERS: Dict[str, Maker] = {
    "explore_lite": ExploreLiteController,
    "nearest": NearestController,
    "report": ReportController,
    "report_printed": PrintedController,
    "yarm": YarmController,
}


class Noted:
    """A controller whose changes of behaviour are events."""

    def __init__(self, controller: Controller) -> None:
        """Nothing done yet."""
        self._controller = controller
        self._behaviour = ""

    def step(self, observation: Observation) -> Step:
        """One pass of the controller's."""
        step = self._controller.step(observation)
        if step.behaviour == self._behaviour:
            return step
        self._behaviour = step.behaviour
        change = Event(observation.now_s, "behaviour", (("name", step.behaviour),))
        return replace(step, events=(*step.events, change))


def make_controller(params: ExploreParams, seed: int) -> Controller:
    """The controller that the parameters name; it notes what it changes over to.

    Raises:
        ValueError: there is none of that name.
    """
    if params.controller not in CONTROLLERS:
        raise ValueError(f"controller {params.controller!r} is not known; known: {', '.join(sorted(CONTROLLERS))}")
    return Noted(CONTROLLERS[params.controller](params, seed))
