"""Driving to goals: the rules of speed, bumps, being stuck, ways that close."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import List, Optional, Tuple

import numpy as np
import pytest

from python.exploration.explorer_samples import far_scan, moved, observe
from python.navigation.map_samples import drawn
from yarm.experiments.explore.measures import SPEED_SLACK
from yarm.experiments.explore.trial import ExploreSpec, run_trial
from yarm.exploration.driver import SOON_PASSED, SOON_SWEPT, TOUCHING_M, Driven, Driver, DriverSettings, Drives
from yarm.exploration.model import LOOP_S, LowView
from yarm.exploration.params import ExploreParams
from yarm.exploration.seen import EDGE_M
from yarm.exploration.yarm import DRIVING
from yarm.geometry import Pose2
from yarm.geometry.scans import Odometry
from yarm.navigation.grid_map import GridMap
from yarm.robots import turtlebot
from yarm.robots.turtlebot import Bumper, BumperEvent

HALL = drawn("############\n#..........#\n#..........#\n#..........#\n############", scale=10)
START = Pose2(1.0, 1.25)
GOAL = (4.5, 1.25)
BOLD = DriverSettings(cautious=False)


class Rig:
    """A driver and an ideal robot."""

    def __init__(self, settings: DriverSettings = BOLD, grid_map: GridMap = HALL) -> None:
        self.driver = Driver(ExploreParams(), settings)
        self.map, self.count, self.pose, self.now_s = grid_map, 0, START, 0.0

    def go(self, x: float, y: float, yaw_rad: Optional[float] = None, range_m: float = 4.0) -> str:
        self.driver.sense(observe(self.now_s, self.pose, self.map, self.count, scan=far_scan(range_m)))
        field = self.driver.field(self.pose)
        return self.driver.go(field, self.map.cell_of(x, y), yaw_rad)

    def step(self, bumps: Tuple[BumperEvent, ...] = (), moves: bool = True, range_m: float = 4.0) -> Driven:
        seen = observe(self.now_s, self.pose, self.map, self.count, bumps, far_scan(range_m))
        self.driver.sense(seen)
        driven = self.driver.step(seen)
        if moves:
            self.pose = moved(self.pose, driven.command)
        self.now_s += LOOP_S
        return driven

    def until(self, *states: Drives, most_s: float = 60.0, range_m: float = 4.0, moves: bool = True) -> List[Driven]:
        given: List[Driven] = []
        while not given or given[-1].state not in states:
            given.append(self.step(range_m=range_m, moves=moves))
            assert len(given) * LOOP_S < most_s, f"not {states} after {most_s} s: {given[-1]}"
        return given


def test_it_arrives_at_the_pose() -> None:
    rig = Rig()
    assert rig.go(*GOAL, math.pi / 2) == ""
    given = rig.until(Drives.ARRIVED)
    assert math.hypot(rig.pose.x - GOAL[0], rig.pose.y - GOAL[1]) < 0.08
    assert rig.pose.yaw_rad == pytest.approx(math.pi / 2, abs=0.07)
    assert max(g.command.v_mps for g in given) == pytest.approx(0.3)
    assert rig.step().state is Drives.IDLE and rig.step().command.v_mps == 0.0


def test_a_goal_that_the_disc_does_not_fit_is_refused() -> None:
    assert "cannot get there" in Rig().go(5.4, 1.25)


def test_walls_ahead_make_it_slow_by_the_map_and_by_the_scan() -> None:
    rig = Rig()
    rig.go(5.2, 1.25)
    for _ in range(400):
        driven = rig.step()
        if driven.state is Drives.ARRIVED:
            break
        assert driven.command.v_mps <= 0.15 + 1e-9 or 5.5 - rig.pose.x >= 0.7 - 0.05
    assert driven.state is Drives.ARRIVED
    seen = Rig()
    seen.go(*GOAL)
    assert max(g.command.v_mps for g in seen.until(Drives.ARRIVED, range_m=0.65)) <= 0.15 + 1e-9


def test_it_creeps_where_the_floor_was_never_seen() -> None:
    rig = Rig(DriverSettings(cautious=True))
    rig.go(*GOAL, range_m=math.nan)
    given = rig.until(Drives.ARRIVED, range_m=math.nan)
    assert max(g.command.v_mps for g in given) <= 0.1
    seeing = Rig(DriverSettings(cautious=True))
    seeing.go(*GOAL)
    assert max(g.command.v_mps for g in seeing.until(Drives.ARRIVED)) == pytest.approx(0.3)


def test_yarm_turns_round_quickly_and_does_not_swing_over() -> None:
    rig = Rig(DRIVING)
    rig.step()
    rig.driver.turn(rig.pose, math.radians(179.0))
    given = rig.until(Drives.ARRIVED)
    rates = np.array([g.command.w_radps for g in given])
    assert rates.min() >= 0.0 and rates.max() == pytest.approx(DRIVING.turn_radps)
    assert np.abs(np.diff(rates[:-1])).max() <= DRIVING.turn_up_radps2 * LOOP_S + 1e-9
    assert len(given) * LOOP_S < 3.0
    assert abs(rig.pose.yaw_rad - math.radians(179.0)) <= DRIVING.arrive_rad


def test_ways_are_searched_for_again_only_from_farther_away() -> None:
    rig = Rig()
    rig.step()
    ways = rig.driver.field(START)
    assert rig.driver.field(Pose2(START.x + 0.04, START.y), 0.05) is ways
    assert rig.driver.field(Pose2(START.x + 2.0, START.y)) is ways
    assert rig.driver.field(Pose2(START.x + 0.06, START.y), 0.05) is not ways


def test_ways_that_were_searched_for_early_are_there_when_they_are_asked_for() -> None:
    rig = Rig()
    rig.step()
    there, first = Pose2(START.x + 0.3, START.y), rig.driver.field(START)
    rig.driver.search_early(there, 0.05)
    assert rig.driver.field(there) is first, "who asks for ways from anywhere gets those that he had"
    assert rig.driver.field(there, 0.05) is rig.driver.field(there) is not first
    assert rig.driver.field(there).start == there
    rig.driver.search_early(Pose2(there.x + 0.04, there.y), 0.05)
    assert rig.driver.field(Pose2(there.x + 0.06, there.y), 0.05).start.x == there.x + 0.06


def test_all_floor_that_the_body_is_about_to_sweep_is_looked_at() -> None:
    for x in np.arange(turtlebot.RADIUS_M, 0.27, 0.01):
        for y in np.arange(-turtlebot.RADIUS_M, turtlebot.RADIUS_M + 1e-9, 0.01):
            gap = np.hypot(*(SOON_PASSED - (x, y)).T).min()
            assert gap <= EDGE_M / math.sqrt(2.0), f"nothing is looked at within {gap:.3f} m of ({x:.2f}, {y:.2f})"


def test_what_lies_beside_the_body_is_looked_at_before_it_speeds_up() -> None:
    for x in np.arange(0.0, 0.27, 0.01):
        for y in np.arange(-turtlebot.RADIUS_M, turtlebot.RADIUS_M + 1e-9, 0.01):
            if math.hypot(x, y) > turtlebot.RADIUS_M + 0.01:
                gap = np.hypot(*(SOON_SWEPT - (x, y)).T).min()
                assert gap <= 0.5 * EDGE_M, f"nothing is looked at within {gap:.3f} m of ({x:.2f}, {y:.2f})"


def test_a_long_brick_that_was_met_is_not_met_again_at_its_end() -> None:
    measures = run_trial(ExploreSpec("bricks_200", "yarm", seed=0, time_limit_s=60.0)).measures
    assert measures.bumps == 1 and measures.bumped_again == 0 and measures.share > 0.9


@pytest.mark.parametrize("arena", ["bricks_7", "bricks_13", "bricks_24"])
def test_bricks_beside_the_way_are_not_met_at_speed(arena: str) -> None:
    measures = run_trial(ExploreSpec(arena, "yarm", seed=0, time_limit_s=180.0)).measures
    assert measures.fastest_bump <= DriverSettings().touch_mps + SPEED_SLACK
    assert measures.bumped_again == 0 and measures.too_fast_near_s == 0.0


def test_a_bump_is_backed_off_from_slowly_and_ends_the_goal() -> None:
    rig = Rig()
    rig.go(*GOAL)
    for _ in range(30):
        rig.step()
    x = rig.pose.x
    driven = rig.step((BumperEvent(Bumper.CENTER, True),))
    assert driven.state is Drives.BACKING and [event.kind for event in driven.events] == ["bump"]
    given = rig.until(Drives.FAILED)
    assert "bumped" in given[-1].reason and x - rig.pose.x == pytest.approx(0.12, abs=0.02)
    assert all(-0.1 <= g.command.v_mps <= 0.0 and g.command.w_radps == 0.0 for g in given)
    assert rig.step((BumperEvent(Bumper.CENTER, False),)).state is Drives.IDLE


def test_wheels_that_do_not_move_it_mean_stuck() -> None:
    rig = Rig()
    rig.go(*GOAL)
    given = rig.until(Drives.BACKING, most_s=6.0, moves=False)
    assert given[-1].events[0].kind == "stuck"
    assert "odometry" in rig.until(Drives.FAILED)[-1].reason


def test_wheels_that_spin_while_its_place_stays_mean_stuck() -> None:
    rig = Rig()
    assert rig.go(*GOAL) == ""
    slipped, given = 0.0, Driven(Drives.DRIVING)
    while given.state is Drives.DRIVING and rig.now_s < 8.0:
        odometry = Pose2(slipped, 0.0)
        plain = observe(rig.now_s, rig.pose, rig.map, rig.count)
        seen = replace(plain, odometry=Odometry(rig.now_s, odometry), map_from_odom=START.compose(odometry.inverse()))
        rig.driver.sense(seen)
        given = rig.driver.step(seen)
        slipped, rig.now_s = slipped + given.command.v_mps * LOOP_S, rig.now_s + LOOP_S
    assert slipped > 0.5 and given.state is Drives.BACKING
    assert given.events[0].kind == "stuck" and 2.5 < rig.now_s < 5.0


def test_who_is_stuck_with_something_behind_him_goes_ahead() -> None:
    rig = Rig()
    rig.go(*GOAL)
    rig.until(Drives.BACKING, most_s=6.0, moves=False)
    told = [rig.step(moves=False).command.v_mps]
    while told[-1] < 0.0:
        told.append(rig.step(moves=False).command.v_mps)
    assert 12 <= len(told) <= 16 and told[-1] == pytest.approx(0.08)
    x = rig.pose.x
    rig.until(Drives.FAILED)
    assert rig.pose.x - x == pytest.approx(0.12, abs=0.02)


def test_who_is_stuck_between_two_things_gives_the_goal_up() -> None:
    rig = Rig()
    rig.go(*GOAL)
    rig.until(Drives.BACKING, most_s=6.0, moves=False)
    cells = HALL.cells.copy()
    cells[HALL.cell_of(START.x + TOUCHING_M - 0.02, START.y)] = 100
    rig.map, rig.count = GridMap(cells, 0.05, HALL.origin), 1
    given = rig.until(Drives.FAILED, moves=False)
    assert len(given) <= 16 and all(g.command.v_mps <= 0.0 for g in given)


def test_who_bumped_into_something_does_not_go_ahead_again() -> None:
    rig = Rig()
    rig.go(*GOAL)
    rig.step((BumperEvent(Bumper.CENTER, True),))
    assert all(g.command.v_mps <= 0.0 for g in rig.until(Drives.FAILED, moves=False))


def test_turning_in_place_is_not_stuck() -> None:
    rig = Rig()
    rig.driver.sense(observe(0.0, rig.pose, rig.map))
    rig.driver.turn(rig.pose, 3.0)
    assert rig.until(Drives.ARRIVED, most_s=8.0)[-1].state is Drives.ARRIVED
    assert rig.pose.yaw_rad == pytest.approx(3.0, abs=0.07)


def test_a_way_that_closes_is_planned_anew_or_given_up() -> None:
    rig = Rig()
    rig.go(*GOAL)
    for _ in range(10):
        rig.step()
    cells = HALL.cells.copy()
    cells[10:30, 50:54] = 100
    rig.map, rig.count = GridMap(cells, 0.05, HALL.origin), 1
    assert rig.step().state is Drives.DRIVING and len(rig.driver.path) > 2
    shut = cells.copy()
    shut[:, 50:54] = 100
    rig.map, rig.count = GridMap(shut, 0.05, HALL.origin), 2
    driven = rig.step()
    assert driven.state is Drives.FAILED and "cannot get there" in driven.reason and driven.command.v_mps == 0.0


def test_something_right_ahead_stops_it_and_ends_the_goal() -> None:
    rig = Rig()
    rig.go(*GOAL)
    for _ in range(10):
        rig.step()
    given = []
    for _ in range(30):
        low = LowView(rig.now_s, np.array([[TOUCHING_M - 0.01, 0.0]]))
        seen = replace(observe(rig.now_s, rig.pose, HALL), low=low)
        rig.driver.sense(seen)
        given.append(rig.driver.step(seen))
        rig.now_s += LOOP_S
    failed = [g for g in given if g.state is Drives.FAILED]
    assert len(failed) == 1 and "ahead" in failed[0].reason
    assert all(g.command.v_mps == 0.0 for g in given[3:])


def test_a_jump_of_the_pose_voids_the_way() -> None:
    rig = Rig()
    rig.go(*GOAL)
    rig.step()
    seen = observe(rig.now_s, Pose2(2.0, 1.25), HALL, jumped=True)
    rig.driver.sense(seen)
    driven = rig.driver.step(seen)
    assert driven.state is Drives.IDLE and driven.command.v_mps == 0.0 and len(rig.driver.path) == 0


def test_without_map_or_pose_it_stands() -> None:
    driver = Driver(ExploreParams())
    with pytest.raises(RuntimeError, match="map"):
        driver.field(START)
    assert driver.sense(observe(0.0, START, None)) is None
    assert driver.step(observe(0.0, START, None)).state is Drives.IDLE
    assert np.array_equal(driver.path, np.zeros((0, 2)))
