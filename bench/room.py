#!/usr/bin/env python3
"""What a simulated second of the TurtleBot in its room costs, without ROS.

    python3 bench/room.py [--arena practice] [--seconds 120] [--seed 3]

The robot drives 0.2 m/s and turns where its scan sees less than 0.6 m, so it bumps into what the scan does not see.
Then the RGB camera draws the practice layout from random places: ``rgb``, and the bytes of its message: ``colour``.
Processor time of one core. A row for every tick, scan and image goes to ``bench/data/room.csv``.
"""

from __future__ import annotations

import argparse
import time
from functools import partial
from typing import Callable, Dict, List

import numpy as np
import raw_rows

from yarm.experiments.inspect.eyes import Camera
from yarm.geometry import Pose2
from yarm.geometry.scans import Scan
from yarm.sim.engine.room import RoomWorld
from yarm.sim.scenes.arena import load_arena
from yarm.sim.scenes.layout_file import find_layout
from yarm.sim.sensors.rgb_camera import RgbFrame

NEAR_M = 0.6
COMMAND_TICKS = 10
FRAMES = 300
FROM_WALL_M = 0.2


class Costs:
    """Processor milliseconds of each part."""

    def __init__(self) -> None:
        self.parts: Dict[str, List[float]] = {}

    def of(self, part: str, work: Callable[[], object]) -> object:
        """Do a piece of work and note what it took."""
        start = time.process_time()
        result = work()
        self.parts.setdefault(part, []).append(1e3 * (time.process_time() - start))
        return result

    def rows(self) -> List[Dict[str, object]]:
        """Every piece of work: its part, its number within the part, and what it took."""
        return [
            {"part": part, "number": number, "ms": round(spent, 4)}
            for part, times in self.parts.items()
            for number, spent in enumerate(times)
        ]


def nearest(scan: Scan) -> float:
    """Least valid range, metres; 0 when nothing is seen."""
    seen = scan.ranges[scan.valid()]
    return float(np.min(seen)) if len(seen) else 0.0


def draw_frames(costs: Costs, seed: int) -> None:
    """Frames of the RGB camera from random places in the practice layout, also where a box stands."""
    layout = find_layout("practice")
    camera, rng = Camera(layout, seed), np.random.default_rng(seed)
    (x0, y0), (x1, y1) = layout.arena.lower, layout.arena.upper
    for number in range(FRAMES):
        low, high = (x0 + FROM_WALL_M, y0 + FROM_WALL_M, -np.pi), (x1 - FROM_WALL_M, y1 - FROM_WALL_M, np.pi)
        pose = Pose2(*(float(value) for value in rng.uniform(low, high)))
        frame = costs.of("rgb", partial(camera.frame, pose, number))
        assert isinstance(frame, RgbFrame)
        costs.of("colour", lambda shown=frame: shown.rgb().tobytes())


def main() -> None:
    """Drive, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--arena", default="practice", help="a shipped arena, or a file")
    parser.add_argument("--seconds", type=float, default=120.0, help="simulated time")
    parser.add_argument("--seed", type=int, default=3, help="of the places that the RGB camera draws from")
    options = parser.parse_args()
    arena = load_arena(options.arena)
    costs, bumps, ahead_m = Costs(), 0, 0.0
    with RoomWorld(arena) as world:
        while world.time_s < options.seconds:
            if world.ticks % COMMAND_TICKS == 0:
                free = ahead_m > NEAR_M
                world.drive(0.2 if free else 0.0, 0.0 if free else 0.6)
            costs.of("tick", world.tick)
            if world.scan_due():
                scan = costs.of("scan", world.scan)
                assert isinstance(scan, Scan)
                ahead_m = nearest(scan)
            bumps += sum(event.pressed for event in world.take_bumps())
        total_s = sum(sum(times) for times in costs.parts.values()) / 1e3
        for _ in range(50):
            costs.of("depth", world.depth)
    draw_frames(costs, options.seed)
    print(f"{arena.name}, {len(arena.blocks)} blocks, {options.seconds:g} s, {bumps} bumps")
    print(f"physics and scan: {options.seconds / total_s:.1f} simulated seconds a second of one core")
    for part, times in costs.parts.items():
        p50, p99 = np.percentile(times, (50, 99))
        print(f"{part:6s} {p50:7.3f} {p99:7.3f} ms (median, 99th percentile)")
    raw_rows.save(raw_rows.DATA / "room.csv", costs.rows())


if __name__ == "__main__":
    main()
