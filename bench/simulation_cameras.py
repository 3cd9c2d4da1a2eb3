#!/usr/bin/env python3
"""Milliseconds for one camera set (four 320 x 320 depth clouds), beside PyBullet's TinyRenderer in the same run.

    python3 bench/simulation_cameras.py [--plot results/bench/simulation_cameras.png]

CPU time of one core, median and 99th percentile over many sets. Also how it grows with robots, and, for Embree, with
triangles. Every single time goes to ``bench/data/simulation_cameras.csv``.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Tuple

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pybullet
import raw_rows

from yarm.geometry.solids import Shape, Solid
from yarm.sim.engine.world import SimWorld
from yarm.sim.scenes.scene import Scene, load_scene, scene_from
from yarm.sim.sensors.camera_model import KINECT, Rays
from yarm.sim.sensors.cameras import Eyes
from yarm.sim.sensors.meshes import sphere_triangles
from yarm.sim.sensors.rays_embree import EmbreeRays, EmbreeSolid
from yarm.sim.sensors.rays_native import NativeRays, library_path

ROOT = Path(__file__).resolve().parents[1]
SPOTS = ((2.0, 1.9, 180), (-2.0, 1.9, 0), (2.0, -1.9, 180), (-2.0, -1.9, 0), (2.0, 0.9, 180), (2.0, -0.9, 180))


@dataclass(frozen=True)
class Times:
    """CPU milliseconds, one after the other."""

    each_ms: Tuple[float, ...]

    @property
    def p50(self) -> float:
        """Median."""
        return float(np.percentile(self.each_ms, 50))

    @property
    def p99(self) -> float:
        """99th percentile."""
        return float(np.percentile(self.each_ms, 99))

    def __str__(self) -> str:
        return f"{self.p50:8.2f} {self.p99:8.2f} ms"

    def rows(self, scene: str, what: str) -> List[Dict[str, Any]]:
        """A row a repeat."""
        return [
            {"scene": scene, "what": what, "repeat": repeat, "cpu_ms": f"{ms:.3f}"}
            for repeat, ms in enumerate(self.each_ms)
        ]


def measured(work: Callable[[], object], repeats: int) -> Times:
    """Times of a piece of work, after one warming up."""
    work()
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        times.append(1e3 * (time.process_time() - start))
    return Times(tuple(times))


def camera_set(world: SimWorld, rays: Rays, repeats: int = 200) -> Times:
    """One set of clouds with noise."""
    eyes = Eyes(1, True, rays)
    eyes.look_at(world.bodies, world.transforms())
    transforms = world.transforms()
    return measured(lambda: [eyes.overhead_cloud(camera, transforms, 1) for camera in (1, 2, 3, 4)], repeats)


def tiny_renderer(world: SimWorld) -> Times:
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

    return measured(draw, 30)


def physics(world: SimWorld) -> Times:
    """The eight physics steps of a camera frame, with contacts gathered."""
    return measured(lambda: (world.tick(), world.tick()), 200)


def robots_scene(n: int) -> Scene:
    """N robots and the HC10."""
    robots = [
        {"name": f"ankurbot_{i + 1}", "type": "ankurbot", "x": x, "y": y, "heading_deg": heading}
        for i, (x, y, heading) in enumerate(SPOTS[:n])
    ]
    return scene_from(
        {"name": f"{n}", "robots": robots, "manipulators": [{"name": "hc10_barc", "type": "hc10"}]}, "bench"
    )


def triangles_table() -> List[Tuple[int, Times]]:
    """Embree: 20 000 rays against one ball of more and more triangles."""
    directions = KINECT.directions().reshape(-1, 3)[40000:60000]
    rows = []
    for n in (1, 8, 32):
        corners = np.concatenate([sphere_triangles(0.5 + 0.001 * k) for k in range(n)])
        solid = EmbreeSolid(Solid(Shape.SPHERE, (0.5,), np.eye(4)), corners)
        origin = np.array([0.0, 0.0, -2.0], dtype=np.float32)
        rows.append((len(corners), measured(lambda: solid.cast(origin, directions), 50)))  # noqa: B023
    return rows


def compare(path: Optional[Path]) -> List[Dict[str, Any]]:
    """Print what one set costs each renderer; the raw rows."""
    with SimWorld(load_scene("3m")) as world:
        world.run(0.2)
        tiny = tiny_renderer(world)
        rows = [
            ("PyBullet TinyRenderer (no clouds, no noise)", tiny),
            ("Embree (Python)", camera_set(world, EmbreeRays(), 50)),
        ]
        if path is not None:
            rows.append(("C++ primitives (what runs)", camera_set(world, NativeRays(path))))
        steps = physics(world)
        print("scene 3m (3 robots, HC10, table, stand), CPU for one set of four 320 x 320 cameras, p50 and p99:")
        for name, times in rows:
            print(f"  {name:45s} {times}   {tiny.p50 / times.p50:6.1f} x")
        print(f"  {'physics, 8 steps of 1/240 s':45s} {steps}")
    return [row for name, times in [*rows, ("physics", steps)] for row in times.rows("3m", name)]


def growth(path: Optional[Path]) -> List[Tuple[Times, Times]]:
    """Times of a camera set and of a frame's physics with 0, 1, ... robots beside the HC10."""
    rows = []
    for n in range(len(SPOTS) + 1):
        with SimWorld(robots_scene(n)) as world:
            world.run(0.1)
            rows.append((camera_set(world, NativeRays(path) if path is not None else EmbreeRays()), physics(world)))
    return rows


def plot(rows: List[Tuple[Times, Times]], path: Path) -> None:
    """Draw the growth with robots."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure, axes = plt.subplots(figsize=(6.4, 4.0))
    for i, (label, marker) in enumerate((("four depth clouds", "o"), ("physics of a frame (8 steps)", "s"))):
        times = [row[i] for row in rows]
        (line,) = axes.plot([t.p50 for t in times], marker=marker, label=f"{label}, p50")
        axes.plot([t.p99 for t in times], linestyle=":", color=line.get_color(), label=f"{label}, p99")
    axes.set(xlabel="robots beside the HC10", ylabel="CPU ms a camera set", ylim=(0.0, None))
    axes.grid(alpha=0.3)
    axes.legend()
    figure.tight_layout()
    figure.savefig(path, dpi=100)
    plt.close(figure)


def main() -> None:
    """Print the tables, draw the plot."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plot", type=Path, default=ROOT / "results" / "bench" / "simulation_cameras.png")
    options = parser.parse_args()
    path = library_path()
    raw = compare(path)
    rows = growth(path)
    print("growth with robots (HC10 besides), a set and the physics of a frame, p50 and p99 each:")
    for n, (clouds, steps) in enumerate(rows):
        print(f"  {n} robots {clouds} {steps}")
        raw += clouds.rows(f"{n} robots", "four clouds") + steps.rows(f"{n} robots", "physics")
    print("growth with triangles (Embree, 20 000 rays against one body), p50 and p99:")
    for n, times in triangles_table():
        print(f"  {n:7d} triangles {times}")
        raw += times.rows(f"{n} triangles", "Embree (Python), 20 000 rays")
    raw_rows.save(raw_rows.DATA / "simulation_cameras.csv", raw)
    plot(rows, options.plot)
    print(f"plot: {options.plot}")


if __name__ == "__main__":
    main()
