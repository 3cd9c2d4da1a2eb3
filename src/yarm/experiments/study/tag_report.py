"""Tables and figures of the study of rendered views."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np

from yarm.experiments.run.plots import new_figure, save_figure
from yarm.experiments.run.tables import markdown_table
from yarm.experiments.statistics import Proportion, percentile
from yarm.experiments.study.tag_calibration import bins_of, expected_error
from yarm.experiments.study.tag_views import ViewResult, drawn
from yarm.tags.calibration import BLANK, UNKNOWN
from yarm.tags.evidence import ACCEPTING

EDGES = (0.0, 0.2, 0.4, 0.6, 0.8, 0.9, 0.95, 0.99, 0.999, 1.0)
CROWDED = 0.05
"""Counts beside points of the calibration's figure that are nearer to each other than this stand below each other."""
CLEAR_SHARE, CLEAR_M, CLEAR_DEG = 0.5, 0.8, 45.0
"""A view that must be right: so much of the tag, so near, so little from the side."""
NO_LINE = -9
NAMES = ("report", "report_printed", "yarm")


@dataclass(frozen=True)
class TagSummary:
    """What the views come to.

    Attributes:
        views: how many.
        right: ours, of all.
        clear_right: ours, of tags in clear views.
        false_tags: tags named wrongly at the accepting probability, of all views.
        named: strangers and blanks that were named a tag at the accepting probability.
        final: of the answered, those at the accepting probability.
        calibration_error: mean difference of probability and share that was right.
        seconds: median and 95th percentile of the processor time of a look.
        report: of those asked, right.
        printed: of those asked, right.
    """

    views: int
    right: Proportion
    clear_right: Proportion
    false_tags: Proportion
    named: Proportion
    final: Proportion
    calibration_error: float
    seconds: Tuple[float, float]
    report: Proportion
    printed: Proportion


def is_clear(result: ViewResult) -> bool:
    """Whether a tag must be recognised in a view."""
    view = drawn(result.number)
    near = view.distance_m <= CLEAR_M and abs(view.angle_deg) <= CLEAR_DEG
    return result.truth > 0 and near and result.visible >= CLEAR_SHARE


def _share(flags: Sequence[bool]) -> Proportion:
    return Proportion(sum(flags), len(flags))


def summarise_views(results: Sequence[ViewResult]) -> TagSummary:
    """All figures of merit."""
    clear = [r for r in results if is_clear(r)]
    sure = [r.answer is not None and r.probability >= ACCEPTING for r in results]
    wrong_tag = [s and (r.answer or 0) > 0 and r.answer != r.truth for s, r in zip(sure, results)]
    asked = [r for r in results if r.report is not None]
    seconds = [r.seconds for r in results]
    return TagSummary(
        len(results),
        _share([r.answer == r.truth for r in results]),
        _share([r.answer == r.truth for r in clear]),
        _share(wrong_tag),
        _share([wrong for wrong, r in zip(wrong_tag, results) if r.truth <= BLANK]),
        _share([s for s, r in zip(sure, results) if r.answer is not None]),
        expected_error(bins_of(results, EDGES)),
        (percentile(seconds, 50), percentile(seconds, 95)),
        _share([r.report == r.truth for r in asked]),
        _share([r.printed == r.truth for r in asked]),
    )


def summary_table(summary: TagSummary) -> str:
    """The figures of merit beside their targets, Markdown."""
    middle, most = (1000.0 * value for value in summary.seconds)
    rows = [
        ("views", str(summary.views), ""),
        ("right, all views", _counted(summary.right), ""),
        ("right, tags in clear views", _counted(summary.clear_right), ">= 99.5 %"),
        ("false tag at the accepting probability", _counted(summary.false_tags), "none"),
        ("strangers and blanks named a tag there", _counted(summary.named), "none"),
        ("answers that are final after one image", _counted(summary.final), ""),
        ("expected calibration error", f"{summary.calibration_error:.4f}", "<= 0.02"),
        ("processor time of a look, median / 95 %, ms", f"{middle:.0f} / {most:.0f}", "<= 60"),
        ("`report` right, on every image it was shown", _counted(summary.report), ""),
        ("`report_printed` right, the same", _counted(summary.printed), ""),
    ]
    return markdown_table(("measure", "value", "target"), rows)


def _counted(share: Proportion) -> str:
    if not share.trials:
        return "-"
    low, high = share.interval
    return f"{share.hits} of {share.trials}: {100 * share.rate:.1f} % ({100 * low:.1f}-{100 * high:.1f})"


def write_views(results: Sequence[ViewResult], path: Path) -> Path:
    """One line a view."""
    with path.open("w", newline="") as stream:
        writer = csv.writer(stream)
        header = ["number", "truth", "picture", "distance_m", "angle_deg", "blur_px", "gain", "hidden", "neighbours"]
        header += ["visible", "answer", "probability", "status", "likeness", "inliers", "texture", "seconds"]
        writer.writerow([*header, "report", "report_printed"])
        for r in results:
            view = drawn(r.number)
            row: List[object] = [r.number, r.truth, view.picture, f"{view.distance_m:.3f}", f"{view.angle_deg:.1f}"]
            row += [f"{view.imaging.blur_px:.2f}", f"{view.imaging.gain:.2f}", f"{view.hidden:.2f}", view.neighbours]
            best = r.tags[0] if r.tags else ("", "", "")
            row += [r.visible, r.answer, f"{r.probability:.6f}", r.status, best[1], best[2], r.texture, r.seconds]
            writer.writerow([*row, r.report, r.printed])
    return path


def plot_calibration(results: Sequence[ViewResult], folder: Path) -> Path:
    """``tag_calibration.png`` and its CSV: share that was right against the probability that was given."""
    bins = bins_of(results, EDGES)
    with (folder / "tag_calibration.csv").open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["low", "high", "mean_probability", "share_right", "answers"])
        writer.writerows([b.low, b.high, f"{b.mean:.5f}", f"{b.right:.5f}", b.count] for b in bins)
    figure, (axis,) = new_figure(5.6, 4.8)
    axis.plot([0, 1], [0, 1], ":", color="tab:grey")
    crowded = 0
    for before, b in zip([None, *bins], bins):
        crowded = crowded + 1 if before is not None and b.mean - before.mean < CROWDED else 0
        low, high = Proportion(round(b.right * b.count), b.count).interval
        bounds = [[max(0.0, b.right - low)], [max(0.0, high - b.right)]]
        axis.errorbar([b.mean], [b.right], bounds, fmt="o", color="tab:blue", capsize=3)
        beside = (5, -11 - 9 * crowded)
        axis.annotate(str(b.count), (b.mean, b.right), xytext=beside, textcoords="offset points", fontsize=8)
    error = expected_error(bins)
    title = f"{sum(b.count for b in bins)} answers, expected error {error:.4f}"
    axis.set(xlabel="probability given", ylabel="share that was right, 95 %", title=title)
    axis.grid(True, alpha=0.3)
    return save_figure(figure, folder / "tag_calibration.png")


def confusion(pairs: Sequence[Tuple[int, Optional[int]]]) -> Tuple[List[str], np.ndarray]:  # type: ignore[type-arg]
    """Names of the answers, and how often each truth (row) got each answer (column, the last for none)."""
    answers = [*range(1, 16), BLANK, UNKNOWN]
    place: Dict[Optional[int], int] = {answer: i for i, answer in enumerate(answers)}
    table = np.zeros((len(answers), len(answers) + 1), dtype=int)
    for truth, answer in pairs:
        table[place[truth], place.get(answer, len(answers))] += 1
    return [*(str(n) for n in range(1, 16)), "blank", "unknown", "none"], table


def plot_confusion(results: Sequence[ViewResult], folder: Path) -> Path:
    """``tag_confusion.png`` and its CSV: truth against answer of ``report``, ``report_printed`` and ``yarm``."""
    asked = [r for r in results if r.report is not None]
    shown = {
        "report": [(r.truth, r.report) for r in asked],
        "report_printed": [(r.truth, None if r.printed == NO_LINE else r.printed) for r in asked],
        "yarm": [(r.truth, r.answer) for r in results],
    }
    figure, axes = new_figure(16.0, 5.4, len(NAMES))
    with (folder / "tag_confusion.csv").open("w", newline="") as stream:
        writer = csv.writer(stream)
        for axis, name in zip(axes, NAMES):
            names, table = confusion(shown[name])
            writer.writerow([name, *names])
            writer.writerows([names[i], *row] for i, row in enumerate(table.tolist()))
            axis.imshow(np.log1p(table), cmap="Blues")
            for (row, column), count in np.ndenumerate(table):
                if count:
                    axis.text(column, row, str(count), ha="center", va="center", fontsize=6)
            right = int(np.trace(table[:, :-1]))
            axis.set(title=f"{name}: {right} of {int(table.sum())} right", xlabel="answer", ylabel="truth")
            axis.set_xticks(range(len(names)))
            axis.set_xticklabels(names, rotation=90, fontsize=7)
            axis.set_yticks(range(len(names) - 1))
            axis.set_yticklabels(names[:-1], fontsize=7)
    return save_figure(figure, folder / "tag_confusion.png")


def report_views(results: Sequence[ViewResult], folder: Path) -> str:
    """Write every table and figure of the views; the text to print."""
    folder.mkdir(parents=True, exist_ok=True)
    write_views(results, folder / "tag_views.csv")
    plot_calibration(results, folder)
    plot_confusion(results, folder)
    text = summary_table(summarise_views(results))
    (folder / "tag_summary.md").write_text(text + "\n")
    return text
