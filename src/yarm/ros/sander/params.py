"""Parameters of the sander's node."""

from __future__ import annotations

from dataclasses import dataclass

from yarm.control.sander.params import TOP_M, SanderParams
from yarm.params import param
from yarm.robots.hc10 import NAME
from yarm.safety.params import GuardParams


@dataclass(frozen=True)
class SanderNodeParams(SanderParams, GuardParams):
    """What ``config/cell/hc10_state_machine.yaml`` holds."""

    arm: str = param(NAME, "", "name of the arm; its topics are below it")
    scan_every: int = param(4, "", "one of so many clouds of the wrist camera is used while scanning", 1, 100)
    scan_stride: int = param(3, "", "one of so many rows and columns of a cloud is used", 1, 20)
    scan_volume_m: float = param(
        0.7, "m", "points further than this from the part's centre, x or y, are left out", 0.1, 2.0
    )
    scan_lowest_m: float = param(0.5, "m", "points below this height are left out", 0.0, TOP_M)
    status_hz: float = param(10.0, "Hz", "least rate of the status", 0.5, 60.0)
    sync: bool = param(
        False, "", "lock-step: act on a tick only with everything that belongs to it, and acknowledge it"
    )
    sync_after: str = param(
        "multi_robot_controls_server", "", "lock-step: node whose commands are awaited; empty: none"
    )
