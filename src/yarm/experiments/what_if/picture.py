"""The picture of an answer: when the runs of each alternative had cleared, and how long the arms were paused."""

from __future__ import annotations

from pathlib import Path
from typing import Sequence

import numpy as np

from yarm.experiments.run.plots import COLOURS, new_figure, save_figure
from yarm.experiments.what_if.trial import WhatIfResult

LONGER = 1.05
"""The axis of time goes on beyond the last run by this factor."""


def plot(results: Sequence[WhatIfResult], names: Sequence[str], path: Path, title: str) -> Path:
    """Share of the runs that have cleared by a time, and how long the manipulators were paused, run by run."""
    figure, (left, right) = new_figure(11.0, 4.2, 2)
    last_s = max((result.clear_s for result in results if result.cleared), default=0.0)
    for k, name in enumerate(names):
        own = [result for result in results if result.spec.name == name]
        times = sorted(result.clear_s for result in own if result.cleared)
        shares = np.arange(1, len(times) + 1) / max(1, len(own))
        colour = COLOURS[k % len(COLOURS)]
        marker = "os^Dv<>p"[k % 8]
        left.step(
            [0.0, *times, LONGER * last_s], [0.0, *shares, len(times) / max(1, len(own))], where="post", color=colour
        )
        left.plot(times, shares, marker, color=colour, ms=4, label=name)
        paused = [result.paused_s for result in own]
        spread = k + 0.3 * ((np.arange(len(paused)) + 0.5) / max(1, len(paused)) - 0.5)
        right.plot(spread, paused, marker, color=colour, ms=5, alpha=0.7)
        if paused:
            right.plot([k - 0.3, k + 0.3], [float(np.median(paused))] * 2, "-", color=colour, lw=2)
    left.set(xlabel="simulated time, s", ylabel="share of runs cleared", ylim=(-0.02, 1.05), title=title)
    left.set_xlim(left=0.0)
    left.grid(True, alpha=0.3)
    left.legend(fontsize="small", loc="upper left")
    right.set(ylabel="s paused in a run (line: median)", title="manipulators")
    right.set_xticks(range(len(names)))
    right.set_xticklabels(names, rotation=15, ha="right", fontsize="small")
    right.set_ylim(0.0, 1.1 * max([1.0, *(result.paused_s for result in results)]))
    return save_figure(figure, path)
