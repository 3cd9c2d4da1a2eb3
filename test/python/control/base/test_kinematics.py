"""Casters and body velocity."""

from __future__ import annotations

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from yarm.control.base.kinematics import (
    BODY_CENTRE,
    body_velocity,
    driving_casters,
    full_turn,
    turning_casters,
    turning_centre,
)

ANGLES = st.floats(-math.pi, math.pi)
PLACES = st.floats(-3.0, 3.0)


def test_turning_about_the_body_puts_the_casters_at_45_degrees():
    assert [round(math.degrees(a), 6) for a in turning_casters(BODY_CENTRE)] == [-45.0, 45.0, 45.0, -45.0]


def test_turning_about_the_end_effector_puts_them_at_the_known_angles():
    degrees = [round(math.degrees(a), 2) for a in turning_casters((1.30, 0.0))]
    assert degrees == [82.57, -82.57, 84.09, -84.09]


def test_a_centre_under_a_caster_is_refused():
    with pytest.raises(ValueError, match="under the caster"):
        turning_casters((0.15, -0.15))


@given(PLACES, PLACES)
def test_casters_define_the_centre_they_were_made_for(x, y):
    assume(all(math.hypot(x - cx, y - cy) > 0.02 for cx in (0.15, -0.15) for cy in (0.15, -0.15)))
    centre = turning_centre(turning_casters((x, y)))
    assert centre is not None
    assert math.hypot(centre[0] - x, centre[1] - y) < 1e-5


@given(ANGLES, st.floats(-1.0, 1.0))
def test_parallel_casters_translate_and_never_turn(angle, speed):
    vx, vy, yaw_rate = body_velocity([angle] * 4, speed, 1.0)
    assert yaw_rate == 0.0
    assert (vx, vy) == pytest.approx((speed * math.cos(angle), speed * math.sin(angle)), abs=1e-9)


def test_turning_about_the_end_effector_moves_the_body_sideways():
    vx, vy, yaw_rate = body_velocity(turning_casters((1.30, 0.0)), 0.0, 0.5)
    assert (vx, vy, yaw_rate) == pytest.approx((0.0, -0.65, 0.5), abs=1e-9)


@given(ANGLES, st.lists(ANGLES, min_size=4, max_size=4))
def test_driving_either_way_round_goes_in_the_wanted_direction(direction, current):
    casters, sign = driving_casters(direction, current)
    assert len(set(casters)) == 1
    assert abs(casters[0]) <= math.pi
    vx, vy, _ = body_velocity(casters, sign * 0.5, 0.0)
    assert (vx, vy) == pytest.approx((0.5 * math.cos(direction), 0.5 * math.sin(direction)), abs=1e-9)


@given(ANGLES)
def test_driving_keeps_room_for_steering_at_the_casters_stops(direction):
    casters, _ = driving_casters(direction, [0.0] * 4)
    assert abs(casters[0]) <= math.pi - 0.3 + 1e-9


@given(st.floats(-50.0, 50.0))
def test_full_turn_keeps_the_direction(angle):
    wrapped = full_turn(angle)
    assert abs(wrapped) <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)
