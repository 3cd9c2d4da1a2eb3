"""Parameters of the controls server."""

from __future__ import annotations

from dataclasses import dataclass

from yarm.control.base.params import BaseParams
from yarm.control.hand import HandParams
from yarm.params import ParamError, param
from yarm.robots.hc10 import PRIVATE_AREA, area_text, parse_area
from yarm.safety.params import GuardParams


@dataclass(frozen=True)
class ControlsServerParams(BaseParams, HandParams, GuardParams):
    """What ``config/cell/multi_robot_controls_server.yaml`` holds."""

    stale_s: float = param(1.0, "s", "a robot whose pose is older than this is stopped and its goal aborted", 0.1, 10.0)
    hold_s: float = param(0.3, "s", "a robot whose pose is older than this stands still until it is fresh", 0.05, 5.0)
    gone_s: float = param(1.0, "s", "a robot missing from the seeds for this long loses its action server", 0.1, 60.0)
    feedback_hz: float = param(10.0, "Hz", "feedback of a goal under way", 0.5, 60.0)
    manipulator_timeout_s: float = param(180.0, "s", "a manipulator's goal is given up after this", 5.0, 3600.0)
    manipulator_area: str = param(
        area_text(PRIVATE_AREA),
        "cells",
        "private area of a manipulator whose station is at the world's origin: x from, to, y from, to, z from, to",
    )
    sync: bool = param(
        False, "", "lock-step: act on a tick only with everything that belongs to it, and acknowledge it"
    )
    sync_after: str = param("commander", "", "lock-step: node whose acknowledgement is awaited; empty for none")
    sync_set_hz: float = param(30.0, "Hz", "lock-step: camera sets, at whole multiples of their period", 1.0, 1000.0)

    def __post_init__(self) -> None:
        """Refuse an area that is none.

        Raises:
            ParamError: names the value and its form.
        """
        try:
            parse_area(self.manipulator_area)
        except ValueError as error:
            raise ParamError(f"manipulator_area: {error}") from error
