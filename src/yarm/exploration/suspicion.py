"""Where a thing that the robot bumped into may go on: ground near the place that was never seen from near enough."""

from __future__ import annotations

import math
from typing import List, Optional

import numpy as np

from yarm.exploration.seen import SweptGround
from yarm.geometry import FloatArray, Pose2
from yarm.navigation.costs import blocked
from yarm.navigation.grid_map import GridMap
from yarm.navigation.overlay import BEARINGS
from yarm.robots.turtlebot import RADIUS_M, Bumper

REACH_M = 0.9
"""A thing that was bumped into may go on for so long beyond where it was met."""
WEIGHT = 10.0
"""Every metre on which the body would pass such ground costs so many more."""


class Suspicion:
    """Ground, in the map frame, that ways had better not lead over until the camera has seen it.

    Args:
        floor: which ground the camera has seen from near enough to show what is low.
    """

    def __init__(self, floor: SweptGround) -> None:
        self._floor = floor
        self._met: List[FloatArray] = []

    def met(self, pose: Pose2, bumper: Bumper) -> None:
        """A robot at a pose of the map bumped into something with a sector of its bumper."""
        bearing = BEARINGS[bumper]
        self._met.append(pose.moved(RADIUS_M * np.array([[math.cos(bearing), math.sin(bearing)]]))[0])

    def weights(self, grid_map: GridMap, radius_m: float) -> Optional[FloatArray]:
        """(rows, columns) what a metre costs more for a disc whose centre is in a cell; None where nothing was met."""
        if not self._met:
            return None
        centres = grid_map.centres_of(np.argwhere(np.ones(grid_map.cells.shape, bool)))
        away = np.min([np.hypot(*(centres - place).T) for place in self._met], axis=0).reshape(grid_map.cells.shape)
        unseen = (away <= REACH_M) & ~grid_map.occupied & ~self._floor.over(grid_map, 0.0)
        return WEIGHT * blocked(unseen, radius_m / grid_map.resolution_m)
