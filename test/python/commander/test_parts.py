"""Answers, shapes, goals and supervision on their own."""

from __future__ import annotations

import math

import numpy as np
import pytest

from python.commander.fake_cell import SHAPE, SPEC
from yarm.commander.answers import AnswerError, parse_answer
from yarm.commander.events import CancelGoal, GoalDone, Outcome, Target
from yarm.commander.goals import GoalBook, Purpose, remaining
from yarm.commander.supervision import distance_to_cells
from yarm.geometry.solids import Shape, Solid
from yarm.robots.ankurbot import ankurbot_mask
from yarm.robots.shapes import robot_shape


def test_answers():
    assert parse_answer("SPACE=XY/AREA=17,7,15").area == (17, 7, 15)
    answer = parse_answer("SPACE=SWITCH/AREA=11,29,17,32,0,10")
    columns = answer.private_columns(SPEC)
    assert columns[11, 17] and columns[29, 32] and not columns[10, 17] and not columns[29, 33]
    assert columns.sum() == 19 * 16


@pytest.mark.parametrize("text", ["", "SPACE=XY", "SPACE=XY/AREA=1,2", "SPACE=Z/AREA=1,2,3", "SPACE=XY/AREA=a,b,c"])
def test_bad_answers_are_quoted(text):
    with pytest.raises(AnswerError, match="calibration answer"):
        parse_answer(text)


def pose(x=0.0, y=0.0, z=0.0):
    matrix = np.eye(4)
    matrix[:3, 3] = (x, y, z)
    return matrix


def test_the_shape_from_solids_is_the_drawn_robot():
    solids = [
        Solid(Shape.CYLINDER, (0.35, 0.45), pose(-1.3, 0, 0.325 - 0.89)),
        Solid(Shape.BOX, (0.10, 0.10, 0.42), pose(-1.3, 0, 0.76 - 0.89)),
        Solid(Shape.BOX, (1.30, 0.08, 0.08), pose(-0.65, 0, 0.0)),
        Solid(Shape.SPHERE, (0.04,), pose()),
        *[Solid(Shape.SPHERE, (0.05,), pose(-1.3 + x, y, 0.05 - 0.89)) for x in (-0.15, 0.15) for y in (-0.15, 0.15)],
    ]
    shape = robot_shape(solids, 0.89)
    for yaw in (0.0, math.pi / 2, 2.1):
        made, drawn = shape.mask(SPEC, yaw), ankurbot_mask(SPEC, yaw)
        assert np.array_equal(made.cells, drawn.cells)


def test_masks_are_shared_by_heading():
    assert SHAPE.mask(SPEC, 1.0).cells is SHAPE.mask(SPEC, 1.0 + 1e-5).cells


def test_an_unknown_solid_is_named():
    with pytest.raises(ValueError, match="'cone'"):
        robot_shape([Solid("cone", (1.0,), pose())], 0.0)


def test_distance_to_cells_is_to_their_squares():
    cells = np.array([[25, 25, 3]])
    assert distance_to_cells(SPEC, (0.05, 0.05), cells) == 0.0
    assert distance_to_cells(SPEC, (0.3, 0.05), cells) == pytest.approx(0.2)
    assert distance_to_cells(SPEC, (-0.3, -0.4), cells) == pytest.approx(0.5)
    assert distance_to_cells(SPEC, (0.0, 0.0), np.zeros((0, 3))) == math.inf


def test_a_goal_is_cancelled_once_and_ends_once():
    book = GoalBook()
    sent = book.send("r", Purpose.STEP, "False", 1.0, Target(1.0, 0.0, 0.0))
    assert book.cancel("r", 2.0, "why") == [CancelGoal("r", sent.serial)]
    assert book.cancel("r", 2.5, "again") == []
    assert [goal.robot for goal in book.overdue(8.0, 5.0)] == ["r"]
    assert book.end(GoalDone("r", sent.serial + 1, Outcome.SUCCEEDED)) is None
    assert book.end(GoalDone("r", sent.serial, Outcome.PREEMPTED)).why == "why"
    assert book.end(GoalDone("r", sent.serial, Outcome.PREEMPTED)) is None


def test_progress_counts_ways_and_turns():
    target = Target(1.0, 0.0, math.pi)
    assert remaining(target, 0.0, 0.0, 0.0) == pytest.approx(1.0 + 1.3 * math.pi)
    book = GoalBook()
    book.send("r", Purpose.STEP, "False", 0.0, target)
    book.note_progress("r", 0.0, 0.0, 0.0, 1.0)
    assert book.active["r"].best_s == 1.0
    book.note_progress("r", 0.01, 0.0, 0.0, 2.0)
    assert book.active["r"].best_s == 1.0
    book.note_progress("r", 0.0, 0.0, 0.1, 3.0)
    assert book.active["r"].best_s == 3.0
