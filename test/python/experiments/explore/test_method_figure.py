"""The figure of the report's frontier mode, and the ways it compares."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest

from yarm.experiments.explore.method_figure import breadth_first, length_of, plot_method
from yarm.exploration.report.params import ReportParams
from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap


def half_known() -> GridMap:
    """A hall of 4 x 3 m with a wall in it whose far end nobody has seen."""
    cells = np.full((80, 100), -1, dtype=np.int8)
    cells[10:70, 10:60] = 0
    cells[10, 10:60] = cells[69, 10:60] = cells[10:70, 10] = 100
    cells[10:50, 35] = 100
    return GridMap(cells, 0.05, Pose2(-1.0, -1.0))


def test_the_panels_and_their_frontiers_are_written(tmp_path: Path) -> None:
    picture = plot_method(half_known(), Pose2(0.0, 0.2), tmp_path / "method.png", ReportParams())
    assert picture.stat().st_size > 20000
    with (tmp_path / "method.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) > 3 and sum(float(row["probability"]) for row in rows) == pytest.approx(1.0, abs=1e-3)


def test_maps_that_show_nothing_are_refused(tmp_path: Path) -> None:
    room = half_known()
    unknown = GridMap(np.full_like(room.cells, -1), 0.05, room.origin)
    with pytest.raises(ValueError, match="no known cell"):
        plot_method(unknown, Pose2(0.0, 0.0), tmp_path / "a.png", ReportParams())
    walled = room.cells.copy()
    walled[10:70, 59] = 100
    with pytest.raises(ValueError, match="no frontier can be reached"):
        plot_method(GridMap(walled, 0.05, room.origin), Pose2(0.0, 0.2), tmp_path / "b.png", ReportParams())


def test_the_fewest_cells_are_not_the_shortest_way() -> None:
    free = np.ones((9, 9), dtype=bool)
    free[1:, 4] = False
    way = breadth_first(free, (8, 0), (8, 8))
    assert len(way) == 17 and tuple(way[0]) == (8, 0) and tuple(way[-1]) == (8, 8)
    assert length_of(np.array([[0, 0], [1, 1], [1, 2]])) == pytest.approx(math.sqrt(2.0) + 1.0)
    free[:, 4] = False
    assert len(breadth_first(free, (8, 0), (8, 8))) == 1
