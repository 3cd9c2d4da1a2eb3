"""What the report takes from a scan, and when it holds the robot for stuck."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from support.report_rig import scan
from yarm.exploration.model import Observation
from yarm.exploration.report.view import DEFAULTS, Room, Track, View, Watcher, room_of
from yarm.geometry import Pose2
from yarm.geometry.scans import Odometry


def test_sides_and_centre() -> None:
    assert room_of(scan(1.0, left=2.0, right=3.0)) == Room(1.0, 1.0, 1.0)
    wide = scan(1.0, left=0.75, right=0.5)
    assert room_of(wide) == Room(1.0, 0.75, 0.5)


@pytest.mark.parametrize("ahead", [0.4, 5.5, math.nan])
def test_too_near_too_far_and_nothing_look_alike(ahead: float) -> None:
    assert room_of(scan(ahead)).centre == math.inf


def test_the_program_sees_beyond_five_metres() -> None:
    assert room_of(scan(5.5), valid_m=math.inf).centre == pytest.approx(5.5)


def test_a_side_without_a_valid_beam_is_a_hundred_metres() -> None:
    seen = room_of(scan(math.nan, left=math.nan, right=1.5))
    assert seen.left == DEFAULTS.nothing and seen.right == pytest.approx(1.5)


def test_the_outermost_beams_on_the_left_do_not_count() -> None:
    seen = scan(2.0)
    seen.ranges[-20:] = 0.6
    assert room_of(seen).left == pytest.approx(2.0)
    seen.ranges[-21] = 0.6
    assert room_of(seen).left == pytest.approx(0.6)


def test_a_lone_nan_is_mended_as_the_text_has_it_and_not_in_the_program() -> None:
    seen = scan(math.nan, left=math.nan, right=math.nan)
    middle = len(seen.ranges) // 2
    seen.ranges[middle - 1 : middle + 2] = (0.3, math.nan, 1.3)
    seen.ranges[middle + 1] = 0.9
    assert room_of(seen).centre == pytest.approx(0.6), "the mean of a neighbour too near to count, and 0.9"
    assert room_of(seen, mend_single=False).centre == pytest.approx(0.9)
    seen.ranges[middle - 1] = math.nan
    assert room_of(seen).centre == pytest.approx(0.9), "two together stay"


def test_a_scan_without_beams_shows_nothing() -> None:
    empty = dataclasses.replace(scan(1.0), ranges=np.empty(0, np.float32))
    assert room_of(empty) == Room()


def test_before_scan_and_odometry_there_is_no_view() -> None:
    watcher = Watcher()
    assert watcher.look(Observation(0.0, scan=scan(1.0))) is None
    assert watcher.look(Observation(0.0, Odometry(0.0, Pose2(0.0, 0.0)))) is None
    view = watcher.look(Observation(0.1, Odometry(0.1, Pose2(0.0, 0.0, 3.0)), None, scan(1.0)))
    assert view is not None and view.turned_rad == 0.0
    view = watcher.look(Observation(0.2, Odometry(0.2, Pose2(0.0, 0.0, -3.0)), None, scan(1.0)))
    assert view is not None and view.turned_rad == pytest.approx(2 * math.pi - 6.0)


def track(v_mps: float, w_radps: float, driven_mps: float, turned_radps: float) -> Track:
    told = Track(15.0)
    for i in range(200):
        odom = Pose2(0.1 * i * driven_mps, 0.0)
        told.add(View(Observation(0.1 * i), 0.1 * i, odom, Room(), 0.1 * turned_radps), v_mps, w_radps)
    return told


@pytest.mark.parametrize(
    "v, w, driven, turned, stuck",
    [
        (0.2, 0.0, 0.2, 0.0, False),
        (0.2, 0.0, 0.01, 0.0, True),
        (0.0, -0.4, 0.0, -0.4, False),
        (0.0, -0.4, 0.0, -0.01, True),
        (0.0, 0.0, 0.0, 0.0, False),
    ],
)
def test_stuck_is_told_to_move_and_hardly_moving(v: float, w: float, driven: float, turned: float, stuck: bool) -> None:
    assert track(v, w, driven, turned).hardly_moved(0.3, 0.3) is stuck


def test_less_than_a_window_is_no_evidence() -> None:
    short = Track(15.0)
    for i in range(100):
        short.add(View(Observation(0.1 * i), 0.1 * i, Pose2(0.0, 0.0), Room()), 0.2, 0.0)
    assert not short.hardly_moved(0.3, 0.3)
