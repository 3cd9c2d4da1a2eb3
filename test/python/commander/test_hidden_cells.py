"""What no camera sees counts as parameter ``hidden`` says: who is refused a goal for it is told why, and by whom."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from python.commander.fake_cell import SPEC, FakeCell
from yarm.commander.params import CommanderParams
from yarm.geometry import CellState, Visibility
from yarm.geometry.cell_map import NO_HIDER

TARGET = (-1.95, 1.65)
HIDDEN = np.s_[4:9, 38:46, 0:18]
"""Cells about the target, from the floor to over the robots, and nowhere at the border."""


class ShadyCell(FakeCell):
    """A cell in which ``HIDDEN`` can be hidden by somebody; without ``tells`` nothing is told of visibility."""

    hider = None
    tells = True

    def map(self):
        found = super().map()
        if not self.tells:
            return found
        states = np.where(found.grid > 0, CellState.OCCUPIED, CellState.FREE).astype(np.int8)
        hidden_by = np.zeros(SPEC.shape, dtype=np.uint32)
        if self.hider is not None:
            states[HIDDEN] = CellState.HIDDEN
            hidden_by[HIDDEN] = NO_HIDER if self.hider == "" else 1 << list(found.objects).index(self.hider)
        return replace(found, visibility=Visibility(states, hidden_by[states < CellState.FREE]))


def mission(hidden, **changes):
    """Two robots, one of them with a target, the other far off and without one."""
    params = CommanderParams(hidden=hidden, starts_clear=True, hidden_age_s=2.0)
    cell = ShadyCell(params, ankurbot_1=(0.65, 1.6, math.pi), ankurbot_2=(0.65, -1.9, math.pi))
    for name, value in changes.items():
        setattr(cell, name, value)
    cell.calibrate()
    cell.targets["target_1"] = TARGET
    assert cell.request(jump_state=5).success
    return cell


def reasons(cell):
    return " ".join(task.reason for task in cell.status.tasks)


def test_a_goal_in_cells_that_nobody_has_seen_for_long_is_refused_until_they_are_seen():
    cell = mission("known_bodies", hider="")
    cell.run(lambda: "no camera sees it" in reasons(cell), 30.0)
    cell.run_for(5.0)
    assert "a hidden space of 720 cells from (4, 38, 0) on (no camera sees it)" in reasons(cell)
    assert cell.status.tasks[0].status == "unreachable"
    cell.hider = None
    cell.run(cell.idle, 60.0)
    assert cell.status.outcome == "succeeded"


def test_what_a_registered_robot_hides_is_driven_into_and_so_is_anything_when_hidden_is_free():
    for hidden, hider in (("known_bodies", "ankurbot_2"), ("free", "")):
        cell = mission(hidden, hider=hider)
        cell.run(cell.idle, 60.0)
        assert cell.status.outcome == "succeeded", hidden


def test_who_would_have_to_move_is_told():
    cell = mission("occupied", hider="ankurbot_2")
    cell.run(lambda: "hidden" in reasons(cell), 30.0)
    assert "(behind ankurbot_2, which would have to move)" in reasons(cell)


def test_a_step_into_cells_that_something_has_got_into_meanwhile_is_stopped():
    cell = mission("occupied")
    cell.run(lambda: cell.robots["ankurbot_1"].goal is not None and cell.robots["ankurbot_1"].x < 0.5, 30.0)
    cell.hider = ""
    cell.run(lambda: any("(no camera sees it) is in the way" in line for line in cell.said), 5.0)
    cell.hider = None
    cell.run(cell.idle, 60.0)
    assert cell.status.outcome == "succeeded"


def test_without_visibility_every_robot_is_stopped_and_told_what_to_do():
    cell = mission("known_bodies")
    cell.run(lambda: cell.robots["ankurbot_1"].goal is not None, 30.0)
    cell.tells = False
    cell.run(lambda: "set visibility of merge_clouds to true" in cell.status.reason, 5.0)
    assert "set visibility of merge_clouds to true" in cell.commander.objection(cell.now)
    cell.run_for(0.5)
    assert cell.robots["ankurbot_1"].goal is None
    cell.tells = True
    cell.run(cell.idle, 60.0)
    assert cell.status.outcome == "succeeded"
