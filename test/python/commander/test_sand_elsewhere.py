"""What manipulators are told to keep off, so that they sand elsewhere meanwhile."""

from __future__ import annotations

import math

from python.commander.fake_cell import SPEC, FakeArm, FakeCell
from yarm.commander.params import CommanderParams

START = (-0.4, 1.6, -math.pi / 2)
PIECE = (-0.12, 0.10)
FAR = (1.7, -1.6)


def cell_with(debris, **params):
    cell = FakeCell(CommanderParams(sand_elsewhere=True, **params), ankurbot_1=START)
    cell.arms["hc10_barc"] = FakeArm(tip=(-0.25, -0.6, 0.75))
    cell.debris = dict(debris)
    cell.calibrate()
    cell.run_for(0.3)
    return cell


def told(cell):
    """Columns of each order to the manipulator, in order, and the distances."""
    orders = [goal for goal in cell.orders if goal.robot == "hc10_barc" and goal.action in ("ON", "OFF")]
    return [({SPEC.column_of(place) for place in goal.keep_off.places}, goal.keep_off.distance_m) for goal in orders]


def test_debris_is_told_with_the_distance_that_it_must_keep_not_to_be_paused():
    cell = cell_with({"debris_1": PIECE})
    columns, distance_m = told(cell)[-1]
    assert SPEC.column_of(PIECE) in columns
    assert distance_m > cell.params.pause_distance_m
    assert cell.arms["hc10_barc"].on, "it is farther than the pause distance"


def test_paused_it_is_told_from_where_it_is_let_go_on():
    cell = cell_with({})
    cell.arms["hc10_barc"].tip = (-0.12, 0.0, 0.75)
    cell.debris["debris_1"] = PIECE
    cell.run_for(0.5)
    assert not cell.arms["hc10_barc"].on
    places, distance_m = cell.orders[-1].keep_off.places, cell.orders[-1].keep_off.distance_m
    assert distance_m > cell.params.resume_distance_m
    apart = min(math.dist(place, (-0.12, -0.6)) for place in places)
    cell.arms["hc10_barc"].tip = (-0.12, -0.6, 0.75)
    cell.run_for(0.5)
    assert (apart > distance_m) is cell.arms["hc10_barc"].on is True


def test_what_is_far_from_its_area_is_not_told():
    cell = cell_with({"debris_1": FAR})
    assert all(SPEC.column_of(FAR) not in columns for columns, _ in told(cell))


def test_the_way_of_a_robot_is_told_before_it_is_there_and_no_longer_when_it_is_gone():
    cell = cell_with({"debris_1": PIECE})
    before = len(told(cell))
    assert cell.request(jump_state=5).success
    cell.run(cell.idle, 240.0)
    assert cell.status.outcome == "succeeded" and cell.touches == []
    orders = told(cell)[before:]
    assert max(len(columns) for columns, _ in orders) > 10
    cell.run_for(3.0)
    columns, _ = told(cell)[-1]
    assert SPEC.column_of(PIECE) not in columns
    robot = cell.commander.cell.robots["ankurbot_1"].cells[:, :2].tolist()
    beside = {(x + i, y + j) for x, y in robot for i in (0, 1) for j in (0, 1)}
    assert columns <= beside, "debris is gone, and the robot stands"


def test_nothing_is_told_unless_it_is_asked_for():
    cell = FakeCell(CommanderParams(), ankurbot_1=START)
    cell.arms["hc10_barc"] = FakeArm(tip=(-0.25, -0.6, 0.75))
    cell.debris = {"debris_1": PIECE}
    cell.calibrate()
    cell.run_for(0.3)
    assert told(cell) and all(columns == set() and distance == 0.0 for columns, distance in told(cell))
