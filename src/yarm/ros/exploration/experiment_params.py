"""Parameters of the node ``run_exploration``."""

from __future__ import annotations

from dataclasses import dataclass

from yarm.params import param


@dataclass(frozen=True)
class ExplorationRunParams:
    """One exploration: what to follow, how long to wait, where to write."""

    arena: str = param("practice", "", "the arena that is explored")
    seed: int = param(3, "", "seed of the noise and of the controller's draws", 0, 2**31 - 1)
    folder: str = param("results/explore", "", "folder of the results; made when missing")
    start_limit_s: float = param(120.0, "s", "wall time until the explorer must have started", 1.0, 3600.0)
    stall_limit_s: float = param(60.0, "s", "wall time simulated time may stand still", 1.0, 3600.0)
    film_hz: float = param(
        0.0, "Hz", "pictures a second of simulated time in run.film, which the console plays; 0: no film", 0.0, 30.0
    )
