#!/usr/bin/env python3
"""Records test/data/golden_sets.npz anew; needed when the cell, the cameras or the recording's format change.

    source tools/env.sh && test/support/record_golden.py

Then keep the metadata it must give: ``rostest yarm perception_golden.test write:=--write-golden``.
"""

from __future__ import annotations

import sys
from itertools import islice
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from support import golden, recorder

SCENE = "2m1ma"
SETS = 48
EVERY = 6
"""One set in so many is kept once things move."""


def depth_of(whole: recorder.WholeSet) -> np.ndarray:
    """Depth steps (4, height, width) of a set."""
    with np.errstate(invalid="ignore"):
        images = [
            golden.quantised(np.stack([cloud["x"], cloud["y"], cloud["z"]], axis=-1), matrix)
            for cloud, matrix in zip(whole.clouds, whole.cameras)
        ]
    return np.stack(images)


def main() -> None:
    """Three sets at rest, then one in ``EVERY``."""
    kept = []
    for count, whole in enumerate(islice(recorder.camera_sets(SCENE), SETS)):
        if count < 3 or (not whole.still and count % EVERY == EVERY - 1):
            kept.append(
                golden.GoldenSet(whole.stamp_ns, whole.still, depth_of(whole), whole.frames, whole.registry, b"")
            )
    golden.save(golden.Golden(whole.fixed_frames, recorder.KINECT.fov_rad, tuple(kept)))


if __name__ == "__main__":
    main()
