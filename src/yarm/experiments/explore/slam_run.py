"""Explores with the real SLAM and the explorer's own session, without ROS: what the nodes do, within calls."""

from __future__ import annotations

import time
from typing import Callable, Optional

from yarm.exploration.model import Controller, LowView, Observation, Step
from yarm.exploration.params import ExploreParams
from yarm.exploration.session import OVER, Session, State
from yarm.navigation.grid_map import GridMap
from yarm.navigation.slam_native import Mapper, MapperCounts
from yarm.sim.room_robot import RoomRobot

MAP_S = 5.0
"""Between two maps; map_update_interval of slam_gmapping."""
LOW_PASSES = 2
"""Every n-th pass brings a depth image."""


class SlamExplorer:
    """Senses and controller in one: scans go to the map maker, and what it says to the explorer's session.

    Attributes:
        world_from_map: pose of the map's frame in the world: where the robot started.
        slam_cpu_s: processor time that mapping has taken, s.
    """

    def __init__(
        self, world: RoomRobot, params: ExploreParams, make: Callable[[], Controller], map_s: float = MAP_S
    ) -> None:
        """Nothing seen; the run begins with the first pass.

        Args:
            world: moves the robot.
            params: limits of the run.
            make: makes the controller.
            map_s: between two maps.
        """
        self.world_from_map = world.truth
        self.slam_cpu_s = 0.0
        self._world = world
        self._session = Session(params, make, autostart=True)
        self._mapper = Mapper()
        self._bare: Optional[GridMap] = None
        self._maps = 0
        self._map_s, self._map_due_s = map_s, 0.0

    @property
    def map(self) -> Optional[GridMap]:
        """The newest, with what is too low for the scan; None before the first."""
        return self._session.keeper.newest

    @property
    def counts(self) -> MapperCounts:
        """What the map maker has done."""
        return self._mapper.counts

    def observe(self, now_s: float, passes: int) -> Observation:
        """Measure, and have the scan mapped."""
        world = self._world
        odometry, scan = world.odometry(), world.scan()
        began = time.process_time()
        mapped = self._mapper.add(odometry, scan)
        if now_s >= self._map_due_s:
            self._bare = self._mapper.map()
            self._maps += 1
            self._map_due_s = now_s + self._map_s
        self.slam_cpu_s += time.process_time() - began
        low = LowView(now_s, world.low_view()) if passes % LOW_PASSES == 0 else None
        return Observation(
            now_s=now_s,
            odometry=odometry,
            map_from_odom=mapped.map_from_odom,
            scan=scan,
            bumps=world.take_bumps(),
            map=self._bare,
            map_count=self._maps,
            low=low,
        )

    def step(self, observation: Observation) -> Step:
        """One pass of the session; the end of the time is the loop's to notice."""
        told = self._session.step(observation)
        ended = told.state in (State.DONE, State.FAILED) and told.reason != OVER
        return Step(told.command, told.behaviour, told.events, ended, told.reason, told.intent)
