"""Writes one inspection's results; the same files for rounds without ROS and for physics."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Sequence

import cv2
import yaml

from yarm.experiments.inspect.measures import Measures, faults_of, measure
from yarm.experiments.inspect.pictures import plot_round
from yarm.experiments.inspect.proof import write_proof
from yarm.experiments.inspect.record import LookRecord, OrderRow, PathRow, RoundRecord, TouchRow
from yarm.experiments.run.writers import plain_values, write_events, write_rows
from yarm.inspection.model import OURS, Verdict, reading_words
from yarm.inspection.result_file import lines_of
from yarm.sim.scenes.arena import Arena
from yarm.tags.motifs import GreyImage
from yarm.tags.printed import laser_text, map_text, row_of

TABLES = {"path": PathRow, "orders": OrderRow, "touches": TouchRow}
FILES = (
    "summary.yaml",
    "result.txt",
    "result.csv",
    "result.yaml",
    "views.csv",
    "events.csv",
    *(f"{name}.csv" for name in TABLES),
    "map.png",
    "time.png",
    "proof.html",
)
REPORT_FILES = ("changeEngine.txt", "MapText.txt", "LaserText.txt")
"""Those that only the report's rounds leave, besides: result, rows of the votes, rows of unmatched boxes."""


@dataclass(frozen=True)
class ResultRow:
    """What became of a box, in visiting order.

    Attributes:
        box: its number.
        read: tag's number, blank, unknown or none.
        truth: tag's number or blank.
        right: whether they agree.
        probability: of what was read.
        duplicate: a box visited before bears the same tag.
        x: of the box as it was given, map, metres.
        y: metres.
        phi: rad.
        found_s: when, since the start.
        moved_m: how far it seems to stand from there; 0 when it does not.
        note: what else is wrong with it.
        reason: why it has no verdict.
    """

    box: int
    read: str
    truth: str
    right: bool
    probability: float
    duplicate: bool
    x: float
    y: float
    phi: float
    found_s: float
    moved_m: float
    note: str
    reason: str


@dataclass(frozen=True)
class OurViewRow:
    """What ours made of one image and one answer: a tag, blank (0), unknown (-1); -2 when the image had none.

    Attributes:
        t_s: when the image came, since the start.
        box: that was looked at.
        x: of the robot as it believed, map, metres.
        y: metres.
        yaw: rad.
        status: whether the image could be used.
        finding: how the box stands.
        share: of the face that is seen.
        texture: of the face.
        answer: that this row is about.
        probability: of it by this image alone.
        likeness: correlation of tag and face; NaN for no tag.
        inliers: matches that agree with the pose.
    """

    t_s: float
    box: int
    x: float
    y: float
    yaw: float
    status: str
    finding: str
    share: float
    texture: float
    answer: int
    probability: float
    likeness: float
    inliers: int


@dataclass(frozen=True)
class ReportViewRow:
    """The report's indicators of one tag in one image; -69.42 where nothing was measured.

    Attributes:
        t_s: when the image came, since the start.
        box: that was looked at.
        x: of the robot as it believed, map, metres.
        y: metres.
        yaw: rad.
        tag: number from 1.
        status: 0 found, else why not.
        good: good matches.
        keypoints: in the image.
        share: good matches for each keypoint of the tag.
        area_px2: of the outline.
        effective_px2: its area inside the image, less half of that outside.
        tangled: whether its sides cross.
        angles: at the corners, degrees, top left first and clockwise.
        bottom_left_deg: the angle at the corner that is bottom left.
        predicted_deg: what it should be.
        corners: x, y in pixels, top left first and clockwise.
        rejection: why it does not count; empty when it does.
    """

    t_s: float
    box: int
    x: float
    y: float
    yaw: float
    tag: int
    status: float
    good: int
    keypoints: int
    share: float
    area_px2: float
    effective_px2: float
    tangled: bool
    angles: str
    bottom_left_deg: float
    predicted_deg: float
    corners: str
    rejection: str


def write_inspection(
    record: RoundRecord,
    arena: Arena,
    folder: Path,
    parameters: Optional[Mapping[str, Any]] = None,
    versions: Optional[Mapping[str, str]] = None,
    faults: Sequence[str] = (),
    tags: Optional[Mapping[int, GreyImage]] = None,
) -> None:
    """Write all files of a round into a folder, which is made when missing.

    Args:
        record: of the round.
        arena: its room.
        folder: where to.
        parameters: of everybody who took part.
        versions: of what it ran on, besides the recognition's library.
        faults: what went wrong besides: a round that broke off is no success.
        tags: pictures that were looked for, by number; the shipped ones unless given.

    Raises:
        ValueError: nothing of the way was recorded.
    """
    folder.mkdir(parents=True, exist_ok=True)
    measures = measure(record)
    rows = [result_row(verdict, record) for verdict in record.verdicts]
    summary = summary_of(record, measures, rows, parameters or {}, versions or {}, faults)
    _dump(summary, folder / "summary.yaml")
    _dump({"boxes": [plain_values(dataclasses.asdict(row)) for row in rows]}, folder / "result.yaml")
    write_rows(folder / "result.csv", ResultRow, rows)
    for name, cls in TABLES.items():
        write_rows(folder / f"{name}.csv", cls, getattr(record, name))
    write_events(record.events, folder / "events.csv")
    _write_lines(folder / "result.txt", lines_of(OURS, record.verdicts))
    if record.info.controller == OURS:
        write_rows(folder / "views.csv", OurViewRow, [row for look in record.looks for row in our_rows(look)])
    else:
        write_rows(folder / "views.csv", ReportViewRow, [row for look in record.looks for row in report_rows(look)])
        _write_printed(record, folder)
    plot_round(record, arena, folder)
    write_proof(record, measures, folder / "proof.html", tags)


def result_row(verdict: Verdict, record: RoundRecord) -> ResultRow:
    """A verdict beside the truth."""
    reading, pose, truth = verdict.reading, verdict.pose, record.truth[verdict.box]
    return ResultRow(
        verdict.box,
        reading_words(reading.tag),
        reading_words(truth),
        reading.tag == truth,
        reading.probability,
        verdict.duplicate,
        pose.x,
        pose.y,
        pose.yaw_rad,
        verdict.found_s,
        reading.moved_m,
        reading.note,
        verdict.reason,
    )


def summary_of(
    record: RoundRecord,
    measures: Measures,
    rows: Sequence[ResultRow],
    parameters: Mapping[str, Any],
    versions: Mapping[str, str],
    faults: Sequence[str],
) -> Dict[str, Any]:
    """What summary.yaml holds: plain values, null for what is not a finite number."""
    wrong = [*faults, *faults_of(record, measures)]
    verdicts = {row.box: f"{row.read}, {'right' if row.right else f'it is {row.truth}'}" for row in rows}
    return {
        "case": "inspect",
        **plain_values(dataclasses.asdict(record.info)),
        "success": not wrong,
        "faults": wrong,
        "stage": str(record.stage),
        "reason": record.reason,
        **plain_values(dataclasses.asdict(measures)),
        "verdicts": verdicts,
        "versions": {"opencv": cv2.__version__, **versions},
        "parameters": plain_values(parameters),
    }


def our_rows(look: LookRecord) -> List[OurViewRow]:
    """Rows of an image that ours looked at, the likest tag first; one when nothing could be said."""
    seen, at = look.look, look.robot
    if seen is None:
        return []
    fits = {fit.tag: fit for fit in seen.fits}
    others = [answer for answer in seen.probabilities if answer not in fits]
    rows = []
    for answer in [*fits, *others] or [-2]:
        fit = fits.get(answer)
        rows.append(
            OurViewRow(
                *(look.t_s, look.box, at.x, at.y, at.yaw_rad, seen.status.value, seen.finding.value),
                *(seen.share, seen.texture, answer, seen.probabilities.get(answer, 0.0)),
                float("nan") if fit is None else fit.likeness,
                0 if fit is None else fit.inliers,
            )
        )
    return rows


def report_rows(look: LookRecord) -> List[ReportViewRow]:
    """Rows of an image that the report looked at, a tag each."""
    at = look.robot
    return [
        ReportViewRow(
            *(look.t_s, look.box, at.x, at.y, at.yaw_rad, seen.tag, seen.status, seen.good, seen.keypoints),
            *(seen.share, seen.area_px2, seen.effective_px2, seen.tangled),
            " ".join(f"{angle:.2f}" for angle in seen.angles),
            *(seen.bottom_left_deg, seen.predicted_deg),
            "" if seen.corners is None else " ".join(f"{value:.1f}" for value in seen.corners.ravel()),
            look.rejection(seen),
        )
        for seen in look.sightings
    ]


def _write_lines(path: Path, lines: Sequence[str]) -> None:
    path.write_text("".join(f"{line}\n" for line in lines))


def _write_printed(record: RoundRecord, folder: Path) -> None:
    """The three files that the report's program leaves; rows are those that count by the round's own rule."""
    images = [[row_of(seen) for seen in look.sightings if not look.rejection(seen)] for look in record.looks]
    unmatched = {verdict.box for verdict in record.verdicts if verdict.reading.tag < 0}
    left = [row for look, rows in zip(record.looks, images) if look.box in unmatched for row in rows]
    result, votes, others = (folder / name for name in REPORT_FILES)
    _write_lines(result, lines_of(record.info.controller, record.verdicts))
    votes.write_text(map_text(images))
    others.write_text(laser_text(left))


def _dump(values: Mapping[str, Any], path: Path) -> None:
    path.write_text(yaml.safe_dump(dict(values), sort_keys=False, width=120))
