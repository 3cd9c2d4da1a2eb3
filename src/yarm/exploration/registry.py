"""The exploration controllers by name."""

from __future__ import annotations

from typing import Callable, Dict

from yarm.exploration.explore_lite import ExploreLiteController
from yarm.exploration.model import Controller
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


def make_controller(params: ExploreParams, seed: int) -> Controller:
    """The controller that the parameters name.

    Raises:
        ValueError: there is none of that name.
    """
    if params.controller not in CONTROLLERS:
        raise ValueError(f"controller {params.controller!r} is not known; known: {', '.join(sorted(CONTROLLERS))}")
    return CONTROLLERS[params.controller](params, seed)
