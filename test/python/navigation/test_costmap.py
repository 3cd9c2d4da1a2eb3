"""Marks of the scan: set where beams end, kept while hidden, cleared where beams pass; values of the message."""

from __future__ import annotations

import math

import numpy as np
import pytest

from python.navigation.map_samples import drawn
from yarm.geometry import Pose2
from yarm.geometry.scans import Scan
from yarm.navigation.costmap import BLIND_M, INSCRIBED, LETHAL, Costmap, inflated, points_near, window
from yarm.navigation.grid_map import UNKNOWN, GridMap

HERE = Pose2(1.0, 2.0)
BEAMS = 201


def scan(range_m: float, half_rad: float = 0.05, elsewhere_m: float = math.nan) -> Scan:
    """Beams over 60 degrees; those within half_rad of ahead end at one range, the others at another."""
    angles = np.linspace(-math.pi / 6, math.pi / 6, BEAMS)
    ranges = np.where(np.abs(angles) <= half_rad, range_m, elsewhere_m).astype(np.float32)
    return Scan(0.0, ranges, -math.pi / 6, math.pi / 3 / (BEAMS - 1), 0.45, 5.0)


def empty() -> GridMap:
    cells = np.zeros((80, 80), np.int8)
    cells[:, -2:] = 100
    return GridMap(cells, 0.05, Pose2(0.0, 0.0))


def cell(costmap: Costmap, x: float, y: float) -> bool:
    return bool(costmap.marked[costmap.static.cell_of(x, y)])


def test_what_the_map_does_not_have_is_marked() -> None:
    costmap = Costmap(empty())
    costmap.see(HERE, scan(1.02))
    assert cell(costmap, 2.02, 2.0) and costmap.version == 1
    assert costmap.grid.occupied[costmap.static.cell_of(2.02, 2.0)] and not costmap.static.occupied[40, 40]


def test_what_the_map_has_and_what_is_far_or_lonely_is_not_marked() -> None:
    costmap = Costmap(empty())
    costmap.see(Pose2(2.0, 2.0), scan(1.88))
    costmap.see(Pose2(0.2, 2.0), scan(2.6))
    costmap.see(HERE, scan(1.02, half_rad=0.001))
    assert not costmap.marked.any() and costmap.version == 0


def test_a_mark_stays_while_nothing_is_seen_of_it_and_goes_when_beams_pass() -> None:
    costmap = Costmap(empty())
    costmap.see(HERE, scan(1.02))
    costmap.see(HERE, scan(math.nan))
    costmap.see(HERE.compose(Pose2(0.0, 0.0, 1.5)), scan(1.8))
    costmap.see(HERE, scan(0.7))
    assert cell(costmap, 2.02, 2.0)
    costmap.see(HERE, scan(2.2, half_rad=0.5))
    assert not cell(costmap, 2.02, 2.0)


def test_a_mark_beyond_the_range_of_clearing_stays() -> None:
    costmap = Costmap(empty())
    costmap.see(HERE, scan(2.02))
    costmap.see(Pose2(-0.2, 2.0), scan(4.0, half_rad=0.5))
    assert cell(costmap, 3.02, 2.0)


def test_clearing_forgets_marks_only() -> None:
    costmap = Costmap(empty())
    costmap.see(HERE, scan(1.02))
    costmap.clear()
    assert not costmap.marked.any() and costmap.grid.occupied.any() and costmap.version == 2
    costmap.clear()
    assert costmap.version == 2


def test_clearing_keeps_what_the_scan_would_not_see_again() -> None:
    costmap = Costmap(empty())
    costmap.see(HERE, scan(1.02))
    costmap.clear(Pose2(1.5, 2.0))
    assert costmap.version == 2 and not costmap.marked.any()
    costmap.see(HERE, scan(1.02))
    costmap.clear(Pose2(2.02 - BLIND_M + 0.05, 2.0))
    assert cell(costmap, 2.02, 2.0)
    away = np.hypot(*(costmap.static.centres_of(np.argwhere(costmap.marked)) - (2.02 - BLIND_M + 0.05, 2.0)).T)
    assert away.max() <= BLIND_M + 0.05


def test_unknown_cells_around_the_robot_are_taken_for_free_on_request() -> None:
    costmap = Costmap(drawn("????????\n?......?\n????????"))
    costmap.clear_unknown(Pose2(0.1, 0.1), 0.3)
    assert costmap.grid.free[0, 0] and costmap.grid.unknown[-1, -1]


def test_values_fall_from_the_robots_radius_to_the_inflation() -> None:
    cells = np.zeros((1, 40), np.int8)
    cells[0, 0], cells[0, -1] = 100, UNKNOWN
    values = inflated(GridMap(cells, 0.05, Pose2(0.0, 0.0)), 0.2, 0.5, 5.0)[0]
    assert values[0] == LETHAL and set(values[1:5]) == {INSCRIBED} and values[11] == 0 and values[-1] == UNKNOWN
    assert list(values[5:11]) == sorted(values[5:11], reverse=True)
    assert values[6] == pytest.approx((INSCRIBED - 1) * math.exp(-0.5), abs=1.0)


def test_the_window_is_where_the_robot_is_and_never_empty() -> None:
    part = window(empty(), Pose2(1.0, 3.9), 1.0)
    assert part.rows <= 21 and part.columns == 21 and part.origin.distance(Pose2(0.5, 3.4)) < 0.08
    assert min(window(empty(), Pose2(90.0, -90.0), 1.0).cells.shape) >= 1


def test_points_near_are_in_the_robots_axes() -> None:
    points = points_near(empty(), Pose2(3.5, 2.0, math.pi / 2), 1.0)
    assert points[:, 1].max() == pytest.approx(-0.425) and len(points)
