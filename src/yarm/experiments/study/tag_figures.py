"""Figures of recognition, each with its numbers as CSV: captures, spread, indicators, crop, detectors."""

from __future__ import annotations

import csv
from dataclasses import dataclass, replace
from pathlib import Path
from time import process_time
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

import cv2
import numpy as np

from yarm.experiments.inspect.sheet import our_pair, our_photo
from yarm.experiments.run.plots import new_figure, save_figure
from yarm.experiments.statistics import Proportion, percentile
from yarm.experiments.study.tag_views import TagView, drawn, picture_of, recogniser, report_recogniser, staged
from yarm.sim.sensors.rgb_camera import Imaging
from yarm.tags.calibration import BLANK, UNKNOWN
from yarm.tags.pictures import DESIGNS, contact_sheet, shipped_pictures
from yarm.tags.printed import LEAST_GOOD_PRINTED
from yarm.tags.report import (
    LEAST_AREA_PX2,
    LEAST_SHARE,
    ReportRecogniser,
    Sighting,
    cropped,
    predicted_angle_deg,
)

CAPTURES: Tuple[Tuple[float, float], ...] = ((0.2, 0.0), (0.5, 0.0), (0.8, 0.0), (0.5, 30.0), (0.5, 60.0), (0.5, 80.0))
"""Distances from the box's middle, metres, and angles, degrees."""
SPREAD = 100
INDICATOR_VIEWS, CROP_VIEWS, DETECTOR_VIEWS = 60, 40, 40
PROOF_VIEW = 4
"""A view of the table that is shown in full."""
DETECTORS = ("sift", "orb", "akaze")
FIRST_FIGURE_VIEW = 2_000_000
"""Views of figures are others than those of the table."""


@dataclass(frozen=True)
class Labelled:
    """A sighting in a drawn view, by the view's number, and whether its tag was the one on the box."""

    view: int
    sighting: Sighting
    right: bool


def plain_view(distance_m: float, angle_deg: float, tag: int, number: int = 0) -> TagView:
    """A tag in good light, with nothing else about."""
    return TagView(number, tag, "", distance_m, angle_deg, 0.16, Imaging(), 0.0, 0)


def tag_views_from(first: int, count: int, **changes: Any) -> List[TagView]:
    """Drawn views that show a tag, with some of their values fixed."""
    found: List[TagView] = []
    number = FIRST_FIGURE_VIEW + first
    while len(found) < count:
        view = drawn(number)
        if view.truth > 0:
            found.append(replace(view, **changes))
        number += 1
    return found


def write_rows(path: Path, header: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """A CSV file."""
    with path.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(header)
        writer.writerows(rows)


def plot_captures(folder: Path) -> Path:
    """What the camera shows from several places, whole and cropped, with the good matches of the right tag."""
    figure, axes = new_figure(15.0, 5.4, 2 * len(CAPTURES), rows=2)
    rows = []
    for i, (distance, angle) in enumerate(CAPTURES):
        frame, _, _ = staged(plain_view(distance, angle, 4))
        for crop, axis in zip((False, True), (axes[i], axes[i + len(CAPTURES)])):
            seen = next(s for s in report_recogniser(crop).look(frame.grey) if s.tag == 4)
            axis.imshow(cropped(frame.grey)[0] if crop else frame.grey, cmap="gray", vmin=0, vmax=255)
            axis.set(title=f"{distance} m, {angle:.0f} deg: {seen.good} good, {seen.rejection or 'kept'}"[:46])
            axis.title.set_fontsize(7)
            axis.axis("off")
            rows.append([distance, angle, int(crop), seen.good, f"{seen.area_px2:.0f}", seen.rejection])
    write_rows(folder / "tag_captures.csv", ["distance_m", "angle_deg", "crop", "good", "area_px2", "rejection"], rows)
    return save_figure(figure, folder / "tag_captures.png")


def plot_spread(folder: Path, count: int = SPREAD) -> Path:
    """Good matches, area and share over many pictures from one place: what differs is the noise alone."""
    one = ReportRecogniser({4: picture_of(4, "")})  # type: ignore[dict-item]
    rows = []
    for number in range(count):
        frame, _, _ = staged(plain_view(0.5, 20.0, 4, number))
        (seen,) = one.look(frame.grey)
        rows.append((number, seen.good, seen.area_px2, seen.share))
    write_rows(folder / "tag_spread.csv", ["picture", "good", "area_px2", "share"], rows)
    figure, axes = new_figure(11.0, 3.4, 3)
    shown = ((1, 1.0, "good matches"), (2, 1e-3, "area, 1000 px2"), (3, 1.0, "good matches / keypoints"))
    for axis, (column, unit, name) in zip(axes, shown):
        values = unit * np.array([row[column] for row in rows], dtype=float)
        axis.hist(values, bins=20, color="tab:blue")
        axis.set(xlabel=name, title=f"{values.mean():.4g} +- {values.std():.2g}")
    axes[0].set_ylabel(f"pictures of {count}")
    return save_figure(figure, folder / "tag_spread.png")


def labelled_sightings(count: int) -> List[Labelled]:
    """Sightings of all tags in drawn views, right and wrong ones."""
    found = []
    for view in tag_views_from(0, count):
        frame, _, _ = staged(view)
        sightings = report_recogniser().look(frame.grey, 1, predicted_angle_deg(view.angle_deg))
        found += [Labelled(view.number, s, s.tag == view.truth) for s in sightings]
    return found


@dataclass(frozen=True)
class Indicator:
    """One of the report's indicators.

    Attributes:
        name: for axis and table.
        column: name of its column in the table of values.
        value: of a sighting.
        threshold: of the report; None where it has none.
        logarithmic: its axis.
        binary: it is 0 or 1.
        more_is_better: whether right tags have more of it.
    """

    name: str
    column: str
    value: Callable[[Sighting], float]
    threshold: Optional[float] = None
    logarithmic: bool = False
    binary: bool = False
    more_is_better: bool = True


INDICATORS = (
    Indicator("3 area, px2", "area_px2", lambda s: s.area_px2, LEAST_AREA_PX2, logarithmic=True),
    Indicator("4 good matches / keypoints of the tag", "share", lambda s: s.share, LEAST_SHARE),
    Indicator("6 tangled: 0, not: 1", "untangled", lambda s: float(not s.tangled), 0.5, binary=True),
    Indicator("7 keypoints in the image", "keypoints", lambda s: float(s.keypoints)),
    Indicator("8 good matches", "good", lambda s: float(s.good), float(LEAST_GOOD_PRINTED)),
    Indicator(
        "9 angle off 90 at most, deg",
        "off_square_deg",
        lambda s: max(abs(a - 90.0) for a in s.angles),
        more_is_better=False,
    ),
    Indicator(
        "10, 12 angle - predicted, deg",
        "off_predicted_deg",
        lambda s: abs(s.bottom_left_deg - s.predicted_deg),
        more_is_better=False,
    ),
    Indicator("11 effective area, px2", "effective_px2", lambda s: s.effective_px2),
)


@dataclass(frozen=True)
class Curve:
    """How well a number tells right from wrong, threshold by threshold.

    Attributes:
        thresholds: falling, the first one infinite; at each what has as much or more is taken.
        false: share of the wrong ones that are taken.
        true: share of the right ones.
        area: under the curve; 0.5 is a coin's.
    """

    thresholds: Tuple[float, ...]
    false: Tuple[float, ...]
    true: Tuple[float, ...]
    area: float


def roc(right: Sequence[float], wrong: Sequence[float]) -> Curve:
    """The receiver operating characteristic of a number of which right ones have more."""
    thresholds = (np.inf, *np.unique([*right, *wrong])[::-1].tolist())
    true = tuple(float(np.mean(np.asarray(right) >= t)) for t in thresholds)
    false = tuple(float(np.mean(np.asarray(wrong) >= t)) for t in thresholds)
    return Curve(thresholds, false, true, float(np.trapz(true, false)))


def plot_indicators(folder: Path, count: int = INDICATOR_VIEWS) -> Path:
    """Distribution of each indicator for right and wrong tags with its threshold, error rates, and ROC.

    Only sightings with an outline count. Besides the figure: the rates, every value, and every point of the curves.
    """
    sightings = [item for item in labelled_sightings(count) if item.sighting.corners is not None]
    figure, axes = new_figure(18.0, 6.6, len(INDICATORS) + 2, rows=2)
    rows, points = [], []
    for axis, indicator in zip(axes, INDICATORS):
        right, wrong = (
            [v for item in sightings if item.right == truth for v in [indicator.value(item.sighting)] if np.isfinite(v)]
            for truth in (True, False)
        )
        _histogram(axis, indicator, right, wrong)
        sign = 1.0 if indicator.more_is_better else -1.0
        curve = roc([sign * v for v in right], [sign * v for v in wrong])
        points += [
            [indicator.column, f"{sign * t:.6g}", f"{false:.4f}", f"{true:.4f}"]
            for t, false, true in zip(curve.thresholds, curve.false, curve.true)
        ]
        axes[-2].plot(curve.false, curve.true, label=f"{indicator.name}: {curve.area:.2f}")
        rates = ["", ""]
        if indicator.threshold is not None:
            missed = float(np.mean(np.array(right) <= indicator.threshold))
            taken = float(np.mean(np.array(wrong) > indicator.threshold))
            rates = [f"{missed:.4f}", f"{taken:.4f}"]
            axis.set_title(f"misses {100 * missed:.0f} % right, takes {100 * taken:.0f} % wrong", fontsize=9)
        rows.append([indicator.name, indicator.threshold, *rates, f"{curve.area:.4f}", len(right), len(wrong)])
    axes[-2].set(xlabel="wrong tags taken", ylabel="right tags taken", title="ROC")
    handles, labels = axes[-2].get_legend_handles_labels()
    axes[-1].axis("off")
    axes[-1].legend(handles, labels, fontsize="small", loc="center", title="area under the ROC")
    header = ["indicator", "threshold", "right_missed", "wrong_taken", "area_under_roc", "right", "wrong"]
    write_rows(folder / "tag_indicators.csv", header, rows)
    write_rows(folder / "tag_roc.csv", ["indicator", "threshold", "wrong_taken", "right_taken"], points)
    _write_values(folder / "tag_indicator_values.csv", sightings)
    return save_figure(figure, folder / "tag_indicators.png")


def _write_values(path: Path, sightings: Sequence[Labelled]) -> None:
    """A row a sighting: the view, the tag, whether it is on the box, and every indicator."""
    header = ["view", "tag", "right", *(indicator.column for indicator in INDICATORS)]
    rows = [
        [item.view, item.sighting.tag, int(item.right), *(f"{i.value(item.sighting):.6g}" for i in INDICATORS)]
        for item in sightings
    ]
    write_rows(path, header, rows)


def _histogram(axis: Any, indicator: Indicator, right: Sequence[float], wrong: Sequence[float]) -> None:
    """Shares of right and of wrong tags by the indicator's value, with the threshold."""
    low, high = np.percentile([*right, *wrong], [2, 98])
    bins = np.geomspace(1.0, max(high, 1e4), 25) if indicator.logarithmic else np.linspace(low, high, 25)
    if indicator.binary:
        bins = np.array([-0.25, 0.25, 0.75, 1.25])
    for values, colour, label in ((wrong, "tab:red", "wrong tag"), (right, "tab:green", "right tag")):
        shown = np.clip(values, bins[0], bins[-1])
        axis.hist(shown, bins=bins, weights=np.full(len(shown), 1 / len(shown)), alpha=0.55, color=colour, label=label)
    if indicator.threshold is not None:
        axis.axvline(indicator.threshold, color="black", lw=1)
    axis.set(xlabel=indicator.name, ylabel="share", xscale="log" if indicator.logarithmic else "linear")
    axis.legend(fontsize="small")


def right_by_report(
    recogniser: ReportRecogniser, views: Sequence[TagView], coloured: bool = False
) -> Tuple[Proportion, List[float]]:
    """Views in which the right tag alone survives, and the processor time of each, s; of pictures grey or coloured."""
    hits, seconds = 0, []
    for view in views:
        frame, _, _ = staged(view)
        picture = frame.rgb() if coloured else frame.grey
        began = process_time()
        sightings = recogniser.look(picture)
        seconds.append(process_time() - began)
        hits += [s.tag for s in sightings if not s.rejection] == [view.truth]
    return Proportion(hits, len(views)), seconds


def plot_crop(folder: Path, count: int = CROP_VIEWS) -> Path:
    """The report's recognition with and without its crop, grey and coloured, at boxes alone and between two others."""
    rows, bars = [], []
    for neighbours in (0, 2):
        views = tag_views_from(500, count, neighbours=neighbours, hidden=0.0, distance_m=0.6, angle_deg=15.0)
        for crop, coloured in ((False, False), (True, False), (True, True)):
            share, seconds = right_by_report(report_recogniser(crop), views, coloured)
            name = f"{'clustered' if neighbours else 'alone'}\n{'crop' if crop else 'whole'}"
            bars.append((f"{name}, colour" if coloured else name, share, percentile(seconds, 50)))
            cells = [share.hits, share.trials, f"{1000 * percentile(seconds, 50):.1f}"]
            rows.append([neighbours, int(crop), int(coloured), *cells])
    write_rows(folder / "tag_crop.csv", ["neighbours", "crop", "coloured", "right", "views", "median_ms"], rows)
    return _bars(bars, folder / "tag_crop.png")


def plot_detectors(folder: Path, count: int = DETECTOR_VIEWS) -> Path:
    """Accuracy of the report's recognition against processor time, for each detector."""
    views = tag_views_from(900, count)
    tags: Dict[int, Any] = {number: picture_of(number, "") for number in DESIGNS}
    rows, bars = [], []
    for name in DETECTORS:
        share, seconds = right_by_report(ReportRecogniser(tags, name), views)
        bars.append((name, share, percentile(seconds, 50)))
        rows.append([name, share.hits, share.trials, f"{1000 * percentile(seconds, 50):.1f}"])
    write_rows(folder / "tag_detectors.csv", ["detector", "right", "views", "median_ms"], rows)
    return _bars(bars, folder / "tag_detectors.png")


def _bars(bars: Sequence[Tuple[str, Proportion, float]], path: Path) -> Path:
    figure, axes = new_figure(9.0, 3.6, 2)
    places = range(len(bars))
    shares = np.array([share.rate for _, share, _ in bars])
    bounds = np.array([share.interval for _, share, _ in bars])
    axes[0].bar(places, shares, yerr=np.abs(np.stack([shares - bounds[:, 0], bounds[:, 1] - shares])), capsize=4)
    axes[0].set(ylabel="the right tag alone is kept, 95 %", ylim=(0, 1.05))
    axes[1].bar(places, [1000.0 * seconds for _, _, seconds in bars], color="tab:orange")
    axes[1].set(ylabel="processor time an image, ms")
    for axis in axes:
        axis.set_xticks(list(places))
        axis.set_xticklabels([name for name, _, _ in bars], fontsize=8)
    return save_figure(figure, path)


def plot_tags(folder: Path) -> Path:
    """The fifteen tags, beside each other."""
    path = folder / "tag_pictures.png"
    cv2.imwrite(str(path), contact_sheet({str(number): p for number, p in shipped_pictures().items()}))
    return path


def plot_proof(folder: Path, number: int = PROOF_VIEW) -> Path:
    """One look of ours: the image with the predicted and the found outline, face beside tag with matches, answers."""
    frame, told, _ = staged(drawn(number))
    look = recogniser().look(frame.grey, told)
    best = look.fits[0]
    figure, axes = new_figure(14.0, 4.2, 3)
    axes[0].imshow(cv2.cvtColor(our_photo(frame.grey, told, look), cv2.COLOR_BGR2RGB))
    axes[0].set_title("orange: where the pose puts the face, green: where the tag lies", fontsize=9)
    pair = our_pair(frame.grey, told, look, shipped_pictures())
    if pair is not None:
        axes[1].imshow(cv2.cvtColor(pair, cv2.COLOR_BGR2RGB))
    title = f"tag {best.tag} and the face, upright: likeness {best.likeness:.2f}, {best.inliers} matches"
    axes[1].set_title(title, fontsize=9)
    names = {BLANK: "blank", UNKNOWN: "unknown"}
    axes[2].bar([names.get(a, str(a)) for a in look.probabilities], list(look.probabilities.values()))
    axes[2].set(yscale="log", ylim=(1e-12, 2.0), ylabel="probability")
    axes[2].tick_params(axis="x", rotation=90)
    for axis in axes[:2]:
        axis.axis("off")
    return save_figure(figure, folder / "tag_proof.png")


DRAWN = (plot_tags, plot_proof, plot_captures, plot_spread, plot_indicators, plot_crop, plot_detectors)


def draw_figures(folder: Path) -> List[Path]:
    """Every figure of recognition."""
    folder.mkdir(parents=True, exist_ok=True)
    return [draw(folder) for draw in DRAWN]
