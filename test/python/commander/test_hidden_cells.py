"""What no camera sees counts as parameter ``hidden`` says: who is refused a goal for it is told why, and by whom."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from python.commander.fake_cell import SPEC, FakeCell
from yarm.commander.params import CommanderParams
from yarm.geometry import CellState, Visibility
from yarm.geometry.cell_map import NO_HIDER
from yarm.planning.tasks.unhiding import MOST_ASKED

TARGET = (-1.95, 1.65)
HIDDEN = np.s_[4:9, 38:46, 0:18]
"""Cells about the target, from the floor to over the robots, and nowhere at the border."""


class ShadyCell(FakeCell):
    """A cell in which ``HIDDEN`` can be hidden by somebody; without ``tells`` nothing is told of visibility."""

    hider = None
    tells = True
    leaves_m = math.inf
    """Way from its place after which the hider hides nothing any more."""
    place = None

    def map(self):
        found = super().map()
        if not self.tells:
            return found
        states = np.where(found.grid > 0, CellState.OCCUPIED, CellState.FREE).astype(np.int8)
        hidden_by = np.zeros(SPEC.shape, dtype=np.uint32)
        if self.hider is not None and not self.has_left():
            states[HIDDEN] = CellState.HIDDEN
            hidden_by[HIDDEN] = NO_HIDER if self.hider == "" else 1 << list(found.objects).index(self.hider)
        return replace(found, visibility=Visibility(states, hidden_by[states < CellState.FREE]))

    def has_left(self):
        if self.place is None or self.hider not in self.robots:
            return False
        robot = self.robots[self.hider]
        return math.dist(self.place, (robot.x, robot.y)) > self.leaves_m


def mission(hidden, **changes):
    """Two robots, one of them with a target, the other far off and without one."""
    params = CommanderParams(hidden=hidden, starts_clear=True, hidden_age_s=2.0)
    cell = ShadyCell(params, ankurbot_1=(0.65, 1.6, math.pi), ankurbot_2=(0.65, -1.9, math.pi))
    for name, value in changes.items():
        setattr(cell, name, value)
    cell.place = (0.65, -1.9)
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


def test_where_the_cell_is_clear_at_the_start_what_was_hidden_before_the_calibration_does_not_count():
    """Perception has no names before it; what hides may be anybody then."""
    for starts_clear, outcome in ((True, "succeeded"), (False, "")):
        params = CommanderParams(hidden="known_bodies", starts_clear=starts_clear, hidden_age_s=2.0)
        cell = ShadyCell(params, ankurbot_1=(0.65, 1.6, math.pi), ankurbot_2=(0.65, -1.9, math.pi))
        cell.hider = ""
        cell.run_for(5.0)
        cell.calibrate()
        cell.hider, cell.targets["target_1"] = "ankurbot_2", TARGET
        assert cell.request(jump_state=5).success
        cell.run_for(40.0)
        assert cell.status.outcome == outcome, starts_clear


def test_after_a_commanders_death_what_was_hidden_meanwhile_has_to_be_seen_first():
    cell = mission("known_bodies", hider="ankurbot_2", leaves_m=0.3)
    cell.run(lambda: cell.robots["ankurbot_1"].goal is not None, 30.0)
    assert "hidden" not in reasons(cell)
    cell.start_commander_again(taken_up=True)
    cell.run(lambda: "(behind ankurbot_2, which would have to move)" in reasons(cell), 30.0)
    cell.run(cell.idle, 90.0)
    assert cell.status.outcome == "succeeded"
    moved = math.dist(cell.place, (cell.robots["ankurbot_2"].x, cell.robots["ankurbot_2"].y))
    assert moved > 0.3, "it was reached unseen"


def test_who_would_have_to_move_is_told():
    cell = mission("occupied", hider="ankurbot_2")
    cell.run(lambda: "hidden" in reasons(cell), 30.0)
    assert "(behind ankurbot_2, which would have to move)" in reasons(cell)


def test_an_idle_robot_that_hides_what_a_goal_needs_is_sent_aside_and_the_goal_is_reached():
    cell = mission("occupied", hider="ankurbot_2", leaves_m=0.3)
    cell.run(cell.idle, 90.0)
    assert cell.status.outcome == "succeeded"
    moved = math.dist(cell.place, (cell.robots["ankurbot_2"].x, cell.robots["ankurbot_2"].y))
    assert moved > 0.3, "it was reached past the hider"


def test_one_that_hides_it_wherever_it_goes_is_not_sent_round_for_ever():
    cell = mission("occupied", hider="ankurbot_2")
    sent = []
    for _ in range(25):
        cell.run_for(1.0)
        robot = cell.robots["ankurbot_2"]
        sent.append((round(robot.x, 2), round(robot.y, 2)))
    places = [place for place, after in zip(sent, sent[1:]) if place == after]
    assert len(dict.fromkeys(places)) <= MOST_ASKED + 1, places
    assert len(set(sent[-8:])) == 1, sent
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
