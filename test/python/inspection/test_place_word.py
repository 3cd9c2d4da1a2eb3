"""Whether the place is known, by each kind of word that a localisation has."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from yarm.inspection.place_word import MOST_M, MOST_RAD, WAIT_S, PlaceWord, spread

LATER_S = 10.0 + WAIT_S


def covariance(x=0.0, y=0.0, yaw=0.0, xy=0.0):
    whole = np.zeros((6, 6))
    whole[0, 0], whole[1, 1], whole[5, 5] = x, y, yaw
    whole[0, 1] = whole[1, 0] = xy
    return whole.ravel().tolist()


def word(*covariances):
    made = PlaceWord()
    for each in covariances:
        assert made.pose(each, 10.0) == ""
    return made


@given(st.floats(0.0, 2.0), st.floats(0.0, 2.0), st.floats(-math.pi, math.pi), st.floats(0.0, 3.0))
def test_the_spread_is_the_longest_half_axis_however_the_ellipse_lies(one_m, other_m, turn_rad, off_rad):
    turn = np.array([[math.cos(turn_rad), -math.sin(turn_rad)], [math.sin(turn_rad), math.cos(turn_rad)]])
    plane = turn @ np.diag([one_m**2, other_m**2]) @ turn.T
    found = spread(covariance(plane[0, 0], plane[1, 1], off_rad**2, plane[0, 1]))
    np.testing.assert_allclose(found, (max(one_m, other_m), off_rad), atol=1e-7)


def test_below_both_limits_the_place_is_known_and_at_either_it_is_not():
    sure = covariance(0.099**2, 0.099**2, math.radians(4.9) ** 2)
    assert word(sure).at(LATER_S) == (True, "")
    for wide in (
        covariance(x=MOST_M**2),
        covariance(y=MOST_M**2),
        covariance(yaw=MOST_RAD**2),
        covariance(0.09**2, 0.09**2, xy=0.05**2),
    ):
        known, fault = word(sure, wide).at(LATER_S)
        assert not known and "less than 0.10 m and 5 degrees" in fault
        assert word(wide, sure).at(LATER_S) == (True, ""), "the newest counts"
    assert "a deviation of 0.50 m and 14.3 degrees" in word(covariance(0.25, 0.01, 0.0625)).at(LATER_S)[1]


@pytest.mark.parametrize(
    ("broken", "said"),
    [
        (covariance(x=math.nan), "not all are finite"),
        (covariance(y=math.inf), "not all are finite"),
        (covariance(xy=math.nan), "not all are finite"),
        (covariance(yaw=math.nan), "not all are finite"),
        (covariance(x=-0.01), "one is below zero"),
        (covariance(y=-0.01), "one is below zero"),
        (covariance(yaw=-0.01), "one is below zero"),
        (covariance(x=0.001, y=0.001, xy=0.002), "one is below zero"),
        ([0.0] * 9, "9 numbers, expected 36"),
    ],
)
def test_what_is_no_covariance_is_refused_and_the_place_no_longer_known(broken, said):
    made = word(covariance())
    assert made.at(LATER_S)[0]
    assert said in made.pose(broken, 10.0)
    known, fault = made.at(LATER_S)
    assert not known and said in fault


def test_rounding_below_zero_is_no_fault():
    assert word(covariance(-1e-17, 1e-4, -2e-16)).at(LATER_S) == (True, "")


def test_who_says_itself_whether_the_place_is_known_is_believed_alone():
    made = word(covariance())
    made.say(False, "the scan does not agree with the map")
    assert made.said and made.at(LATER_S) == (False, "the scan does not agree with the map")
    made.pose(covariance(), 11.0)
    assert not made.at(LATER_S)[0]
    made.say(True, "")
    made.pose(covariance(x=9.0), 11.0)
    assert made.at(LATER_S) == (True, "")
    made.forget()
    made.pose(covariance(), 0.0)
    assert made.said and made.at(LATER_S) == (False, ""), "it is there still when time has gone backwards"


def test_a_first_pose_waits_for_what_its_sender_may_say_besides():
    made = word(covariance())
    assert not made.at(10.0 + 0.9 * WAIT_S)[0] and made.at(10.0 + WAIT_S)[0]
    made.pose(covariance(), 20.0)
    assert made.at(20.0)[0], "only the first"
    made.forget()
    assert made.at(20.0) == (False, "")
    said = PlaceWord()
    said.pose(covariance(), 10.0)
    said.say(True, "")
    assert said.at(10.0) == (True, "")
