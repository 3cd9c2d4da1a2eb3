"""Alternatives side by side: distributions of the time to clear, pauses, least clearance, and why runs failed."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import List, Sequence, Tuple

import numpy as np

from yarm.experiments.html import number
from yarm.experiments.run.tables import text_table
from yarm.experiments.statistics import percentile
from yarm.experiments.what_if.trial import WhatIfResult

HEADER = ("alternative", "cleared", "s to clear p50", "p90", "pauses", "paused s p50", "clearance m", "refusals")


@dataclass(frozen=True)
class Answer:
    """One alternative over its runs; fields as in WhatIfAnswer.msg."""

    name: str
    runs: int
    cleared: int
    clear_p50_s: float
    clear_p90_s: float
    pauses_mean: float
    paused_p50_s: float
    least_clearance_m: float
    refusals: int
    reasons: Tuple[str, ...] = ()


def answers(results: Sequence[WhatIfResult], names: Sequence[str]) -> List[Answer]:
    """An answer for each alternative that has runs, in their order."""
    found = []
    for name in names:
        own = [result for result in results if result.spec.name == name]
        if own:
            found.append(_answer(name, own))
    return found


def _answer(name: str, own: Sequence[WhatIfResult]) -> Answer:
    times = [result.clear_s for result in own if result.cleared]
    counted = Counter(reason for result in own for reason in result.reasons)
    return Answer(
        name,
        len(own),
        len(times),
        percentile(times, 50),
        percentile(times, 90),
        float(np.mean([result.pauses for result in own])),
        percentile([result.paused_s for result in own], 50),
        min(result.least_m for result in own),
        sum(result.refusals for result in own),
        tuple(f"{count} x {reason}" for reason, count in counted.most_common()),
    )


def table(found: Sequence[Answer]) -> str:
    """The alternatives side by side, and below why runs did not clear."""
    rows = [
        (
            one.name,
            f"{one.cleared} of {one.runs}",
            number(one.clear_p50_s, 1),
            number(one.clear_p90_s, 1),
            number(one.pauses_mean, 1),
            number(one.paused_p50_s, 1),
            number(one.least_clearance_m, 3),
            str(one.refusals),
        )
        for one in found
    ]
    reasons = [f"{one.name}: {reason}" for one in found for reason in one.reasons]
    return "\n".join([text_table(HEADER, rows), *reasons])
