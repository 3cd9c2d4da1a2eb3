"""A sander that dies at any moment, the one after it, and one that has not looked for a while."""

from __future__ import annotations

import json

import numpy as np
import pytest

from python.control.arm_samples import PART_TOP_M, planner, scan
from python.control.sander.test_machine import Cell
from yarm.control.sander.machine import UNWATCHED_S, SanderMachine
from yarm.control.sander.memory import ARC_STEP_M, PlanRecord, SanderMemory
from yarm.control.sander.params import SanderParams
from yarm.control.sander.states import Button, SanderState
from yarm.control.sander.steps import DoneJob
from yarm.records import plain, read


def dies(cell, coasts_s=0.5, plan=True):
    """The sander is gone, the arm goes on for a while until its controller stops it; another sander takes over."""
    memory = read(SanderMemory, json.loads(json.dumps(plain(cell.machine.memory))))
    kept = cell.machine.plan if plan else None
    record = None if kept is None else read(PlanRecord, json.loads(json.dumps(plain(PlanRecord.of(kept)))))
    if cell.motion is not None:
        cell.q = cell.motion.at(cell.now_s + coasts_s - cell.motion_s)
    cell.motion, cell.now_s = None, cell.now_s + coasts_s + 2.0
    cell.machine = SanderMachine(planner(0.04), SanderParams(), DoneJob, scan)
    cell.machine.take_up(memory, None if record is None else record.plan())


def test_a_plan_survives_being_written():
    cell = Cell()
    cell.sanding(0.01)
    plan = cell.machine.plan
    again = read(PlanRecord, json.loads(json.dumps(plain(PlanRecord.of(plan))))).plan()
    assert again.raster.length_m == plan.raster.length_m
    for arc in np.linspace(0.0, plan.raster.length_m, 7):
        assert np.array_equal(again.point_at(arc), plan.point_at(arc))
    for ours, theirs in zip(again.joints, plan.joints):
        assert np.array_equal(ours, theirs)


def test_sanding_goes_on_where_it_was():
    cell = Cell()
    cell.sanding(0.3)
    dies(cell)
    assert cell.machine.report.progress >= 0.3
    taken_up_s = cell.now_s
    assert cell.run(20.0, until=lambda: cell.machine.report.progress > 0.31), cell.machine.report
    heights = [planner().kinematics.tip(q)[2, 3] for now_s, q, _ in cell.log if now_s > taken_up_s]
    assert max(heights) > PART_TOP_M + 0.2, "it lifts first"
    assert min(heights) > PART_TOP_M - 0.003


def test_paused_it_stays_paused_until_it_is_enabled():
    cell = Cell()
    cell.sanding(0.2)
    cell.run(3.0, switches=[False])
    dies(cell)
    progress = cell.machine.report.progress
    cell.run(4.0)
    assert cell.machine.report.progress == progress
    assert cell.machine.report.lifted and not cell.machine.report.enabled
    assert cell.run(10.0, switches=[True], until=lambda: cell.machine.report.progress > progress)


@pytest.mark.parametrize("after_s", [0.5, 3.0, 5.5])
def test_on_its_way_to_the_part_it_gets_there(after_s):
    cell = Cell()
    cell.run(after_s, [Button.ADVANCE])
    dies(cell)
    assert cell.run(60.0, until=lambda: cell.machine.state is SanderState.TELEOPERATION), cell.machine.report


def test_on_its_way_to_storage_it_gets_there():
    cell = Cell()
    cell.sanding(0.05)
    cell.run(0.6, [Button.STORE])
    dies(cell)
    assert cell.run(30.0, until=lambda: cell.machine.state is SanderState.STORAGE), cell.machine.report


@pytest.mark.parametrize("presses", [(), (Button.ADVANCE,)])
def test_one_that_rested_rests(presses):
    cell = Cell()
    if presses:
        cell.teleoperation()
    state, before = cell.machine.state, cell.q.copy()
    dies(cell)
    cell.run(2.0)
    assert cell.machine.state is state
    assert np.abs(cell.q - before).max() < 1e-6


def test_held_in_the_midst_it_stays_held():
    cell = Cell()
    cell.sanding(0.05)
    cell.run(0.5, [Button.HOLD])
    dies(cell)
    before = cell.q.copy()
    cell.run(2.0)
    assert np.abs(cell.q - before).max() < 1e-6


@pytest.mark.parametrize("begun", [False, True])
def test_without_what_the_scan_saw_it_scans_once_more_and_sands(begun):
    cell = Cell()
    if begun:
        cell.sanding(0.1)
    else:
        cell.teleoperation()
    dies(cell, plan=False)
    presses = () if begun else [Button.START]
    assert cell.run(10.0, presses, until=lambda: cell.machine.state is SanderState.SCANNING), cell.machine.report
    assert cell.run(60.0, until=lambda: cell.machine.plan is not None), cell.machine.report
    assert cell.run(20.0, until=lambda: cell.machine.report.progress > 0.0), cell.machine.report


def test_who_has_not_looked_for_long_begins_again_from_where_the_arm_is():
    cell = Cell()
    cell.sanding(0.2)
    cell.q = cell.motion.at(cell.now_s + 0.3 - cell.motion_s)
    cell.motion, cell.now_s = None, cell.now_s + UNWATCHED_S + 5.0
    here = cell.q.copy()
    cell.run(0.05)
    assert np.abs(cell.q - here).max() < 0.01
    progress = cell.machine.report.progress
    assert cell.run(20.0, until=lambda: cell.machine.report.progress > progress), cell.machine.report
    assert cell.machine.report.reason == ""


def test_only_what_matters_is_written():
    cell = Cell()
    cell.sanding(0.1)
    before = cell.machine.memory
    cell.run(2.1 / 60.0)
    assert cell.machine.memory.arc_m > before.arc_m
    assert cell.machine.memory.as_good_as(before)
    cell.run(5.0 * ARC_STEP_M / 0.1)
    assert not cell.machine.memory.as_good_as(before)
