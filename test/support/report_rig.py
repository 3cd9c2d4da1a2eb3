"""Observations made by hand: a scan with room at the right, ahead and at the left, and odometry that obeys."""

from __future__ import annotations

import math
from typing import Dict, List, Optional, Tuple

import numpy as np

from yarm.exploration.model import LOOP_S, Command, Controller, Observation, Step
from yarm.geometry import Pose2
from yarm.geometry.scans import Odometry, Scan
from yarm.navigation.grid_map import GridMap
from yarm.robots.turtlebot import SCAN_BEAMS, SCAN_FOV_RAD, Bumper, BumperEvent

AHEAD = math.radians(6.5)


def scan(ahead: float, left: float = 2.0, right: float = 2.0, stamp_s: float = 0.0) -> Scan:
    """A scan with these ranges, metres; nan for nothing."""
    increment = SCAN_FOV_RAD / (SCAN_BEAMS - 1)
    angles = -SCAN_FOV_RAD / 2 + increment * np.arange(SCAN_BEAMS)
    ranges = np.where(angles < 0, right, left)
    ranges[np.abs(angles) <= AHEAD] = ahead
    return Scan(stamp_s, ranges.astype(np.float32), -SCAN_FOV_RAD / 2, increment, 0.45, 10.0)


class Rig:
    """Steps a controller; the base does exactly what it is told unless it is held."""

    def __init__(self, controller: Controller) -> None:
        self.controller = controller
        self.pose = Pose2(0.0, 0.0)
        self.map_from_odom = Pose2(0.0, 0.0)
        self.passes = 0
        self.held = False
        self.map: Optional[GridMap] = None
        self.steps: List[Step] = []

    @property
    def now_s(self) -> float:
        return self.passes * LOOP_S

    def step(self, seen: Scan, *bumps: Tuple[Bumper, bool]) -> Step:
        observation = Observation(
            self.now_s,
            Odometry(self.now_s, self.pose),
            self.map_from_odom,
            seen,
            tuple(BumperEvent(bumper, pressed) for bumper, pressed in bumps),
            self.map,
        )
        step = self.controller.step(observation)
        self.steps.append(step)
        self.passes += 1
        if not self.held:
            self.pose = moved(self.pose, step.command)
        return step

    def run(self, seconds: float, seen: Scan) -> List[Step]:
        return [self.step(seen) for _ in range(round(seconds / LOOP_S))]

    def shares(self) -> Dict[str, int]:
        """Passes of each behaviour."""
        names = [step.behaviour for step in self.steps]
        return {name: names.count(name) for name in dict.fromkeys(names)}


def moved(pose: Pose2, command: Command) -> Pose2:
    return pose.compose(Pose2(command.v_mps * LOOP_S, 0.0, command.w_radps * LOOP_S))


def room(size: int = 60, known: int = 40) -> GridMap:
    """Walls around the first ``known`` rows and columns, 5 cm cells; the wall at the greatest x has a door."""
    cells = np.full((size, size), -1, np.int8)
    cells[5:known, 5:known] = 0
    cells[5, 5:known] = cells[known - 1, 5:known] = 100
    cells[5:known, 5] = cells[5:known, known - 1] = 100
    cells[12 : known - 7, known - 1] = 0
    return GridMap(cells, 0.05, Pose2(-1.0, -1.0))
