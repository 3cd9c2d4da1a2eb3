"""What the Commander makes of a map: robots followed with hysteresis, and the map without them for the planner."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from python.commander.fake_cell import NO_CELLS, SHAPE, SPEC
from yarm.commander.cell_state import CellState
from yarm.commander.params import CommanderParams
from yarm.geometry import CellMap, MappedObject, quaternion_from_rpy


def seen(name, kind, cells, position=(0.0, 0.0, 0.9), yaw=0.0):
    return MappedObject(name, kind, 1, position, tuple(quaternion_from_rpy(0, 0, yaw)), np.array(cells).reshape(-1, 3))


def world_of(*objects, noise=(), shapes=True, before=None):
    """A world that has taken one map: the objects' cells, and cells of nobody."""
    cell = before or CellState(CommanderParams())
    cell.shapes = {o.name: SHAPE for o in objects if o.kind == "Mobile" and shapes}
    grid = np.zeros(SPEC.shape, dtype=np.int8)
    for cells in [*(o.cells for o in objects), np.array(noise, dtype=np.int64).reshape(-1, 3)]:
        grid[tuple(cells.T)] = np.minimum(grid[tuple(cells.T)] + 1, 2)
    cell.take_map(CellMap(1.0, SPEC, grid, {o.name: o for o in objects}))
    return cell


CENTER = (*SPEC.column_centre((20, 25)), 0.89)


def test_the_planners_map_has_neither_the_cells_seen_as_robots_nor_those_drawn():
    drawn = SHAPE.mask(SPEC, 0.0).at((20, 25))
    beside = [[20, 30, 13], [20, 31, 13]]
    robot = seen("r", "Mobile", [*drawn.tolist(), *beside], CENTER)
    crate = seen("crate", "Obstacle", [drawn[0].tolist(), [40, 40, 3]])
    lone = [drawn[1].tolist(), [45, 45, 5]]
    request = world_of(robot, crate, noise=lone).request({}, {})
    assert np.argwhere(request.occupied).tolist() == [[40, 40, 3], [45, 45, 5]]
    assert np.array_equal(request.robots[0].cells, drawn)
    assert request.objects["crate"].tolist() == crate.cells.tolist()


def test_a_robot_without_a_known_shape_has_the_cells_that_were_seen():
    cells = [[20, 25, 13], [19, 25, 13]]
    request = world_of(seen("r", "Mobile", cells, CENTER), shapes=False).request({}, {})
    assert sorted(request.robots[0].cells.tolist()) == sorted(cells)
    assert not request.occupied.any()


def test_what_is_being_deleted_is_neither_a_goal_nor_in_the_map():
    debris = seen("debris_1", "Debris", [[10, 10, 12]], (*SPEC.column_centre((10, 10)), 0.8))
    cell = world_of(debris, seen("target_1", "Target", NO_CELLS, CENTER))
    assert cell.request({}, {}).occupied.sum() == 1 and set(cell.open_goals()) == {"debris_1", "target_1"}
    cell.queue.claim([replace(cell.open_goals()["debris_1"], robot="r")])
    cell.queue.pop("r")
    assert not cell.request({}, {}).occupied.any() and set(cell.open_goals()) == {"target_1"}


def test_nothing_is_known_before_the_first_map():
    request = CellState(CommanderParams()).request({}, {})
    assert request.occupied.shape == SPEC.shape and not request.occupied.any() and request.robots == ()


@pytest.mark.parametrize(("off", "column"), [(0.055, (20, 25)), (0.065, (21, 25))])
def test_a_robot_stays_in_its_column_a_little_beyond_the_border(off, column):
    cell = world_of(seen("r", "Mobile", NO_CELLS, CENTER))
    moved = (CENTER[0] + off, CENTER[1], CENTER[2])
    assert world_of(seen("r", "Mobile", NO_CELLS, moved), before=cell).robots["r"].column == column


@pytest.mark.parametrize(("turned_deg", "nominal_deg"), [(2.9, 0.0), (3.1, 3.1)])
def test_a_robot_counts_as_at_its_heading_while_near_it(turned_deg, nominal_deg):
    cell = world_of(seen("r", "Mobile", NO_CELLS, CENTER))
    world_of(seen("r", "Mobile", NO_CELLS, CENTER, math.radians(turned_deg)), before=cell)
    assert math.degrees(cell.robots["r"].nominal_yaw_rad) == pytest.approx(nominal_deg)
