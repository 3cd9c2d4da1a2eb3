"""The exploration study's trials as the study's runner takes them, with what each of them depends on."""

from __future__ import annotations

from functools import lru_cache

from yarm.experiments.explore.trial import ExploreResult, ExploreSpec, run_trial
from yarm.experiments.study.runner import TrialKind, fingerprint
from yarm.experiments.study.sources import files_of
from yarm.exploration.registry import CONTROLLERS
from yarm.resources import resource

TRIAL = "yarm.experiments.explore.trial"


def code_of(spec: ExploreSpec) -> str:
    """Digest of what a trial depends on: world, judge and all else that a trial imports, and its own controller.

    The other controllers are left out, so a change of one has only its own trials run again. It reaches no compiled
    code; a trial uses none.
    """
    return _code_of(spec.controller)


@lru_cache(maxsize=None)
def _code_of(controller: str) -> str:
    own = CONTROLLERS[controller].__module__
    others = {make.__module__ for make in CONTROLLERS.values()} - {own}
    return fingerprint([*files_of([TRIAL, own], others), resource("scenes", "exploration")])


EXPLORE_TRIALS: TrialKind[ExploreSpec, ExploreResult] = TrialKind(run_trial, ExploreResult.from_json, code_of)
