"""What is reported of a plan: how many particles were there, and how many it needed."""

from __future__ import annotations

import numpy as np

from python.planning.samples import block, request, robot, walls
from yarm.commander.events import ShowPlan
from yarm.geometry import GridSpec
from yarm.planning.fleet.yarm_planner import YarmPlanner
from yarm.planning.model.types import Goal
from yarm.ros.commander.reports import plan_report

SPEC = GridSpec((30, 24, 4), (0.0, 0.0, 0.0), (3.0, 2.4, 0.4))


def test_a_straight_way_needs_no_particles_and_one_around_a_wall_does():
    needed = []
    for occupied in (np.zeros(SPEC.shape, dtype=bool), walls(SPEC, [(14, 16, 0, 18)])):
        ask = request(SPEC, occupied, [robot("a", (4, 6), block(2, 2))], [Goal("t", "Target", (25, 6))])
        plan = YarmPlanner().plan(ask, np.random.default_rng(0))
        report = plan_report(ShowPlan(ask, plan), "yarm", 1.0)
        assert (report.status, report.particles) == ("SOLVED", len(plan.graph.particles))
        needed.append(report.particles_needed)
    assert needed[0] == 0
    assert 0 < needed[1] <= report.particles
