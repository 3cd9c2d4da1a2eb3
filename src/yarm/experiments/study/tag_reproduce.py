"""The part of ``rosrun yarm reproduce`` that is about recognition."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Callable

from yarm.experiments.study.runner import Progress
from yarm.experiments.study.tag_calibration import FIRST_TRAINING_VIEW, fitted, fitted_chance, write_calibration
from yarm.experiments.study.tag_figures import draw_figures
from yarm.experiments.study.tag_report import report_views
from yarm.experiments.study.tag_study import pieces, run_views

REPORT_EVERY = 4
"""The report's recognisers take ten times as long as ours."""


def add_options(options: argparse.ArgumentParser) -> None:
    """Options of this part."""
    options.add_argument("--views", type=int, default=10000, help="rendered views of tags")
    options.add_argument("--first-view", type=int, default=0, help="number of the first; others are other pictures")
    options.add_argument(
        "--report-every",
        type=int,
        default=REPORT_EVERY,
        help="every so many-th view is also shown to the report's recognisers; 0: none",
    )
    options.add_argument("--fit-views", type=int, default=0, help="views to fit the recogniser's weights to; 0: none")


def tags(options: argparse.Namespace, folder: Path, bar: Callable[[str], Progress]) -> str:
    """Recognition on rendered views, with its figures; the text to print.

    Args:
        options: as parsed.
        folder: to write to and to resume from; made when missing.
        bar: makes what shows the progress of a title.

    Raises:
        StudyError: views raised.
    """
    folder.mkdir(parents=True, exist_ok=True)
    texts = []
    if options.fit_views:
        training = pieces(FIRST_TRAINING_VIEW, options.fit_views, 0)
        seen = run_views(training, folder / "tag_trials", options.scheduler, options.workers, bar("tags, fit"))
        file = folder / "tag_calibration.yaml"
        write_calibration(fitted(seen), file)
        texts.append(f"weights fitted to {len(seen)} views: {file}")
        texts.append(f"chance that a look is final: {fitted_chance(seen)}")
    judged = pieces(options.first_view, options.views, options.report_every)
    results = run_views(judged, folder / "tag_trials", options.scheduler, options.workers, bar("tags"))
    texts.append(report_views(results, folder))
    texts += [f"figure: {path}" for path in draw_figures(folder)]
    return "\n".join(texts)
