"""Parameters of the node that runs and judges one inspection, beside those of the inspector that it holds."""

from __future__ import annotations

from dataclasses import dataclass

from yarm.params import param


@dataclass(frozen=True)
class InspectionRunParams:
    """One inspection: the truth it is judged by, how long to wait, where to write."""

    layout: str = param("practice", "", "the layout that is inspected")
    seed: int = param(3, "", "seed of the noise and the light; -1: the layout's own", -1, 2**31 - 1)
    folder: str = param("results/inspect", "", "folder of the results; made when missing")
    start_limit_s: float = param(120.0, "s", "wall time until the round must have begun", 1.0, 3600.0)
    stall_limit_s: float = param(60.0, "s", "wall time simulated time may stand still", 1.0, 3600.0)
    once: bool = param(True, "", "end with the round; false: the inspector goes on, and later rounds are not judged")
    film_hz: float = param(
        0.0, "Hz", "pictures a second of simulated time in run.film, which the console plays; 0: no film", 0.0, 30.0
    )
