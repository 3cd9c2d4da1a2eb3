"""The inspection study's trials as the study's runner takes them, with what each of them depends on."""

from __future__ import annotations

from functools import lru_cache
from typing import FrozenSet, Mapping

from yarm.experiments.inspect.fault_trial import FaultResult, FaultSpec, run_fault
from yarm.experiments.inspect.trial import InspectResult, InspectSpec, run_trial
from yarm.experiments.study.runner import TrialKind, fingerprint
from yarm.experiments.study.sources import files_of
from yarm.inspection.model import CONTROLLERS, OURS, PRINTED, REPORT
from yarm.resources import resource

TRIAL, FAULT = "yarm.experiments.inspect.trial", "yarm.experiments.inspect.fault_trial"
OWN: Mapping[str, FrozenSet[str]] = {
    OURS: frozenset({"yarm.inspection.round", "yarm.tags.recogniser", "yarm.tags.evidence", "yarm.tags.chance"}),
    REPORT: frozenset({"yarm.inspection.report_round"}),
    PRINTED: frozenset({"yarm.inspection.report_round", "yarm.inspection.printed_round", "yarm.tags.printed"}),
}
"""Modules that decide the rounds of some controllers alone; whatever these alone import goes with them."""
DATA = (("scenes", "inspection"), ("config", "inspection"))


def code_of(spec: InspectSpec) -> str:
    """Digest of what a trial depends on: world, judge and all else that a trial imports, and its own controller.

    It reaches no compiled code; a trial uses none.
    """
    return digest(TRIAL, frozenset({spec.controller}))


def fault_code_of(spec: FaultSpec) -> str:
    """The same of a round with one of the report's faults, which may be the printed vote."""
    return digest(FAULT, frozenset({REPORT, PRINTED}))


@lru_cache(maxsize=None)
def digest(module: str, controllers: FrozenSet[str]) -> str:
    """Of a module and all it imports but what only other controllers take."""
    own = frozenset().union(*(OWN[name] for name in controllers))
    others = frozenset().union(*(OWN[name] for name in CONTROLLERS)) - own
    return fingerprint([*files_of([module, *sorted(own)], others), *(resource(*folder) for folder in DATA)])


INSPECT_TRIALS: TrialKind[InspectSpec, InspectResult] = TrialKind(run_trial, InspectResult.from_json, code_of)
FAULT_TRIALS: TrialKind[FaultSpec, FaultResult] = TrialKind(run_fault, FaultResult.from_json, fault_code_of)
