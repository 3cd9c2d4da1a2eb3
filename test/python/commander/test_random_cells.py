"""Missions in random cells, without physics: all that can be reached is reached, the rest refused, nothing touches."""

from __future__ import annotations

import pytest

from python.commander.random_mission import RandomMission, faults_of
from yarm.sim.scenes.random_cell import random_cell

CELLS = (("slips", 1), ("unregistered", 3), ("unreachable", 5), ("crowded", 6))


@pytest.mark.parametrize(("kind", "seed"), CELLS)
def test_a_random_cell_ends_well(kind: str, seed: int) -> None:
    assert faults_of(kind, seed) == []


def test_a_goal_that_is_left_without_a_reason_is_a_fault() -> None:
    mission = RandomMission(random_cell("plain", 0))
    name = sorted(mission._there())[0]
    for robot in mission.cell.robots.values():
        robot.stuck = True
    mission.cell.run_for(1.0)
    assert any(f.startswith(f"{name} was not reached") for f in mission._faults({name}))
