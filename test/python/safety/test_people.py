"""Where somebody who moves by himself may be, and how far a robot must be from him."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from yarm.geometry import Pose2
from yarm.geometry.solids import Shape, Solid, surface_points
from yarm.safety.clearance import Body, Disc, Foresight, Motion
from yarm.safety.monitor import Monitor, Seen
from yarm.safety.params import SafetyParams
from yarm.safety.people import NOBODY, Tracked, Walking, disc_of, people_among, separation, sigma_of

WALKING = Walking()
MAN = Tracked(3, (1.0, 0.0, 0.85), (0.0, 0.0), (0.3, 0.4, 1.7), 0.0, 0.0, 5.0, 10.0)
ROBOT = surface_points([Solid(Shape.BOX, (1.3, 0.08, 0.08), np.eye(4))], 0.08)
HEIGHT = 0.89
TARGET = Pose2(3.0, 0.0)


@pytest.mark.parametrize(
    ("age_s", "speed", "sigma", "bound"),
    [
        (0.0, 0.0, 0.0, 1.6),
        (0.5, 0.0, 0.0, 0.8),
        (1.0, 0.0, 0.0, 0.0),
        (5.0, 0.29, 0.1, 0.0),
        (5.0, 0.5, 0.1, 0.7),
        (0.5, 1.0, 0.0, 1.3),
        (0.0, 2.0, 0.1, 2.2),
        (5.0, 2.0, 0.1, 2.2),
    ],
)
def test_whoever_is_first_seen_may_walk_and_is_then_as_fast_as_he_is_seen_to_be(age_s, speed, sigma, bound):
    seen = replace(MAN, age_s=age_s, velocity_mps=(0.6 * speed, 0.8 * speed), speed_sigma_mps=sigma)
    assert WALKING.bound_mps(seen) == pytest.approx(bound)


def test_a_disc_holds_his_box_his_walk_any_way_and_what_is_not_known_of_his_place():
    seen = replace(MAN, velocity_mps=(0.0, 0.9), speed_sigma_mps=0.05, place_sigma_m=0.02)
    disc = disc_of(seen, WALKING)
    rng = np.random.default_rng(1)
    for angle in rng.uniform(-math.pi, math.pi, 40):
        off = rng.uniform((-0.15, -0.2, 0.0), (0.15, 0.2, 1.7))
        walked = 0.9 * 0.7 * np.array([math.cos(angle), math.sin(angle), 0.0])
        assert disc.distance((np.array([1.0, 0.0, 0.0]) + off + walked)[None], 0.7) < 0.0
    assert disc.radius_m == pytest.approx(0.25 + 0.04)
    assert disc.distance(np.array([[1.0, 0.0, 1.9]]), 0.0) == pytest.approx(0.2)
    assert disc.distance(np.array([[2.0, 0.0, 0.5]]), 1.0) == pytest.approx(1.0 - 0.29 - 1.0)


def test_who_is_followed_moves_by_his_track_alone_and_others_by_the_map():
    boxes = np.array([[0.8, -0.2, 0.0, 1.2, 0.2, 1.7]])
    walker, other = Body("unknown_3", (), boxes, (1.0, 0.0), 0.05), Body("unknown_4", (), boxes, (0.5, 0.0), 0.05)
    seen = replace(MAN, velocity_mps=(0.9, 0.0))
    found = people_among([walker, other], [seen], WALKING, 10.1)
    assert found[1] is other
    assert (found[0].boxes is boxes, found[0].velocity_mps, found[0].age_s) == (True, (0.0, 0.0), pytest.approx(0.1))
    assert found[0].disc == disc_of(seen, WALKING)
    stands = people_among([walker], [MAN], WALKING, 10.1)[0]
    assert stands.disc is None and stands.boxes is boxes


def test_who_is_followed_and_not_on_the_map_counts_too():
    (hidden,) = people_among([], [MAN], WALKING, 10.1)
    assert hidden.name == "unknown_3" and hidden.disc is not None and hidden.boxes is None


def test_the_separation_is_the_way_of_both_until_the_robot_stands_and_a_clearance():
    """ISO/TS 15066: 1.6 m/s x (0.1 + 0.2 + 1 / 1.5) s + 1 m/s x 0.2 s + 1 / (2 x 1.5) m + 0.03 m."""
    person = Body("unknown_3", (), None, age_s=0.1, disc=Disc(3.0, 0.0, 0.25, 1.7, 1.6))
    apart = separation(np.array([[0.0, 0.0, 0.9]]), Motion(1.0), person, Foresight(), 0.03)
    assert apart.who == "unknown_3" and apart.distance_m == pytest.approx(2.75)
    assert apart.required_m == pytest.approx(1.6 * (0.3 + 2.0 / 3.0) + 0.2 + 1.0 / 3.0 + 0.03)
    still = separation(np.array([[0.0, 0.0, 0.9]]), Motion(), person, Foresight(), 0.03)
    assert still.required_m == pytest.approx(1.6 * 0.3 + 0.03)
    assert separation(ROBOT, Motion(1.0), Body("table"), Foresight(), 0.03) is NOBODY


def verdict_on(person, moves=True):
    """Of a robot on its way along x at 1 m/s, or standing there without a goal."""
    monitor, said = Monitor(SafetyParams()), None
    for i in range(3):
        pose = Pose2(i / 30.0 if moves else 0.0, 0.0)
        seen = Seen(pose, HEIGHT, ROBOT, TARGET if moves else None, "g" if moves else "")
        said = monitor.look(i / 30.0, {"r": seen}, {"r": [person]})["r"]
    return said


@pytest.mark.parametrize("angle_deg", [0.0, 45.0, 90.0])
def test_a_robot_stops_for_one_who_may_reach_it_from_any_side_before_it_stands(angle_deg):
    x, y = 1.2 + 1.4 * math.cos(math.radians(angle_deg)), 1.4 * math.sin(math.radians(angle_deg))
    for speed, stops in ((1.6, True), (0.3, False)):
        person = Body("unknown_3", (), None, age_s=0.1, disc=Disc(x, y, 0.25, 1.7, speed))
        said = verdict_on(person)
        assert said.held is stops, (speed, said)
        assert said.apart.who == "unknown_3"
        assert not stops or said.apart.room_m < 0.3


def test_a_robot_that_stands_is_not_stopped_and_still_says_how_near_somebody_is():
    person = Body("unknown_3", (), None, age_s=0.1, disc=Disc(1.2, 0.0, 0.25, 1.7, 1.6))
    said = verdict_on(person, moves=False)
    assert not said.held and said.apart.distance_m == pytest.approx(1.2 - 0.25 - 0.65, abs=0.05)


def test_who_is_far_stops_nobody():
    assert not verdict_on(Body("unknown_3", (), None, age_s=0.1, disc=Disc(4.5, 0.0, 0.25, 1.7, 1.6))).held


def test_the_greatest_deviation_of_a_covariance():
    assert sigma_of(np.array([[0.04, 0.0], [0.0, 0.01]])) == pytest.approx(0.2)
    assert sigma_of(np.array([[0.05, 0.04], [0.04, 0.05]])) == pytest.approx(0.3)
