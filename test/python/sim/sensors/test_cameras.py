"""Clouds agree with the world: PyBullet's own ray test is the independent oracle."""

from __future__ import annotations

import hashlib
import math
from typing import Iterator, List, Tuple

import numpy as np
import pybullet
import pytest

from yarm.geometry import transform_points
from yarm.sim.engine.world import SimWorld
from yarm.sim.scenes.scene import load_scene
from yarm.sim.scenes.specs import ThingSpec
from yarm.sim.sensors.camera_model import FAR, KINECT, WRIST, Rays, looking_at
from yarm.sim.sensors.cameras import Eyes
from yarm.sim.sensors.noise import NormalPool, axial_sigma
from yarm.sim.sensors.rays_embree import EmbreeRays
from yarm.sim.sensors.rays_native import NativeRays, _library, library_path

BUILT = library_path()
BACKENDS: List[Rays] = [EmbreeRays()] + ([NativeRays(BUILT)] if BUILT else [])


@pytest.fixture(scope="module")
def world() -> Iterator[SimWorld]:
    with SimWorld(load_scene("2m1ma")) as world:
        world.spawn(ThingSpec("debris_1", "Debris", -0.15, 0.2, 0.75, 0.3))
        world.spawn(ThingSpec("box", "Obstacle", 0.3, -1.9, 0.25, 0.5, (0.3, 0.4, 0.5)))
        world.run(0.5)
        yield world


def eyes_on(world: SimWorld, noise: bool, rays: Rays, seed: int = 7) -> Eyes:
    eyes = Eyes(seed, noise, rays)
    eyes.look_at(world.bodies, world.transforms())
    return eyes


def oracle(world: SimWorld, T_world_optical: np.ndarray, rays: np.ndarray, far_m: float) -> np.ndarray:
    """Depth of PyBullet's own ray test, FAR where nothing is hit; rays (n, 3) with z component 1, optical frame."""
    ends = transform_points(T_world_optical, rays * far_m)
    starts = np.broadcast_to(T_world_optical[:3, 3], ends.shape)
    hits = []
    for i in range(0, len(ends), 4000):
        hits += pybullet.rayTestBatch(
            starts[i : i + 4000].tolist(), ends[i : i + 4000].tolist(), physicsClientId=world.client
        )
    return np.array([FAR if hit[0] < 0 else hit[2] * far_m for hit in hits])


@pytest.mark.parametrize("rays", BACKENDS, ids=lambda rays: type(rays).__name__)
@pytest.mark.parametrize("camera", [1, 2, 4])
def test_depth_agrees_with_the_engines_own_rays(world: SimWorld, rays: Rays, camera: int) -> None:
    eyes = eyes_on(world, False, rays)
    image = eyes.overhead_image(camera, world.transforms())
    choice = np.random.default_rng(camera).permutation(KINECT.pixels)[:6000]
    directions = KINECT.directions().reshape(-1, 3)[choice].astype(float)
    true = oracle(world, eyes.overhead_poses[camera - 1], directions, 10.5)
    ours = image.depth.reshape(-1)[choice]
    both = (true < 10.0) & (ours < 10.0)
    # One pixel in a thousand may fall on the other side of an edge; the engine's shapes have a margin of 1 mm.
    assert np.mean((true < 10.0) != (ours < 10.0)) < 1e-3
    error = np.abs(true - ours)[both]
    assert np.mean(error > 0.006) < 2e-3
    on_body = both & (image.rgb.reshape(-1)[choice] != 0x8A8A86)
    assert np.count_nonzero(on_body) > 50
    assert np.median(np.abs(true - ours)[on_body]) < 0.002


@pytest.mark.skipif(BUILT is None, reason="the C++ library is not built")
def test_the_two_ways_of_casting_agree(world: SimWorld) -> None:
    first, second = (eyes_on(world, False, rays) for rays in BACKENDS)
    for camera in (1, 2, 3, 4):
        a, b = first.overhead_image(camera, world.transforms()), second.overhead_image(camera, world.transforms())
        error = np.abs(a.depth - b.depth)
        assert np.mean(error > 0.005) < 1e-4
        assert np.mean(a.rgb != b.rgb) < 1e-4
        assert np.mean(np.abs(a.sigma - b.sigma) > 0.002) < 1e-3
    optical = world.transforms()["hc10_barc/wrist_camera_optical_frame"]
    a_cloud = first.wrist_cloud(optical, world.transforms(), 1).copy()
    b_cloud = second.wrist_cloud(optical, world.transforms(), 1)
    assert np.mean(np.isfinite(a_cloud["z"]) != np.isfinite(b_cloud["z"])) < 1e-3


@pytest.mark.skipif(BUILT is None, reason="the C++ library is not built")
def test_the_two_noise_models_agree() -> None:
    for depth in (0.5, 1.0, 3.0, 8.0):
        for cosine in (1.0, -0.7, 0.49, 0.2, 0.01, 0.0):
            python = float(axial_sigma(np.float32(depth), np.float32(cosine)))
            assert _library(BUILT).yarmRaysSigma(depth, cosine) == pytest.approx(python, rel=1e-3)


@pytest.mark.parametrize("rays", BACKENDS, ids=lambda rays: type(rays).__name__)
def test_points_lie_on_the_surfaces_within_the_sensors_noise(world: SimWorld, rays: Rays) -> None:
    clean, noisy = eyes_on(world, False, rays), eyes_on(world, True, rays)
    image = clean.overhead_image(1, world.transforms())
    cloud = noisy.overhead_cloud(1, world.transforms(), 3)
    assert cloud.shape == (320, 320) and cloud.dtype.itemsize == 16
    seen = np.isfinite(cloud["z"])
    assert np.array_equal(np.isfinite(cloud["x"]), seen) and np.array_equal(np.isfinite(cloud["y"]), seen)
    assert cloud["z"][seen].min() >= 0.5 and cloud["z"][seen].max() <= 10.0
    scaled = ((cloud["z"] - image.depth) / np.maximum(image.sigma, 1e-6))[
        seen & (image.depth < 9.5) & (image.depth > 0.6)
    ]
    assert abs(float(scaled.mean())) < 0.02
    assert float(scaled.std()) == pytest.approx(1.0, abs=0.02)
    assert float(np.mean(np.abs(scaled) > 3.0)) == pytest.approx(0.0027, abs=0.0015)
    rows, columns = np.nonzero(seen)
    u = (columns + 0.5 - 160.0) / KINECT.focal_px
    v = (rows + 0.5 - 160.0) / KINECT.focal_px
    assert cloud["x"][seen] == pytest.approx(u * cloud["z"][seen], rel=1e-4, abs=1e-5)
    assert cloud["y"][seen] == pytest.approx(v * cloud["z"][seen], rel=1e-4, abs=1e-5)


@pytest.mark.parametrize("rays", BACKENDS, ids=lambda rays: type(rays).__name__)
def test_nothing_nearer_than_the_range_or_farther(world: SimWorld, rays: Rays) -> None:
    eyes = eyes_on(world, False, rays)
    cloud = eyes.overhead_cloud(1, world.transforms(), 0)
    assert np.isnan(cloud["z"][0]).all()  # the horizon is below the image's upper edge
    low = looking_at((1.0, 2.3, 0.30), (1.0, 2.3 + 1e-3, 0.0))
    image = eyes._overhead[0].__class__(KINECT, rays)
    solids = eyes._all
    seen = image.cloud(image.render(low, solids, solids.poses(world.transforms())), None)
    assert np.isnan(seen["z"]).mean() > 0.99  # the floor is 0.30 m away


def test_optical_frames_are_x_right_y_down_z_forward() -> None:
    pose = looking_at((3.0, 0.0, 2.0), (0.0, 0.0, 0.3))
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1.0)
    assert pose[:3, 0] == pytest.approx([0.0, 1.0, 0.0], abs=1e-12)  # looking along -x, right is +y
    assert pose[2, 1] < 0.0 and pose[0, 2] < 0.0
    assert KINECT.focal_px == pytest.approx(160.0 / math.tan(math.radians(67.5)))
    assert WRIST.width * WRIST.height == 76800


def test_noise_is_the_kinects() -> None:
    table = {0.5: 0.0012, 1.0: 0.0019, 2.0: 0.0061, 3.0: 0.0140, 4.0: 0.0258, 5.0: 0.0414}
    for depth, sigma in table.items():
        assert float(axial_sigma(np.float32(depth), np.float32(1.0))) == pytest.approx(sigma, abs=6e-5)
    square = float(axial_sigma(np.float32(2.0), np.float32(1.0)))
    grazing = float(axial_sigma(np.float32(2.0), np.float32(math.cos(math.radians(80.0)))))
    assert grazing > square + 0.003


def test_the_pool_is_seeded_and_differs_by_camera_and_frame() -> None:
    pool, same, other = NormalPool(5), NormalPool(5), NormalPool(6)
    numbers = pool.take(102400, 1, 10)
    assert np.array_equal(numbers, same.take(102400, 1, 10))
    for different in (pool.take(102400, 2, 10), pool.take(102400, 1, 11), other.take(102400, 1, 10)):
        assert abs(float(np.corrcoef(numbers, different)[0, 1])) < 0.02
    assert float(numbers.mean()) == pytest.approx(0.0, abs=0.02)
    assert float(numbers.std()) == pytest.approx(1.0, abs=0.02)


def clouds_hash(frames: int) -> Tuple[str, str]:
    """Hash of the poses and of the clouds of a short run with a moving robot."""
    poses, clouds = hashlib.sha256(), hashlib.sha256()
    with SimWorld(load_scene("2m1ma")) as world:
        eyes = Eyes(2, True)
        eyes.look_at(world.bodies, world.transforms())
        for frame in range(frames):
            world.robots["ankurbot_1"].drive(0.6 * math.sin(0.05 * frame), 0.0, 5.0)
            world.tick()
            world.tick()
            for matrix in world.transforms().values():
                poses.update(matrix.tobytes())
            for camera in (1, 2, 3, 4):
                clouds.update(eyes.overhead_cloud(camera, world.transforms(), frame).tobytes())
    return poses.hexdigest(), clouds.hexdigest()


def test_the_same_run_gives_the_same_bytes() -> None:
    assert clouds_hash(12) == clouds_hash(12)
