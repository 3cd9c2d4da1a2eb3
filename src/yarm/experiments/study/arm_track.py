"""The HC10's real raster: the sander's own plan over the part, in time, computed once and kept on disk."""

from __future__ import annotations

import hashlib
import os
import tempfile
from functools import lru_cache
from pathlib import Path
from typing import List, Sequence

import numpy as np

from yarm.control.arm.errors import ArmError
from yarm.control.arm.model import ArmDescription, load_arm, tool_pose
from yarm.control.sander.params import SanderParams
from yarm.control.sander.planner import TOOL_YAW_RAD, RasterPlan, SanderPlanner
from yarm.experiments.study.arm_player import ArmModel, ArmPlayer, ArmTrack
from yarm.geometry import FloatArray
from yarm.resources import resource

PERIOD_S = 0.05
PART_M = ((-0.45, -0.05), (-0.30, 0.30), 0.73)
"""The part's top: x, y and height, metres, world."""
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
        track = plan_track(load_arm(), SanderParams())
    with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".npz", delete=False) as part:
        np.savez(part, work=track.work, hover=track.hover)
    Path(part.name).replace(path)
    return track


def plan_track(arm: ArmDescription, params: SanderParams) -> ArmTrack:
    """What the sander does on the part, without scanning it: strokes one after the other, the same place each time."""
    planner = SanderPlanner(arm, params)
    plan = planner.raster(_scan())
    work: List[FloatArray] = []
    arc_m = 0.0
    while arc_m < plan.raster.length_m - 1e-3:
        motion = planner.stroke_from(plan, arc_m)
        times = np.arange(0.0, motion.duration_s, PERIOD_S)
        work += [motion.at(float(time)) for time in times]
        arc_m = float(motion.arc_m[-1])
    rows = np.array(work)
    return ArmTrack(PERIOD_S, rows, _hovers(planner, plan, rows, params))


def _scan() -> FloatArray:
    (x0, x1), (y0, y1), z = PART_M
    x, y = np.meshgrid(np.arange(x0, x1 + 1e-9, 0.01), np.arange(y0, y1 + 1e-9, 0.01), indexing="ij")
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, z)])


def _hovers(planner: SanderPlanner, plan: RasterPlan, rows: FloatArray, params: SanderParams) -> FloatArray:
    """Joints straight above each row; solved for some rows, from one to the next, and interpolated between."""
    picks = np.unique(np.append(np.arange(0, len(rows), 5), len(rows) - 1))
    guess = rows[0]
    solved = []
    for row in picks:
        tip = planner.kinematics.tip(rows[row])[:3, 3]
        for height in np.linspace(tip[2], params.hover_height_m, 10) if row == 0 else (params.hover_height_m,):
            above = np.array([tip[0], tip[1], height])
            joints = planner.kinematics.solve(tool_pose(above, np.array([0.0, 0.0, 1.0]), TOOL_YAW_RAD), guess)
            if joints is None:
                raise ArmError(f"no joints for the hover above ({tip[0]:.2f}, {tip[1]:.2f})")
            guess = joints
        solved.append(guess)
    every = np.arange(len(rows))
    return np.column_stack([np.interp(every, picks, column) for column in np.array(solved).T])


def _cache_file() -> Path:
    """Named by what it depends on, so that another robot description makes another file."""
    digest = hashlib.sha256(repr(SanderParams()).encode())
    for source in SOURCES:
        digest.update(resource(*source.split("/")).read_bytes())
    root = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "yarm"
    root.mkdir(parents=True, exist_ok=True)
    return root / f"raster-{digest.hexdigest()[:16]}.npz"
