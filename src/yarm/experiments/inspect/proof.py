"""proof.html: one sheet a box with what its verdict rests on; one file, readable offline, its pictures inside."""

from __future__ import annotations

import base64
import html
from pathlib import Path
from typing import Dict, List, Mapping, Optional, Sequence, Tuple

import cv2

from yarm.experiments.html import figure, table, write_page
from yarm.experiments.inspect.measures import Measures
from yarm.experiments.inspect.record import LookRecord, RoundRecord
from yarm.experiments.inspect.sheet import ColourImage, our_pair, our_photo, report_pair, report_photo
from yarm.inspection.boxes import Box
from yarm.inspection.model import BLANK, UNKNOWN, Verdict, reading_words
from yarm.inspection.reading import face_view
from yarm.tags.evidence import BoxEvidence
from yarm.tags.motifs import GreyImage
from yarm.tags.pictures import shipped_pictures

QUALITY = 80
"""Of the JPEG pictures, per cent."""


def write_proof(
    record: RoundRecord, measures: Measures, path: Path, tags: Optional[Mapping[int, GreyImage]] = None
) -> Path:
    """Write the proof sheets of a round.

    Args:
        record: of the round.
        measures: what it comes to.
        path: of the HTML file.
        tags: pictures that were looked for, by number; the shipped ones unless given.
    """
    info = record.info
    title = f"{info.layout}, {info.controller}, seed {info.seed}"
    head = (
        f"{measures.right} of {measures.boxes} boxes right, {'home in time' if measures.kept else 'not home in time'}, "
        f"{record.end_s:.0f} s of {info.time_limit_s:g} s, {measures.distance_m:.1f} m driven, {measures.bumps} bumps; "
        f"features: {info.detector}"
    )
    tags = shipped_pictures() if tags is None else tags
    boxes = {box.number: box for box in record.boxes}
    sheets = [_sheet(record, boxes[verdict.box], verdict, tags) for verdict in record.verdicts]
    return write_page(path, title, [f"<p>{html.escape(head)}</p>", *sheets])


def _sheet(record: RoundRecord, box: Box, verdict: Verdict, tags: Mapping[int, GreyImage]) -> str:
    """One box."""
    looks = [look for look in record.looks if look.box == box.number]
    read, truth = reading_words(verdict.reading.tag), reading_words(record.truth[box.number])
    kind, mark = ("right", "") if read == truth else ("wrong", f"; it is {truth}")
    double = " (duplicate)" if verdict.duplicate else ""
    parts = [f"<section id='box-{box.number}'>"]
    parts.append(f"<h2 class='{kind}'>Box {box.number}: {html.escape(read + double + mark)}</h2>")
    parts.append(table(("", ""), _facts(record, box, verdict, looks)))
    shown = shown_look(looks, verdict.reading.tag)
    if shown is not None:
        parts.append("<div class='row'>" + _pictures(record, box, shown, verdict, tags) + "</div>")
    parts.append("<div class='row'>" + _scores(box, looks, tags) + _look_table(looks) + "</div>")
    return "\n".join([*parts, "</section>"])


def _facts(record: RoundRecord, box: Box, verdict: Verdict, looks: Sequence[LookRecord]) -> List[Tuple[str, str]]:
    reading, pose = verdict.reading, box.pose
    rows = [("found at", f"{verdict.found_s:.1f} s"), ("probability", f"{reading.probability:.5f}")]
    rows.append(("box", f"x {pose.x:.3f} m, y {pose.y:.3f} m, phi {pose.yaw_rad:.3f} rad"))
    for event in record.events:
        told = dict(event.details)
        if event.kind == "viewpoint" and str(told["box"]) == str(box.number):
            where = f"{float(told['distance_m']):g} m, {float(told['angle_deg']):g} deg"
            rows.append((f"viewpoint at {event.t_s:.1f} s", f"{where}: {told['why']}"))
    if looks:
        at = looks[-1].robot
        rows.append(("seen from", f"x {at.x:.3f} m, y {at.y:.3f} m, yaw {at.yaw_rad:.3f} rad, as the robot believed"))
    if reading.moved_m:
        rows.append(("stands elsewhere", f"{reading.moved_m:.2f} m from where it should"))
    rows += [(name, text) for name, text in (("note", reading.note), ("reason", verdict.reason)) if text]
    return rows


def shown_look(looks: Sequence[LookRecord], tag: int) -> Optional[LookRecord]:
    """The look that speaks most for a verdict; the last one when none does, None without any."""
    speaking = [look for look in looks if _support(look, tag) > 0.0]
    return max(speaking, key=lambda look: _support(look, tag)) if speaking else (looks[-1] if looks else None)


def _support(look: LookRecord, tag: int) -> float:
    if look.look is not None:
        return look.look.probabilities.get(tag, 0.0)
    kept = [float(seen.good) for seen in look.sightings if seen.tag == tag and not look.rejection(seen)]
    return max(kept, default=0.0)


def _pictures(record: RoundRecord, box: Box, look: LookRecord, verdict: Verdict, tags: Mapping[int, GreyImage]) -> str:
    if look.look is not None:
        view = face_view(look.robot, box, record.boxes)
        photo, pair = our_photo(look.image, view, look.look), our_pair(look.image, view, look.look, tags)
        best = look.look.fits[0] if look.look.fits else None
        beside = "the face, upright" if best is None else f"the likest tag, {best.tag}, and the face, upright"
        below = "" if best is None else f": likeness {best.likeness:.2f}, {best.inliers} matches that agree"
        outlines = "orange: where the pose puts the face, green: where the tag lies"
    else:
        found = [seen for seen in look.sightings if seen.corners is not None]
        own = [seen for seen in found if seen.tag == verdict.reading.tag]
        best_seen = max(own or found, key=lambda seen: seen.good, default=None)
        photo = report_photo(look.image, best_seen)
        pair = None if best_seen is None else report_pair(look.image, best_seen, tags)
        beside = "" if best_seen is None else f"tag {best_seen.tag} and what lies inside its outline"
        below = "" if best_seen is None else f": {best_seen.good} good matches, {look.rejection(best_seen) or 'kept'}"
        outlines = "green: the outline by the homography"
    parts = [_figure(photo, f"image at {look.t_s:.1f} s; {outlines}")]
    if pair is not None:
        parts.append(_figure(pair, beside + below))
    return "".join(parts)


def scores_of(box: Box, looks: Sequence[LookRecord], tags: Mapping[int, GreyImage]) -> Dict[int, float]:
    """Of each tag, blank and unknown by all looks: probabilities, or the share of the report's votes.

    Empty when no look could be judged. The report has no score for blank or unknown: they are what is left over.
    """
    if any(look.look is not None for look in looks):
        evidence = BoxEvidence(box.number)
        for look in looks:
            if look.look is not None:
                evidence.add(look.look, look.robot)
        return dict(evidence.verdict().scores)
    kept = [seen.tag for look in looks for seen in look.sightings if not look.rejection(seen)]
    return {tag: kept.count(tag) / len(looks) for tag in tags} if looks else {}


def _scores(box: Box, looks: Sequence[LookRecord], tags: Mapping[int, GreyImage]) -> str:
    scores = scores_of(box, looks, tags)
    if not scores:
        return "<p>no image of it could be judged</p>"
    ours = BLANK in scores
    lines = []
    for answer in [*sorted(tags), BLANK, UNKNOWN]:
        value = scores.get(answer)
        text = "-" if value is None else (f"{value:.2e}" if ours and value < 1e-3 else f"{value:.4f}")
        width = 0.0 if value is None else 100.0 * min(1.0, value)
        bar = f"<td class='bar'><div style='width:{width:.1f}%'></div></td>"
        lines.append(f"<tr><td>{html.escape(reading_words(answer))}</td><td>{text}</td>{bar}</tr>")
    name = "probability" if ours else "images that kept it"
    return f"<table><tr><th>answer</th><th>{name}</th><th></th></tr>{''.join(lines)}</table>"


def _look_table(looks: Sequence[LookRecord]) -> str:
    """A row an image."""
    rows = []
    for number, look in enumerate(looks, start=1):
        if look.look is not None:
            seen = look.look
            answer = "none" if seen.answer is None else reading_words(seen.answer)
            chance = seen.probabilities[seen.answer] if seen.answer is not None else 0.0
            what = f"{answer} {chance:.4f}; {seen.status.value}, {seen.finding.value} {seen.reason}".strip()
            rows.append((str(number), f"{look.t_s:.1f}", f"{100 * seen.share:.0f} %", f"{seen.texture:.3f}", what))
        else:
            kept = [f"{seen.tag} ({seen.good} good)" for seen in look.sightings if not look.rejection(seen)]
            rows.append((str(number), f"{look.t_s:.1f}", "", "", ", ".join(kept) or "nothing kept"))
    return table(("image", "s", "face seen", "texture", "what it says"), rows) if rows else ""


def _figure(picture: ColourImage, caption: str) -> str:
    data = base64.b64encode(cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()).decode()
    image = f"<img alt='{html.escape(caption, quote=True)}' src='data:image/jpeg;base64,{data}'>"
    return figure(image, caption)
