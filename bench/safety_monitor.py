#!/usr/bin/env python3
"""What one look ahead of a robot costs the safety monitor, against looking at every point of it everywhere.

    source tools/env.sh && python3 bench/safety_monitor.py
    python3 bench/safety_monitor.py --case 3m6_bin --looks 500

Robots of a scene drive at random where their tips have 5 cm of room, which is where the monitor is asked all the time.
Both are given the same looks, in turns, in one process; the peer is the same distance of every point at every pose
ahead to every solid within half a metre. Prints milliseconds, p50 and p99, their ratio, and how far the distances that
both find are apart at most. Exit code 1: they differ by more than a nanometre.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from typing import List, Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray, Pose2
from yarm.geometry.solids import Solid, surface_points
from yarm.safety.clearance import Body, Foresight, Motion, Passing, coasting, distance, placed, room_ahead
from yarm.safety.params import SafetyParams
from yarm.sim.engine.world import SimWorld
from yarm.sim.scenes.scene import load_scene

SAME_M = 1e-9
SIGHT, PARAMS = Foresight(), SafetyParams()
Look = Tuple[Pose2, List[Passing]]


def cell(case: str) -> Tuple[FloatArray, float, List[Body]]:
    """Points of the first robot about its tip, the tip's height, and everything else, at the scene's start."""
    scene = load_scene(case)
    world = SimWorld(scene, hands=bool(scene.bins))
    poses = world.transforms()
    drawn = {
        body.name: tuple(
            Solid(item.solid.shape, item.solid.size, poses[item.frame] @ item.T_frame_solid) for item in body.solids
        )
        for body in world.bodies.values()
        if body.name != "floor"
    }
    robot = world.robots[scene.robots[0].name].body
    T_world_ee = poses[robot.seed_frame]
    own = [solid.seen_from(np.linalg.inv(T_world_ee)) for solid in drawn.pop(robot.name)]
    points, height_m = surface_points(own, PARAMS.spacing_m), float(T_world_ee[2, 3])
    return points[points[:, 2] + height_m > 0.02], height_m, [Body(name, solids) for name, solids in drawn.items()]


def every_point(points: FloatArray, height_m: float, passed: Sequence[Passing], bodies: Sequence[Body]) -> float:
    """Least distance ahead, metres."""
    ahead = np.concatenate([placed(points, each.pose, height_m) for each in passed])
    low, high = ahead.min(axis=0) - 0.5, ahead.max(axis=0) + 0.5
    return min(distance(ahead, body, low, high) for body in bodies)


def looks_of(points: FloatArray, height_m: float, bodies: Sequence[Body], count: int, seed: int) -> List[Look]:
    """Poses and what is ahead of them, where nothing is within 5 cm."""
    rng = np.random.default_rng(seed)
    found: List[Look] = []
    while len(found) < count:
        pose = Pose2(*rng.uniform(-2.0, 2.0, 2), rng.uniform(-math.pi, math.pi))
        motion = Motion(*rng.normal(0.0, 0.3, 2), rng.normal(0.0, 0.2))
        passed = coasting(pose, motion, Pose2(*rng.uniform(-2.0, 2.0, 2), pose.yaw_rad), SIGHT)
        if passed and every_point(points, height_m, passed, bodies) > 0.05:
            found.append((pose, passed))
    return found


def main(argv: Sequence[str]) -> int:
    """Measure and print; the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--case", default="2m1ma_bin")
    parser.add_argument("--looks", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(argv)
    points, height_m, bodies = cell(options.case)
    taken_ms, apart_m = np.zeros((options.looks, 2)), 0.0
    for i, (pose, passed) in enumerate(looks_of(points, height_m, bodies, options.looks, options.seed)):
        begun = time.perf_counter()
        ours = room_ahead(points, pose, height_m, passed, bodies, PARAMS.stop_clearance_m).distance_m
        between = time.perf_counter()
        peer = every_point(points, height_m, passed, bodies)
        taken_ms[i] = 1e3 * (between - begun), 1e3 * (time.perf_counter() - between)
        apart_m = max(apart_m, 0.0 if ours == peer else abs(ours - peer))
    (p50, p50_peer), (p99, p99_peer) = np.percentile(taken_ms, 50, axis=0), np.percentile(taken_ms, 99, axis=0)
    solids = sum(len(body.solids) for body in bodies)
    print(f"{options.case}, seed {options.seed}: {options.looks} looks, {len(points)} points, {solids} solids")
    print(f"ours {p50:.2f} / {p99:.2f} ms, every point {p50_peer:.2f} / {p99_peer:.2f} ms: {p50_peer / p50:.1f} times")
    print(f"greatest difference: {apart_m:.1e} m")
    return 0 if apart_m <= SAME_M else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
