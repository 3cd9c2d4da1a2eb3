"""A robot in a small map for the tests of explorers: it moves as told and sees what it is given."""

from __future__ import annotations

import math
from typing import List, Optional, Tuple

import numpy as np

from yarm.exploration.model import LOOP_S, Command, Controller, Observation, Step
from yarm.geometry import Pose2, wrap_angle
from yarm.geometry.scans import Odometry, Scan
from yarm.navigation.grid_map import GridMap
from yarm.robots.turtlebot import BumperEvent


def far_scan(range_m: float = 4.0) -> Scan:
    """A scan that sees the same range everywhere."""
    return Scan(0.0, np.full(61, range_m, np.float32), math.radians(-30.0), math.radians(1.0), 0.45, 10.0)


def observe(
    now_s: float,
    pose: Pose2,
    grid_map: Optional[GridMap],
    count: int = 0,
    bumps: Tuple[BumperEvent, ...] = (),
    scan: Optional[Scan] = None,
    jumped: bool = False,
) -> Observation:
    """An observation with odometry that is the true pose."""
    seen = far_scan() if scan is None else scan
    odometry = Odometry(now_s, pose)
    return Observation(now_s, odometry, Pose2(0.0, 0.0), seen, bumps, grid_map, count, None, jumped)


def moved(pose: Pose2, command: Command) -> Pose2:
    """Where an ideal robot is one pass later."""
    middle = pose.yaw_rad + 0.5 * command.w_radps * LOOP_S
    return Pose2(
        pose.x + command.v_mps * LOOP_S * math.cos(middle),
        pose.y + command.v_mps * LOOP_S * math.sin(middle),
        wrap_angle(pose.yaw_rad + command.w_radps * LOOP_S),
    )


def run_on(controller: Controller, grid_map: GridMap, pose: Pose2, seconds: float) -> Tuple[List[Step], Pose2]:
    """Steps a controller on a map that never changes, until it is done or the time is over."""
    steps: List[Step] = []
    for i in range(round(seconds / LOOP_S)):
        steps.append(controller.step(observe(i * LOOP_S, pose, grid_map)))
        if steps[-1].done:
            break
        pose = moved(pose, steps[-1].command)
    return steps, pose
