"""Nobody is sent where somebody who moves may be before a robot stands; what is under way is the monitor's business."""

from __future__ import annotations

import math

import numpy as np
import pytest

from python.commander.fake_cell import SPEC, FakeCell
from yarm.commander.cell_state import CellState
from yarm.commander.foreseen import where_they_may_be
from yarm.commander.params import CommanderParams
from yarm.commander.pictures import draw_foreseen
from yarm.geometry import CellMap
from yarm.safety.people import Tracked, Walking

AHEAD_S, RADIUS_M, TALL_M = 1.0, 0.25, 1.7


def walker(x, y, velocity=(0.5, 0.0), age_s=5.0, stamp_s=0.0, sigma=0.0, extent=(0.3, 0.4, TALL_M)):
    """Somebody 0.5 m across, by the diagonal of his box."""
    return Tracked(3, (x, y, extent[2] / 2.0), velocity, extent, 0.0, sigma, age_s, stamp_s)


def farthest_m(cells, x, y):
    return np.hypot(*(SPEC.centres(cells)[:, :2] - (x, y)).T).max()


@pytest.mark.parametrize(
    ("somebody", "reach_m"),
    [
        (walker(0.1, 0.2), RADIUS_M + 0.5 * AHEAD_S),
        (walker(0.1, 0.2, velocity=(0.3, -0.4), stamp_s=-0.4), RADIUS_M + 0.5 * (AHEAD_S + 0.4)),
        (walker(0.1, 0.2, velocity=(0.0, 0.0), age_s=0.0), RADIUS_M + Walking.unwatched_mps * AHEAD_S),
        (walker(0.1, 0.2, sigma=0.1), RADIUS_M + 0.7 * AHEAD_S),
    ],
)
def test_where_somebody_may_be(somebody, reach_m):
    (name,), (cells,) = zip(*where_they_may_be(SPEC, [somebody], {"unknown_3"}, 0.0, AHEAD_S).items())
    assert name == "where unknown_3 may be in 1 s"
    far = farthest_m(cells, 0.1, 0.2)
    assert reach_m - 0.15 < far <= reach_m
    assert SPEC.contains(cells).all()
    whole = np.pi * (reach_m / SPEC.resolution[0]) ** 2 * SPEC.shape[2]
    assert len(cells) == pytest.approx(whole, rel=0.1), "the disc is filled, from the floor to the top of the grid"


def test_who_stands_is_where_the_map_shows_him_and_if_it_does_not_where_he_was():
    stands = walker(0.0, 0.0, velocity=(0.0, 0.0))
    assert where_they_may_be(SPEC, [stands], {"unknown_3"}, 0.0, AHEAD_S) == {}
    (cells,) = where_they_may_be(SPEC, [stands], (), 0.0, AHEAD_S).values()
    assert farthest_m(cells, 0.0, 0.0) <= RADIUS_M


def test_over_what_is_low_nothing_is_closed():
    crawls = walker(0.0, 0.0, extent=(0.3, 0.4, 0.2))
    (cells,) = where_they_may_be(SPEC, [crawls], (), 0.0, AHEAD_S).values()
    assert SPEC.lower[2] + cells[:, 2].max() * SPEC.resolution[2] < 0.2


def test_somebody_outside_the_volume_closes_nothing_that_he_cannot_reach():
    assert where_they_may_be(SPEC, [walker(9.0, 0.0)], (), 0.0, AHEAD_S) == {}


@pytest.mark.parametrize("people_s", [0.0, AHEAD_S])
def test_the_planner_is_told_and_the_watch_over_steps_under_way_is_not(people_s):
    cell = CellState(CommanderParams(people_s=people_s))
    cell.take_map(CellMap(1.0, SPEC, np.zeros(SPEC.shape, dtype=np.int8), {}), [walker(0.0, 0.0, stamp_s=1.0)])
    request = cell.request({}, {})
    assert request.occupied.any() == (people_s > 0.0)
    assert ("where unknown_3 may be in 1 s" in request.objects) == (people_s > 0.0)
    under_way = cell.request({}, {}, foreseeing=False)
    assert not under_way.occupied.any() and not under_way.objects
    cell.forget_poses()
    assert not cell.request({}, {}).occupied.any()


class VisitedCell(FakeCell):
    """Somebody walks up and down at a place; the map does not show him."""

    place = (-0.9, 1.65)
    visits = True

    def people(self):
        return (walker(*self.place, stamp_s=self.now),) if self.visits else ()

    def nobody_is_met(self):
        """The robot has nothing where he may be, or might if he came."""
        own = self.commander.cell.request({}, {}).robots[0].cells
        here = [walker(*self.place, stamp_s=self.now)]
        (kept,) = where_they_may_be(SPEC, here, (), self.now, AHEAD_S).values()
        return not np.isin(SPEC.ravel(own[SPEC.contains(own)]), SPEC.ravel(kept)).any()


def mission(place):
    cell = VisitedCell(CommanderParams(people_s=AHEAD_S), ankurbot_1=(0.65, 1.6, math.pi))
    cell.place = place
    cell.calibrate()
    cell.targets["target_1"] = (-1.95, 1.65)
    assert cell.request(jump_state=5).success
    return cell


def test_a_robot_goes_round_where_he_may_be():
    """Without him it goes straight through there."""
    cell = mission((-0.9, 1.65))
    cell.run(lambda: not cell.nobody_is_met() or cell.idle(), 60.0)
    assert cell.status.outcome == "succeeded" and cell.nobody_is_met()
    cell = mission((-0.9, 1.65))
    cell.visits = False
    cell.run(lambda: not cell.nobody_is_met(), 60.0)


def test_a_robot_waits_until_he_has_gone_from_its_goal_and_says_for_what():
    cell = mission((-1.95, 1.65))
    cell.run(lambda: "where unknown_3 may be in 1 s" in " ".join(task.reason for task in cell.status.tasks), 30.0)
    for _ in range(100):
        cell.tick()
        assert cell.nobody_is_met()
    assert cell.status.outcome != "succeeded"
    cell.visits = False
    cell.run(cell.idle, 60.0)
    assert cell.status.outcome == "succeeded"


def test_the_picture_of_the_docs_is_drawn(tmp_path):
    assert draw_foreseen(tmp_path / "foreseen.png").stat().st_size > 20000
