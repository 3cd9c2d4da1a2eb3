"""Plans made in a thread of their own: who waits for them, and who does not."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from yarm.planning.model.types import FleetPlan, PlanStatus
from yarm.ros.commander.background import OneAtATime, in_background

PLAN = FleetPlan(PlanStatus.SOLVED, "", {})
LIMIT_S = 60.0


class Planner:
    """Says what it was asked for; a plan lasts until it is let go."""

    def __init__(self):
        self.calls = []
        self.began, self.goes_on = threading.Event(), threading.Event()

    def plan(self, request, rng):
        """See ``FleetPlanner``."""
        self.calls.append("plan")
        self.began.set()
        assert self.goes_on.wait(LIMIT_S)
        return PLAN

    def reset(self):
        """See ``FleetPlanner``."""
        self.calls.append("reset")


def answered(answer):
    """What it says in the end."""
    for _ in range(int(LIMIT_S / 0.01)):
        if answer() is not None:
            return answer()
        threading.Event().wait(0.01)
    raise AssertionError("no plan")


def test_nobody_waits_for_a_plan_to_forget_what_was_and_the_next_one_begins_anew():
    planner = Planner()
    shared = OneAtATime(planner)
    answer = in_background(lambda: shared.plan(None, np.random.default_rng(3)))
    assert planner.began.wait(LIMIT_S)
    assert answer() is None
    shared.reset()
    assert planner.calls == ["plan"]
    planner.goes_on.set()
    assert answered(answer) is PLAN
    for _ in range(2):
        shared.plan(None, np.random.default_rng(3))
    assert planner.calls == ["plan", "reset", "plan", "plan"]


def test_a_plan_that_is_there_within_the_patience_is_the_answer_at_once():
    assert in_background(lambda: PLAN, patience_s=LIMIT_S)() is PLAN


def test_what_a_planner_raises_is_raised_where_its_plan_is_asked_for():
    def fails():
        raise RuntimeError("no thought")

    answer = in_background(fails, patience_s=LIMIT_S)
    with pytest.raises(RuntimeError, match="no thought"):
        answer()
