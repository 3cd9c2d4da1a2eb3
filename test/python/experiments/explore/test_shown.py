"""The table at the end of a run says what went well and what did not."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from yarm.experiments.explore.cost import RunCost
from yarm.experiments.explore.judge import Judge
from yarm.experiments.explore.live import LiveRecorder
from yarm.experiments.explore.measures import measure
from yarm.experiments.explore.shown import summary_table
from yarm.experiments.explore.writers import faults_of
from yarm.experiments.run.record import NodeUsage
from yarm.exploration.model import Command
from yarm.exploration.params import ExploreParams
from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap
from yarm.sim.scenes.arena import Arena, Block

EDGES = [(0.0, 2.025, 4.1, 0.05), (0.0, -2.025, 4.1, 0.05), (2.025, 0.0, 0.05, 4.1), (-2.025, 0.0, 0.05, 4.1)]
WALLS = tuple(Block(f"w{i}", "wall", Pose2(x, y), (a, b, 0.6)) for i, (x, y, a, b) in enumerate(EDGES))
ARENA = Arena("t", "custom", 0, (-2.0, -2.0), (2.0, 2.0), WALLS, Pose2(0.0, 0.0))


def record_of(known_columns):
    live = LiveRecorder(ARENA, ExploreParams(controller="nearest"), 7, lambda t_s, grid: 0.5, Pose2(0.0, 0.0))
    cells = np.full((84, 84), -1, np.int8)
    cells[:, :known_columns] = 0
    cells[0, :known_columns] = cells[-1, :known_columns] = cells[:, 0] = 100
    cells[:, -1] = 100 if known_columns == 84 else -1
    live.map(0.0, GridMap(cells, 0.05, Pose2(-2.1, -2.1)))
    for i in range(100):
        live.truth(i / 10, Pose2(0.0, 0.0))
        live.passed(i / 10, "look round", Pose2(0.0, 0.0), Command(), 3.0)
    return live.finish(9.0, True, "nothing is left", {})


def test_a_failed_run_says_what_is_wrong():
    record = record_of(40)
    measures = measure(record, Judge(ARENA))
    table = summary_table(record, measures, ["the robot fell asleep", *faults_of(measures)])
    assert "t, nearest, seed 7: FAILED; nothing is left" in table
    assert "wrong: the robot fell asleep" in table
    assert "wrong: 4" in table
    assert "95 % never" in table
    assert "look round" in table


def test_a_good_run_says_success_and_its_figures():
    record = record_of(84)
    measures = replace(measure(record, Judge(ARENA)), share=0.995, times=(10.0, 20.4, math.inf))
    table = summary_table(record, measures, faults_of(measures))
    assert "SUCCESS" in table
    assert "99.5 % of what can be mapped" in table
    assert "90 % at 10 s, 95 % at 20 s, 99 % never" in table
    assert "at rest after the end  yes" in table


def test_a_run_of_nodes_says_how_fast_it_was_and_what_each_cost():
    record = record_of(84)
    nodes = (NodeUsage("room_simulation", 0.6, 12.0, 100.0, 110.0), NodeUsage("explorer", 0.3, 6.0, 90.0, 95.0))
    table = summary_table(record, measure(record, Judge(ARENA)), [], RunCost(120.0, 80.0, nodes))
    assert "120.0 s simulated in 80.0 s (real-time factor 1.50)" in table
    assert "all nodes together need 0.60 cores to keep up with time" in table
    lines = table.splitlines()
    assert "ms a pass" in lines[-4] and lines[-1].split() == ["explorer", "30", "%", "6.0", "90", "-", "95"]
    assert "real-time factor" not in summary_table(record, measure(record, Judge(ARENA)), [])


def test_a_run_in_which_no_time_went_by_has_no_factor():
    for cost in (RunCost(0.0, 1.0, (NodeUsage("explorer", 0.3, 6.0, 90.0, 95.0),)), RunCost(0.0, 0.0)):
        assert math.isnan(cost.cores)
    assert RunCost(0.0, 2.0).real_time_factor == 0.0 and math.isnan(RunCost(0.0, 0.0).real_time_factor)
