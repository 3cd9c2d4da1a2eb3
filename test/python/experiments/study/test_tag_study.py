"""The study of rendered views: it can be stopped and gone on with, its fit and its figures of merit are right."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from typing import Dict, List, Optional, Sequence

import numpy as np
import pytest

from yarm.experiments.study import tag_reproduce
from yarm.experiments.study.reproduce import parser
from yarm.experiments.study.runner import StudyError, load_trials
from yarm.experiments.study.tag_calibration import bins_of, expected_error, fitted, fitted_chance, write_calibration
from yarm.experiments.study.tag_figures import (
    plot_crop,
    plot_indicators,
    plot_proof,
    plot_spread,
    plot_tags,
    roc,
    tag_views_from,
)
from yarm.experiments.study.tag_report import confusion, is_clear, report_views, summarise_views
from yarm.experiments.study.tag_study import PIECE, PIECES, Piece, pieces, run_views
from yarm.experiments.study.tag_views import TagView, ViewResult, drawn, looked, staged
from yarm.geometry.pinhole import face_corners
from yarm.tags.calibration import BLANK, UNKNOWN, load_calibration, probabilities


def rows_of(path: Path) -> List[Dict[str, str]]:
    with path.open() as stream:
        return list(csv.DictReader(stream))


def result(number: int, truth: int, answer: Optional[int], probability: float = 1.0) -> ViewResult:
    return ViewResult(number, truth, 0.9, answer, probability, "looked, in place", ((3, 0.9, 30),), 0.3, 0.02)


def test_a_view_is_drawn_from_its_number_alone() -> None:
    assert drawn(12) == drawn(12)
    views = [drawn(n) for n in range(400)]
    assert {v.truth for v in views} == {*range(1, 16), BLANK, UNKNOWN}
    assert all(0.3 <= v.distance_m <= 1.2 and abs(v.angle_deg) <= 65.0 for v in views)
    assert all(0.0 <= v.imaging.blur_px <= 4.0 and 0.0 <= v.hidden <= 0.5 for v in views)
    assert {v.neighbours for v in views} == {0, 1, 2}


def test_the_post_hides_the_share_it_should() -> None:
    open_view = next(v for v in tag_views_from(0, 40, neighbours=0, distance_m=0.9, angle_deg=10.0))
    shares = [looked(replace(open_view, hidden=hidden), False).visible for hidden in (0.0, 0.25, 0.5)]
    assert shares[0] - shares[1] == pytest.approx(0.25, abs=0.06)
    assert shares[0] - shares[2] == pytest.approx(0.5, abs=0.08)


def test_a_staged_view_is_told_a_pose_that_is_a_little_wrong() -> None:
    view: TagView = drawn(3)
    frame, told, corners = staged(view)
    again, _, _ = staged(view)
    assert np.array_equal(frame.grey, again.grey)
    assert corners.shape == (4, 2)
    pose = told.face_pose
    expected = told.camera.project(face_corners(0.5, 0.4) @ pose[:3, :3].T + pose[:3, 3])
    assert 0.1 < np.abs(expected - corners).max() < 60.0


def test_pieces_cover_every_view_once() -> None:
    numbers = [n for p in pieces(7, 2 * PIECE + 3, 4) for n in range(p.first, p.first + p.count)]
    assert numbers == list(range(7, 7 + 2 * PIECE + 3))


def test_what_is_on_disk_is_not_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ran: List[int] = []

    def counted(view: TagView, with_report: bool) -> ViewResult:
        ran.append(view.number)
        return result(view.number, view.truth, view.truth)

    monkeypatch.setattr("yarm.experiments.study.tag_study.looked", counted)
    wanted = [Piece(0, 3, 0), Piece(3, 2, 0)]
    assert [r.number for r in run_views(wanted[:1], tmp_path, workers=1)] == [0, 1, 2]
    first = run_views(wanted, tmp_path, workers=1)
    assert ran == [0, 1, 2, 3, 4]
    assert run_views(wanted, tmp_path, workers=1) == first
    assert ran == [0, 1, 2, 3, 4]
    (tmp_path / f"{wanted[0].key}.json").write_text("{")
    run_views(wanted, tmp_path, workers=1)
    assert ran[5:] == [0, 1, 2]


def test_a_piece_that_raises_is_named_and_the_others_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def faulty(view: TagView, with_report: bool) -> ViewResult:
        if view.number == 1:
            raise RuntimeError("out of paint")
        return result(view.number, view.truth, view.truth)

    monkeypatch.setattr("yarm.experiments.study.tag_study.looked", faulty)
    with pytest.raises(StudyError, match=r"1 of 2 trials failed: views_0_2_0: RuntimeError\('out of paint'\)"):
        run_views([Piece(0, 2, 0), Piece(2, 2, 0)], tmp_path, workers=1)
    assert list(load_trials(PIECES, tmp_path, [Piece(2, 2, 0)])) == ["views_2_2_0"]


def test_a_real_piece_names_its_tags(tmp_path: Path) -> None:
    results = run_views([Piece(0, 6, 6)], tmp_path / "views", workers=1)
    assert [r.number for r in results] == list(range(6))
    assert results[0].report is not None
    assert results[1].report is None
    assert not any((r.answer or 0) > 0 and r.answer != r.truth for r in results)
    for r in results:
        if r.measures is not None:
            shares = probabilities(r.measures, load_calibration())
            assert shares[r.answer] == pytest.approx(r.probability, abs=0.02), "rounded measures"


def test_the_figures_of_merit() -> None:
    results = [result(n, 3, 3) for n in range(8)] + [result(8, UNKNOWN, 3, 0.9995), result(9, 5, None, 0.0)]
    summary = summarise_views(results)
    assert (summary.right.hits, summary.right.trials) == (8, 10)
    assert (summary.false_tags.hits, summary.named.hits, summary.named.trials) == (1, 1, 1)
    assert summary.final.trials == 9
    near = next(n for n in range(99) if drawn(n).distance_m < 0.8 and abs(drawn(n).angle_deg) < 45.0)
    assert is_clear(result(near, 3, 3))
    assert not is_clear(replace(result(near, 3, 3), visible=0.4))


def test_bins_hold_every_answer_once_and_their_error_is_weighted() -> None:
    results = [result(n, 3, 3 if n < 9 else 4, 0.9) for n in range(10)] + [result(10, 3, 3, 1.0), result(11, 3, None)]
    bins = bins_of(results, (0.0, 0.5, 0.95, 1.0))
    assert [(b.count, round(b.right, 3)) for b in bins] == [(10, 0.9), (1, 1.0)]
    assert expected_error(bins) == pytest.approx(0.0, abs=1e-9)
    assert expected_error(bins_of([result(0, 3, 4, 0.8)], (0.0, 1.0))) == pytest.approx(0.8)


def test_the_fit_finds_weights_that_tell_the_answers_apart(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    results = []
    for n in range(300):
        truth = (3, BLANK, UNKNOWN)[n % 3]
        likeness, inliers = (rng.uniform(0.6, 0.95), 30) if truth == 3 else (rng.uniform(0.0, 0.3), 0)
        texture = rng.uniform(0.005, 0.03) if truth == BLANK else rng.uniform(0.2, 0.4)
        tags = ((3, float(likeness), inliers), (4, 0.1, 0))
        results.append(replace(result(n, truth, 3), tags=tags, texture=float(texture)))
    weights = fitted(results)
    shares = [probabilities(r.measures, weights)[r.truth] for r in results if r.measures is not None]
    assert min(shares) > 0.9
    write_calibration(weights, tmp_path / "weights.yaml")
    assert load_calibration(tmp_path / "weights.yaml") == weights
    with pytest.raises(ValueError, match="none of 1 views could be judged"):
        fitted([result(0, 3, None)])


def test_the_chance_of_a_look_is_fitted_to_what_came_of_tags() -> None:
    results = []
    for n in (n for n in range(400) if drawn(n).truth > 0):
        right = abs(drawn(n).angle_deg) < 50.0
        results.append(result(n, 3, 3 if right else UNKNOWN))
    chance = fitted_chance(results)
    assert chance.of(0.9, 30.0, 0.6) > 0.9 > 0.3 > chance.of(0.9, 65.0, 0.6)
    with pytest.raises(ValueError, match="none of 1 views shows a tag"):
        fitted_chance([result(0, BLANK, BLANK)])


def test_the_confusion_table_counts_truths_in_rows() -> None:
    names, table = confusion([(1, 1), (1, None), (BLANK, UNKNOWN)])
    assert table.sum() == 3
    assert table[0, 0] == table[0, -1] == table[15, 16] == 1
    assert names[15:] == ["blank", "unknown", "none"]


def test_every_table_and_figure_is_written(tmp_path: Path) -> None:
    results = [replace(result(n, drawn(n).truth, drawn(n).truth, 0.99), report=0, printed=-9) for n in range(30)]
    assert "right, all views | 30 of 30" in report_views(results, tmp_path)
    names = {"tag_views.csv", "tag_calibration.csv", "tag_calibration.png", "tag_confusion.csv", "tag_confusion.png"}
    assert names <= {path.name for path in tmp_path.iterdir()}
    assert len((tmp_path / "tag_views.csv").read_text().splitlines()) == 31
    assert plot_spread(tmp_path, 3).is_file()
    assert plot_proof(tmp_path).is_file()
    assert plot_tags(tmp_path).is_file()
    assert plot_crop(tmp_path, 1).is_file()
    rows = [line.split(",")[:3] for line in (tmp_path / "tag_crop.csv").read_text().splitlines()[1:]]
    assert rows == [[alone, *how] for alone in "02" for how in (("0", "0"), ("1", "0"), ("1", "1"))]


def test_the_curve_of_a_perfect_measure_has_area_one() -> None:
    curve = roc([3.0, 4.0], [1.0, 2.0])
    assert curve.area == pytest.approx(1.0) and curve.thresholds == (np.inf, 4.0, 3.0, 2.0, 1.0)
    assert curve.true == (0.0, 0.5, 1.0, 1.0, 1.0) and curve.false == (0.0, 0.0, 0.0, 0.5, 1.0)
    assert roc([1.0, 2.0], [1.0, 2.0]).area == pytest.approx(0.5)


def test_every_indicator_leaves_its_rates_its_values_and_its_curve(tmp_path: Path) -> None:
    plot_indicators(tmp_path, 3)
    rates, values, points = (rows_of(tmp_path / f"tag_{n}.csv") for n in ("indicators", "indicator_values", "roc"))
    assert [row["indicator"].split()[0] for row in rates] == ["3", "4", "6", "7", "8", "9", "10,", "11"]
    views = {row["view"] for row in values}
    assert {row["right"] for row in values} == {"0", "1"} and 2 <= len(views) <= 3, "one may have no outline at all"
    tangled = next(row for row in rates if row["indicator"].startswith("6"))
    wrong = [float(row["untangled"]) for row in values if row["right"] == "0"]
    assert set(wrong) == {0.0, 1.0} and float(tangled["wrong_taken"]) == pytest.approx(np.mean(wrong), abs=1e-4)
    seen = {(row["view"], row["keypoints"]) for row in values}
    assert len(seen) == len(views), "the keypoints of an image are the same for every tag"
    for column in set(points[0]) - {"indicator", "threshold"}:
        for name in {row["indicator"] for row in points}:
            curve = [float(row[column]) for row in points if row["indicator"] == name]
            assert curve == sorted(curve) and curve[0] == 0.0 and curve[-1] == 1.0, (name, column)


def test_the_views_that_are_asked_for_are_looked_at(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: List[Piece] = []

    def run(wanted: Sequence[Piece], *rest: object) -> List[ViewResult]:
        asked.extend(wanted)
        return []

    monkeypatch.setattr(tag_reproduce, "run_views", run)
    monkeypatch.setattr(tag_reproduce, "report_views", lambda results, folder: "table")
    monkeypatch.setattr(tag_reproduce, "draw_figures", lambda folder: [])
    options = parser().parse_args(["--first-view", "1200", "--views", "120", "--report-every", "0"])
    assert tag_reproduce.tags(options, tmp_path, lambda title: lambda done, total, key: None) == "table"
    assert [(piece.first, piece.count, piece.report_every) for piece in asked] == [
        (1200, 50, 0),
        (1250, 50, 0),
        (1300, 20, 0),
    ]
