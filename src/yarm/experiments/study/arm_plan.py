"""The HC10's real raster: the sander's own plan over the part, in time."""

from __future__ import annotations

from typing import List

import numpy as np

from yarm.control.arm.errors import ArmError
from yarm.control.arm.model import ArmDescription, tool_pose
from yarm.control.sander.params import SanderParams
from yarm.control.sander.planner import TOOL_YAW_RAD, RasterPlan, SanderPlanner
from yarm.experiments.study.arm_player import PERIOD_S, ArmTrack
from yarm.geometry import FloatArray

PART_M = ((-0.45, -0.05), (-0.30, 0.30), 0.73)
"""The part's top: x, y and height, metres, world."""


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
