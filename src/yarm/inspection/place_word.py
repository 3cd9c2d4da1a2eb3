"""Whether the robot's place is known, by the localisation's own words; pure.

``amcl`` of this package says of each scan whether the place is known (spread, and scan agreement). The platform's AMCL
says only a pose with its covariance: then the spread decides.
"""

from __future__ import annotations

import math
from typing import Optional, Sequence, Tuple

MOST_M, MOST_RAD = 0.10, math.radians(5.0)
"""A place is known when its deviations are below these."""
WAIT_S = 1.0
"""A localisation that says of each scan what became of it has done so this long after its first pose."""
ROUNDING = 1e-9
"""A variance (m2, rad2) is below zero by this much at most because of rounding."""
SIZE = 36
X, XY, YX, Y, YAW = 0, 1, 6, 7, 35
"""Of the 6 x 6 covariance, row by row, of x, y, z and the turns about them (geometry_msgs/PoseWithCovariance)."""


def spread(covariance: Sequence[float]) -> Tuple[float, float]:
    """Greatest deviation of a place in any direction of the plane, m, and the deviation of its heading, rad.

    Args:
        covariance: 36 numbers, 6 x 6 row by row; m2, m rad and rad2.

    Raises:
        ValueError: it is none: not 36 numbers, one in the plane not finite, a variance below zero.
    """
    if len(covariance) != SIZE:
        raise ValueError(f"a covariance of {len(covariance)} numbers, expected {SIZE}")
    x, y, yaw = covariance[X], covariance[Y], covariance[YAW]
    mixed = 0.5 * (covariance[XY] + covariance[YX])
    if not all(math.isfinite(value) for value in (x, y, yaw, mixed)):
        raise ValueError(
            f"variances {x:g} and {y:g} m2, {yaw:g} rad2, {mixed:g} m2 between x and y: not all are finite"
        )
    middle, half = 0.5 * (x + y), math.hypot(0.5 * (x - y), mixed)
    if min(middle - half, yaw) < -ROUNDING:
        raise ValueError(f"variances {x:g} and {y:g} m2, {yaw:g} rad2, {mixed:g} m2 between x and y: one is below zero")
    return math.sqrt(max(middle + half, 0.0)), math.sqrt(max(yaw, 0.0))


class PlaceWord:
    """The newest word. Once a localisation has said itself whether the place is known, its poses no longer count."""

    def __init__(self) -> None:
        """Nothing heard."""
        self.said = False
        """A localisation has said itself whether the place is known."""
        self.forget()

    def forget(self) -> None:
        """Time went backwards: the place is not known. Who speaks, and how, has not changed."""
        self._known, self._fault = False, ""
        self._first_pose_s: Optional[float] = None

    def say(self, known: bool, fault: str) -> None:
        """By the localisation itself the place is known, or why it is not."""
        self.said, self._known, self._fault = True, known, fault

    def pose(self, covariance: Sequence[float], now_s: float) -> str:
        """A pose with this covariance, 36 numbers as of :func:`spread`, has come; what is wrong with it.

        One that is refused is a word too: that the place is not known.
        """
        known, fault, refused = False, "", ""
        try:
            off_m, off_rad = spread(covariance)
            known = off_m < MOST_M and off_rad < MOST_RAD
            if not known:
                fault = (
                    f"a deviation of {off_m:.2f} m and {math.degrees(off_rad):.1f} degrees, less than {MOST_M:.2f} m "
                    f"and {math.degrees(MOST_RAD):.0f} degrees is a place known"
                )
        except ValueError as error:
            fault = refused = str(error)
        if not self.said:
            self._known, self._fault = known, fault
            if self._first_pose_s is None:
                self._first_pose_s = now_s
        return refused

    def at(self, now_s: float) -> Tuple[bool, str]:
        """Whether the place is known at a time, s, and why not; empty while nobody has said anything."""
        waits = self._first_pose_s is not None and now_s - self._first_pose_s < WAIT_S
        if self._known and waits and not self.said:
            return False, "the first pose has just come; whether its sender says more is not known yet"
        return self._known, self._fault
