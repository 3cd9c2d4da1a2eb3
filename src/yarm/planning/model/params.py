"""Parameters of planning: the planners and the task queue share one set of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from yarm.params import param
from yarm.robots.turns import QUARTER_TURNS_DEG


@dataclass(frozen=True)
class PlannerParams:
    """What can be chosen about YARM (both variants), and about the travel distances that the task queue assigns by."""

    particles: int = param(333, "", "particles of a search at most; of `original` always so many", 1, 100000)
    particles_first: int = param(
        83,
        "",
        "of these the ones that a search begins with; in narrow places up to narrow_factor times denser",
        1,
        100000,
    )
    narrow_factor: float = param(3.0, "", "density of particles in narrow places over that in the open", 1.0, 20.0)
    iteration_limit: int = param(500, "", "rounds of the fleet's search, over a few steps, until TIMEOUT", 1, 1000000)
    turns_deg: Tuple[float, ...] = param(
        QUARTER_TURNS_DEG, "deg", "turns about the end effector allowed before a translation", -180.0, 180.0
    )
    turn_deg_per_cell: float = param(10.0, "deg", "angle whose cost equals one cell of travel", 0.1, 1000.0)
    keep_gain: float = param(
        0.95, "", "a new plan replaces a valid remembered one below this share of its cost", 0.1, 1.0
    )
    least_step_cells: int = param(
        3, "cells", "a waiting robot moves up to a conflict only if at least this far", 1, 1000
    )
    original_margin_cells: int = param(
        2, "cells", "`original` keeps this far from what stands in the map; not published (docs/experiments.md)", 0, 10
    )
