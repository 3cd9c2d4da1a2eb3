"""Speeds by distance left."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from yarm.control.base.params import BaseParams
from yarm.control.base.speed_profile import slew, stopping_speed, table_speed

PARAMS = BaseParams()


@pytest.mark.parametrize(("left_m", "speed"), [(3.1, 5.0), (3.0, 1.0), (0.51, 1.0), (0.5, 0.5), (0.0, 0.5)])
def test_translation_table(left_m, speed):
    assert table_speed(left_m, PARAMS.translation_limits_m, PARAMS.translation_speeds_mps) == speed


@pytest.mark.parametrize(("left_deg", "speed"), [(31.0, 2.0), (30.0, 1.0), (2.1, 1.0), (2.0, 0.25)])
def test_rotation_table(left_deg, speed):
    assert table_speed(left_deg, PARAMS.rotation_limits_deg, (*PARAMS.rotation_speeds_radps, 0.25)) == speed


@given(st.floats(0.0, 5.0), st.floats(0.1, 5.0), st.floats(0.0, 0.5))
def test_the_distance_left_is_just_enough_to_stop(left, deceleration, delay_s):
    speed = stopping_speed(left, deceleration, delay_s)
    assert speed >= 0.0
    assert speed * delay_s + speed**2 / (2.0 * deceleration) == pytest.approx(left, abs=1e-6)


@given(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(0.0, 0.1))
def test_speed_changes_within_the_limits_and_towards_the_wish(current, wanted, dt_s):
    new = slew(current, wanted, 1.0, 1.5, dt_s)
    assert abs(new - current) <= 1.5 * dt_s + 1e-12
    assert abs(new - wanted) <= abs(current - wanted) + 1e-12


def test_a_change_of_sign_passes_through_rest():
    assert slew(0.01, -1.0, 1.0, 1.5, 1.0) == 0.0
