"""Faults of the printed program that its main loop hides or that show over time; each beside a system without it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import List, Tuple

import numpy as np
import pytest

from support.report_rig import Rig, moved, scan
from yarm.experiments.explore.runner import run_kinematic
from yarm.exploration.model import LOOP_S, Command, Observation
from yarm.exploration.params import ExploreParams
from yarm.exploration.registry import make_controller
from yarm.exploration.report.controller import ReportController
from yarm.exploration.report.follow import CellFollower
from yarm.exploration.report.params import ReportParams
from yarm.exploration.report.printed import STUCK_SAMPLES, PrintedController
from yarm.exploration.report.printed_follow import printed_follow, printed_heading, printed_place
from yarm.exploration.report.view import View, Watcher
from yarm.geometry import FloatArray, Pose2
from yarm.geometry.scans import Odometry
from yarm.sim.scenes.arena import Arena, Block

CELL_M = 0.05
AT_ORIGIN = Pose2(0.0, 0.0)


def view_at(odom: Pose2, map_from_odom: Pose2 = AT_ORIGIN, now_s: float = 1.0) -> View:
    view = Watcher().look(Observation(now_s, Odometry(now_s, odom), map_from_odom, scan(2.0)))
    assert view is not None
    return view


def straight(cells: int) -> FloatArray:
    return np.stack([CELL_M * np.arange(cells), np.zeros(cells)], axis=1)


def follow_printed(points: FloatArray, odom: Pose2, seconds: float) -> Tuple[List[Command], Pose2]:
    """What the printed follower commands to a base that obeys; fewer commands when it ends."""
    motion = printed_follow(view_at(odom), points, CELL_M)
    commands: List[Command] = []
    try:
        commands.append(next(motion)[1])
        for _ in range(round(seconds / LOOP_S)):
            odom = moved(odom, commands[-1])
            commands.append(motion.send(view_at(odom))[1])
    except StopIteration:
        pass
    return commands, odom


@pytest.mark.parametrize("yaw_rad", [0.0, 1.0, -2.0])
def test_its_heading_is_the_odometry_s_x_whichever_way_the_robot_looks(yaw_rad: float) -> None:
    odom, frame = Pose2(0.7, 0.2, yaw_rad), Pose2(0.0, 0.0, 0.4)
    assert printed_heading(odom, frame) == pytest.approx(0.7 + math.sin(0.2))
    ours = Observation(1.0, Odometry(1.0, odom), frame).pose
    assert ours is not None and ours.yaw_rad == pytest.approx(yaw_rad + 0.4)


def test_its_place_leaves_out_how_the_odometry_frame_is_turned() -> None:
    odom, frame = Pose2(2.0, 0.0), Pose2(1.0, 0.0, math.pi / 2)
    assert printed_place(odom, frame) == (3.0, 0.0)
    ours = Observation(1.0, Odometry(1.0, odom), frame).pose
    assert ours is not None and (ours.x, ours.y) == pytest.approx((1.0, 2.0))


def test_a_turn_towards_the_path_never_ends_since_turning_changes_nothing() -> None:
    aside = straight(20)[:, ::-1]
    commands, odom = follow_printed(aside, AT_ORIGIN, 60.0)
    assert len(commands) == 601 and all(c.v_mps == 0.0 and c.w_radps > 0.0 for c in commands)
    assert (odom.x, odom.y) == (0.0, 0.0)


def test_it_steers_away_from_the_path_where_the_text_steers_to_it() -> None:
    """From y = -0.004 m the path lies to the left: 0.02 rad, little enough to drive at once."""
    points, aside = straight(20), Pose2(0.0, -0.004, 0.0)
    commands, _ = follow_printed(points, aside, 0.1)
    assert commands[0].v_mps > 0.0 and commands[0].w_radps < 0.0
    text = CellFollower(points, CELL_M, ReportParams()).step(aside)
    assert text is not None and text.v_mps > 0.0 and text.w_radps > 0.0


def test_the_wait_at_the_end_of_a_short_path_never_ends_and_hears_nothing() -> None:
    motion = printed_follow(view_at(AT_ORIGIN), straight(4), CELL_M)
    next(motion)
    there = view_at(Pose2(0.1, 0.0))
    assert [motion.send(there)[1] for _ in range(100)] == [Command()] * 100
    bumped = replace(there, observation=replace(there.observation, now_s=2000.0), now_s=2000.0)
    assert motion.send(bumped) == ("frontier", Command()), "no bump, no deadline"
    text = CellFollower(straight(4), CELL_M, ReportParams())
    assert text.step(Pose2(0.1, 0.0)) is None, "it has arrived"


def test_a_path_of_one_cell_is_done() -> None:
    assert follow_printed(straight(1), AT_ORIGIN, 1.0)[0] == []


@pytest.mark.parametrize("left", [2.0, 2.3, 1.7])
def test_the_stuck_test_is_true_after_its_window_whatever_happens(left: float) -> None:
    """Straight on, and in curves to the left and to the right; all are free to move."""
    printed, text = (Rig(PrintedController(ExploreParams(), 1)), Rig(ReportController(ExploreParams(), 1)))
    for run in (printed, text):
        run.run(40.0, scan(2.0, left=left))
        assert math.hypot(run.pose.x, run.pose.y) > 1.0 or abs(run.pose.yaw_rad) > 1.0
    said = [event for step in printed.steps for event in step.events if event.kind == "stuck"]
    assert [event.t_s for event in said] == [pytest.approx((STUCK_SAMPLES - 1) * LOOP_S)]
    assert printed.shares() == {"forward": 400}, "and nothing comes of it"
    assert not any(event.kind == "stuck" for step in text.steps for event in step.events)


def ways_at(places: Tuple[Pose2, Pose2], seed: int, *mended: str) -> Tuple[float, float]:
    """Which way it turns at a selection at each place, by odometry: 1 left, -1 right; in the map all are the first."""
    here = Rig(PrintedController(ExploreParams(), seed, mended))
    here.run(1.2, scan(2.0))
    ways = []
    for place in places:
        here.pose, here.map_from_odom = place, places[0].compose(place.inverse())
        here.step(scan(0.48))
        ways.append(math.copysign(1.0, here.step(scan(0.48)).command.w_radps))
        here.run(0.2, scan(1.5))
    return ways[0], ways[1]


def test_a_place_is_not_known_again_once_the_odometry_has_drifted() -> None:
    place = Pose2(1.0, 1.0)
    known = [ways_at((place, place), seed) for seed in range(20)]
    assert all(first == -second for first, second in known)
    drifted = [ways_at((place, Pose2(1.3, 1.0)), seed) for seed in range(20)]
    assert any(first == second for first, second in drifted), "drawn as if it had never been there"
    mended = [ways_at((place, Pose2(1.3, 1.0)), seed, "places") for seed in range(20)]
    assert all(first == -second for first, second in mended)


EDGE = 1.525
ROOM = Arena(
    "low",
    "custom",
    0,
    (-1.5, -1.5),
    (1.5, 1.5),
    (
        Block("south", "wall", Pose2(0.0, -EDGE), (3.1, 0.05, 0.6)),
        Block("north", "wall", Pose2(0.0, EDGE), (3.1, 0.05, 0.6)),
        Block("west", "wall", Pose2(-EDGE, 0.0), (0.05, 3.0, 0.6)),
        Block("east", "wall", Pose2(EDGE, 0.0), (0.05, 3.0, 0.6)),
        Block("brick", "low", Pose2(0.2, 0.0), (0.2, 0.8, 0.1)),
    ),
    Pose2(-0.9, 0.0),
)


def hits(name: str) -> int:
    """How often a run touches the brick in five minutes."""
    params = ExploreParams(controller=name, time_limit_s=300.0)
    record = run_kinematic(ROOM, make_controller(params, 1), 1, params)
    return sum(touch.block == "brick" for touch in record.touches)


def test_what_is_low_is_hit_again_and_by_ours_not_at_all() -> None:
    assert hits("report_printed") >= 2
    assert hits("yarm") == 0
