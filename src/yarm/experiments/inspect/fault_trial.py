"""One trial of figure 11: the report's round with one of its known faults switched on, and what is kept of it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, Dict, List, Mapping

from yarm.experiments.inspect.measures import Measures, measure
from yarm.experiments.inspect.physics_run import run_physics_round
from yarm.experiments.inspect.runner import run_round
from yarm.experiments.inspect.switches import FAULTS, FAULTS_IN_PHYSICS
from yarm.experiments.inspect.trial import KINEMATIC, PHYSICS
from yarm.inspection.model import REPORT
from yarm.sim.scenes.layout_file import find_layout

LAYOUTS = ("practice", "open_0", "wall_0", "cluster_0", "corridor_0")
VARIANTS = {KINEMATIC: FAULTS, PHYSICS: FAULTS_IN_PHYSICS}
"""By world: variants of the report's round, and what is switched on in each."""
KEPT = ("right", "named_wrong", "end_s", "goals_failed", "distance_m", "home_m", "home_rad", "computing_s")
"""Figures of merit that a result keeps."""


@dataclass(frozen=True)
class FaultSpec:
    """What a trial is made of.

    Attributes:
        layout: name.
        fault: a name among the variants of its world.
        seed: of noise and light.
        world: KINEMATIC or PHYSICS.
    """

    layout: str
    fault: str
    seed: int
    world: str = KINEMATIC

    @property
    def key(self) -> str:
        """Unique name, good for a file."""
        number = list(VARIANTS[self.world]).index(self.fault)
        return f"{self.world}-{self.layout}-{number}-{self.seed:04d}"


@dataclass(frozen=True)
class FaultResult:
    """What a trial came to.

    Attributes:
        spec: what it was made of.
        boxes: in the layout.
        numbers: by the names of KEPT; units as in Measures.
    """

    spec: FaultSpec
    boxes: int
    numbers: Mapping[str, float]

    def to_json(self) -> Dict[str, Any]:
        """Plain values."""
        return dataclasses.asdict(self)

    @staticmethod
    def from_json(values: Mapping[str, Any]) -> FaultResult:
        """From plain values, as read back.

        Raises:
            TypeError: fields are missing or unknown.
            KeyError: the same.
        """
        numbers = {name: float(values["numbers"][name]) for name in KEPT}
        return FaultResult(FaultSpec(**values["spec"]), int(values["boxes"]), numbers)


def run_fault(spec: FaultSpec) -> FaultResult:
    """Run one trial."""
    run = run_round if spec.world == KINEMATIC else run_physics_round
    found: Measures = measure(run(find_layout(spec.layout), REPORT, spec.seed, VARIANTS[spec.world][spec.fault]))
    return FaultResult(spec, found.boxes, {name: round(float(getattr(found, name)), 4) for name in KEPT})


def fault_specs(layouts: int, world: str = KINEMATIC) -> List[FaultSpec]:
    """Every fault of a world in the first so many of LAYOUTS; layouts outermost."""
    return [FaultSpec(layout, fault, 0, world) for layout in LAYOUTS[:layouts] for fault in VARIANTS[world]]
