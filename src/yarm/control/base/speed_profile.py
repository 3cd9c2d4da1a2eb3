"""Speed from the distance left: the sliding-mode table under a stopping profile, and a limit on its change."""

from __future__ import annotations

import math
from typing import Sequence


def table_speed(left: float, limits: Sequence[float], speeds: Sequence[float]) -> float:
    """Speed of a table: ``speeds[i]`` where the distance left is above ``limits[i]``, the last one below all limits.

    Args:
        left: distance left, >= 0, any unit.
        limits: falling, same unit as left; one fewer than speeds.
        speeds: one for each band, any unit.
    """
    for limit, speed in zip(limits, speeds):
        if left > limit:
            return speed
    return speeds[-1]


def stopping_speed(left: float, deceleration: float, delay_s: float) -> float:
    """Largest speed from which the distance left is enough: v * delay + v^2 / (2 * deceleration) = left."""
    if left <= 0.0:
        return 0.0
    return max(deceleration * (math.sqrt(delay_s * delay_s + 2.0 * left / deceleration) - delay_s), 0.0)


def passing_speed(left: float, speed: float, deceleration: float, delay_s: float) -> float:
    """Largest speed from which another is come down to in the distance left: as ``stopping_speed``, but to that one."""
    if left <= 0.0:
        return speed
    return max(
        deceleration
        * (math.sqrt(delay_s * delay_s + (2.0 * left + speed * speed / deceleration) / deceleration) - delay_s),
        speed,
    )


def slew(current: float, wanted: float, acceleration: float, deceleration: float, dt_s: float) -> float:
    """The wanted signed speed, changed from the current one by no more than the limits allow in a time."""
    if current * wanted < 0.0:
        wanted = 0.0
    rate = acceleration if abs(wanted) > abs(current) else deceleration
    step = rate * max(dt_s, 0.0)
    return current + max(-step, min(step, wanted - current))
