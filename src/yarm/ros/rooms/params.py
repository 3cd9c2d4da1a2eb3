"""Parameters of the room's simulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from yarm.params import param
from yarm.sim.engine.room import RoomParams


@dataclass(frozen=True)
class RoomSimulationParams(RoomParams):
    """What ``config/exploration/room_simulation.yaml`` holds."""

    arena: str = param("practice", "", "shipped arena by name, or path of an arena file ending in .yaml")
    layout: str = param(
        "", "", "boxes with tags in place of an arena: practice, open_0, a file; the RGB camera sees it; empty: none"
    )
    seed: int = param(-1, "", "seed of all noise; -1 takes the arena's own", low=-1, high=2**31 - 1)
    real_time_factor: float = param(
        1.0, "", "greatest simulated seconds per second; 0 as fast as possible", low=0, high=100
    )
    gui: bool = param(False, "", "PyBullet's window")
    depth_every: int = param(1, "", "scans per depth image, when somebody listens", low=1, high=200)
    rgb_rate: float = param(30.0, "Hz", "frames of the RGB camera in a layout, when somebody listens", low=1, high=100)
    map_at_start: bool = param(
        True, "", "the map begins where the robot does: its frame is put there in the world, for pictures of the truth"
    )
    status_period: float = param(1.0, "s", "simulated time between two messages of sim/status", low=0.1, high=60)
    sync: bool = param(False, "", "lock-step: ten times a simulated second wait for every participant")
    participants: Tuple[str, ...] = param((), "", "lock-step: nodes that acknowledge every pass")
    wait_for_map: bool = param(True, "", "lock-step: wait for the transform map -> odom of every scan as well")
    sync_timeout: float = param(10.0, "s", "lock-step: wall time to wait for a participant", low=0.1, high=600)
