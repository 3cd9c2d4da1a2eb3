"""The HC10's real raster, computed once a process and kept."""

from __future__ import annotations

import numpy as np

from yarm.experiments.arm_player import ArmPlayer


def arm_of(rng: np.random.Generator) -> ArmPlayer:
    """The HC10 at work, somewhere in its raster."""
    raise NotImplementedError
