"""Numbers of the report's method; docs/exploration.md says which its text gives and which its program."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Tuple

from yarm.params import param

BEHAVIOURS = (
    *("deadline", "bumper", "stuck", "full_turn", "frontier", "find_exit", "selection", "places", "search"),
    *("stop", "middle", "forward"),
)
"""What can be switched off, one by one."""


@dataclass(frozen=True)
class ReportParams:
    """Speeds, distances and times of the report's behaviours."""

    off: Tuple[str, ...] = param((), "", "behaviours that are switched off", choices=BEHAVIOURS)
    ahead: float = param(math.pi / 30, "rad", "beams within this of ahead are the centre", low=0.001, high=1.0)
    skipped_beams: int = param(20, "", "outermost beams on the left that count for neither side", low=0, high=300)
    nothing: float = param(100.0, "m", "room at a side where no beam is valid", low=0.5, high=1000.0)
    valid_least: float = param(0.45, "m", "what is nearer counts as nothing seen", low=0.0, high=5.0)
    valid_range: float = param(5.0, "m", "what is farther counts as nothing seen", low=0.5, high=100.0)
    speed: float = param(0.2, "m/s", "forward, with room ahead", low=0.01, high=0.7)
    slow_speed: float = param(0.1, "m/s", "forward, near something", low=0.01, high=0.7)
    slow_distance: float = param(0.7, "m", "room ahead below which it is slow", low=0.1, high=5.0)
    stop_distance: float = param(0.5, "m", "room ahead below which it stops and selects a direction", low=0.1, high=5.0)
    middle_gain: float = param(0.3, "rad/s/m", "turn towards the side with more room", low=0.0, high=10.0)
    angular_max: float = param(math.pi / 6, "rad/s", "the program's greatest turn", low=0.01, high=math.pi)
    middle_share: float = param(2 / 3, "", "a turn to the middle of this share of it is none", low=0.01, high=10.0)
    left_share: float = param(0.55, "", "share of the selections that turn left", low=0.0, high=1.0)
    place_size: float = param(0.2, "m", "places nearer than this along x and along y are one", low=0.01, high=5.0)
    places: int = param(20, "", "places of a selection that are remembered", low=1, high=10000)
    selection_rate: float = param(0.4, "rad/s", "turn of a selection", low=0.01, high=math.pi)
    selection_distance: float = param(1.0, "m", "room ahead that ends a selection", low=0.1, high=5.0)
    selection_back: float = param(math.pi / 6, "rad", "it does not end so near where it came from", low=0.0, high=3.0)
    selection_limit: float = param(60.0, "s", "turning on after a whole turn without success", low=0.1, high=900.0)
    bump_speed: float = param(0.05, "m/s", "backing off after a bump", low=0.01, high=0.7)
    bump_turn: float = param(math.pi / 6, "rad/s", "turning away while it backs off", low=0.0, high=math.pi)
    bump_loops: int = param(10, "", "passes of backing off", low=1, high=1000)
    turn_period: float = param(101.0, "s", "from one full turn to the next", low=1.0, high=1e6)
    turn_rate: float = param(math.pi / 12, "rad/s", "of a full turn", low=0.01, high=math.pi)
    turn_rest: float = param(0.1, "rad", "a whole turn is done with less than this left", low=0.001, high=3.0)
    turn_backing: int = param(10, "", "first passes of a full turn, in which it backs", low=0, high=1000)
    turn_pause: float = param(3.0, "s", "standing after a full turn", low=0.0, high=60.0)
    exit_difference: float = param(1.0, "m", "left and right differ by this where an exit may be", low=0.1, high=10.0)
    stuck_window: float = param(15.0, "s", "odometry looked back on", low=1.0, high=300.0)
    stuck_path: float = param(0.3, "m", "less driven in the window is stuck", low=0.01, high=5.0)
    stuck_turn: float = param(0.3, "rad", "less turned in the window is stuck", low=0.01, high=6.0)
    stuck_from: float = param(10.0, "s", "nothing counts as stuck before", low=0.0, high=900.0)
    growth_window: float = param(100.0, "s", "how often the growth of the map is looked at", low=1.0, high=900.0)
    growth_least: float = param(0.25, "m^2", "less mapped in the window starts the frontier mode", low=0.0, high=100.0)
    padding: int = param(5, "cells", "walls are padded by this", low=1, high=50)
    border: int = param(3, "cells", "kept around what is known", low=0, high=50)
    speck: int = param(3, "", "so many occupied cells in a window, or fewer, are a speck", low=0, high=100)
    speck_window: int = param(11, "cells", "side of that window, odd", low=1, high=101)
    unknown: float = param(2.0, "", "an unknown cell beside a frontier counts so much", low=0.0, high=1e4)
    merging: int = param(5, "cells", "side of the window in which frontier cells are one, odd", low=1, high=51)
    obstacle: float = param(100.0, "", "an occupied cell beside a frontier counts so much", low=0.0, high=1e4)
    weight_distance: float = param(1.0, "", "of a frontier's distance, cells", low=-10.0, high=10.0)
    weight_unknown: float = param(1.0, "", "of a frontier's unknown neighbours", low=-10.0, high=10.0)
    weight_obstacles: float = param(0.1, "", "of the obstacles beside it, 100 a cell", low=-10.0, high=10.0)
    draw_least: float = param(1.0, "", "share in the draw of the least fit frontier", low=1e-6, high=1e4)
    follow_short: int = param(8, "cells", "a path of fewer is driven straight to its end", low=1, high=1000)
    follow_tolerance: int = param(2, "cells", "index of the path's cell that is looked at first", low=0, high=100)
    follow_to_go: int = param(4, "cells", "index of the path's cell that is driven to first", low=1, high=100)
    follow_turn: float = param(
        math.pi / 6, "1/s", "turn on the spot towards a cell, times the error", low=0.01, high=10.0
    )
    follow_advance: int = param(2, "cells", "both go on by this", low=1, high=100)
    follow_share: float = param(0.3, "", "of the speed, along a frontier's path", low=0.01, high=1.0)
    follow_gain: float = param(0.37, "1/s", "turn towards the path's next cell", low=0.01, high=5.0)
    follow_aligned: float = param(0.05, "rad", "heading error at which it drives", low=0.001, high=1.0)
    follow_reach: int = param(4, "cells", "distance to the path at which it looks further ahead", low=1, high=50)
    follow_end: float = param(0.1, "m", "distance to the frontier that is there", low=0.01, high=1.0)
    retry: float = param(1.0, "s", "without a way to any frontier it looks again after this", low=0.1, high=900.0)
    attempt: float = param(30.0, "s", "an attempt at a frontier ends", low=1.0, high=900.0)
    aborts: int = param(3, "", "aborts after which a frontier is false", low=0, high=100)


FAST = ReportParams(speed=0.3, slow_speed=0.15)
"""The speeds at which the report saw its map smear."""
