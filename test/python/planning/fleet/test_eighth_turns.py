"""Eighth turns by the masks a robot has at each heading: no way goes round for ever, no room is lost at a border."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Dict, List, Tuple

import numpy as np
import pytest

from yarm.geometry import GridSpec
from yarm.planning.fleet.yarm_planner import YarmPlanner
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import Goal, GoalKind, PlanRequest, PlanStatus, Robot, Waypoint, without_robots
from yarm.planning.verification.checker import check_step
from yarm.robots.ankurbot import HAND_BEAMS, HAND_DISCS
from yarm.robots.shapes import PieceShape, RobotShape

RECORDED = Path(__file__).parents[3] / "data" / "planning" / "loaded_robots_at_a_bin.npz"
"""The map of 2m1ma_bin, seed 11, with both pieces picked up, and where the robots stood."""
SPEC = GridSpec()
EIGHTHS = PlannerParams(turns_deg=(0.0, 90.0, -90.0, 45.0, -45.0))
START_DEG = 10.0
HAND = RobotShape(HAND_DISCS, HAND_BEAMS)
LOADED = HAND.with_load(PieceShape(math.hypot(0.075, 0.03), 0.04))


def standing(name: str, at: Waypoint, shape: RobotShape, known: bool) -> Robot:
    mask_at = partial(shape.mask, SPEC)
    return Robot(name, at.column, at.yaw_rad, mask_at(at.yaw_rad), mask_at=mask_at if known else None)


def recorded(at: Dict[str, Waypoint], known: bool) -> PlanRequest:
    data = np.load(RECORDED)
    occupied = np.unpackbits(data["occupied"])[: math.prod(SPEC.shape)].reshape(SPEC.shape).astype(bool)
    robots = [standing(name, place, LOADED, known) for name, place in at.items()]
    goal = Goal("bin_1", GoalKind.BIN, tuple(data["bin"].tolist()))
    return PlanRequest(SPEC, without_robots(SPEC, occupied, robots), tuple(robots), {"bin_1": goal}, {"one": "bin_1"})


def ridden(known: bool, steps: int, params: PlannerParams = EIGHTHS) -> Tuple[List[Waypoint], bool]:
    """Where the first robot goes step by step, each held against the checker, and whether it arrives."""
    data = np.load(RECORDED)
    places = zip(data["columns"].tolist(), data["yaws_rad"].tolist())
    at = {name: Waypoint(tuple(column), yaw) for name, (column, yaw) in zip(("one", "other"), places)}
    planner, rng, way = YarmPlanner(params), np.random.default_rng(11), [at["one"]]
    for _ in range(steps):
        ask = recorded(at, known)
        plan = planner.plan(ask, rng)
        verdict = check_step(ask, plan)
        assert verdict.safe, verdict.reason
        at.update({name: entry.step for name, entry in plan.robots.items() if entry.step is not None})
        way.append(at["one"])
        if at["one"].column == ask.goals["bin_1"].column:
            return way, True
    return way, False


def test_a_loaded_robot_goes_to_the_bin_without_coming_to_a_place_twice() -> None:
    way, arrived = ridden(True, 12)
    assert arrived
    assert len({(w.column, round(w.yaw_rad, 3)) for w in way}) == len(way)


def test_a_mask_that_is_turned_outwards_goes_round_for_ever_there() -> None:
    """Why the masks are given: from one heading there is a way one way round, from the next one only the other way."""
    way, arrived = ridden(False, 12, replace(EIGHTHS, particles_first=EIGHTHS.particles))
    assert not arrived
    assert len({(w.column, round(w.yaw_rad, 3)) for w in way}) < len(way)


@pytest.mark.parametrize("known", [True, False])
def test_a_home_at_the_border_is_refused_only_when_the_robot_would_reach_out(known: bool) -> None:
    yaw = math.radians(START_DEG + 45.0)
    mask = HAND.mask(SPEC, yaw)
    column = (-int(mask.cells[:, 0].min()), 25)
    robot = standing("one", Waypoint((30, 25), math.radians(START_DEG)), HAND, known)

    def plan(x: int) -> Tuple[PlanStatus, str]:
        goal = Goal("home", GoalKind.HOME, (x, column[1]), yaw_rad=yaw)
        ask = PlanRequest(SPEC, np.zeros(SPEC.shape, bool), (robot,), {"home": goal}, {"one": "home"})
        found = YarmPlanner(EIGHTHS).plan(ask, np.random.default_rng(0))
        assert check_step(ask, found).safe
        return found.status, found.reason

    assert plan(column[0])[0] is (PlanStatus.SOLVED if known else PlanStatus.INVALID_GOAL)
    status, reason = plan(column[0] - 1)
    assert status is PlanStatus.INVALID_GOAL
    assert f"reach out of the mapped volume at {START_DEG + 45:.0f} deg" in reason
