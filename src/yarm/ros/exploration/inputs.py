"""What the explorer hears, turned into an observation."""

from __future__ import annotations

from collections import deque
from typing import Deque, List, Optional, Tuple

from yarm.exploration.model import LowView, Observation
from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap
from yarm.ros.common.robot_inputs import RobotInputs
from yarm.ros.exploration.params import ExplorerParams

MAP_DELAY_S = 0.5
"""In lock-step a map counts from so long after its stamp, so that it counts from the same pass in every run, s."""


class ExplorerInputs(RobotInputs):
    """Everything of the robot, and the map that grows. Thread-safe."""

    def __init__(self, params: ExplorerParams) -> None:
        """Listen from now on."""
        self._params = params
        super().__init__(params, bumper=True, low=params.low_obstacles)

    def forget(self) -> None:
        """Time went backwards: nothing has been heard yet, and no map is known."""
        super().forget()
        with self._changed:
            self._map = None
            self._map_count = 0
            self._maps: Deque[Tuple[float, GridMap]] = deque()

    def observe(self, now_s: float) -> Observation:
        """Everything that is known at a pass of the loop; bumps and low obstacles are handed out once."""
        with self._changed:
            self._wait_for_all_of(now_s)
            self._count_maps(now_s)
            low = self._take_low()
            return Observation(
                now_s,
                self._odometry,
                self._map_from_odom(now_s),
                self._scan,
                self._take_bumps(),
                self._map,
                self._map_count,
                None if low is None else LowView(*low),
            )

    def _stamps(self, now_s: float) -> List[float]:
        low = [] if not self._params.low_obstacles else [float("-inf") if self._low is None else self._low[0]]
        return [*super()._stamps(now_s), self._place_s(), *low]

    def _take_map(self, stamp_s: float, grid: GridMap) -> None:
        self._maps.append((stamp_s, grid))

    def _count_maps(self, now_s: float) -> None:
        """The newest map that counts at this moment."""
        while self._maps and (not self._params.sync or self._maps[0][0] + MAP_DELAY_S <= now_s + 1e-6):
            self._map, self._map_count = self._maps.popleft()[1], self._map_count + 1

    def _map_from_odom(self, now_s: float) -> Optional[Pose2]:
        """The newest, unless it is too old or is not given in the map's frame."""
        link = self._frames.link(self._params.odom_frame)
        if link is None or link.parent != self._params.map_frame:
            return None
        return link.pose if now_s - link.stamp_s <= self._params.transform_tolerance else None
