"""Puts the record of a run together from what is heard of it while it goes on; times on one clock, from its start."""

from __future__ import annotations

import heapq
import math
from typing import Callable, Dict, List, Tuple, Union

import numpy as np

from yarm.experiments.explore.record import (
    BehaviourClock,
    CoverageRow,
    ExploreRecord,
    PathRow,
    TouchRow,
)
from yarm.exploration.model import LOOP_S, Command, Event
from yarm.exploration.params import ExploreParams
from yarm.geometry import Pose2, wrap_angle
from yarm.navigation.grid_map import GridMap
from yarm.sim.scenes.arena import Arena
from yarm.sim.touches import TouchLog

Watch = Callable[[float, GridMap], float]
WATCHED_S = 2.0
"""Passes count until so long after the end."""
LATE_S = 0.5
"""Messages of one moment come within so much time of each other, s."""
_Heard = Union[Pose2, Tuple[str, float, float]]
"""Where the robot is, or a block and a point that it touches."""


class LiveRecorder:
    """Fed in any order within a moment; nothing before the start of the run counts."""

    def __init__(self, arena: Arena, params: ExploreParams, seed: int, watch: Watch, world_from_map: Pose2) -> None:
        """Nothing heard.

        Args:
            arena: the room, for what is low.
            params: limits of the run.
            seed: of the run.
            watch: given the time and a map, its share.
            world_from_map: pose of the map frame in the world.
        """
        self._arena = arena
        self._params = params
        self._seed = seed
        self._watch = watch
        self._world_from_map = world_from_map
        self._log = TouchLog({block.name: block.size[2] for block in arena.blocks})
        self._heard: List[Tuple[float, int, int, _Heard]] = []
        self._count = 0
        self._clock = BehaviourClock()
        self._truth: List[Tuple[float, float, float, float]] = []
        self._passes: List[Tuple[float, Pose2, Command]] = []
        self._coverage: List[CoverageRow] = []
        self._events: List[Event] = []
        self._step_ms: List[float] = []
        self._map: List[GridMap] = []
        self.share = math.nan

    @property
    def bumps(self) -> int:
        """Contacts so far, by the truth; the newest LATE_S are not counted yet."""
        return len(self._touches())

    def truth(self, t_s: float, pose: Pose2) -> None:
        """Where the robot really is, world."""
        if t_s >= -1.0 and (not self._truth or t_s > self._truth[-1][0]):
            self._truth.append((t_s, pose.x, pose.y, pose.yaw_rad))
            self._hear(t_s, pose)
            self._replay(t_s - LATE_S)

    def passed(self, t_s: float, behaviour: str, believed: Pose2, command: Command, took_ms: float) -> None:
        """One pass of the explorer; ``believed`` is in the map."""
        if t_s < 0.0 or (self._passes and t_s <= self._passes[-1][0]):
            return
        self._clock.spend(behaviour, LOOP_S)
        self._passes.append((t_s, self._world_from_map.compose(believed), command))
        self._step_ms.append(took_ms)
        if self._map and (not self._coverage or t_s - self._coverage[-1].t_s >= 1.0 - 1e-6):
            self._coverage.append(CoverageRow(t_s, self._map[-1].known_m2, self.share))

    def map(self, t_s: float, grid: GridMap) -> None:
        """A new map."""
        self._map = [grid]
        self.share = self._watch(t_s, grid)

    def touch(self, t_s: float, block: str, x: float, y: float) -> None:
        """The robot and a block are in contact at a point of the world."""
        self._hear(t_s, (block, x, y))

    def _hear(self, t_s: float, what: _Heard) -> None:
        """Keep it until everything of its moment must have come."""
        self._count += 1
        heapq.heappush(self._heard, (t_s, int(not isinstance(what, Pose2)), self._count, what))

    def _replay(self, until_s: float) -> None:
        """Give what was heard up to a time to the log, in the order of time, the pose of a moment first."""
        while self._heard and self._heard[0][0] <= until_s:
            t_s, _, _, what = heapq.heappop(self._heard)
            if isinstance(what, Pose2):
                self._log.moved(t_s, what)
            else:
                self._log.contact(t_s, *what)

    def event(self, event: Event) -> None:
        """What the explorer says that it did."""
        self._events.append(event)

    def finish(self, end_s: float, done: bool, reason: str, first_seen: Dict[str, float]) -> ExploreRecord:
        """The record of the run, which ended at a time for a reason."""
        self._replay(math.inf)
        self._passes = [row for row in self._passes if row[0] <= end_s + WATCHED_S]
        params, grid = self._params, self._map[-1] if self._map else None
        if grid is not None and self._passes:
            self._coverage.append(CoverageRow(self._passes[-1][0], grid.known_m2, self.share))
        return ExploreRecord(
            arena=self._arena.name,
            controller=params.controller,
            seed=self._seed,
            mode="physics",
            time_limit_s=params.time_limit_s,
            max_speed=params.max_speed,
            near_speed=params.near_speed,
            near_distance=params.near_distance,
            end_s=end_s,
            done=done,
            reason=reason,
            path=self._rows(),
            coverage=tuple(self._coverage),
            touches=self._touches(),
            events=tuple(self._events),
            first_seen=dict(first_seen),
            behaviours=self._clock.seconds,
            step_ms=tuple(self._step_ms),
            map=grid,
            world_from_map=self._world_from_map,
        )

    def _touches(self) -> Tuple[TouchRow, ...]:
        """Those of the run itself."""
        return tuple(TouchRow.of(touch) for touch in self._log.touches if touch.t_s >= 0.0)

    def _rows(self) -> Tuple[PathRow, ...]:
        """The passes, with the truth of their moments and the speed since the one before."""
        if not self._truth or not self._passes:
            return ()
        times, x, y, yaw = (np.array(column) for column in zip(*self._truth))
        at = np.array([t_s for t_s, _, _ in self._passes])
        true_x, true_y, true_yaw = (np.interp(at, times, values) for values in (x, y, np.unwrap(yaw)))
        rows: List[PathRow] = []
        for i, (t_s, believed, command) in enumerate(self._passes):
            way = math.hypot(true_x[i] - true_x[i - 1], true_y[i] - true_y[i - 1]) if i else 0.0
            speed = way / (t_s - self._passes[i - 1][0]) if i else 0.0
            rows.append(
                PathRow(
                    t_s,
                    *(float(true_x[i]), float(true_y[i]), wrap_angle(float(true_yaw[i]))),
                    *(believed.x, believed.y, believed.yaw_rad),
                    command.v_mps,
                    command.w_radps,
                    float(speed),
                )
            )
        return tuple(rows)
