"""explore_lite as it is: cost, centroids, blacklist, and that it gives up."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from python.exploration.explorer_samples import observe, run_on
from python.navigation.map_samples import drawn
from yarm.exploration.explore_lite import ExploreLiteController
from yarm.exploration.params import ExploreParams
from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap

PARAMS = ExploreParams(controller="explore_lite")
# Free ground with a short frontier near by (left) and a long one far away (right).
TWO = drawn("############\n#..........?\n?..........?\n#..........?\n############", scale=10)
START = Pose2(1.0, 1.25)


def goals(controller: ExploreLiteController, grid_map: GridMap, seconds: float) -> list[tuple[float, float]]:
    steps, _ = run_on(controller, grid_map, START, seconds)
    events = [event for step in steps for event in step.events if event.kind == "goal"]
    return [(float(dict(event.details)["x"]), float(dict(event.details)["y"])) for event in events]


def test_the_longer_frontier_wins_by_default_and_its_centroid_is_the_goal() -> None:
    x, y = goals(ExploreLiteController(PARAMS, 0), TWO, 0.1)[0]
    assert x == pytest.approx(5.525) and y == pytest.approx(1.25)


def test_the_nearer_one_wins_when_distance_weighs_more() -> None:
    near = ExploreParams(controller="explore_lite", potential_scale=20.0)
    x, y = goals(ExploreLiteController(near, 0), TWO, 0.1)[0]
    assert x == pytest.approx(0.475) and y == pytest.approx(1.25)


def test_the_cost_takes_the_distance_in_metres_times_the_resolution() -> None:
    step = ExploreLiteController(PARAMS, 0).step(observe(0.0, START, TWO))
    scores = sorted(view.score for view in step.intent.frontiers)
    assert scores[-1] == pytest.approx(30 * 0.05 - 1e-3 * 4.525 * 0.05, abs=1e-4)


def test_short_frontiers_are_left() -> None:
    shut = drawn("######\n#....#\n?....#\n#....#\n######", scale=9)
    assert goals(ExploreLiteController(PARAMS, 0), shut, 0.1) == []
    shorter = ExploreParams(controller="explore_lite", min_frontier_size=0.45)
    assert len(goals(ExploreLiteController(shorter, 0), shut, 0.1)) == 1


def test_a_goal_that_cannot_be_reached_is_blacklisted_and_it_gives_up_with_a_frontier_left() -> None:
    controller = ExploreLiteController(PARAMS, 0)
    walled = drawn("########\n#....#?#\n#....#?#\n#......?\n########", scale=4)
    steps, _ = run_on(controller, walled, Pose2(0.4, 0.4), 5.0)
    assert steps[-1].done and "blacklisted" in steps[-1].reason
    again = controller.step(observe(9.0, START, TWO))
    assert again.done and again.events == (), "it must be started again"


def test_a_time_without_progress_blacklists_a_goal() -> None:
    quick = ExploreParams(controller="explore_lite", progress_timeout=1.5)
    controller = ExploreLiteController(quick, 0)
    events = []
    for i in range(29):
        events += controller.step(observe(0.1 * i, START, TWO)).events
    blacklisted = [event for event in events if event.kind == "blacklist"]
    assert blacklisted and 1.5 < blacklisted[0].t_s < 2.9
    chosen = [dict(event.details)["x"] for event in events if event.kind == "goal"]
    assert chosen[0] == pytest.approx(5.525) and chosen[1] == pytest.approx(0.475)


def test_it_turns_to_the_maps_own_orientation_at_a_goal() -> None:
    step = ExploreLiteController(PARAMS, 0).step(observe(0.0, Pose2(1.0, 1.25, 2.0), TWO))
    assert step.intent.goal is not None and step.intent.goal.yaw_rad == 0.0


def test_a_map_without_free_ground_ends_it() -> None:
    nothing = GridMap(np.full((20, 20), -1, np.int8), 0.05, Pose2(0.0, 0.0))
    assert ExploreLiteController(PARAMS, 0).step(observe(0.0, Pose2(0.5, 0.5), nothing)).done
    assert not ExploreLiteController(PARAMS, 0).step(observe(0.0, Pose2(0.5, 0.5), None)).done
    assert math.isclose(ExploreParams().potential_scale, 1e-3)


def test_it_drives_on_after_the_pose_was_lost() -> None:
    controller = ExploreLiteController(PARAMS, 0)
    controller.step(observe(0.0, START, TWO))
    lost = replace(observe(0.1, START, TWO), map_from_odom=None)
    assert controller.step(lost).behaviour == "wait"
    steps = [controller.step(observe(0.2 + 0.1 * i, START, TWO)) for i in range(15)]
    assert [event.kind for step in steps for event in step.events] == ["goal"]
    assert steps[-1].command.v_mps > 0.0


def test_a_goal_without_a_way_is_not_given_up_at_once() -> None:
    walled = drawn("########\n#....#?#\n#....#?#\n#......?\n########", scale=4)
    small = ExploreParams(controller="explore_lite", min_frontier_size=0.1)
    steps, _ = run_on(ExploreLiteController(small, 0), walled, Pose2(0.4, 0.4), 90.0)
    kinds = [event.kind for step in steps for event in step.events]
    assert "recovery" in kinds and kinds.index("recovery") < kinds.index("done")
    recovered = next(event.t_s for step in steps for event in step.events if event.kind == "recovery")
    assert recovered == pytest.approx(5.1, abs=0.2)
