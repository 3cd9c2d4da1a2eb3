"""Parameters of the simulation node."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from yarm.params import param
from yarm.sim.engine.world import WorldParams
from yarm.sim.scenes.specs import DRAWN, NOT_DRAWN


@dataclass(frozen=True)
class SimulationParams(WorldParams):
    """What ``config/cell/simulation.yaml`` holds."""

    scene: str = param("1m1ma", "", "shipped scene by name, or path of a scene file ending in .yaml")
    seed: int = param(
        -1, "", "seed of the layout and of the depth noise; -1 takes the scene's own", low=-1, high=2**31 - 1
    )
    vary: bool = param(True, "", "a seed other than the scene's own changes its layout where the scene says how")
    hands: bool = param(False, "", "the mobile robots carry a hand: a lift with a suction cup at the arm's tip")
    shapes: str = param(
        DRAWN,
        "",
        "none: nobody is told the mobile robots' shapes; drawn: as the scene says",
        choices=(DRAWN, NOT_DRAWN),
    )
    registry: bool = param(
        True, "", "tell who is in the cell (object_registry, their frames); false: only what drivers would, as hardware"
    )
    depth_noise: bool = param(True, "", "Kinect-like noise on the depth cameras")
    real_time_factor: float = param(
        1.0, "", "greatest simulated seconds per second; 0 as fast as possible", low=0, high=100
    )
    cmd_vel_timeout: float = param(
        0.5, "s", "simulated time after its last cmd_vel that a robot stops; 0 for never", low=0, high=3600
    )
    arm_timeout: float = param(
        0.5, "s", "simulated time after its sander's last word that an arm stops; 0 for never", low=0, high=3600
    )
    gui: bool = param(False, "", "PyBullet's window")
    status_period: float = param(1.0, "s", "simulated time between two messages of sim/status", low=0.1, high=60)
    clearance_every: int = param(1, "", "camera sets per message of sim/clearance", low=1, high=300)
    sync: bool = param(False, "", "lock-step: after each tick wait for every participant")
    tick_participants: Tuple[str, ...] = param((), "", "lock-step: nodes that acknowledge every tick")
    arm_participants: Tuple[str, ...] = param(
        ("hc10_state_machine",), "", "lock-step: those of them that have nothing to say where no manipulator is"
    )
    set_participants: Tuple[str, ...] = param((), "", "lock-step: nodes that acknowledge every camera set")
    wait_for_metadata: bool = param(True, "", "lock-step: wait for planning_metadata of every camera set")
    sync_timeout: float = param(10.0, "s", "lock-step: wall time to wait for a participant", low=0.1, high=600)
    sync_start: float = param(30.0, "s", "lock-step: simulated time its first step is at", low=1, high=600)
