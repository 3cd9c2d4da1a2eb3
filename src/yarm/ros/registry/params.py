"""Parameters of the cell's registry."""

from __future__ import annotations

from dataclasses import dataclass

from yarm.params import param
from yarm.sim.scenes.specs import DRAWN, NOT_DRAWN


@dataclass(frozen=True)
class CellRegistryParams:
    """What ``config/cell/cell_registry.yaml`` holds."""

    cell: str = param("1m1ma", "", "who is in the cell: shipped scene by name, or path of a scene file ending in .yaml")
    hands: bool = param(False, "", "the mobile robots carry a hand; false: those whose type has one")
    shapes: str = param(
        DRAWN,
        "",
        "none: nobody is told the mobile robots' shapes; drawn: as the scene says",
        choices=(DRAWN, NOT_DRAWN),
    )
    extrinsics: str = param("", "", "file of calibrate_cameras: cameras' frames to tell; empty: drivers tell them")
    frame_wait: float = param(
        2.0, "s", "wall time in which drivers may tell a fixed frame before it is told from here", low=0.0, high=60.0
    )
    silent_after: float = param(
        1.0, "s", "age of its oldest frame from which on a robot or arm is not in the cell", low=0.1, high=60.0
    )
    unseen_after: float = param(
        3.0, "s", "a piece that was named but is not seen for so long is worth a word", low=0.5, high=600.0
    )
    diagnostics_period: float = param(1.0, "s", "wall time between two messages on /diagnostics", low=0.1, high=60.0)
