"""The top of a part in squares, and when, how fast and at what angle the tool went over each (ground truth)."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import List, Optional, Sequence, Tuple

import numpy as np

from yarm.control.sander.states import SanderState
from yarm.experiments.run.record import PauseRecord, SquareRow
from yarm.geometry import FloatArray, transform_points
from yarm.geometry.urdf import expand_xacro, parse_urdf
from yarm.resources import resource
from yarm.robots.hc10 import Station, station_boxes
from yarm.sim.scenes.scene import Scene

SQUARE_M = 0.05
TOUCH_M = 0.005
"""The tool touches the part within this of its top, metres."""
GAP_S = 0.5
"""Two looks at the tip farther apart in time give no speed, s."""


@lru_cache(maxsize=1)
def tool_m() -> Tuple[float, float]:
    """Radius of the sander's working face, and how far it is from the flange, metres (urdf/cell/hc10.urdf.xacro)."""
    model = parse_urdf(expand_xacro(resource("urdf", "cell", "hc10.urdf.xacro")))
    radius_m = next(float(solid.size[0]) for solid in model.solids if solid.link == "sander")
    return radius_m, float(model.joints["sander-tip"].T_parent_child[2, 3])


def parts_of(scene: Scene) -> List[PartSquares]:
    """The parts that the manipulators of a scene work on."""
    return [PartSquares(arm.name, arm.station) for arm in scene.arms if not arm.tucked]


class PartSquares:
    """One part; times are those it is told, s."""

    def __init__(self, manipulator: str, station: Station) -> None:
        """Nothing is sanded yet.

        Args:
            manipulator: who works on it.
            station: where it is.
        """
        self.manipulator = manipulator
        self._radius_m, self._length_m = tool_m()
        part = next(box for box in station_boxes() if box.name == "part")
        spans = [np.arange(-s / 2 + SQUARE_M / 2, s / 2, SQUARE_M) + c for s, c in zip(part.size[:2], part.centre)]
        self._places = [(i, j) for i in range(len(spans[0])) for j in range(len(spans[1]))]
        self._middles: FloatArray = np.array([(x, y) for x in spans[0] for y in spans[1]])
        self._top_m = part.centre[2] + part.size[2] / 2
        self._pose = station.pose
        self._from_world = np.linalg.inv(station.pose)
        self.forget()

    def forget(self) -> None:
        """Nothing is sanded yet, and nothing known of the manipulator."""
        count = len(self._places)
        self._sanded_s, self._nearest_m = np.full(count, np.nan), np.full(count, np.inf)
        self._speeds, self._tilts = np.full(count, np.nan), np.full(count, np.nan)
        self._last: Optional[Tuple[float, FloatArray]] = None
        self._words, self._progress, self._worked = "", 0.0, False

    def shift(self, by_s: float) -> None:
        """Times count from another beginning: add this to them, s."""
        self._sanded_s += by_s
        self._last = None

    def note(self, words: str, progress: float) -> None:
        """What the manipulator does, and the share of its raster that is done."""
        self._words, self._progress = words, progress
        self._worked = self._worked or words == SanderState.SCAN_TO_PATH.words

    def tool(self, time_s: float, flange: Sequence[float], axis: Sequence[float]) -> None:
        """Where the tool's flange is, (3,) metres, and the direction the tool looks in, (3,) of length 1, world."""
        tip = np.asarray(flange) + self._length_m * np.asarray(axis)
        at = transform_points(self._from_world, tip[None])[0]
        last, self._last = self._last, (time_s, at)
        touches = abs(at[2] - self._top_m) <= TOUCH_M
        if not touches or last is None or not 0.0 < time_s - last[0] <= GAP_S:
            return
        speed = float(np.linalg.norm(at - last[1])) / (time_s - last[0])
        tilt = math.degrees(math.acos(min(1.0, max(-1.0, -float(axis[2])))))
        away = np.hypot(*(self._middles - at[:2]).T)
        over = away <= self._radius_m
        self._sanded_s[over & np.isnan(self._sanded_s)] = time_s
        nearer = away < self._nearest_m
        self._nearest_m[nearer] = away[nearer]
        self._speeds[over & nearer], self._tilts[over & nearer] = speed, tilt

    def rows(self, pauses: Sequence[PauseRecord]) -> Tuple[SquareRow, ...]:
        """Every square; why one was not sanded is told with the manipulator's pauses."""
        heights = np.full((len(self._middles), 1), self._top_m)
        world = transform_points(self._pose, np.hstack([self._middles, heights]))
        found = []
        for k, (row, column) in enumerate(self._places):
            sanded_s = float(self._sanded_s[k])
            reason = "" if math.isfinite(sanded_s) else self._why_not(k, pauses)
            x_m, y_m = float(world[k, 0]), float(world[k, 1])
            numbers = (sanded_s, float(self._speeds[k]), float(self._tilts[k]))
            found.append(SquareRow(self.manipulator, row, column, x_m, y_m, *numbers, reason))
        return tuple(found)

    def _why_not(self, k: int, pauses: Sequence[PauseRecord]) -> str:
        done = f"{100.0 * self._progress:.0f} % of the raster done"
        if not self._worked:
            return f"the manipulator never came to its raster: {self._words or 'its sander said nothing'}"
        if self._progress >= 1.0:
            return f"the raster was done and led no nearer than {1e3 * self._nearest_m[k]:.0f} mm"
        still = [p for p in pauses if p.manipulator == self.manipulator and math.isnan(p.end_s)]
        if still:
            return f"paused since {still[-1].start_s:.1f} s ({still[-1].cause or 'no cause told'}), {done}"
        return f"the mission ended with {done}"
