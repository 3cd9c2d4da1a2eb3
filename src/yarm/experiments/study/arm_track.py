"""The HC10's real raster in time, computed once (``arm_plan``) and kept on disk."""

from __future__ import annotations

import hashlib
import importlib
import os
import tempfile
from functools import lru_cache
from pathlib import Path
from typing import Sequence

import numpy as np

from yarm.control.arm.model import load_arm
from yarm.control.sander.params import SanderParams
from yarm.experiments.study.arm_player import PERIOD_S, ArmModel, ArmPlayer, ArmTrack
from yarm.geometry import FloatArray
from yarm.resources import resource

SOURCES = ("urdf/cell/hc10.urdf.xacro", "config/cell/hc10.yaml")
TIP_LINK = "sander_tip"


def arm_of(share: float) -> ArmPlayer:
    """The HC10 at work, so much of its raster done, 0 to 1."""
    track = raster_track()
    return ArmPlayer(_model(), track, share * track.length_s)


def folded_points(joints: Sequence[float]) -> FloatArray:
    """Points (n, 3) on the HC10's links at joints (6,), rad; metres, frame of its station."""
    return _model().points(np.array(joints))


@lru_cache(maxsize=1)
def _model() -> ArmModel:
    arm = load_arm()
    base = np.eye(4)
    base[:3, 3] = arm.base_xyz
    return ArmModel(arm.model, base, TIP_LINK)


@lru_cache(maxsize=1)
def raster_track() -> ArmTrack:
    """The track, from this process, from the disk, or computed now (some seconds)."""
    path = _cache_file()
    try:
        with np.load(path) as stored:
            return ArmTrack(PERIOD_S, stored["work"], stored["hover"])
    except (OSError, KeyError, ValueError):
        planner = importlib.import_module("yarm.experiments.study.arm_plan")  # loading it takes a quarter of a second
        track: ArmTrack = planner.plan_track(load_arm(), SanderParams())
    with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".npz", delete=False) as part:
        np.savez(part, work=track.work, hover=track.hover)
    Path(part.name).replace(path)
    return track


def _cache_file() -> Path:
    """Named by what it depends on, so that another robot description makes another file."""
    digest = hashlib.sha256(repr(SanderParams()).encode())
    for source in SOURCES:
        digest.update(resource(*source.split("/")).read_bytes())
    root = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "yarm"
    root.mkdir(parents=True, exist_ok=True)
    return root / f"raster-{digest.hexdigest()[:16]}.npz"
