"""A camera that is off is brought to its place by what it sees of known bodies. ``-s`` prints the docs' figures."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))
from camera_samples import CAMERAS, apart, cell, off_by

from yarm.calibration.extrinsics import LEAST_POINTS, Refined, averaged, calibrated, pick, refine, sharpen
from yarm.calibration.surfaces import nearest_surface
from yarm.geometry import transform_points
from yarm.geometry.depth_noise import kinect_sigma

CLOUDS, POINTS, NEAR_POINTS = 30, 2000, 8000
SEEDS = (1, 2)
FAR_M, FAR_DEG = 0.05, 3.0
NEAR_M, NEAR_DEG = 0.005, 0.1


@pytest.fixture(scope="module")
def simulated():
    return cell("2m1ma")


def looked(simulated, camera, told, rng, clouds=CLOUDS, points=POINTS):
    """What of so many clouds is looked at, and its deviations."""
    seen = [simulated.cloud(camera, k) for k in range(clouds)]
    together = np.concatenate([cloud[pick(cloud, told, simulated.static, rng, points)] for cloud in seen])
    return together, kinect_sigma(together[:, 2])


@pytest.mark.parametrize("camera", CAMERAS)
def test_from_three_degrees_and_five_centimetres(simulated, camera):
    for seed in SEEDS:
        rng = np.random.default_rng(100 * camera + seed)
        true = simulated.true_pose(camera)
        told = off_by(true, rng, FAR_M, FAR_DEG)
        clouds = [simulated.cloud(camera, CLOUDS * seed + k) for k in range(CLOUDS)]
        refined = calibrated(clouds, told, simulated.static, simulated.moving, rng, NEAR_POINTS)
        assert refined.ok, refined.reason
        off_m, off_deg = apart(true, refined.pose)
        sys.stdout.write(
            f"\ncamera {camera}, seed {seed}: {1000 * off_m:.1f} mm, {off_deg:.3f} deg left; "
            f"sigma {1000 * refined.sigma_m:.1f} mm"
        )
        assert off_m <= NEAR_M
        assert off_deg <= NEAR_DEG
        assert refined.moved_m == pytest.approx(FAR_M, abs=NEAR_M)
        assert np.degrees(refined.turned_rad) == pytest.approx(FAR_DEG, abs=NEAR_DEG)
        assert refined.after_m < refined.before_m


def test_outlines_tell_what_no_face_does(simulated):
    """A camera in the table's plane of symmetry sees no face that tells where it is across; 8 mm off comes back."""
    camera, across = 4, np.array([0.0, 0.008, 0.0])
    rng = np.random.default_rng(6)
    true = simulated.true_pose(camera)
    points, sigmas = averaged([simulated.cloud(camera, k) for k in range(CLOUDS)])
    rows = pick(points, true, simulated.static, rng, NEAR_POINTS)
    shifted = true.copy()
    shifted[:3, 3] += across
    start = Refined(True, "", shifted)
    sharp = sharpen(start, points[rows], sigmas[rows], shifted, simulated.static, simulated.moving)
    assert apart(true, sharp.pose)[0] < 0.003
    assert sharp.moved_m == pytest.approx(0.008, abs=0.003)
    assert apart(true, sharp.pose)[0] < 3.0 * sharp.sigma_m < 0.015
    assert sharp.significance > 1.0


def test_outlines_alone_tell_and_their_deviation_says_so(simulated):
    """Not one point on a face that tells where it is across, as it happens to be: the outline still does."""
    camera = 4
    true = simulated.true_pose(camera)
    points, sigmas = averaged([simulated.cloud(camera, k) for k in range(CLOUDS)])
    rows = pick(points, true, simulated.static, np.random.default_rng(8), NEAR_POINTS)
    world = transform_points(true, points[rows])
    facing = np.abs(nearest_surface(world, simulated.static).normal[:, 1]) < 0.1
    points, sigmas = points[rows][facing], sigmas[rows][facing]
    faces = refine(points, sigmas, true, simulated.static, simulated.moving)
    assert faces.sigma_m > 0.05, "no face tells"
    sharp = sharpen(faces, points, sigmas, true, simulated.static, simulated.moving)
    assert sharp.sigma_m < 0.005
    assert apart(true, sharp.pose)[0] < 3.0 * sharp.sigma_m


def test_no_outline_is_told_of_a_bare_floor(simulated):
    true = simulated.true_pose(1)
    points, sigmas = averaged([simulated.cloud(1, k) for k in range(CLOUDS)])
    floor = np.flatnonzero(np.abs(transform_points(true, points)[:, 2]) < 0.01)[::10]
    told = Refined(True, "", true)
    assert sharpen(told, points[floor], sigmas[floor], true, ()).sigma_m > 0.05


def test_who_passes_through_a_few_pictures_is_left_out(simulated):
    """Somebody 0.5 m nearer in the same hundred pixels of 5 of 30 pictures."""
    clouds = [simulated.cloud(1, k) for k in range(CLOUDS)]
    alone = averaged(clouds)[0]
    some = np.flatnonzero(alone[:, 2] < 4.0)[:100]
    for cloud in clouds[:5]:
        cloud[some] *= 1.0 - 0.5 / np.linalg.norm(cloud[some], axis=1, keepdims=True)
    there = averaged(clouds)[0]
    assert np.nanmax(np.abs(there[some] - alone[some])) < 0.02
    others = np.setdiff1d(np.arange(len(alone)), some)
    assert np.array_equal(there[others], alone[others], equal_nan=True)


def test_a_pixel_that_is_seldom_seen_is_none(simulated):
    clouds = [simulated.cloud(1, k) for k in range(4)]
    pixel = np.flatnonzero(np.isfinite(clouds[0]).all(axis=1))[0]
    for cloud in clouds[:3]:
        cloud[pixel] = np.nan
    assert np.isnan(averaged(clouds)[0][pixel]).all()


def test_clouds_of_other_pixels_are_refused(simulated):
    clouds = [simulated.cloud(1, 0), simulated.cloud(1, 1)[:-5]]
    rng = np.random.default_rng(1)
    refined = calibrated(clouds, simulated.true_pose(1), simulated.static, simulated.moving, rng, NEAR_POINTS)
    assert not refined.ok
    assert refined.reason == "clouds of 102395 to 102400 points, organised ones are needed: the same pixels in each"


def test_a_camera_in_its_place_stays_there(simulated):
    rng = np.random.default_rng(9)
    true = simulated.true_pose(2)
    points, sigmas = looked(simulated, 2, true, rng)
    refined = refine(points, sigmas, true, simulated.static, simulated.moving)
    assert refined.significance < 3.0
    assert refined.moved_m < NEAR_M


def test_what_is_not_seen_is_left_to_what_was_told(simulated):
    """Above a bare floor nothing tells where along it a camera is: the deviation says so."""
    rng = np.random.default_rng(3)
    true = simulated.true_pose(1)
    told = off_by(true, rng, 0.0, 1.0)
    points, sigmas = looked(simulated, 1, told, rng, clouds=2)
    refined = refine(points, sigmas, told, ())
    assert refined.ok
    assert refined.sigma_m > 0.05
    assert abs(refined.pose[2, 3] - true[2, 3]) < 0.02, "its height is seen"


def test_too_few_points_are_said(simulated):
    told = simulated.true_pose(1)
    few = np.ones((LEAST_POINTS - 1, 3))
    refined = refine(few, np.ones(len(few)), told, simulated.static)
    assert not refined.ok
    assert refined.reason == "299 points, at least 300 near known surfaces are needed"
    nowhere = np.tile([0.0, 0.0, -50.0], (LEAST_POINTS, 1))
    assert (
        "0 points near known static surfaces" in refine(nowhere, np.ones(len(nowhere)), told, simulated.static).reason
    )


def test_the_points_near_solids_are_all_taken(simulated):
    rng = np.random.default_rng(4)
    told = simulated.true_pose(1)
    cloud = simulated.cloud(1, 0)
    picked = pick(cloud, told, simulated.static, rng, 100)
    assert len(picked) == 150
    assert np.isfinite(picked).all()
    assert len(pick(cloud, told, simulated.static, rng, 10**6)) == np.isfinite(cloud).all(axis=1).sum()
