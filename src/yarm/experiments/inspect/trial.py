"""One trial of the inspection study: a round in a layout of the benchmark, and what is kept of it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Dict, Mapping, Tuple

from yarm.experiments.inspect.measures import measure
from yarm.experiments.inspect.record import RoundRecord
from yarm.experiments.inspect.runner import run_round
from yarm.sim.scenes.layout import Layout
from yarm.sim.scenes.layout_maker import make_layout

KINEMATIC, PHYSICS = "kinematic", "physics"
NUMBERS = (
    "right",
    "named_wrong",
    "end_s",
    "home_m",
    "home_rad",
    "distance_m",
    "bumps",
    "place_p95_m",
    "place_p95_deg",
    "looking_s",
    "slowest_look_s",
    "computing_s",
)
"""Figures of merit that a result keeps."""


@dataclass(frozen=True)
class InspectSpec:
    """What a trial is made of.

    Attributes:
        kind: of the layout.
        layout: its seed.
        controller: who drives the round.
        seed: of noise and light.
        world: KINEMATIC or PHYSICS.
    """

    kind: str
    layout: int
    controller: str
    seed: int
    world: str = KINEMATIC

    @property
    def key(self) -> str:
        """Unique name, good for a file."""
        world = "" if self.world == KINEMATIC else f"{self.world}-"
        return f"{world}{self.kind}_{self.layout}-{self.controller}-{self.seed:04d}"


@dataclass(frozen=True)
class InspectResult:
    """What a trial came to.

    Attributes:
        spec: what it was made of.
        kept: home in time, by the truth.
        boxes: in the layout.
        numbers: by the names of NUMBERS; units as in Measures.
        unread: numbers of the boxes that got no or a wrong verdict, and the reason of each.
    """

    spec: InspectSpec
    kept: bool
    boxes: int
    numbers: Mapping[str, float]
    unread: Tuple[Tuple[int, str], ...]

    @property
    def all_right(self) -> bool:
        """Every box was read right."""
        return self.numbers["right"] == self.boxes

    def to_json(self) -> Dict[str, Any]:
        """Plain values."""
        return dataclasses.asdict(self)

    @staticmethod
    def from_json(values: Mapping[str, Any]) -> InspectResult:
        """From plain values, as read back.

        Raises:
            TypeError: fields are missing or unknown.
            KeyError: the same.
        """
        plain = dict(values)
        plain["spec"] = InspectSpec(**plain["spec"])
        plain["numbers"] = {name: float(plain["numbers"][name]) for name in NUMBERS}
        plain["unread"] = tuple((int(box), str(reason)) for box, reason in plain["unread"])
        return InspectResult(**plain)


def run_trial(spec: InspectSpec) -> InspectResult:
    """Run one trial in the kinematic world."""
    layout = layout_of(spec.kind, spec.layout)
    return result_of(spec, layout, run_round(layout, spec.controller, spec.seed))


def result_of(spec: InspectSpec, layout: Layout, record: RoundRecord) -> InspectResult:
    """What is kept of a record."""
    wrong = [v for v in record.verdicts if v.reading.tag != layout.tags[v.box - 1]]
    unread = tuple((v.box, v.reason or f"read as {v.reading.tag}") for v in wrong)
    measures = measure(record)
    numbers = {name: round(float(getattr(measures, name)), 4) for name in NUMBERS}
    return InspectResult(spec, measures.kept, len(layout.boxes), numbers, unread)


@lru_cache(maxsize=8)
def layout_of(kind: str, seed: int) -> Layout:
    """A layout of the benchmark."""
    return make_layout(kind, seed)
