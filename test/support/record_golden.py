#!/usr/bin/env python3
"""Records test/data/golden_sets.npz anew; needed when the cell, the cameras or the recording's format change.

source tools/env.sh && roscore & test/support/record_golden.py
Then keep the metadata it must give: ``rostest yarm perception_golden.test write:=--write-golden``.
"""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import List

import numpy as np
import rospy
from sensor_msgs.msg import PointCloud2
from tf2_msgs.msg import TFMessage

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from yarm.srv import SpawnObstacles

from support import golden, recorder
from yarm.geometry import transform_matrix
from yarm.ros import names

FOV_RAD = float(np.deg2rad(135.0))
SCENE = "2m1ma"
CALIBRATING_SETS = 3
SETS = 9
EVERY = 6
"""One set in so many is kept once things move."""
LIMIT_S = 300.0


class Keeper:
    """Keeps some of the sets that come by."""

    def __init__(self) -> None:
        self.sets: List[golden.GoldenSet] = []
        self._seen = 0
        self._recorder = recorder.Recorder(self._on_set)

    @property
    def fixed_frames(self) -> TFMessage:
        """The cameras' and the fixed bodies' frames."""
        return self._recorder.fixed_frames

    def _on_set(self, whole: recorder.WholeSet) -> None:
        self._seen += 1
        calibrating = len(self.sets) < CALIBRATING_SETS
        if len(self.sets) < SETS and (calibrating or self._seen % EVERY == 0):
            depth = np.stack([self._depth(cloud) for cloud in whole.clouds])
            self.sets.append(golden.GoldenSet(whole.stamp_ns, calibrating, depth, whole.frames, whole.registry, b""))

    def _depth(self, data: bytes) -> np.ndarray:
        cloud = golden.from_bytes(PointCloud2, data)
        fixed = {t.child_frame_id: t.transform for t in self.fixed_frames.transforms}
        t, q = fixed[cloud.header.frame_id].translation, fixed[cloud.header.frame_id].rotation
        matrix = transform_matrix([t.x, t.y, t.z], [q.x, q.y, q.z, q.w])
        points = np.frombuffer(cloud.data, np.float32).reshape(cloud.height, cloud.width, 4)[..., :3]
        with np.errstate(invalid="ignore"):
            return golden.quantised(points, matrix)


def spawn_debris(keeper: Keeper) -> None:
    """Once the calibrating sets are kept; the simulator may answer late."""
    while len(keeper.sets) < CALIBRATING_SETS:
        time.sleep(0.02)
    rospy.ServiceProxy(names.SPAWN_OBSTACLES, SpawnObstacles)("debris_9", "Debris", -0.2, 0.1, 0.76, 0.5, [])


def main() -> None:
    """Calibrate, spawn a piece of debris, drive a robot, keep the sets."""
    rospy.init_node(recorder.NODE, disable_signals=True)
    keeper = Keeper()
    simulation = subprocess.Popen(recorder.command(SCENE))
    threading.Thread(target=spawn_debris, args=(keeper,), daemon=True).start()
    end = time.monotonic() + LIMIT_S
    try:
        while len(keeper.sets) < SETS and time.monotonic() < end:
            time.sleep(0.05)
    finally:
        simulation.send_signal(signal.SIGINT)
    print(f"{len(keeper.sets)} of {SETS} sets")
    golden.save(golden.Golden(golden.to_bytes(keeper.fixed_frames), FOV_RAD, tuple(keeper.sets)))
    simulation.wait(timeout=LIMIT_S)


if __name__ == "__main__":
    main()
