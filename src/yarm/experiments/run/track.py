"""The way of every end effector, kept small: an hour of two robots at 20 Hz is 8 MB instead of 60."""

from __future__ import annotations

from array import array
from typing import List, Tuple

from yarm.experiments.run.record import PathRow

_NUMBERS = 7
"""Numbers kept of a row; the robot by its index."""


class Track:
    """Rows in the order they came."""

    def __init__(self) -> None:
        """Nothing yet."""
        self._robots: List[str] = []
        self._numbers = array("d")

    def add(self, row: PathRow) -> None:
        """Keep one more row."""
        if row.robot not in self._robots:
            self._robots.append(row.robot)
        robot = float(self._robots.index(row.robot))
        self._numbers.extend((row.time_s, robot, row.x_m, row.y_m, row.yaw_rad, row.column_x, row.column_y))

    def rows(self) -> Tuple[PathRow, ...]:
        """All rows."""
        numbers = [self._numbers[i : i + _NUMBERS] for i in range(0, len(self._numbers), _NUMBERS)]
        return tuple(PathRow(time_s, self._robots[int(robot)], *rest) for time_s, robot, *rest in numbers)
