"""Patience and recovery behaviours of move_base around the driver."""

from __future__ import annotations

import math
from typing import List, Optional, Tuple

import numpy as np
import pytest

from python.exploration.explorer_samples import moved, observe
from python.navigation.map_samples import drawn
from yarm.exploration.driver import Driven, Driver, DriverSettings, Drives
from yarm.exploration.model import LOOP_S
from yarm.exploration.move_base import MoveBase, Patience
from yarm.exploration.params import ExploreParams
from yarm.geometry import Pose2, wrap_angle
from yarm.geometry.scans import Scan
from yarm.navigation.grid_map import GridMap

OPEN = drawn("########\n#......#\n#......#\n########", scale=10)
SHUT = drawn("########\n#..#...#\n#..#...#\n########", scale=10)
START = Pose2(1.0, 1.0)
FAR = Pose2(3.0, 1.0)
LITTLE = Patience(planner_patience=2.0)


class Bench:
    """A robot that does what it is told on a map."""

    def __init__(self, patience: Patience = LITTLE, blocked_s: float = 1.5) -> None:
        self.driver = Driver(
            ExploreParams(), DriverSettings(unknown_passable=True, cautious=False, blocked_s=blocked_s)
        )
        self.base = MoveBase(self.driver, patience)
        self.pose, self.now_s, self.count = START, 0.0, 0

    def run(self, grid_map: GridMap, seconds: float, scan: Optional[Scan] = None) -> List[Tuple[float, Driven]]:
        """Until the goal has ended or the time is over; every map is a new one."""
        self.count += 1
        steps = []
        for _ in range(round(seconds / LOOP_S)):
            seen = observe(self.now_s, self.pose, grid_map, self.count, scan=scan)
            self.driver.sense(seen)
            driven = self.base.step(seen)
            steps.append((self.now_s, driven))
            self.pose, self.now_s = moved(self.pose, driven.command), self.now_s + LOOP_S
            if driven.state in (Drives.ARRIVED, Drives.FAILED):
                break
        return steps


def recoveries(steps: List[Tuple[float, Driven]]) -> List[Tuple[float, str]]:
    return [
        (now_s, str(dict(event.details)["behaviour"]))
        for now_s, driven in steps
        for event in driven.events
        if event.kind == "recovery"
    ]


def turned(steps: List[Tuple[float, Driven]]) -> float:
    return sum(driven.command.w_radps * LOOP_S for _, driven in steps)


def test_a_goal_with_a_way_is_driven_to() -> None:
    bench = Bench()
    bench.base.send(FAR)
    steps = bench.run(OPEN, 30.0)
    assert steps[-1][1].state is Drives.ARRIVED and bench.pose.distance(FAR) < 0.1
    assert recoveries(steps) == []
    assert bench.run(OPEN, 1.0)[-1][1].state is Drives.IDLE, "an ended goal is not driven to again"


def test_without_a_way_it_waits_clears_and_turns_twice_before_it_aborts() -> None:
    bench = Bench()
    bench.base.send(FAR)
    steps = bench.run(SHUT, 60.0)
    assert steps[-1][1].state is Drives.FAILED and "cannot get there" in steps[-1][1].reason
    found = recoveries(steps)
    assert [name for _, name in found] == ["clear", "turn", "clear", "turn"]
    assert found[0][0] == pytest.approx(2.0, abs=0.15), "the planner's patience comes first"
    assert turned(steps) == pytest.approx(2 * 2.0 * math.pi, abs=0.5)
    whole_turn_s = 2.0 * math.pi / 1.2
    assert steps[-1][0] > 5 * 2.0 + 2 * whole_turn_s


def test_a_way_that_opens_meanwhile_is_driven() -> None:
    bench = Bench()
    bench.base.send(FAR)
    bench.run(SHUT, 5.0)
    steps = bench.run(OPEN, 40.0)
    assert steps[-1][1].state is Drives.ARRIVED


def test_a_goal_that_is_sent_during_a_turn_waits_for_its_end() -> None:
    bench = Bench()
    bench.base.send(FAR)
    steps = bench.run(SHUT, 5.0)
    assert recoveries(steps)[-1][1] == "turn"
    begun = turned(steps)
    bench.base.send(Pose2(1.0, 1.25))
    steps = bench.run(SHUT, 30.0)
    assert steps[-1][1].state is Drives.ARRIVED
    first_drive = next(i for i, (_, driven) in enumerate(steps) if driven.command.v_mps > 0.0)
    assert begun + turned(steps[:first_drive]) > 2.0 * math.pi - 0.3


def test_what_stands_ahead_although_the_map_is_free_brings_a_recovery_at_once() -> None:
    bench = Bench(blocked_s=1.0)
    bench.base.send(FAR)
    wall = Scan(0.0, np.full(61, 0.19, np.float32), -0.5, 1.0 / 60.0, 0.05, 10.0)
    steps = bench.run(OPEN, 3.0, scan=wall)
    found = recoveries(steps)
    assert found and found[0][1] == "clear" and found[0][0] < 2.0


def test_cancel_ends_goal_and_turn() -> None:
    bench = Bench()
    bench.base.send(FAR)
    bench.run(SHUT, 5.0)
    bench.base.cancel()
    steps = bench.run(OPEN, 2.0)
    assert all(driven.state is Drives.IDLE and driven.command.w_radps == 0.0 for _, driven in steps)


def test_a_new_goal_gets_the_whole_patience_again() -> None:
    bench = Bench()
    bench.base.send(FAR)
    bench.run(SHUT, 3.0)
    bench.base.send(Pose2(3.2, 1.2))
    steps = bench.run(SHUT, 3.0)
    found = recoveries(steps)
    assert [name for _, name in found] == ["clear"] and found[0][0] == pytest.approx(5.0, abs=0.2)
    assert wrap_angle(bench.pose.yaw_rad) == pytest.approx(0.0, abs=1e-6)
