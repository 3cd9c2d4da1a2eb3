"""The report's frontier mode on its way: what ends an attempt, what ends the mode, and what comes next."""

from __future__ import annotations

from typing import Any, Callable, Dict, List

import pytest

from support.report_rig import Rig, room, scan
from yarm.exploration.model import Command
from yarm.exploration.params import ExploreParams
from yarm.exploration.report.controller import ReportController
from yarm.exploration.report.params import ReportParams
from yarm.geometry import FloatArray, Pose2
from yarm.robots.turtlebot import Bumper

PARAMS = ReportParams(turn_period=10000.0, off=("stuck",))
CLEAR, WALL = scan(2.0), scan(0.49)


def under_way(seed: int = 1) -> Rig:
    """Its first attempt at a frontier has just begun; it is held until then."""
    here = Rig(ReportController(ExploreParams(), seed, PARAMS))
    here.map, here.held = room(), True
    here.run(2.0 * PARAMS.growth_window, CLEAR)
    assert here.step(CLEAR).behaviour == "frontier", f"seed {seed}"
    here.held = False
    return here


def noted(here: Rig, last: int = 0) -> List[Any]:
    """What the mode noted in the last passes, or in all."""
    details: List[Dict[str, Any]] = [
        dict(event.details) for step in here.steps[-last:] for event in step.events if event.kind == "frontier"
    ]
    return [what["what"] for what in details]


def way(here: Rig) -> FloatArray:
    path = here.steps[-1].intent.path
    assert path is not None and len(path) > 1
    return path


def test_after_a_bump_it_backs_off_and_plans_again_to_the_same_frontier() -> None:
    here = under_way()
    here.run(5.0, CLEAR)
    target = way(here)[-1]
    here.step(CLEAR, (Bumper.LEFT, True))
    here.step(CLEAR, (Bumper.LEFT, True))
    assert noted(here, 2) == ["abort"], "pressed again while it backs off, it is the same attempt that ended"
    here.run(0.9, CLEAR)
    assert all(step.behaviour == "bumper" for step in here.steps[-11:])
    begun = here.pose
    assert here.step(CLEAR).behaviour == "frontier"
    assert tuple(way(here)[-1]) == tuple(target) and noted(here) == ["drawn", "abort"]
    assert begun.distance(Pose2(*way(here)[0])) <= 0.05, "from where it is now"


def test_after_a_bump_in_front_the_frontier_comes_before_the_selection() -> None:
    here = under_way()
    here.step(scan(0.9), (Bumper.CENTER, True))
    here.run(2.0, scan(0.9))
    assert [step.behaviour for step in here.steps[-21:]] == ["bumper"] * 10 + ["frontier"] * 11


@pytest.mark.parametrize("ahead, aborts", [(0.51, 0), (0.49, 1)])
def test_less_than_half_a_metre_ahead_ends_an_attempt(ahead: float, aborts: int) -> None:
    here = under_way()
    here.run(5.0, CLEAR)
    target = way(here)[-1]
    here.step(scan(ahead))
    here.step(CLEAR)
    assert noted(here) == ["drawn"] + ["abort"] * aborts
    assert here.steps[-1].behaviour == "frontier" and tuple(way(here)[-1]) == tuple(target)


def test_facing_a_wall_the_attempts_are_used_up_in_four_passes() -> None:
    """Each next attempt begins in the pass that ended the one before."""
    here = under_way()
    steps = here.run(0.4, WALL)
    assert noted(here) == ["drawn", "abort", "abort", "abort", "abort", "false"]
    assert [step.behaviour for step in steps[:3]] == ["frontier"] * 3


def test_an_attempt_lasts_thirty_seconds() -> None:
    here = under_way()
    here.held = True
    target = way(here)[-1]
    here.run(29.9, CLEAR)
    assert noted(here) == ["drawn"]
    here.run(0.3, CLEAR)
    assert noted(here) == ["drawn", "abort"]
    assert here.steps[-1].behaviour == "frontier" and tuple(way(here)[-1]) == tuple(target)
    here.run(29.7, CLEAR)
    assert noted(here) == ["drawn", "abort"], "the next one has thirty of its own"
    here.run(0.5, CLEAR)
    assert noted(here) == ["drawn", "abort", "abort"]


def bumped(here: Rig) -> None:
    here.step(CLEAR, (Bumper.LEFT, True))


def walled(here: Rig) -> None:
    here.step(WALL)


def too_long(here: Rig) -> None:
    here.held = True
    before = len(noted(here))
    for _ in range(310):
        here.step(CLEAR)
        if len(noted(here)) > before:
            return


@pytest.mark.parametrize("abort", [bumped, walled, too_long])
def test_after_more_than_three_aborts_the_frontier_is_false_and_it_drives_on(abort: Callable[[Rig], None]) -> None:
    here = under_way()
    for count in range(1, 4):
        abort(here)
        here.run(1.1, CLEAR)
        assert noted(here) == ["drawn"] + ["abort"] * count
        assert here.steps[-1].behaviour == "frontier", f"after {count} aborts"
    abort(here)
    assert noted(here) == ["drawn"] + ["abort"] * 4 + ["false"]
    assert here.steps[-1].behaviour != "frontier" and here.steps[-1].intent.path is None
    here.held = True
    after = here.run(50.0, CLEAR)
    bumped(here)
    assert "frontier" not in {step.behaviour for step in after} and after[-1].command == Command(0.2, 0.0)
    assert noted(here, 501) == [], "what is hit now ends no attempt"


def test_a_frontier_reached_ends_the_mode() -> None:
    here = under_way()
    target = Pose2(*way(here)[-1])
    seen_from = here.pose
    for _ in range(300):
        seen_from = here.pose
        if here.step(CLEAR).behaviour != "frontier":
            break
    assert noted(here) == ["drawn", "reached"]
    assert here.steps[-1].behaviour == "forward" and here.steps[-1].intent.path is None
    assert seen_from.distance(target) <= PARAMS.follow_end + 1e-9
    here.held = True
    assert {step.behaviour for step in here.run(50.0, CLEAR)} == {"forward"}
