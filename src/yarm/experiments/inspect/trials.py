"""The inspection study's trials as the study's runner takes them, with what each of them depends on."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, FrozenSet, List, Mapping

from yarm.experiments.inspect.fault_trial import FaultResult, FaultSpec, run_fault
from yarm.experiments.inspect.physics_run import run_physics_round
from yarm.experiments.inspect.trial import PHYSICS, InspectResult, InspectSpec, layout_of, result_of, run_trial
from yarm.experiments.study.runner import TrialKind, fingerprint
from yarm.experiments.study.sources import files_of
from yarm.inspection.model import CONTROLLERS, OURS, PRINTED, REPORT
from yarm.navigation import slam_native
from yarm.resources import resource
from yarm.sim.sensors import rays_native

TRIAL, FAULT = "yarm.experiments.inspect.trial", "yarm.experiments.inspect.fault_trial"
PHYSICS_RUN = "yarm.experiments.inspect.physics_run"
OWN: Mapping[str, FrozenSet[str]] = {
    OURS: frozenset({"yarm.inspection.round", "yarm.tags.recogniser", "yarm.tags.evidence", "yarm.tags.chance"}),
    REPORT: frozenset({"yarm.inspection.report_round"}),
    PRINTED: frozenset({"yarm.inspection.report_round", "yarm.inspection.printed_round", "yarm.tags.printed"}),
}
"""Modules that decide the rounds of some controllers alone; whatever these alone import goes with them."""
DATA = (("scenes", "inspection"), ("config", "inspection"))


def run_any(spec: InspectSpec) -> InspectResult:
    """Run a trial in its world."""
    if spec.world != PHYSICS:
        return run_trial(spec)
    layout = layout_of(spec.kind, spec.layout)
    return result_of(spec, layout, run_physics_round(layout, spec.controller, spec.seed))


def code_of(spec: InspectSpec) -> str:
    """Digest of what a trial depends on: world, judge and all else that a trial imports, and its own controller.

    In physics the libraries count that it loads; in the kinematic world it reaches no compiled code.
    """
    own = frozenset({spec.controller})
    return fingerprint_of_physics(own) if spec.world == PHYSICS else digest(TRIAL, own)


@lru_cache(maxsize=None)
def fingerprint_of_physics(controllers: FrozenSet[str], trial: str = TRIAL) -> str:
    """The digest of a module's trials in physics: that of the others, the physics, and the compiled libraries."""
    libraries: List[Any] = [slam_native.library_path(), rays_native.library_path()]
    sources = [digest(trial, controllers), digest(PHYSICS_RUN, controllers)]
    return "-".join([*sources, fingerprint([path for path in libraries if path is not None])])


def fault_code_of(spec: FaultSpec) -> str:
    """The same of a round with one of the report's faults, which may be the printed vote."""
    own = frozenset({REPORT, PRINTED})
    return fingerprint_of_physics(own, FAULT) if spec.world == PHYSICS else digest(FAULT, own)


@lru_cache(maxsize=None)
def digest(module: str, controllers: FrozenSet[str]) -> str:
    """Of a module and all it imports but what only other controllers take."""
    own = frozenset().union(*(OWN[name] for name in controllers))
    others = frozenset().union(*(OWN[name] for name in CONTROLLERS)) - own
    return fingerprint([*files_of([module, *sorted(own)], others), *(resource(*folder) for folder in DATA)])


INSPECT_TRIALS: TrialKind[InspectSpec, InspectResult] = TrialKind(run_any, InspectResult.from_json, code_of)
FAULT_TRIALS: TrialKind[FaultSpec, FaultResult] = TrialKind(run_fault, FaultResult.from_json, fault_code_of)
