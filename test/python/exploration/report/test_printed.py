"""The printed loop as it runs: each known fault is there; where the text's system has none, that is shown beside."""

from __future__ import annotations

import math
from typing import Tuple

import numpy as np
import pytest

from support.report_rig import Rig, room, scan
from yarm.exploration.model import Command
from yarm.exploration.params import ExploreParams
from yarm.exploration.report.controller import ReportController
from yarm.exploration.report.frontiers import Reach, cropped, frontiers, padded
from yarm.exploration.report.params import ReportParams
from yarm.exploration.report.printed import FAULTS, PrintedController
from yarm.exploration.report.printed_frontier import printed_fitness, printed_grid, printed_path
from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap
from yarm.robots.turtlebot import Bumper

PARAMS = ExploreParams(controller="report_printed")


def printed(seed: int = 1, limit_s: float = 900.0) -> Rig:
    return Rig(PrintedController(ExploreParams(time_limit_s=limit_s), seed))


def mended(*faults: str, limit_s: float = 900.0) -> Rig:
    return Rig(PrintedController(ExploreParams(time_limit_s=limit_s), 1, faults))


def text(seed: int = 1, limit_s: float = 900.0) -> Rig:
    return Rig(ReportController(ExploreParams(time_limit_s=limit_s), seed))


def test_a_side_bump_is_never_cleared() -> None:
    here, there = printed(), text()
    for run in (here, there):
        run.step(scan(2.0), (Bumper.LEFT, True))
        run.step(scan(2.0), (Bumper.LEFT, False))
        run.run(60.0, scan(2.0))
    assert here.shares() == {"bumper": 602} and here.steps[-1].command == Command(-0.05, -math.pi / 6)
    assert there.steps[-1].behaviour == "forward"


def test_after_the_front_is_hit_it_goes_on_backing_in_a_circle() -> None:
    here = printed()
    here.step(scan(2.0), (Bumper.RIGHT, True))
    here.step(scan(2.0), (Bumper.CENTER, True))
    here.run(12.0, scan(2.0))
    assert here.steps[-1].command == Command(-0.05, math.pi / 6)


def test_the_front_manoeuvre_takes_thirteen_loops_less_the_selection() -> None:
    here = printed()
    here.step(scan(2.0), (Bumper.CENTER, True))
    here.run(3.0, scan(2.0))
    assert here.shares()["bumper"] == 12, "the thirteenth ends it and begins to select"


def test_a_selection_hears_no_bumper() -> None:
    here, there = printed(), text()
    for run in (here, there):
        run.run(1.2, scan(2.0))
        run.step(scan(0.48))
        run.run(1.0, scan(0.48))
    assert here.step(scan(0.48), (Bumper.CENTER, True)).behaviour == "selection"
    assert there.step(scan(0.48), (Bumper.CENTER, True)).behaviour == "bumper"


def test_a_selection_hears_no_deadline() -> None:
    here, there = printed(limit_s=10.0), text(limit_s=10.0)
    for run in (here, there):
        run.run(9.0, scan(2.0))
        run.run(31.0, scan(0.48))
    moving = [0.1 * i for i, step in enumerate(here.steps) if step.command != Command()]
    assert moving[-1] > 20.0 and not here.steps[-1].done
    assert all(step.command == Command() for step in there.steps[101:]) and there.steps[-1].done


@pytest.mark.parametrize("ahead, stands", [(math.nan, True), (0.5, True), (0.51, False), (5.9, False), (6.0, True)])
def test_in_its_first_second_it_stands_without_room_ahead_or_with_too_much(ahead: float, stands: bool) -> None:
    here = printed()
    first = here.run(1.1, scan(ahead))
    assert {step.behaviour for step in first} == {"forward"}
    assert {step.command == Command() for step in first} == {stands}
    after = here.step(scan(ahead)).behaviour
    assert after == ("selection" if stands else "forward"), "from then on what stops it makes it select"


def test_exactly_six_metres_ahead_are_too_far_to_drive_and_no_reason_to_turn() -> None:
    here = printed()
    here.run(2.0, scan(6.0))
    assert {step.command for step in here.steps} == {Command()}
    assert here.step(scan(2.0)).command.v_mps > 0.0


def searching(*last: float) -> Rig:
    """After a whole turn that found no way, and passes of the search with this room ahead."""
    here = printed()
    here.run(1.2, scan(2.0))
    here.step(scan(0.48))
    for _ in range(200):
        if rate(here) == pytest.approx(math.pi / 6):
            break
        here.step(scan(0.9))
    whole = (2.0 * math.pi - 0.1) / (math.pi / 8 * 0.1)
    assert here.shares()["selection"] == pytest.approx(whole + 1, abs=1.01), "360 degrees at pi/8, and a pass at pi/6"
    for ahead in last:
        here.step(scan(ahead))
        assert rate(here) == pytest.approx(math.pi / 6), f"with {ahead} m ahead"
    return here


def rate(here: Rig) -> float:
    """How fast it turns in place, rad/s; 0 while it drives."""
    command = here.steps[-1].command
    return abs(command.w_radps) if command.v_mps == 0.0 else 0.0


@pytest.mark.parametrize(
    "seen, end",
    [
        ((1.1, 1.2, 1.3), 1.25),
        ((1.1,), 1.1),
        ((0.9, 0.8, 0.7, 1.1), 1.0),
        ((7.0, 6.5, 6.1), 5.9),
    ],
)
def test_after_a_whole_turn_it_turns_on_while_room_grows_or_is_no_way(seen: Tuple[float, ...], end: float) -> None:
    here = searching(*seen)
    assert len({math.copysign(1.0, step.command.w_radps) for step in here.steps[13:]}) == 1, "the way it was turning"
    assert here.step(scan(end)).behaviour == "forward"


def test_after_a_whole_turn_it_turns_on_for_a_minute_at_most() -> None:
    here = searching()
    here.run(59.8, scan(0.9))
    assert rate(here) == pytest.approx(math.pi / 6)
    here.run(0.3, scan(0.9))
    assert here.steps[-1].behaviour == "forward"


def test_it_ends_after_the_time_not_at_it() -> None:
    here = printed(limit_s=10.0)
    here.run(10.1, scan(2.0))
    assert here.steps[100].command.v_mps > 0.0 and here.step(scan(2.0)).done


def test_it_never_ends_early() -> None:
    here = printed()
    here.map = GridMap(np.zeros((10, 10), np.int8), 0.05, Pose2(0.0, 0.0))
    here.run(300.0, scan(2.0))
    assert not any(step.done for step in here.steps)


def test_open_space_stops_it_as_a_near_wall_does() -> None:
    for ahead in (7.0, 0.4, math.nan):
        here = printed()
        here.run(1.2, scan(2.0))
        here.step(scan(ahead))
        assert here.step(scan(ahead)).behaviour == "selection"


def test_a_junction_is_driven_straight_through() -> None:
    turn = printed().step(scan(3.0, left=4.0, right=1.0)).command.w_radps
    assert turn == 0.0


def test_a_place_is_remembered_and_answered_the_other_way() -> None:
    here = printed(5)
    here.run(1.2, scan(2.0))
    ways = []
    for _ in range(2):
        here.pose = Pose2(1.0, 1.0)
        here.step(scan(0.48))
        ways.append(here.step(scan(0.48)).command.w_radps)
        here.run(0.2, scan(1.5))
    assert ways[0] == -ways[1] and abs(ways[0]) == pytest.approx(math.pi / 8)


def test_the_full_turn_takes_27_seconds_of_101_and_hears_no_bumper() -> None:
    here = printed()
    here.run(101.0, scan(2.0, left=1.1, right=1.1))
    here.pose = Pose2(0.0, 0.0, here.pose.yaw_rad)
    for i in range(300):
        here.step(scan(2.0), (Bumper.CENTER, i == 150))
    shares = here.shares()
    assert 23.0 <= 0.1 * shares["full_turn"] <= 24.2 and 2.8 <= 0.1 * shares["pause"] <= 3.0
    assert here.steps[1030 + 150 - 10].behaviour == "full_turn"


def test_in_a_manoeuvre_the_full_turn_begins_from_an_old_heading() -> None:
    here = printed()
    here.run(100.0, scan(2.0))
    here.step(scan(2.0), (Bumper.RIGHT, True))
    here.run(30.0, scan(2.0))
    assert here.shares()["full_turn"] < 235


def test_standing_still_before_frontiers_it_answers_with_none_of_its_modes() -> None:
    here = printed()
    here.map = room()
    for _ in range(8990):
        here.step(scan(2.0, left=1.1, right=1.1))
        here.pose = Pose2(0.0, 0.0, here.pose.yaw_rad)
    assert set(here.shares()) == {"forward", "full_turn", "pause"}


def test_the_same_seed_gives_the_same_run() -> None:
    runs = []
    for _ in range(2):
        here = printed(9)
        for i in range(500):
            here.step(scan(0.45 + 0.1 * (i % 9)))
        runs.append([(step.command, step.events) for step in here.steps])
    assert runs[0] == runs[1]


def test_the_fast_beam_alone_decides_the_speed() -> None:
    seen = scan(0.6)
    assert printed().step(seen).command.v_mps == 0.1
    seen.ranges[len(seen.ranges) - 1 - 320] = 2.0
    assert printed().step(seen).command.v_mps == 0.2
    seen.ranges[len(seen.ranges) - 1 - 320] = math.nan
    assert printed().step(seen).command.v_mps == 0.1


def shifted_room() -> GridMap:
    """The room in the corner of a larger map, so that cropping moves it."""
    small = room()
    cells = np.full((120, 120), -1, np.int8)
    cells[50:110, 40:100] = small.cells
    return GridMap(cells, 0.05, Pose2(-3.0, -3.5))


def test_the_padded_grid_is_copied_from_the_wrong_corner() -> None:
    whole = shifted_room()
    small, grid = cropped(whole), printed_grid(whole, 5)
    assert small is not None and grid is not None
    right = padded(small, 5)
    assert grid.shape == right.shape and (right == 100).any() and not np.array_equal(grid, right)


@pytest.mark.parametrize("map_of", [room, shifted_room])
def test_no_path_can_come_out_where_the_text_has_one(map_of: object) -> None:
    whole = map_of()  # type: ignore[operator]
    path = printed_path(whole, Pose2(0.0, 0.0))
    assert path is None or len(path) <= 1
    small = cropped(whole)
    assert small is not None
    cells, robot = padded(small, 5), small.cell_of(0.0, 0.0)
    reach = Reach(cells, robot)
    ways = [reach.path(f.row, f.column) for f in frontiers(cells, robot, ReportParams())]
    assert any(len(way) > 5 for way in ways)


def test_obstacles_weigh_nothing_and_distance_is_rewarded() -> None:
    assert printed_fitness(10.0, 6.0, 400.0) == printed_fitness(10.0, 6.0, 0.0) == 16.0
    assert printed_fitness(40.0, 6.0, 0.0) > printed_fitness(10.0, 16.0, 0.0)


def test_mended_a_side_bump_ends_and_may_come_again() -> None:
    here = mended("side_bump")
    for _ in range(2):
        here.step(scan(2.0), (Bumper.LEFT, True))
        here.step(scan(2.0), (Bumper.LEFT, False))
        here.run(3.0, scan(2.0))
        assert here.steps[-1].behaviour == "forward"
    assert here.shares()["bumper"] == 20


def test_mended_a_selection_hears_a_bump_and_the_deadline() -> None:
    here = mended("deaf", "side_bump", limit_s=10.0)
    here.run(1.2, scan(2.0))
    here.run(1.0, scan(0.48))
    assert here.steps[-1].behaviour == "selection"
    here.step(scan(0.48), (Bumper.LEFT, True))
    assert here.step(scan(0.48)).behaviour == "bumper"
    here.run(9.0, scan(0.48))
    assert here.steps[-1].done, "the unmended one goes on for a minute and more"


def test_mended_a_full_turn_hears_a_bump_or_there_is_none() -> None:
    here = mended("deaf", "side_bump")
    here.run(105.0, scan(2.0, left=1.1, right=1.1))
    assert here.steps[-1].behaviour == "full_turn"
    here.step(scan(2.0, left=1.1, right=1.1), (Bumper.CENTER, True))
    assert here.step(scan(2.0)).behaviour == "bumper"
    there = mended("full_turn")
    there.run(130.0, scan(2.0, left=1.1, right=1.1))
    assert "full_turn" not in there.shares() and "pause" not in there.shares()


def test_mended_open_space_is_driven_into_and_what_is_not_seen_is_not() -> None:
    for ahead, expected in ((7.0, "forward"), (0.4, "selection"), (math.nan, "selection")):
        here = mended("open_space")
        here.run(1.2, scan(2.0))
        here.step(scan(ahead))
        assert here.step(scan(ahead)).behaviour == expected


def test_mended_a_junction_is_turned_into_with_the_strongest_turn() -> None:
    for left, right, sign in ((4.0, 1.0, 1), (1.0, 4.0, -1)):
        command = mended("junction").step(scan(3.0, left=left, right=right)).command
        assert command.w_radps == pytest.approx(sign * math.pi / 9) and command.v_mps > 0.0
    slight = [run.step(scan(3.0, left=1.2, right=1.0)).command for run in (mended("junction"), printed())]
    assert slight[0] == slight[1] and slight[0].w_radps > 0.0


def test_a_fault_that_nobody_knows_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="faults rust are not known; known: side_bump"):
        mended(*FAULTS, "rust")
