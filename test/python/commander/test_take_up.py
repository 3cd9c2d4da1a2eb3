"""A Commander that dies at any moment, and the one after it, which knows what the journal held."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from python.commander.fake_cell import FakeArm, FakeCell
from yarm.commander.memory import Memory
from yarm.commander.params import CommanderParams
from yarm.commander.states import State
from yarm.records import plain, read

pytestmark = pytest.mark.usefixtures("execution")

FIRST, SECOND = (0.65, 1.6, math.pi), (0.65, -1.9, math.pi)
PIECES = {"debris_1": (-0.35, 0.35), "debris_2": (0.25, -0.35)}
SEEDS = range(2)


def cell_with(robots=None, debris=None, **params):
    cell = FakeCell(CommanderParams(**params), **(robots or {"ankurbot_1": FIRST, "ankurbot_2": SECOND}))
    cell.arms["hc10_barc"] = FakeArm()
    cell.debris = dict(PIECES if debris is None else debris)
    cell.calibrate()
    return cell


def succeeds(cell, limit_s=200.0):
    cell.run(cell.idle, limit_s)
    assert cell.touches == []
    assert cell.status.outcome == "succeeded", f"{cell.status}\n" + "\n".join(map(str, cell.said[-12:]))


def reached(cell):
    return {task.goal: task.robot for task in cell.status.tasks if task.status == "reached"}


@pytest.mark.parametrize("seed", SEEDS)
def test_a_mission_ends_well_whenever_the_commander_dies(seed):
    rng = np.random.default_rng(seed)
    cell = cell_with()
    assert cell.request(jump_state=5).success
    deaths = sorted(cell.now + rng.uniform(0.0, 20.0, size=4))
    for death in deaths:
        cell.run(lambda at=death: cell.now >= at or cell.idle(), 60.0)
        cell.start_commander_again(taken_up=True)
    calibrated = len(cell.association)
    succeeds(cell)
    assert cell.debris == {}
    assert set(reached(cell)) == set(PIECES), (seed, cell.status)
    assert all(on for _, on in cell.association[2:calibrated]), "association stays on"
    assert len([goal for _, goal in cell.sent if goal.action == "CALIBRATION"]) == 3


@pytest.mark.parametrize("seed", SEEDS)
def test_with_hands_nothing_is_lost_whenever_the_commander_dies(seed):
    rng = np.random.default_rng(seed)
    cell = cell_with({"ankurbot_1": (0.65, -1.9, math.pi)}, {"debris_1": (0.25, -0.35)}, removal="bin")
    cell.bins = {"bin_1": (1.9, -1.2)}
    assert cell.request(jump_state=5).success
    for _ in range(3):
        cell.run_for(rng.uniform(0.5, 12.0))
        cell.start_commander_again(taken_up=True)
    succeeds(cell)
    assert cell.binned("debris_1"), seed


@pytest.mark.parametrize("stage", ["picking", "carrying", "dropping"])
def test_a_hand_goes_on_with_what_it_was_at(stage):
    cell = cell_with({"ankurbot_1": (0.65, -1.9, math.pi)}, {"debris_1": (0.25, -0.35)}, removal="bin")
    cell.bins = {"bin_1": (1.9, -1.2)}
    assert cell.request(jump_state=5).success
    cell.run(lambda: any(task.status == stage for task in cell.status.tasks), 100.0)
    cell.run_for(0.5)
    cell.start_commander_again(taken_up=True)
    succeeds(cell)
    assert cell.binned("debris_1")
    assert set(reached(cell)) == {"debris_1"}, cell.status


def test_a_piece_let_go_while_nobody_looked_is_done():
    cell = cell_with({"ankurbot_1": (0.65, -1.9, math.pi)}, {"debris_1": (0.25, -0.35)}, removal="bin")
    cell.bins = {"bin_1": (1.9, -1.2)}
    assert cell.request(jump_state=5).success
    cell.run(lambda: any(task.status == "dropping" for task in cell.status.tasks), 100.0)
    cell.release("ankurbot_1")
    cell.start_commander_again(taken_up=True)
    succeeds(cell)
    assert set(reached(cell)) == {"debris_1"}, cell.status


def test_until_everything_is_known_again_nobody_may_move_and_it_says_what_is_missing():
    cell = cell_with()
    assert cell.request(jump_state=5).success
    cell.run(lambda: cell.robots["ankurbot_1"].goal is not None, 20.0)
    cell.start_commander_again(taken_up=True)
    assert cell.status.busy
    assert "waits for planning_metadata" in cell.status.reason
    assert cell.commander.objection(cell.now) != ""
    assert {task.goal for task in cell.status.tasks} == set(PIECES)
    cell.lost = {"ankurbot_2"}
    sent = len(cell.sent)
    cell.run_for(3.0)
    assert [goal for _, goal in cell.sent[sent:] if goal.target is not None] == []
    assert "waits for the action server of ankurbot_2" in cell.commander.objection(cell.now)
    cell.find("ankurbot_2")
    succeeds(cell)


def test_who_asks_for_a_stop_meanwhile_gets_it():
    cell = cell_with()
    assert cell.request(jump_state=5).success
    cell.run(lambda: cell.robots["ankurbot_1"].goal is not None, 20.0)
    cell.start_commander_again(taken_up=True)
    assert cell.request(previous_state=True).success
    cell.run(cell.idle, 20.0)
    assert cell.status.state is State.MENU
    assert cell.status.outcome == "stopped"


def test_calibration_begins_anew():
    cell = FakeCell(ankurbot_1=FIRST)
    assert cell.request(current_state=True).success
    assert cell.request(next_state=True).success
    cell.run_for(0.5)
    cell.start_commander_again(taken_up=True)
    cell.run(cell.idle, 20.0)
    assert (cell.status.state, cell.status.outcome) == (State.CALIBRATION, "succeeded")
    assert [on for _, on in cell.association] == [False, False, False, True]


def test_cleanup_goes_on():
    cell = cell_with(debris={})
    assert cell.request(jump_state=5).success
    cell.run(cell.idle, 20.0)
    cell.robots["ankurbot_1"].x += 0.8
    assert cell.request(next_state=True).success
    cell.run_for(0.5)
    cell.start_commander_again(taken_up=True)
    succeeds(cell)
    assert cell.status.state is State.CLEANUP
    assert abs(cell.robots["ankurbot_1"].x - FIRST[0]) < 0.1
    assert cell.arms["hc10_barc"].told[-1][1] == "CLEANUP"


def test_what_has_ended_is_shown_as_it_was():
    cell = cell_with()
    assert cell.request(jump_state=5).success
    succeeds(cell)
    before = cell.status
    cell.start_commander_again(taken_up=True)
    assert (cell.status.outcome, cell.status.state) == (before.outcome, before.state)
    assert reached(cell) == {task.goal: task.robot for task in before.tasks}
    assert cell.request(next_state=True).success
    succeeds(cell)


def test_a_deletion_that_was_asked_for_is_not_waited_for_in_vain():
    cell = cell_with()
    assert cell.request(jump_state=5).success
    cell.deletes = False
    cell.run(lambda: any("was not deleted" in text for text in cell.said), 60.0)
    cell.debris.clear()
    cell.start_commander_again(taken_up=True)
    succeeds(cell)
    assert any("is gone already: refused" in text for text in cell.said)


def test_a_simulator_that_was_started_again_meanwhile_is_calibrated_first():
    cell = cell_with()
    assert cell.request(jump_state=5).success
    cell.run_for(3.0)
    cell.start_commander_again(taken_up=True)
    cell.now = 0.0
    cell.run_for(0.2)
    assert cell.status.state is State.CALIBRATION
    succeeds(cell)
    cell.run(cell.idle, 200.0)
    assert cell.status.state is State.BOUNDLESS
    assert cell.debris == {}


def test_a_memory_survives_being_written():
    cell = cell_with({"ankurbot_1": (0.65, -1.9, math.pi)}, {"debris_1": (0.25, -0.35)}, removal="bin")
    cell.bins = {"bin_1": (1.9, -1.2)}
    assert cell.request(jump_state=5).success
    seen = set()
    for _ in range(20):
        cell.run_for(1.0)
        memory = cell.commander.memory(cell.now)
        assert read(Memory, json.loads(json.dumps(plain(memory)))).same_as(memory)
        seen |= {task.status.value for task in memory.tasks}
    assert {"ASSIGNED", "HELD", "REACHED"} <= seen, seen
