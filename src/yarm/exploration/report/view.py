"""What the report's behaviours look at: three distances of the scan, and how far the robot has turned and driven."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Deque, Optional, Tuple

import numpy as np

from yarm.exploration.model import Observation
from yarm.exploration.report.params import ReportParams
from yarm.geometry import FloatArray, Pose2, wrap_angle
from yarm.geometry.scans import Scan

DEFAULTS = ReportParams()


@dataclass(frozen=True)
class Room:
    """Room around the robot by one scan, metres.

    Attributes:
        centre: least of the beams ahead; inf where none is valid, so that too near and too far look alike.
        left: least of the left half; ``ReportParams.nothing`` where none is valid.
        right: least of the right half, likewise.
    """

    centre: float = math.inf
    left: float = DEFAULTS.nothing
    right: float = DEFAULTS.nothing


def room_of(
    scan: Scan,
    valid_m: float = DEFAULTS.valid_range,
    mend_single: bool = True,
    params: ReportParams = DEFAULTS,
) -> Room:
    """The three distances of a scan.

    Args:
        scan: beams from right to left.
        valid_m: what is farther counts as nothing; inf for the program, which compares with 6 m later.
        mend_single: a lone NaN becomes the mean of its two neighbours, as the text has it and the program has not.
        params: what is too near, which beams are ahead, and which count for neither side.
    """
    leftwards = np.asarray(scan.ranges, dtype=float)[::-1]
    angles = scan.angles()[::-1]
    if mend_single:
        leftwards = _mended(leftwards)
    with np.errstate(invalid="ignore"):
        seen = np.where((leftwards >= params.valid_least) & (leftwards <= valid_m), leftwards, np.inf)
    n = len(seen)
    if n == 0:
        return Room(math.inf, params.nothing, params.nothing)
    centre = seen[np.abs(angles) <= params.ahead]
    return Room(
        float(centre.min()) if centre.size else math.inf,
        _least(seen[min(params.skipped_beams, n // 2) : n // 2], params.nothing),
        _least(seen[n // 2 :], params.nothing),
    )


def _least(seen: FloatArray, nothing_m: float) -> float:
    least = float(seen.min()) if seen.size else math.inf
    return least if math.isfinite(least) else nothing_m


def _mended(ranges: FloatArray) -> FloatArray:
    """A NaN between two numbers becomes their mean."""
    mended = ranges.copy()
    lone = np.isnan(ranges[1:-1]) & ~np.isnan(ranges[:-2]) & ~np.isnan(ranges[2:])
    mended[1:-1][lone] = 0.5 * (ranges[:-2][lone] + ranges[2:][lone])
    return mended


@dataclass(frozen=True)
class View:
    """One pass as the behaviours see it.

    Attributes:
        observation: all of it.
        now_s: time since the start, s.
        odom: base in the odometry frame.
        room: of the newest scan.
        turned_rad: change of heading since the last pass, + = left.
    """

    observation: Observation
    now_s: float
    odom: Pose2
    room: Room
    turned_rad: float = 0.0


class Watcher:
    """Makes a View of each observation."""

    def __init__(
        self, valid_m: float = DEFAULTS.valid_range, mend_single: bool = True, params: ReportParams = DEFAULTS
    ) -> None:
        """Look at scans with these rules; see ``room_of``."""
        self._rules = (valid_m, mend_single, params)
        self._yaw: Optional[float] = None
        self._scan: Optional[Scan] = None
        self._room = Room()

    def look(self, observation: Observation) -> Optional[View]:
        """The view; None before the first scan and odometry."""
        if observation.odometry is None or observation.scan is None:
            return None
        if observation.scan is not self._scan:
            self._scan, self._room = observation.scan, room_of(observation.scan, *self._rules)
        odom = observation.odometry.pose
        turned = 0.0 if self._yaw is None else wrap_angle(odom.yaw_rad - self._yaw)
        self._yaw = odom.yaw_rad
        return View(observation, observation.now_s, odom, self._room, turned)


@dataclass(frozen=True)
class _Moment:
    t_s: float
    x: float
    y: float
    turned_rad: float
    v_mps: float
    w_radps: float


class Track:
    """Odometry and commands of a window of time: whether the robot does what it is told."""

    def __init__(self, window_s: float) -> None:
        """Remember this long."""
        self._window_s = window_s
        self._moments: Deque[_Moment] = deque()

    def add(self, view: View, v_mps: float, w_radps: float) -> None:
        """Note a pass and what was commanded at it."""
        self._moments.append(_Moment(view.now_s, view.odom.x, view.odom.y, view.turned_rad, v_mps, w_radps))
        while self._moments and self._moments[0].t_s < view.now_s - self._window_s - 1e-6:
            self._moments.popleft()

    def forget(self) -> None:
        """Begin anew."""
        self._moments.clear()

    def hardly_moved(self, path_m: float, turn_rad: float) -> bool:
        """Whether it was told to drive, or to turn, at every pass of a whole window, and did so for less than this."""
        moments = self._moments
        if not moments or moments[-1].t_s - moments[0].t_s < self._window_s - 0.15:
            return False
        if all(m.v_mps != 0.0 for m in moments):
            return self.done()[0] < path_m
        return all(m.w_radps != 0.0 for m in moments) and self.done()[1] < turn_rad

    def done(self) -> Tuple[float, float]:
        """Path, metres, and sum of the changes of heading either way, rad, in the window."""
        moments = list(self._moments)
        path = sum(math.hypot(b.x - a.x, b.y - a.y) for a, b in zip(moments, moments[1:]))
        return path, sum(abs(m.turned_rad) for m in moments[1:])
