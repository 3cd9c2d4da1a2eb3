"""The last piece of a way, driven by odometry alone when the place that is believed moves as the robot turns.

A localisation in a map of cells sees each surface some centimetres off. Which ones it sees depends on the heading, so
the believed place swings while the robot turns where it stands: it drives to the goal, turns to the goal's heading, and
finds itself beside it; and when it turns back to the goal, it seems to be there already. Over a few centimetres
odometry knows better. What is missing at the goal's heading is driven by it alone, with its frame held where it is.
"""

from __future__ import annotations

from typing import Optional

from yarm.geometry import Pose2

MOST = 3
"""So often the last piece is driven for one goal."""


class Approach:
    """Of one goal."""

    def __init__(self) -> None:
        """The believed place is followed."""
        self._held: Optional[Pose2] = None
        self._begun = 0

    def begin(self, pose: Pose2, odometry: Optional[Pose2]) -> bool:
        """Hold odometry's frame where it is from now on; whether that can be done, or has been done often enough."""
        if odometry is None or self._begun >= MOST:
            return False
        self._begun += 1
        self._held = pose.compose(odometry.inverse())
        return True

    def end(self) -> None:
        """Follow the believed place again."""
        self._held = None

    def place(self, pose: Pose2, odometry: Optional[Pose2]) -> Pose2:
        """Where the robot is: as it is believed, or by odometry while its frame is held."""
        return pose if self._held is None or odometry is None else self._held.compose(odometry)
