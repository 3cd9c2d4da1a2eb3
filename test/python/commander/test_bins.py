"""Missions that carry debris to a bin: the core, the real planner, a kinematic cell with hands, and what goes wrong."""

from __future__ import annotations

import math

import pytest

from python.commander.fake_cell import LANDED_M, FakeArm, FakeCell
from yarm.commander.params import CommanderParams

pytestmark = pytest.mark.usefixtures("execution")

START = (0.65, 1.6, math.pi)
SECOND = (0.65, -1.9, math.pi)
PIECE = (-0.12, 0.10)
BIN, OTHER_BIN = (0.45, -1.45), (0.95, -1.45)
BESIDE = (0.15, -1.45)


def cell_with(debris=(PIECE,), bins=(BIN,), params=None, **robots):
    cell = FakeCell(params or CommanderParams(removal="bin"), **(robots or {"ankurbot_1": START}))
    cell.arms["hc10_barc"] = FakeArm()
    cell.debris = {f"debris_{i + 1}": at for i, at in enumerate(debris)}
    cell.bins = {f"bin_{i + 1}": at for i, at in enumerate(bins)}
    cell.calibrate()
    assert cell.request(jump_state=5).success
    return cell


def outcome_of(cell, limit_s=240.0):
    cell.run(cell.idle, limit_s)
    assert cell.touches == []
    return cell.status


def tasks(cell, goal):
    return [(task.status, task.robot) for task in cell.status.tasks if task.goal == goal]


def works(cell):
    """What the hands were told, in order."""
    return [action.action for _, action in cell.sent if " " in action.action]


def until(cell, *statuses, goal="debris_1"):
    cell.run(lambda: [status for status, _ in tasks(cell, goal)] == list(statuses), 120.0)


def binned(cell):
    return {name: cell.binned(name) for name in cell.debris}


def test_a_piece_ends_in_the_bin_and_is_shown_on_its_way():
    cell = cell_with()
    for status in ("picking", "carrying", "dropping"):
        until(cell, status)
        assert tasks(cell, "debris_1") == [(status, "ankurbot_1")]
    assert outcome_of(cell).outcome == "succeeded"
    assert binned(cell) == {"debris_1": True}
    assert tasks(cell, "debris_1") == [("reached", "ankurbot_1")]
    assert works(cell) == ["PICK debris_1", "DROP bin_1"]


def test_a_robot_with_a_load_is_planned_for_with_it():
    cell = cell_with()
    until(cell, "carrying")
    cell.tick()
    loaded = cell.commander.cell.robots["ankurbot_1"].mask
    cell.run(cell.idle, 120.0)
    empty = cell.commander.cell.shapes["ankurbot_1"].mask(cell.commander.cell.spec, loaded.yaw_rad)
    assert len(loaded.cells) > len(empty.cells)


def test_two_robots_share_a_bin_without_meeting():
    cell = cell_with([(-0.12, 0.20), (-0.20, -0.20)], ankurbot_1=START, ankurbot_2=SECOND)
    assert outcome_of(cell).outcome == "succeeded"
    assert binned(cell) == {"debris_1": True, "debris_2": True}
    dropped = {robot for _, action in cell.sent if action.action == "DROP bin_1" for robot in [action.robot]}
    assert dropped == {"ankurbot_1", "ankurbot_2"}


def test_cleanup_brings_what_is_left_to_the_bin_before_everybody_goes_home():
    cell = cell_with()
    until(cell, "carrying")
    assert cell.request(previous_state=True).success
    cell.run(cell.idle, 60.0)
    assert not cell.binned("debris_1")
    assert cell.request(jump_state=5).success
    cell.run(cell.idle, 120.0)
    cell.debris["debris_2"] = (-0.2, 0.1)
    cell.run_for(0.2)
    assert cell.request(next_state=True).success
    assert outcome_of(cell).outcome == "succeeded"
    assert binned(cell) == {"debris_1": True, "debris_2": True}
    assert math.dist((cell.robots["ankurbot_1"].x, cell.robots["ankurbot_1"].y), START[:2]) < 0.1


def test_a_hand_that_meets_nothing_looks_again_and_gives_the_piece_back_after_three_tries():
    cell = cell_with(params=CommanderParams(removal="bin", give_up_s=3.0))
    cell.leaky = {"ankurbot_1"}
    status = outcome_of(cell)
    assert works(cell) == ["PICK debris_1"] * 3
    assert status.outcome == "failed"
    assert status.reason == (
        "debris_1: not picked up in 3 tries: ABORTED nothing met down to 0.200 m, where the lift ends"
    )
    assert tasks(cell, "debris_1") == [("unreachable", "")]


def test_a_vacuum_that_fails_once_costs_a_try():
    cell = cell_with()
    cell.leaky = {"ankurbot_1"}
    cell.run(lambda: works(cell) == ["PICK debris_1"] * 2, 60.0)
    cell.leaky = set()
    assert outcome_of(cell).outcome == "succeeded"
    assert binned(cell) == {"debris_1": True}


@pytest.mark.parametrize(("off", "tries"), [(-0.024, 2), (0.024, 3)])
def test_a_piece_that_is_seen_beside_itself_is_found_by_looking_across_it(off, tries):
    cell = cell_with()
    cell.seen_off = (0.0, off)
    assert outcome_of(cell).outcome == "succeeded"
    assert works(cell) == ["PICK debris_1"] * tries + ["DROP bin_1"]
    assert binned(cell) == {"debris_1": True}


def test_a_piece_too_low_for_the_hands_is_refused_with_the_numbers_and_nobody_goes_there():
    cell = cell_with([PIECE, (0.9, 0.0)], params=CommanderParams(removal="bin", give_up_s=3.0))
    cell.heights["debris_2"] = 0.02
    status = outcome_of(cell)
    assert status.outcome == "failed"
    assert status.reason == "debris_2: its top is 0.04 m high, and the hands reach down to 0.65 m"
    assert tasks(cell, "debris_2") == [("unreachable", "")]
    assert works(cell) == ["PICK debris_1", "DROP bin_1"]
    cell.heights["debris_2"], cell.debris["debris_2"] = 0.75, PIECE
    assert cell.request(current_state=True).success
    assert outcome_of(cell).outcome == "succeeded"
    assert binned(cell) == {"debris_1": True, "debris_2": True}


def test_what_was_given_back_is_a_goal_again_once_it_has_moved():
    cell = cell_with()
    cell.leaky = {"ankurbot_1"}
    until(cell, "unreachable")
    cell.leaky = set()
    cell.debris["debris_1"] = (-0.25, 0.1)
    assert outcome_of(cell).outcome == "succeeded"
    assert binned(cell) == {"debris_1": True}


def test_what_was_given_back_is_a_goal_again_once_the_piece_beside_it_is_gone():
    cell = cell_with([PIECE, (PIECE[0], PIECE[1] + 0.07)])
    cell.leaky = {"ankurbot_1"}
    until(cell, "unreachable")
    cell.leaky = set()
    assert outcome_of(cell).outcome == "succeeded"
    assert binned(cell) == {"debris_1": True, "debris_2": True}
    picks = [word for word in works(cell) if word.startswith("PICK")]
    assert picks == ["PICK debris_1"] * 3 + ["PICK debris_2", "PICK debris_1"]


def test_a_piece_that_is_moved_while_a_hand_is_on_its_way_to_it_is_followed():
    cell = cell_with()
    until(cell, "picking")
    cell.debris["debris_1"] = (-0.30, -0.1)
    cell.run(lambda: any("no longer where" in text or "nothing met" in text for text in cell.said), 60.0)
    assert outcome_of(cell).outcome == "succeeded"
    assert binned(cell) == {"debris_1": True}


def test_a_piece_that_slips_off_the_cup_is_debris_again_at_once():
    cell = cell_with()
    until(cell, "carrying")
    cell.run(lambda: cell.robots["ankurbot_1"].goal is not None, 60.0)
    at = cell.debris["debris_1"]
    cell.release("ankurbot_1")
    cell.heights["debris_1"], cell.debris["debris_1"] = 0.75, PIECE
    cell.run_for(0.2)
    assert at != BIN
    assert "ankurbot_1 has lost debris_1" in cell.said
    assert [status for status, _ in tasks(cell, "debris_1")] != ["carrying"]
    assert outcome_of(cell).outcome == "succeeded"
    assert binned(cell) == {"debris_1": True}


def test_a_piece_that_the_map_shows_off_the_hand_is_debris_again_whatever_the_hand_says():
    cell = cell_with()
    until(cell, "carrying")
    cell.run_for(0.2)
    robot = cell.robots["ankurbot_1"]
    robot.holds, cell.heights["debris_1"], cell.debris["debris_1"] = "", 0.75, PIECE
    cell.run_for(0.2)
    assert "ankurbot_1 has lost debris_1" in cell.said
    assert cell.commander.cell.loads == {} and cell.commander.cell.grasping["ankurbot_1"]
    assert outcome_of(cell).outcome == "succeeded"
    assert binned(cell) == {"debris_1": True}


def test_a_hand_that_took_the_neighbour_carries_that_to_the_bin_and_the_piece_stays_debris():
    cell = cell_with([PIECE, (-0.30, 0.10)])
    until(cell, "picking")
    cell.run(lambda: cell.robots["ankurbot_1"].holds == "debris_1", 60.0)
    cell.debris["debris_2"], cell.debris["debris_1"] = cell.debris["debris_1"], cell.debris["debris_2"]
    cell.robots["ankurbot_1"].holds = "debris_2"
    cell.heights.update(debris_1=0.75, debris_2=0.83)
    cell.run(lambda: cell.status.tasks and tasks(cell, "debris_2") == [("carrying", "ankurbot_1")], 10.0)
    assert "ankurbot_1 has lost debris_1" in cell.said
    assert outcome_of(cell).outcome == "succeeded"
    assert binned(cell) == {"debris_1": True, "debris_2": True}
    assert [word for word in works(cell) if word.startswith("PICK")] == ["PICK debris_1", "PICK debris_1"]


def test_a_new_commander_takes_what_hangs_on_a_hand_to_the_bin():
    cell = cell_with()
    until(cell, "carrying")
    cell.start_commander_again()
    cell.calibrate()
    assert cell.request(jump_state=5).success
    assert outcome_of(cell).outcome == "succeeded"
    assert works(cell) == ["PICK debris_1", "DROP bin_1"]
    assert binned(cell) == {"debris_1": True}


def test_a_piece_that_falls_beside_the_bin_is_no_success():
    cell = cell_with(params=CommanderParams(removal="bin", give_up_s=3.0))
    until(cell, "dropping")
    cell.run(lambda: cell.robots["ankurbot_1"].holds == "", 60.0)
    cell.debris["debris_1"], cell.heights["debris_1"] = BESIDE, LANDED_M
    status = outcome_of(cell)
    assert "debris_1 was let go over bin_1 and does not lie in it" in cell.said
    assert status.outcome == "failed"
    assert "debris_1" in status.reason


def test_a_piece_that_is_taken_out_of_the_bin_is_debris_again():
    cell = cell_with()
    assert outcome_of(cell).outcome == "succeeded"
    cell.debris["debris_1"], cell.heights["debris_1"] = PIECE, 0.75
    assert cell.request(current_state=True).success
    assert outcome_of(cell).outcome == "succeeded"
    assert works(cell) == ["PICK debris_1", "DROP bin_1"] * 2
    assert binned(cell) == {"debris_1": True}


def test_a_bin_that_is_moved_is_followed():
    cell = cell_with()
    until(cell, "carrying")
    cell.run(lambda: cell.robots["ankurbot_1"].goal is not None, 60.0)
    cell.bins["bin_1"] = (BIN[0] + 0.3, BIN[1])
    assert outcome_of(cell).outcome == "succeeded"
    assert binned(cell) == {"debris_1": True}


def test_a_full_bin_is_named_and_another_is_taken():
    cell = cell_with(bins=(BIN, OTHER_BIN))
    cell.blocked_bins = {"bin_1"}
    cell.debris["debris_9"], cell.heights["debris_9"] = BIN, 0.50
    assert outcome_of(cell).outcome == "succeeded"
    assert binned(cell) == {"debris_1": True, "debris_9": True}
    assert works(cell) == ["PICK debris_1", "DROP bin_2"]
    named = [text for text in cell.said if "is full" in text]
    assert len(named) == 1 and "bin_1 is full: a piece in it lies 0.50 m high, at most 0.45" in named[0]


def test_a_bin_that_takes_nothing_counts_as_full():
    cell = cell_with(bins=(BIN, OTHER_BIN))
    cell.blocked_bins = {"bin_1"}
    assert outcome_of(cell).outcome == "succeeded"
    assert binned(cell) == {"debris_1": True}
    assert works(cell) == ["PICK debris_1", *["DROP bin_1"] * 3, "DROP bin_2"]
    assert len([text for text in cell.said if "bin_1 is full: nothing was let go in 3 tries" in text]) == 1


def test_without_a_bin_that_takes_more_the_mission_waits_and_says_so():
    cell = cell_with(params=CommanderParams(removal="bin", give_up_s=3.0))
    cell.blocked_bins = {"bin_1"}
    status = outcome_of(cell)
    assert status.outcome == "failed"
    assert status.reason == (
        "ankurbot_1 carries debris_1 and waits for a bin: bin_1 is full: nothing was let go in 3 tries: "
        "ABORTED met something 0.100 m down; is the bin full?"
    )
    assert tasks(cell, "debris_1") == [("carrying", "ankurbot_1")]


def test_without_any_bin_nothing_is_carried_anywhere():
    cell = cell_with(bins=(), params=CommanderParams(removal="bin", give_up_s=3.0))
    status = outcome_of(cell)
    assert status.outcome == "failed"
    assert status.reason == "ankurbot_1 carries debris_1 and waits for a bin: there is none on the map"


def test_a_hand_that_is_never_done_is_cancelled_with_a_reason():
    cell = cell_with(params=CommanderParams(removal="bin", hand_timeout_s=3.0))
    until(cell, "picking")
    cell.robots["ankurbot_1"].stuck = True
    cell.run(lambda: any("not done within 3 s" in text for text in cell.said), 60.0)
    cell.robots["ankurbot_1"].stuck = False
    assert outcome_of(cell).outcome == "succeeded"
    assert binned(cell) == {"debris_1": True}


def test_a_robot_without_a_hand_gives_the_piece_back_with_the_servers_reason():
    cell = cell_with(params=CommanderParams(removal="bin", give_up_s=3.0))
    cell.handless = {"ankurbot_1"}
    status = outcome_of(cell)
    assert status.outcome == "failed"
    assert status.reason == "debris_1: not picked up in 3 tries: REJECTED PICK debris_1: ankurbot_1 has no hand"


def test_a_new_simulator_forgets_what_hung_on_the_hands():
    cell = cell_with()
    until(cell, "carrying")
    cell.release("ankurbot_1")
    cell.debris["debris_1"], cell.heights["debris_1"] = PIECE, 0.75
    cell.restart()
    assert cell.commander.cell.loads == {}
    cell.run(lambda: cell.binned("debris_1"), 240.0)


def test_three_robots_bring_six_pieces_to_two_bins():
    places = [(0.28, 0.45), (0.28, -0.45), (-0.20, 0.47), (-0.20, -0.47), (0.30, 0.0), (-0.12, 0.0)]
    starts = {f"ankurbot_{i + 1}": (0.65, y, math.pi) for i, y in enumerate((1.9, -1.9, 0.0))}
    cell = cell_with(places, bins=(BIN, (0.45, 1.45)), **starts)
    assert outcome_of(cell).outcome == "succeeded"
    assert binned(cell) == {f"debris_{i + 1}": True for i in range(6)}
    assert sorted(works(cell)) == sorted(
        [f"PICK debris_{i + 1}" for i in range(6)] + [word for word in works(cell) if word.startswith("DROP bin_")]
    )
    assert len(works(cell)) == 12
