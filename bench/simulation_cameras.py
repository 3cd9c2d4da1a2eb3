#!/usr/bin/env python3
"""Milliseconds for one camera set (four 320 x 320 depth clouds), beside PyBullet's TinyRenderer in the same run.

    python3 bench/simulation_cameras.py

CPU time of one core, median of several sets. Also how it grows with robots, and, for Embree, with triangles.
"""

from __future__ import annotations

import statistics
import time
from typing import Callable, List, Tuple

import numpy as np
import pybullet

from yarm.geometry.urdf import Solid
from yarm.sim.camera_model import KINECT, Rays
from yarm.sim.cameras import Eyes
from yarm.sim.meshes import sphere_triangles
from yarm.sim.rays_embree import EmbreeRays, EmbreeSolid
from yarm.sim.rays_native import NativeRays, library_path
from yarm.sim.scene import Scene, load_scene, scene_from
from yarm.sim.world import World

SPOTS = ((2.0, 1.9, 180), (-2.0, 1.9, 0), (2.0, -1.9, 180), (-2.0, -1.9, 0), (2.0, 0.9, 180), (2.0, -0.9, 180))


def milliseconds(work: Callable[[], object], repeats: int = 15) -> float:
    """Median CPU milliseconds of a piece of work, after one warming up."""
    work()
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        times.append(1e3 * (time.process_time() - start))
    return statistics.median(times)


def camera_set(world: World, rays: Rays) -> float:
    """One set of clouds with noise."""
    eyes = Eyes(1, True, rays)
    eyes.look_at(world.bodies, world.transforms())
    transforms = world.transforms()
    return milliseconds(lambda: [eyes.overhead_cloud(camera, transforms, 1) for camera in (1, 2, 3, 4)])


def tiny_renderer(world: World) -> float:
    """Four images of PyBullet's software renderer: pictures and depth buffers only, no clouds, no noise."""
    lens = pybullet.computeProjectionMatrixFOV(135.0, 1.0, 0.1, 10.0)
    poses = Eyes(1, False).overhead_poses
    views = [pybullet.computeViewMatrix(p[:3, 3], p[:3, 3] + p[:3, 2], (0.0, 0.0, 1.0)) for p in poses]

    def draw() -> None:
        for view in views:
            pybullet.getCameraImage(
                KINECT.width, KINECT.height, view, lens,
                renderer=pybullet.ER_TINY_RENDERER, physicsClientId=world.client,
            )  # fmt: skip

    return milliseconds(draw, repeats=5)


def physics(world: World) -> float:
    """The eight physics steps of a camera frame, with contacts gathered."""
    return milliseconds(lambda: (world.tick(), world.tick()), repeats=60)


def robots_scene(n: int) -> Scene:
    """N robots and the HC10."""
    robots = [
        {"name": f"ankurbot_{i + 1}", "type": "ankurbot", "x": x, "y": y, "heading_deg": heading}
        for i, (x, y, heading) in enumerate(SPOTS[:n])
    ]
    return scene_from(
        {"name": f"{n}", "robots": robots, "manipulators": [{"name": "hc10_barc", "type": "hc10"}]}, "bench"
    )


def triangles_table() -> List[Tuple[int, float]]:
    """Embree: 20 000 rays against one ball of more and more triangles."""
    directions = KINECT.directions().reshape(-1, 3)[40000:60000]
    rows = []
    for n in (1, 8, 32):
        corners = np.concatenate([sphere_triangles(0.5 + 0.001 * k) for k in range(n)])
        solid = EmbreeSolid(Solid("sphere", (0.5,), "ball", np.eye(4)), corners)
        origin = np.array([0.0, 0.0, -2.0], dtype=np.float32)
        rows.append((len(corners), milliseconds(lambda: solid.cast(origin, directions))))  # noqa: B023
    return rows


def main() -> None:
    """Print the tables."""
    path = library_path()
    with World(load_scene("3m")) as world:
        world.run(0.2)
        print("scene 3m (3 robots, HC10, table, stand), CPU ms for one set of four 320 x 320 cameras:")
        tiny = tiny_renderer(world)
        rows = [
            ("PyBullet TinyRenderer (no clouds, no noise)", tiny),
            ("Embree (Python)", camera_set(world, EmbreeRays())),
        ]
        if path is not None:
            rows.append(("C++ primitives (what runs)", camera_set(world, NativeRays(path))))
        for name, value in rows:
            print(f"  {name:45s} {value:8.2f} ms   {tiny / value:6.1f} x")
        print(f"  {'physics, 8 steps of 1/240 s':45s} {physics(world):8.2f} ms")
    print("growth with robots (HC10 besides), ms a set and ms of physics a frame:")
    for n in range(len(SPOTS) + 1):
        with World(robots_scene(n)) as world:
            world.run(0.1)
            best = NativeRays(path) if path is not None else EmbreeRays()
            print(f"  {n} robots {camera_set(world, best):8.2f} ms {physics(world):8.2f} ms")
    print("growth with triangles (Embree, 20 000 rays against one body):")
    for n, value in triangles_table():
        print(f"  {n:7d} triangles {value:8.2f} ms")


if __name__ == "__main__":
    main()
