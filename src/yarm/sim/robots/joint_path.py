"""Following a streamed joint trajectory within the joints' limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from yarm.geometry import FloatArray


@dataclass(frozen=True, eq=False)
class JointLimits:
    """Lower and upper angle, rad, and greatest speed, rad/s, of each joint, (n,) each."""

    lower: FloatArray
    upper: FloatArray
    speed: FloatArray


class JointPathError(ValueError):
    """A trajectory was refused; the message names the joint or value and what is accepted."""


class JointPath:
    """Set-points along a trajectory: linear between its points, never faster than the joints' limits.

    Points beyond a joint's limits are clamped to them. A piece that would need more than a joint's greatest speed is
    stretched in time. A new trajectory replaces the old one from the present set-point on. ``brake`` brings it to rest
    on the way that it is on.
    """

    def __init__(self, start: npt.ArrayLike, limits: JointLimits) -> None:
        """Hold ``start`` (n,), rad, until a trajectory comes."""
        self._limits = limits
        self._from: FloatArray = np.asarray(start, dtype=float).copy()
        self._points: List[Tuple[FloatArray, float]] = []
        self._elapsed_s = 0.0
        self._braking: Tuple[float, float] = (0.0, 0.0)
        self.position: FloatArray = self._from.copy()
        self.velocity: FloatArray = np.zeros_like(self._from)

    @property
    def moving(self) -> bool:
        """Whether set-points are still to come."""
        return bool(self._points)

    def follow(self, positions: npt.ArrayLike, times_s: Sequence[float]) -> List[str]:
        """Take a trajectory.

        Args:
            positions: (m, n), rad; with m = 0 the arm stops where it is.
            times_s: (m,) time from the start of each point, s; never falling.

        Returns:
            a sentence for each value that had to be clamped or stretched.

        Raises:
            JointPathError: not finite, of the wrong shape, or times that fall; nothing changes then.
        """
        times = np.asarray(times_s, dtype=float).reshape(-1)
        n = len(self.position)
        points = np.asarray(positions, dtype=float)
        if points.size == 0 and len(times) == 0:
            points = points.reshape(0, n)
        if points.ndim != 2 or points.shape != (len(times), n):
            raise JointPathError(f"points of shape {points.shape} must be {len(times)} times {n} joints")
        if not (np.all(np.isfinite(points)) and np.all(np.isfinite(times))):
            raise JointPathError("positions and times must be finite")
        if len(times) and (times[0] < 0.0 or np.any(np.diff(times) < 0.0)):
            raise JointPathError(f"times must not be negative or fall; they are {times.tolist()[:8]}")
        return self._take(points, times)

    def brake(self, stop_s: float) -> None:
        """Come to rest on the trajectory, evenly slower for so long, s; once is enough."""
        if self.moving and not self._braking[0]:
            self._braking = (stop_s, stop_s)

    def _take(self, points: FloatArray, times: FloatArray) -> List[str]:
        notes = []
        clamped = np.clip(points, self._limits.lower, self._limits.upper)
        if not np.array_equal(clamped, points):
            joints = np.nonzero(np.any(clamped != points, axis=0))[0] + 1
            notes.append(f"joint(s) {joints.tolist()} clamped to their limits")
        self._from, self._elapsed_s, self._points = self.position.copy(), 0.0, []
        self._braking = (0.0, 0.0)
        last, last_time, stretched = self._from, 0.0, 0
        for point, time in zip(clamped, times):
            needed = float(np.max(np.abs(point - last) / self._limits.speed))
            given = float(time) - last_time
            stretched += int(needed > given * (1.0 + 1e-6) + 1e-9)
            self._points.append((point, max(needed, given)))
            last, last_time = point, float(time)
        if stretched:
            notes.append(f"{stretched} piece(s) slowed down to the joints' greatest speeds")
        if not self._points:
            self.velocity = np.zeros_like(self.position)
        return notes

    def advance(self, dt_s: float) -> None:
        """Move the set-point on by a time step, s."""
        stop_s, left_s = self._braking
        if not stop_s or not self._points:
            self._advance(dt_s)
            return
        after_s = left_s - dt_s if left_s > dt_s + 1e-9 else 0.0
        self._braking = (stop_s, after_s)
        self._advance((left_s**2 - after_s**2) / (2.0 * stop_s))
        self.velocity = self.velocity * (after_s / stop_s)
        if not after_s:
            self._points, self._braking = [], (0.0, 0.0)

    def _advance(self, dt_s: float) -> None:
        remaining = dt_s
        while self._points:
            target, duration = self._points[0]
            left = duration - self._elapsed_s
            if left > remaining + 1e-12:
                self._elapsed_s += remaining
                share = self._elapsed_s / duration
                self.position = self._from + share * (target - self._from)
                self.velocity = (target - self._from) / duration
                return
            remaining -= max(left, 0.0)
            self._points.pop(0)
            self._from, self._elapsed_s, self.position = target, 0.0, target.copy()
        self.velocity = np.zeros_like(self.position)
