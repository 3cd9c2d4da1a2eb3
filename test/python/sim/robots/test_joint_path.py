"""Streamed joint trajectories: linear between points, never beyond limits or speeds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from yarm.sim.robots.joint_path import JointLimits, JointPath, JointPathError

LIMITS = JointLimits(np.array([-1.0, -2.0]), np.array([1.0, 2.0]), np.array([1.0, 0.5]))


def test_linear_between_points_and_still_at_the_end() -> None:
    path = JointPath([0.0, 0.0], LIMITS)
    assert path.follow([[0.5, 0.0], [0.5, 0.4]], [1.0, 2.0]) == []
    path.advance(0.5)
    assert path.position == pytest.approx([0.25, 0.0])
    assert path.velocity == pytest.approx([0.5, 0.0])
    path.advance(1.0)
    assert path.position == pytest.approx([0.5, 0.2])
    path.advance(9.0)
    assert path.position == pytest.approx([0.5, 0.4])
    assert not path.moving and not path.velocity.any()


def test_limits_clamp_and_speeds_stretch_and_both_are_said() -> None:
    path = JointPath([0.0, 0.0], LIMITS)
    notes = path.follow([[5.0, 0.0]], [0.1])
    assert any("joint(s) [1] clamped" in note for note in notes)
    assert any("1 piece(s) slowed" in note for note in notes)
    path.advance(0.5)
    assert path.position == pytest.approx([0.5, 0.0])


def test_a_new_path_replaces_the_old_one_and_an_empty_one_stops() -> None:
    path = JointPath([0.0, 0.0], LIMITS)
    path.follow([[1.0, 0.0]], [1.0])
    path.advance(0.3)
    path.follow([], [])
    path.advance(1.0)
    assert path.position == pytest.approx([0.3, 0.0])


@pytest.mark.parametrize(
    ("points", "times", "words"),
    [
        ([[np.nan, 0.0]], [1.0], "finite"),
        ([[0.0, 0.0]], [np.inf], "finite"),
        ([[0.0]], [1.0], "2 joints"),
        ([[0.0, 0.0]], [1.0, 2.0], "2 times 2 joints"),
        ([[0.0, 0.0], [0.1, 0.0]], [1.0, 0.5], "fall"),
        ([[0.0, 0.0]], [-1.0], "negative"),
    ],
)
def test_bad_trajectories_are_refused_and_change_nothing(points: list, times: list, words: str) -> None:
    path = JointPath([0.0, 0.0], LIMITS)
    path.follow([[0.5, 0.0]], [1.0])
    with pytest.raises(JointPathError, match=words):
        path.follow(points, times)
    path.advance(2.0)
    assert path.position == pytest.approx([0.5, 0.0])


@settings(max_examples=30, deadline=None)
@given(
    st.lists(st.tuples(st.floats(-9, 9), st.floats(-9, 9), st.floats(0, 1)), min_size=1, max_size=6),
    st.floats(0.001, 0.2),
)
def test_no_set_point_ever_breaks_a_limit_or_a_speed(pieces: list, dt: float) -> None:
    path = JointPath([0.0, 0.0], LIMITS)
    path.follow([[a, b] for a, b, _ in pieces], np.cumsum([t for _, _, t in pieces]).tolist())
    for _ in range(100):
        before = path.position.copy()
        path.advance(dt)
        assert np.all(path.position >= LIMITS.lower - 1e-12) and np.all(path.position <= LIMITS.upper + 1e-12)
        assert np.all(np.abs(path.position - before) <= LIMITS.speed * dt + 1e-9)


def test_a_brake_comes_to_rest_on_the_way_evenly_and_forgets_the_rest():
    path = JointPath([0.0, 0.0], LIMITS)
    path.follow([[1.0, 0.5], [1.0, 1.5]], [2.0, 4.0])
    path.advance(1.0)
    path.brake(0.2)
    speeds = []
    for _ in range(10):
        before = path.position.copy()
        path.advance(0.02)
        speeds.append((path.position - before)[0] / 0.02)
    assert np.all(np.diff(speeds) < 0.0)
    assert path.position == pytest.approx([0.55, 0.275])
    assert not path.moving
    assert np.all(path.velocity == 0.0)
    path.follow([[0.0, 0.0]], [2.0])
    path.advance(3.0)
    assert path.position == pytest.approx([0.0, 0.0])


def test_a_brake_before_the_end_and_one_without_a_way_are_harmless():
    path = JointPath([0.0, 0.0], LIMITS)
    path.brake(0.2)
    path.follow([[0.01, 0.0]], [0.1])
    path.advance(0.05)
    path.brake(10.0)
    path.brake(10.0)
    path.advance(1.0)
    assert path.position == pytest.approx([0.01, 0.0])
    assert not path.moving
