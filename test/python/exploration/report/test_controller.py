"""The report's explorer, behaviour by behaviour, each also switched off."""

from __future__ import annotations

import math
from typing import Any, List, Mapping

import pytest

from support.report_rig import Rig, room, scan
from yarm.exploration.model import Command
from yarm.exploration.params import ExploreParams
from yarm.exploration.registry import make_controller
from yarm.exploration.report import behaviours, frontier_mode
from yarm.exploration.report.behaviours import to_the_middle
from yarm.exploration.report.controller import ReportController
from yarm.exploration.report.params import BEHAVIOURS, FAST, ReportParams
from yarm.geometry import Pose2
from yarm.geometry.scans import Scan
from yarm.robots.turtlebot import Bumper

PARAMS = ExploreParams(controller="report")
BUMPS = {bumper: (bumper, True) for bumper in Bumper}


def rig(seed: int = 1, **numbers: Any) -> Rig:
    return Rig(ReportController(PARAMS, seed, ReportParams(**numbers)))


@pytest.mark.parametrize("ahead, speed", [(2.0, 0.2), (0.71, 0.2), (0.69, 0.1), (0.51, 0.1)])
def test_forward_slows_near_something(ahead: float, speed: float) -> None:
    assert rig().step(scan(ahead)).command == Command(speed, 0.0)


def test_the_fast_profile() -> None:
    fast = Rig(ReportController(PARAMS, 1, FAST))
    assert fast.step(scan(2.0)).command.v_mps == 0.3 and fast.step(scan(0.6)).command.v_mps == 0.15


def test_it_keeps_to_the_middle() -> None:
    assert rig().step(scan(3.0, left=1.5, right=1.0)).command.w_radps == pytest.approx(0.15)
    assert rig(off=("middle",)).step(scan(3.0, left=1.5, right=1.0)).command.w_radps == 0.0


def test_a_strong_turn_becomes_none() -> None:
    assert to_the_middle(3.0, 1.0, ReportParams()) == 0.0
    assert to_the_middle(2.0, 1.0, ReportParams()) == pytest.approx(0.3)


@pytest.mark.parametrize("ahead", [0.48, math.nan])
def test_without_room_it_stops_and_turns_until_there_is(ahead: float) -> None:
    here = rig()
    assert here.step(scan(ahead)).command == Command()
    turning = here.step(scan(ahead))
    assert turning.behaviour == "selection" and abs(turning.command.w_radps) == 0.4
    here.run(1.0, scan(0.8))
    assert here.steps[-1].behaviour == "selection"
    assert here.step(scan(1.2)).behaviour == "forward"


def test_a_selection_does_not_end_where_it_came_from() -> None:
    here = rig()
    here.step(scan(0.48))
    here.run(math.radians(165.0) / 0.4, scan(0.48))
    assert here.step(scan(3.0)).behaviour == "selection"
    here.run(math.radians(50.0) / 0.4, scan(0.48))
    assert here.step(scan(3.0)).behaviour == "forward"


def test_after_a_whole_turn_it_takes_the_next_local_maximum() -> None:
    here = rig(turn_period=1000.0)
    here.step(scan(0.48))
    here.run(2.0 * math.pi / 0.4, scan(0.9))
    for ahead in (1.1, 1.2, 1.3):
        assert here.step(scan(ahead)).behaviour == "selection"
    assert here.step(scan(1.25)).behaviour == "forward"


def test_it_does_not_turn_for_ever() -> None:
    here = rig(turn_period=1000.0)
    here.step(scan(0.48))
    here.run(2.0 * math.pi / 0.4 + 62.0, scan(0.48))
    assert here.shares()["forward"] >= 2


def test_without_the_search_a_whole_turn_ends_it() -> None:
    here = rig(turn_period=1000.0, off=("search",))
    here.step(scan(0.48))
    here.run(2.0 * math.pi / 0.4 - 1.0, scan(0.9))
    assert here.steps[-1].behaviour == "selection"
    here.run(1.5, scan(0.9))
    assert here.steps[-1].behaviour == "forward"


def test_without_the_stop_it_goes_on_slowly_and_a_bump_still_selects() -> None:
    here = rig(off=("stop",))
    assert here.step(scan(0.48)).command == Command(0.1, 0.0)
    here.step(scan(0.9), (Bumper.CENTER, True))
    here.run(1.0, scan(0.9))
    assert here.step(scan(0.9)).behaviour == "selection"


def test_without_selections_none_begins() -> None:
    here = rig(off=("selection",))
    assert here.step(scan(0.48)).command == Command(0.1, 0.0)
    here.step(scan(0.9), (Bumper.CENTER, True))
    here.run(2.0, scan(0.9))
    assert not any(event.kind == "draw" for step in here.steps for event in step.events)


def test_without_driving_ahead_it_stands() -> None:
    assert rig(off=("forward",)).step(scan(2.0)).command == Command()


def test_left_is_drawn_more_often() -> None:
    left = 0
    for seed in range(400):
        here = rig(seed)
        here.step(scan(0.48))
        left += here.step(scan(0.48)).command.w_radps > 0.0
    assert 190 <= left <= 250


def test_at_a_remembered_place_it_turns_the_other_way() -> None:
    here = rig(3)
    ways = []
    for _ in range(4):
        here.step(scan(0.48))
        ways.append(here.step(scan(0.48)).command.w_radps)
        here.step(scan(2.0))
        here.pose = Pose2(0.1, 0.1)
    assert ways[1] == -ways[0]
    assert len(set(ways[1:])) == 1, "the first match counts, which stays the first place"


def test_without_places_the_way_is_drawn_there_as_anywhere() -> None:
    def ways(seed: int, **numbers: Any) -> List[float]:
        here = rig(seed, **numbers)
        turns = []
        for _ in range(2):
            here.step(scan(0.48))
            turns.append(here.step(scan(0.48)).command.w_radps)
            here.step(scan(2.0))
            here.pose = Pose2(0.1, 0.1)
        return turns

    assert all(first == -second for first, second in (ways(seed) for seed in range(20)))
    drawn = [ways(seed, off=("places",)) for seed in range(20)]
    assert any(first == second for first, second in drawn) and any(first != second for first, second in drawn)


def test_a_place_is_remembered_by_the_laser_s_selections_alone() -> None:
    here = rig(3)
    here.step(scan(0.9), (Bumper.CENTER, True))
    here.run(1.5, scan(0.9))
    assert here.steps[-1].behaviour == "selection"
    here.step(scan(2.0))
    here.pose = Pose2(0.0, 0.0)
    here.step(scan(0.48))
    again = [dict(event.details)["again"] for step in here.steps for event in step.events if event.kind == "draw"]
    assert again == [0, 0]


def test_only_the_last_twenty_places_are_remembered() -> None:
    def again_after(others: int) -> int:
        here = rig(3, turn_period=10000.0, off=("stuck", "frontier", "find_exit"))
        for i in [*range(others + 1), 0]:
            here.pose = Pose2(float(i), 0.0)
            here.step(scan(0.48))
            here.step(scan(2.0))
        draws = [dict(event.details)["again"] for step in here.steps for event in step.events if event.kind == "draw"]
        assert len(draws) == others + 2 and sum(draws[:-1]) == 0
        return int(draws[-1])

    assert again_after(19) == 1 and again_after(20) == 0


@pytest.mark.parametrize("bumper, turn", [(Bumper.LEFT, -1), (Bumper.RIGHT, 1), (Bumper.CENTER, 1)])
def test_a_bump_backs_off_and_turns_away_for_ten_loops(bumper: Bumper, turn: int) -> None:
    here = rig()
    steps = [here.step(scan(2.0), (bumper, True)), *here.run(0.9, scan(2.0))]
    assert all(step.command == Command(-0.05, turn * math.pi / 6) for step in steps)
    assert here.pose.distance(Pose2(0.0, 0.0)) == pytest.approx(0.05, abs=0.005)
    after = here.step(scan(2.0))
    assert after.behaviour == ("forward" if bumper != Bumper.CENTER else after.behaviour)


def test_a_bump_in_front_ends_in_a_selection() -> None:
    here = rig()
    here.step(scan(0.9), (Bumper.CENTER, True))
    here.run(1.0, scan(0.9))
    assert here.step(scan(0.9)).behaviour == "selection"


def test_a_bump_interrupts_a_selection() -> None:
    here = rig()
    here.step(scan(0.48))
    here.run(1.0, scan(0.48))
    assert here.step(scan(0.48), (Bumper.LEFT, True)).behaviour == "bumper"


def test_with_the_bumper_off_it_drives_on() -> None:
    assert rig(off=("bumper",)).step(scan(2.0), (Bumper.CENTER, True)).command.v_mps == 0.2


def test_a_full_turn_every_101_seconds_and_a_pause() -> None:
    here = rig(off=("frontier",))
    here.run(140.0, scan(2.0))
    names = [step.behaviour for step in here.steps]
    assert names.index("full_turn") == 1020
    turning = [step.command for step in here.steps if step.behaviour == "full_turn"]
    assert all(command.v_mps == -0.05 for command in turning[:9]) and turning[12].v_mps == 0.0
    assert 23.0 <= 0.1 * len(turning) <= 24.1
    assert 2.8 <= 0.1 * names.count("pause") <= 3.0
    off = rig(off=("full_turn", "frontier"))
    off.run(140.0, scan(2.0))
    assert set(off.shares()) == {"forward"}


def test_held_fast_it_turns_around_and_not_when_it_moves() -> None:
    held, free = rig(turn_period=1000.0, off=("frontier",)), rig(turn_period=1000.0, off=("frontier",))
    held.held = True
    held.run(17.0, scan(2.0))
    free.run(60.0, scan(2.0))
    assert "full_turn" in held.shares() and "full_turn" not in free.shares()
    off = rig(turn_period=1000.0, off=("stuck", "frontier"))
    off.held = True
    off.run(17.0, scan(2.0))
    assert "full_turn" not in off.shares()


def test_turning_right_is_turning_too() -> None:
    here = rig(turn_period=1000.0)
    for seed in range(20):
        here = rig(seed, turn_period=1000.0)
        here.step(scan(0.48))
        if here.step(scan(0.48)).command.w_radps < 0.0:
            break
    here.run(20.0, scan(0.48))
    assert "full_turn" not in here.shares()


def test_an_exit_at_a_remembered_place_is_looked_into() -> None:
    def passing(here: Rig) -> str:
        here.step(scan(0.48))
        here.run(0.5, scan(0.48))
        here.step(scan(3.0))
        here.pose = Pose2(2.0, 0.0)
        here.step(scan(3.0))
        here.pose = Pose2(0.1, 0.0)
        return here.step(scan(3.0, left=4.0, right=1.0)).behaviour

    assert passing(rig()) == "find_exit" and passing(rig(off=("find_exit",))) == "forward"


def test_an_exit_is_looked_for_in_the_pass_that_enters_the_place_alone() -> None:
    def at_the_place(*rooms: Scan) -> str:
        here = rig()
        here.step(scan(0.48))
        here.step(scan(3.0))
        here.pose = Pose2(2.0, 0.0)
        here.step(scan(3.0))
        for seen in rooms:
            here.pose = Pose2(0.1, 0.0)
            here.step(seen)
        return here.steps[-1].behaviour

    narrow, wide = scan(3.0), scan(3.0, left=4.0, right=1.0)
    assert at_the_place(wide) == "find_exit" and at_the_place(scan(3.0, left=2.0, right=1.0)) == "forward"
    assert at_the_place(narrow, wide) == "forward", "what opens later is passed by"


def assert_listed(here: Rig, drawn: Mapping[str, Any]) -> None:
    """With the draw all frontiers are told that it was made from, in the order of d, I, W, R, P."""
    listed = [dict(event.details) for event in here.steps[-1].events if event.kind == "candidate"]
    assert all(list(row) == ["x", "y", "d", "I", "W", "R", "P"] for row in listed)
    assert sum(row["P"] for row in listed) == pytest.approx(1.0, abs=1e-5)
    assert sum(row["P"] > 0.0 for row in listed) == drawn["of"]
    assert any(all(row[name] == drawn[name] for name in "dIWRP") for row in listed)
    for row in listed:
        assert row["R"] == pytest.approx(row["d"] + row["I"] - 0.1 * row["W"], abs=1e-3)


def test_a_map_that_does_not_grow_starts_the_frontier_mode() -> None:
    here = rig(turn_period=1000.0, off=("stuck",))
    here.map, here.held = room(), True
    here.run(200.0, scan(2.0))
    assert set(here.shares()) == {"forward"}
    assert here.step(scan(2.0)).behaviour == "frontier"
    drawn = [event for step in here.steps for event in step.events if event.kind == "frontier"]
    names = dict(drawn[0].details)
    assert names["what"] == "drawn" and {"d", "I", "W", "R", "P"} <= set(names)
    assert_listed(here, names)
    off = rig(turn_period=1000.0, off=("frontier",))
    off.map = room()
    off.run(210.0, scan(2.0))
    assert "frontier" not in off.shares()


def test_at_the_deadline_it_stands_whatever_it_did() -> None:
    here = Rig(ReportController(ExploreParams(time_limit_s=2.0), 1))
    here.step(scan(0.48))
    here.run(1.9, scan(0.48))
    end = here.step(scan(0.48), (Bumper.LEFT, True))
    assert end.done and end.command == Command() and end.behaviour == "deadline"


def test_every_behaviour_is_a_class_that_can_be_switched_off() -> None:
    modules = (behaviours, frontier_mode)
    named = (getattr(cls, "name", None) for module in modules for cls in vars(module).values() if isinstance(cls, type))
    classes = {name for name in named if isinstance(name, str)}
    assert classes == set(BEHAVIOURS)


def test_without_its_deadline_it_goes_on() -> None:
    here = Rig(ReportController(ExploreParams(time_limit_s=2.0), 1, ReportParams(off=("deadline",))))
    here.run(3.0, scan(2.0))
    assert here.steps[-1].command.v_mps == 0.2 and not here.steps[-1].done


def test_the_same_seed_gives_the_same_run() -> None:
    runs = []
    for _ in range(2):
        here = Rig(make_controller(PARAMS, 7))
        for i in range(300):
            here.step(scan(0.45 + 0.1 * (i % 9)))
        runs.append([(step.command, step.behaviour, step.events) for step in here.steps])
    assert runs[0] == runs[1]
