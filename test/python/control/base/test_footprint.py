"""The mobile robot's extent in cells."""

from __future__ import annotations

import numpy as np
import pytest

from yarm.control.base.footprint import box_around, extent_in_cells
from yarm.geometry.grid import GridSpec
from yarm.geometry.poses import quaternion_from_rpy, transform_matrix


def test_the_shipped_robot_takes_17_by_7_by_15_cells():
    boxes = [
        (np.array([-0.35, -0.35, 0.10]), np.array([0.35, 0.35, 0.55])),
        (np.array([0.0, -0.04, 0.85]), np.array([1.34, 0.04, 0.97])),
    ]
    assert extent_in_cells(boxes, GridSpec()) == (17, 7, 15)


def test_what_is_above_the_grid_does_not_count():
    assert extent_in_cells([(np.zeros(3), np.array([0.1, 0.1, 9.0]))], GridSpec())[2] == 20


def test_no_solids_are_refused():
    with pytest.raises(ValueError, match="at least one solid"):
        extent_in_cells([], GridSpec())


def test_box_around_a_turned_box():
    pose = transform_matrix((1.0, 2.0, 3.0), quaternion_from_rpy(0.0, 0.0, np.pi / 2))
    lower, upper = box_around(np.array([0.5, 0.1, 0.2]), pose)
    assert lower == pytest.approx([0.9, 1.5, 2.8])
    assert upper == pytest.approx([1.1, 2.5, 3.2])
