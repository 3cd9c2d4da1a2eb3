"""The watch names a camera that is off, and no other. ``-s`` prints the figures of the docs."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))
from camera_samples import CAMERAS, apart, cell, off_by

from yarm.calibration.extrinsics import pick
from yarm.calibration.watch import ExtrinsicsWatch, WatchLimits

LIMITS = WatchLimits(window_s=6.0)
POINTS, PERIOD_S = 1000, 1.0


@pytest.fixture(scope="module")
def simulated():
    return cell("1m1ma")


def looked(cloud, simulated, told, rng):
    """What the watch sees of a cloud."""
    return cloud[pick(cloud, told, simulated.static, rng, POINTS)]


def judged(simulated, camera, told, first, clouds=6):
    """The word after so many clouds, a second apart."""
    watch, rng = ExtrinsicsWatch(LIMITS), np.random.default_rng(first)
    for k in range(clouds):
        watch.see(PERIOD_S * k, looked(simulated.cloud(camera, first + k), simulated, told, rng), told)
    return watch.judge(simulated.static, simulated.moving)


@pytest.mark.parametrize("camera", CAMERAS)
def test_a_camera_that_is_right_is_not_named(simulated, camera):
    for first in (0, 100, 200):
        word = judged(simulated, camera, simulated.true_pose(camera), first)
        assert word.known
        assert not word.off, word.text
        sys.stdout.write(f"\nright: camera {camera}: significance {word.refined.significance:.1f}")


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize(("shift_m", "turn_deg"), [(0.0, 0.5), (0.01, 0.0), (0.05, 2.0)])
def test_one_that_is_off_is_named_with_its_correction(simulated, camera, shift_m, turn_deg):
    true = simulated.true_pose(camera)
    for seed in (1, 2):
        told = off_by(true, np.random.default_rng(10 * camera + seed), shift_m, turn_deg)
        word = judged(simulated, camera, told, 300 * seed)
        assert word.off, word.text
        off_m, off_deg = apart(true, word.refined.pose)
        sys.stdout.write(
            f"\n{1000 * shift_m:.0f} mm, {turn_deg} deg: camera {camera}: corrected to {1000 * off_m:.1f} mm, "
            f"{off_deg:.2f} deg, significance {word.refined.significance:.0f}"
        )
        assert off_m < max(0.015, shift_m)
        assert off_deg < max(0.2, 0.5 * turn_deg)
        assert "deg from where it is told to be" in word.text


def test_a_camera_that_is_pushed_is_named_once_its_old_points_are_gone(simulated):
    """Told where it was: it is the camera that has moved."""
    camera, seconds = 3, 12
    told = simulated.true_pose(camera)
    watch, rng = ExtrinsicsWatch(LIMITS), np.random.default_rng(5)
    moved = off_by(np.eye(4), rng, 0.0, 0.5)
    named = []
    for second in range(seconds):
        cloud = simulated.cloud(camera, second)
        cloud = cloud @ moved[:3, :3].T if second >= 3 else cloud
        watch.see(float(second), looked(cloud, simulated, told, rng), told)
        if second >= 3 and watch.judge(simulated.static, simulated.moving).off:
            named.append(second - 3)
    assert named
    assert named[0] <= 7


def test_nothing_is_said_of_few_clouds_and_after_a_new_word(simulated):
    word = judged(simulated, 1, simulated.true_pose(1), 0, clouds=2)
    assert not word.known
    assert word.text == "2 clouds, 3 are needed"
    watch, rng = ExtrinsicsWatch(LIMITS), np.random.default_rng(1)
    true = simulated.true_pose(1)
    told = off_by(true, rng, 0.0, 1.0)
    for k in range(10):
        now = told if k < 8 else true
        watch.see(float(k), looked(simulated.cloud(1, k), simulated, now, rng), now)
    assert watch.judge(simulated.static, simulated.moving).text == "2 clouds, 3 are needed"
    watch.see(1.0, np.ones((5, 3)), true)
    assert watch.judge(simulated.static, simulated.moving).text == "1 clouds, 3 are needed", "time went back"
