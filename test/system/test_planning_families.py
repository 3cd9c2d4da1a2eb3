"""A hundred seeded instances of each family, stepped to the end: ``yarm`` solves them and never touches anything."""

from __future__ import annotations

import numpy as np
import pytest

from yarm.planning.model.types import PlanStatus
from yarm.planning.registry import make_planner
from yarm.planning.scenes.instances import FAMILIES, make_instance
from yarm.planning.scenes.stepping import step_to_end
from yarm.planning.verification.bruteforce import touches

COUNT = 100
BRUTE_EVERY = 4
"""Every so many instances each step is also simulated by brute force, besides the checker's verdict."""


@pytest.mark.parametrize("family", FAMILIES)
def test_yarm_on_a_hundred_instances(family):
    planner = make_planner("yarm")
    failed = []
    for seed in range(COUNT):
        found = []

        def look(request, plan, verdict, seed=seed, found=found):
            if not verdict.safe:
                found.append(verdict.reason)
            if seed % BRUTE_EVERY == 0:
                found.extend(touches(request, plan))

        scene = make_instance(family, seed).scene
        run = step_to_end(scene, planner, np.random.default_rng(seed), observe=look, clearance=False)
        assert not found, (family, seed, found)
        if run.status is not PlanStatus.SOLVED:
            failed.append((seed, run.status.value, run.reason))
    assert len(failed) <= COUNT // 100, failed
