"""Missions in random cells, without physics: all that can be reached is reached, the rest refused, nothing touches."""

from __future__ import annotations

import pytest

from python.commander.random_mission import Fault, RandomMission, run_cell
from yarm.experiments.cells.outcome import CellSpec
from yarm.sim.scenes.random_cell import random_cell

CELLS = (
    ("plain", 0),
    ("slips", 1),
    ("close", 2),
    ("unregistered", 3),
    ("unregistered", 12),
    ("unreachable", 5),
    ("crowded", 6),
    ("mixed", 26),
)
STRICKEN = ((Fault.COMMANDER, "slips", 10), (Fault.CONTROLS, "mixed", 8))


@pytest.mark.parametrize(("kind", "seed"), CELLS)
def test_a_random_cell_ends_well(kind: str, seed: int) -> None:
    assert run_cell(CellSpec(kind, seed)).faults == ()


@pytest.mark.parametrize(("fault", "kind", "seed"), STRICKEN, ids=[fault.name.lower() for fault, _, _ in STRICKEN])
def test_a_random_cell_ends_well_although_nodes_die(fault: Fault, kind: str, seed: int) -> None:
    mission = RandomMission(random_cell(kind, seed), fault)
    assert mission.run().faults == ()
    assert len(mission.struck) > 1, f"the fault happened only at {mission.struck}"
    assert all(robots for _, robots in mission.struck), "nobody was on its way"


def test_a_goal_that_is_left_without_a_reason_is_a_fault() -> None:
    mission = RandomMission(random_cell("plain", 0))
    name = sorted(mission._there())[0]
    for robot in mission.cell.robots.values():
        robot.stuck = True
    mission.cell.run_for(1.0)
    assert any(f.startswith(f"{name} was not reached") for f in mission._faults({name}, {}))
