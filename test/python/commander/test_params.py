"""The Commander's parameters reach the planner and the task queue."""

from __future__ import annotations

import dataclasses

from yarm.commander.params import CommanderParams
from yarm.planning.model.params import PlannerParams


def test_the_commander_hands_on_what_it_was_given_and_keeps_the_other_defaults() -> None:
    assert CommanderParams().planner_params == PlannerParams()
    given = CommanderParams(particles=77, particles_first=40, turns_deg=(0.0, 45.0)).planner_params
    assert given == dataclasses.replace(PlannerParams(), particles=77, particles_first=40, turns_deg=(0.0, 45.0))
