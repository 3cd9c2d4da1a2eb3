"""Driving to goals in a kinematic room: goals reached, everything that can be wrong named, and the robot standing."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from python.navigation.driving import Drive, map_of, outline
from support.rooms import block
from yarm.geometry import Pose2, wrap_angle
from yarm.navigation.approach import MOST
from yarm.navigation.bodies import with_bodies
from yarm.navigation.grid_map import GridMap
from yarm.navigation.move_base import MoveBase, Observation, Status, Step
from yarm.navigation.path_check import check_path
from yarm.sim.kinematic.world import KinematicWorld

SCREEN = block("screen", 0.9, 0.0, (0.2, 1.6, 0.6))
TIGHT = {"xy_goal_tolerance": 0.05, "yaw_goal_tolerance": 0.04, "controller_frequency": 10.0}
PERSON = block("person", 0.9, 0.0, (0.25, 0.35, 0.6))


def stands(step: Step) -> bool:
    return step.drive is not None and step.drive.v_mps == 0.0 and step.drive.w_radps == 0.0


class TestGoals:
    def test_a_goal_is_reached_within_the_platforms_tolerance(self) -> None:
        drive = Drive()
        drive.go(1.2, -1.0, math.pi / 2)
        assert drive.run().status is Status.SUCCEEDED and stands(drive.steps[-1])
        assert drive.here.distance(Pose2(1.2, -1.0)) <= 0.15
        assert abs(wrap_angle(drive.here.yaw_rad - math.pi / 2)) <= 0.3
        assert drive.base.goal is None

    def test_a_tighter_tolerance_is_kept(self) -> None:
        drive = Drive(xy_goal_tolerance=0.04, yaw_goal_tolerance=0.05, controller_frequency=10.0)
        drive.go(-1.2, 0.9, -2.0)
        assert drive.run().status is Status.SUCCEEDED
        assert drive.here.distance(Pose2(-1.2, 0.9)) <= 0.04 and abs(wrap_angle(drive.here.yaw_rad + 2.0)) <= 0.05

    def test_a_known_screen_is_driven_round_without_a_touch(self) -> None:
        drive = Drive(SCREEN)
        drive.go(1.6, 0.0)
        assert drive.run().status is Status.SUCCEEDED and not drive.world.touches
        assert max(abs(step.drive.v_mps) for step in drive.steps if step.drive) <= 0.3

    def test_a_new_goal_while_driving_takes_over(self) -> None:
        drive = Drive()
        drive.go(1.5, 0.0)
        drive.run(until=lambda _: drive.here.x > 0.4)
        drive.go(-1.0, 1.0, 1.0)
        assert drive.run().status is Status.SUCCEEDED and drive.here.distance(Pose2(-1.0, 1.0)) <= 0.15

    def test_a_cancelled_goal_is_dropped(self) -> None:
        drive = Drive()
        drive.go(1.5, 0.0)
        drive.run(until=lambda _: drive.here.x > 0.2)
        drive.base.cancel()
        assert drive.step() == Step() and drive.base.goal is None and len(drive.base.path) == 0

    def test_idle_says_nothing(self) -> None:
        assert Drive().step() == Step()

    @pytest.mark.parametrize("bad", [(math.nan, 0.0, 0.0), (0.0, math.inf, 0.0), (0.0, 0.0, math.nan)])
    def test_numbers_that_are_none_are_refused(self, bad: tuple) -> None:
        with pytest.raises(ValueError, match="finite"):
            MoveBase().go(Pose2(*bad), 0.0)


class TestBesideAWall:
    """Goals so near to a wall that the robot is stopped before it just short of them."""

    @pytest.mark.parametrize("gap_m", [0.258, 0.262])
    @pytest.mark.parametrize("aside_m", [0.9, 1.6])
    def test_a_robot_stopped_within_the_tolerance_turns_to_the_goals_heading(
        self, gap_m: float, aside_m: float
    ) -> None:
        drive = Drive(**TIGHT)
        for y, yaw_rad in ((0.8, 2.3), (0.4, -2.3)):
            drive.go(0.9, y - aside_m)
            assert drive.run(40.0).status is Status.SUCCEEDED
            goal = Pose2(2.0 - gap_m, y, yaw_rad)
            drive.go(goal.x, goal.y, goal.yaw_rad)
            step = drive.run(40.0)
            assert step.status is Status.SUCCEEDED, f"{goal}: {step.reason}"
            assert drive.believed.distance(goal) <= 0.05 and abs(wrap_angle(drive.here.yaw_rad - yaw_rad)) <= 0.05
        assert not drive.world.touches and not any("recovers" in event for event in drive.events)


class TestLastPiece:
    """The believed place swings while the robot turns, as in a map of cells."""

    @pytest.mark.parametrize("seed", range(3))
    def test_goals_are_reached_within_less_than_the_swing(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        drive = Drive(swing_m=0.06, **TIGHT)
        driven = 0
        for _ in range(8):
            x, y, yaw_rad = rng.uniform((-1.4, -1.4, -math.pi), (1.4, 1.4, math.pi))
            goal = Pose2(x, y, yaw_rad)
            drive.go(goal.x, goal.y, goal.yaw_rad)
            step = drive.run(60.0)
            assert step.status is Status.SUCCEEDED, step.reason
            assert drive.believed.distance(goal) <= 0.05
            assert abs(wrap_angle(drive.believed.yaw_rad - goal.yaw_rad)) <= 0.04
            driven += any("drives that by odometry" in event for event in drive.events)
            drive.events.clear()
        assert driven >= 2

    def test_without_odometry_it_is_given_up_with_what_is_missing(self) -> None:
        drive = Drive(swing_m=0.25, **TIGHT)
        observe = drive.observe
        drive.observe = lambda: replace(observe(), odometry=None)
        drive.go(1.2, 0.0, -2.0)
        step = drive.run(60.0)
        assert step.status is Status.ABORTED and stands(step)
        assert "the way ended" in step.reason and "the tolerance is 0.05 m" in step.reason

    def test_a_place_that_never_agrees_is_given_up_after_three_attempts(self) -> None:
        drive = Drive(**TIGHT)
        drive.go(1.0, 0.0, 2.0)
        exact, facing, off_m = drive.observe, False, 0.0

        def observe() -> Observation:
            """Each time the robot faces the goal's heading there, its place seems another 0.1 m to the side."""
            nonlocal facing, off_m
            seen = exact()
            assert seen.pose is not None
            before, facing = facing, seen.pose.x > 0.8 and abs(seen.pose.yaw_rad - 2.0) < 0.1
            off_m += 0.1 if facing and not before else 0.0
            pose = Pose2(seen.pose.x, seen.pose.y + off_m, seen.pose.yaw_rad) if facing else seen.pose
            return replace(seen, pose=pose)

        drive.observe = observe
        step = drive.run(120.0)
        assert step.status is Status.ABORTED and "the way ended" in step.reason
        assert sum("drives that by odometry" in event for event in drive.events) == MOST

    def test_a_goal_whose_way_must_end_beside_it_is_given_up_at_once(self) -> None:
        drive = Drive(block("box", 1.0, 0.0, (0.4, 0.4, 0.6)), xy_goal_tolerance=0.02, controller_frequency=10.0)
        drive.go(0.598, 0.024)
        step = drive.run(60.0)
        assert step.reason == "the way ended 0.03 m from the goal, the tolerance is 0.02 m"
        assert not any("drives that by odometry" in event for event in drive.events)


class TestNoWay:
    def test_a_goal_inside_a_known_body_is_named_at_once(self) -> None:
        drive = Drive(SCREEN)
        drive.go(0.9, 0.1)
        step = drive.run(1.0)
        assert step.status is Status.ABORTED and "(0.90, 0.10) lies inside an obstacle" in step.reason and stands(step)

    def test_a_goal_too_near_to_a_wall_is_named(self) -> None:
        drive = Drive()
        drive.go(1.85, 0.0)
        assert "the disc needs 0.2 m" in drive.run(1.0).reason

    def test_a_goal_outside_the_map_is_named(self) -> None:
        drive = Drive()
        drive.go(7.0, 0.0)
        assert "outside the map" in drive.run(1.0).reason

    def test_an_enclosed_start_is_named(self) -> None:
        fence = [
            block("east", 0.35, 0.0, (0.1, 0.8, 0.6)), block("west", -0.35, 0.0, (0.1, 0.8, 0.6)),
            block("north", 0.0, 0.35, (0.8, 0.1, 0.6)), block("south", 0.0, -0.35, (0.8, 0.1, 0.6)),
        ]  # fmt: skip
        drive = Drive(*fence)
        drive.go(1.5, 1.5)
        step = drive.run(1.0)
        assert step.status is Status.ABORTED and ("enclosed" in step.reason or "no way" in step.reason)
        assert drive.here == Pose2(0.0, 0.0)

    def test_a_goal_that_somebody_stands_on_is_given_up_after_both_recoveries(self) -> None:
        drive = Drive(PERSON, known=[])
        drive.go(0.9, 0.0)
        step = drive.run(200.0)
        assert step.status is Status.ABORTED and not drive.world.touches
        assert "forgot what was seen, turned once before" in step.reason, step.reason
        assert [event.split(":")[0] for event in drive.events if "recovers" in event] == [
            "recovers (forgot what was seen)", "recovers (turned once)"
        ]  # fmt: skip

    def test_one_that_has_driven_backs_off_along_the_way_it_came_and_then_gives_up(self) -> None:
        drive = Drive()
        drive.go(1.4, 0.6)
        drive.run(until=lambda _: drive.here.x > 0.55)
        drive.put(block("person", 1.4, 0.6, (0.35, 0.35, 0.6)))
        drive.run(60.0, until=lambda _: any("backed off" in event for event in drive.events))
        stuck = drive.here
        drive.run(20.0, until=lambda _: drive.here.distance(stuck) > 0.3)
        assert drive.steps[-1].drive is not None and drive.steps[-1].drive.v_mps < 0.0
        assert math.hypot(drive.here.x, drive.here.y) < math.hypot(stuck.x, stuck.y)
        step = drive.run(200.0)
        assert step.status is Status.ABORTED and not drive.world.touches
        assert "forgot what was seen, backed off, turned once before" in step.reason, step.reason

    def test_who_steps_in_again_each_time_it_comes_back_is_given_up_on(self) -> None:
        drive = Drive()
        drive.go(1.4, 0.0)
        person, there = block("person", 1.4, 0.0, (0.35, 0.35, 0.6)), False

        def step_in(_: Step) -> bool:
            nonlocal there
            wanted = drive.here.x > (0.45 if there else 0.6)
            if wanted != there:
                there = wanted
                drive.put(*([person] if there else []))
            return False

        step = drive.run(200.0, until=step_in)
        assert step.status is Status.ABORTED
        assert len([event for event in drive.events if event.startswith("recovers")]) == 3, drive.events
        assert "forgot what was seen, backed off, turned once before" in step.reason, step.reason

    def test_it_does_not_back_into_what_the_map_has_behind_it(self) -> None:
        drive = Drive()
        drive.go(1.4, 0.6)
        drive.run(until=lambda _: drive.here.x > 0.55)
        behind = block("behind", drive.here.x - 0.5, drive.here.y - 0.25, (0.2, 0.6, 0.6))
        drive.put(block("person", 1.4, 0.6, (0.35, 0.35, 0.6)), behind)
        drive.map, drive.map_count = with_bodies(map_of(drive.arena), [outline(behind)]), 2
        step = drive.run(200.0)
        assert step.status is Status.ABORTED and not drive.world.touches
        assert "backed off" in step.reason, step.reason

    def test_recoveries_come_as_they_are_listed(self) -> None:
        drive = Drive(PERSON, known=[], recovery_behaviors=("turn", "clear"))
        drive.go(0.9, 0.0)
        assert "turned once, forgot what was seen before" in drive.run(200.0).reason

    def test_without_recoveries_it_is_given_up_when_patience_ends(self) -> None:
        drive = Drive(PERSON, known=[], recovery_behavior_enabled=False)
        drive.go(0.9, 0.0)
        drive.run(30.0)
        assert not [event for event in drive.events if "recovers" in event]


class TestSomebodyInTheWay:
    def test_who_is_not_in_the_map_is_driven_round(self) -> None:
        drive = Drive(PERSON, known=[])
        drive.go(1.6, 0.0)
        assert drive.run().status is Status.SUCCEEDED and not drive.world.touches

    def test_who_steps_into_the_way_is_driven_round(self) -> None:
        drive = Drive()
        drive.go(1.6, 0.0)
        drive.run(until=lambda _: drive.here.x > 0.1)
        drive.put(PERSON)
        assert drive.run().status is Status.SUCCEEDED and not drive.world.touches

    def test_who_has_gone_is_forgotten_when_beams_pass(self) -> None:
        drive = Drive(PERSON, known=[])
        drive.run(2.0, until=lambda _: drive.now_s > 1.0)
        assert drive.base.grid is not None and drive.base.grid.occupied[drive.base.grid.cell_of(0.775, 0.0)]
        drive.put()
        drive.run(2.0, until=lambda _: drive.now_s > 2.0)
        assert drive.base.grid.cells[drive.base.grid.cell_of(0.775, 0.0)] == 0

    def test_a_wall_across_the_room_that_goes_away_lets_it_pass_after_clearing(self) -> None:
        across = block("across", 0.9, 0.0, (0.2, 4.0, 0.6))
        drive = Drive(across, known=[])
        drive.go(1.6, 0.0)
        drive.run(40.0, until=lambda _: any("no way" in event for event in drive.events))
        drive.put()
        assert drive.run().status is Status.SUCCEEDED


class TestSensors:
    def driving(self) -> Drive:
        drive = Drive()
        drive.go(1.6, 0.0)
        drive.run(until=lambda step: step.drive is not None and step.drive.v_mps > 0.2)
        return drive

    def test_a_silent_scan_stops_it_within_half_a_second(self) -> None:
        drive = self.driving()
        last_s, drive.scans = drive.now_s - drive.params.period_s, False
        drive.run(1.0, until=stands)
        assert drive.now_s - drive.params.period_s - last_s <= 0.5
        step = drive.run(20.0)
        assert step.status is Status.ABORTED and "newest scan is" in step.reason and "waited 5 s" in step.reason

    def test_a_scan_that_comes_back_lets_it_drive_on(self) -> None:
        drive = self.driving()
        drive.scans = False
        drive.run(2.0, until=stands)
        drive.scans = True
        assert drive.run().status is Status.SUCCEEDED

    def test_a_place_that_is_not_known_stops_it_and_is_named(self) -> None:
        drive = self.driving()
        drive.placed = False
        assert stands(drive.step())
        assert "place in the map is not known: test" in drive.run(20.0).reason

    def test_a_missing_map_is_named(self) -> None:
        drive = Drive()
        drive.map = None
        drive.go(1.0, 0.0)
        assert stands(drive.step()) and "no map" in drive.run(20.0).reason

    def test_a_map_of_another_size_under_way_is_taken(self) -> None:
        drive = self.driving()
        grid = drive.map
        assert grid is not None
        wider = np.pad(grid.cells, 7, constant_values=-1)
        drive.map = GridMap(wider, grid.resolution_m, grid.origin.compose(Pose2(-0.35, -0.35)))
        drive.map_count += 1
        assert drive.run().status is Status.SUCCEEDED and drive.here.distance(Pose2(1.6, 0.0)) <= 0.15

    def test_a_map_that_takes_the_way_leads_round(self) -> None:
        drive = self.driving()
        drive.put(SCREEN)
        drive.map = map_of(drive.world.arena)
        drive.map_count += 1
        assert drive.run().status is Status.SUCCEEDED and not drive.world.touches

    def test_time_that_goes_back_forgets_everything(self) -> None:
        drive = self.driving()
        drive.base.forget()
        assert drive.base.goal is None and drive.base.grid is None and drive.step().drive is None


class TestBumps:
    def test_what_the_scan_cannot_see_is_met_once_and_driven_round(self) -> None:
        drive = Drive(block("brick", 0.9, 0.0, (0.15, 0.5, 0.1), "low"), known=[])
        drive.go(1.6, 0.0)
        assert drive.run(200.0).status is Status.SUCCEEDED
        assert 1 <= len(drive.world.touches) <= 4 and any("bumped, center" in event for event in drive.events)


class TestPlans:
    def test_a_plan_while_driving_changes_nothing(self) -> None:
        drive = Drive(SCREEN)
        drive.go(1.6, 0.0)
        drive.run(until=lambda _: drive.now_s > 3.0)
        before = drive.base.path.copy()
        way = drive.base.make_plan(Pose2(-1.5, -1.5), Pose2(1.5, 1.5))
        assert not way.reason and np.array_equal(drive.base.path, before)
        assert drive.map is not None and check_path(drive.map, way.path, 0.2).clear
        assert tuple(way.path[0]) == (-1.5, -1.5) and tuple(way.path[-1]) == (1.5, 1.5)

    def test_clearing_keeps_who_stands_where_the_scan_is_blind(self) -> None:
        drive = Drive(PERSON, known=[])
        drive.step()
        drive.world = KinematicWorld(replace(drive.arena, start=Pose2(0.45, 0.0)), 4)
        drive.step()
        drive.base.clear_costmaps()
        assert drive.base.grid is not None and drive.base.grid.occupied[drive.base.grid.cell_of(0.775, 0.0)]
        drive.world = KinematicWorld(drive.arena, 4)
        drive.step()
        drive.base.clear_costmaps()
        assert not drive.base.grid.occupied[drive.base.grid.cell_of(0.775, 0.0)]

    def test_a_place_that_cannot_be_reached_has_no_plan_and_a_reason(self) -> None:
        drive = Drive(SCREEN)
        drive.step()
        assert len(drive.base.make_plan(drive.here, Pose2(0.9, 0.0)).path) == 0
        assert "inside an obstacle" in drive.base.make_plan(drive.here, Pose2(0.9, 0.0)).reason
        assert MoveBase().make_plan(drive.here, drive.here).reason == "there is no map yet"

    def test_a_tolerance_moves_the_end_beside_the_obstacle(self) -> None:
        drive = Drive(SCREEN)
        drive.step()
        end = drive.base.make_plan(drive.here, Pose2(0.9, 0.0), 0.5).path[-1]
        assert 0.2 < math.hypot(end[0] - 0.9, end[1]) <= 0.5

    def test_requests_clear_what_was_seen_and_what_is_not_known(self) -> None:
        drive = Drive(PERSON, known=[])
        drive.step()
        assert drive.base.grid is not None and drive.map is not None
        assert (drive.base.grid.occupied & ~drive.map.occupied).any()
        drive.base.clear_costmaps()
        assert not (drive.base.grid.occupied & ~drive.map.occupied).any()
        corner = Pose2(-1.9, -1.9)
        assert drive.base.grid.unknown.any()
        drive.base.clear_unknown_space(corner)
        assert not drive.base.grid.unknown[0, 0] and drive.base.grid.unknown[-1, -1]


def test_a_turn_ends_although_the_place_is_lost_meanwhile() -> None:
    drive = Drive(PERSON, known=[], sensor_patience=2.0)
    drive.go(0.9, 0.0)
    drive.run(60.0, until=lambda _: any("turned once" in event for event in drive.events))
    drive.step()
    drive.placed = False
    assert drive.run(10.0).status is Status.ABORTED and stands(drive.steps[-1])


def test_observations_without_anything_move_nothing() -> None:
    base = MoveBase()
    base.go(Pose2(1.0, 0.0), 0.0)
    first = base.step(Observation(0.0))
    assert stands(first) and first.status is Status.ACTIVE
    assert replace(first, events=()) == base.step(Observation(0.2))
