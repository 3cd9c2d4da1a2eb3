"""Proof sheets: one file, a section a box, pictures inside, scores of all answers, why each view was chosen."""

from __future__ import annotations

import base64
import dataclasses
import re
from pathlib import Path
from typing import List

import cv2
import numpy as np

from python.experiments.inspect_samples import SMALL, ours, report, told
from yarm.experiments.inspect.measures import measure
from yarm.experiments.inspect.proof import scores_of, shown_look, write_proof
from yarm.experiments.inspect.record import RoundRecord
from yarm.inspection.model import BLANK, UNKNOWN, UNSEEN
from yarm.tags.pictures import shipped_pictures

TAGS = shipped_pictures()


def written(record: RoundRecord, path: Path) -> str:
    return write_proof(record, measure(record), path / "proof.html").read_text(encoding="utf-8")


def test_the_pictures_are_those_that_were_looked_for(tmp_path: Path) -> None:
    """A round with a tag file of one's own, whose numbers need not be those of the shipped ones."""
    record = ours()
    looks = []
    for entry in record.looks:
        assert entry.look is not None
        fits = tuple(dataclasses.replace(fit, tag=fit.tag + 40) for fit in entry.look.fits)
        looks.append(dataclasses.replace(entry, look=dataclasses.replace(entry.look, fits=fits)))
    shifted = dataclasses.replace(record, looks=tuple(looks))
    own = {number + 40: picture for number, picture in TAGS.items()}
    path = write_proof(shifted, measure(shifted), tmp_path / "own.html", own)
    drawn, usual = pictures(path.read_text(encoding="utf-8")), pictures(written(record, tmp_path))
    assert len(drawn) == len(usual) and all(np.array_equal(a, b) for a, b in zip(drawn, usual))
    other = {number: TAGS[number % len(TAGS) + 1] for number in TAGS}
    path = write_proof(record, measure(record), tmp_path / "other.html", other)
    drawn = pictures(path.read_text(encoding="utf-8"))
    assert all((np.array_equal(a, b)) == (a.shape[1] == 640) for a, b in zip(drawn, usual)), (
        "the pairs differ, the photos not"
    )


def pictures(text: str) -> List[np.ndarray]:
    found = re.findall(r"src='data:image/jpeg;base64,([^']+)'", text)
    return [cv2.imdecode(np.frombuffer(base64.b64decode(data), np.uint8), cv2.IMREAD_COLOR) for data in found]


def test_a_sheet_a_box_with_two_pictures_each_and_nothing_from_outside(tmp_path: Path) -> None:
    text = written(ours(), tmp_path)
    assert re.findall(r"<section id='box-(\d+)'", text) == [str(verdict.box) for verdict in ours().verdicts]
    assert "http" not in text and "<script" not in text and "src='" in text and text.count("src='") == 8
    shapes = [picture.shape for picture in pictures(text)]
    assert shapes == [(480, 640, 3), (250, 600, 3)] * 4
    assert text.count("<td>unknown</td>") == 4 and text.count("cheapest round over") == 4
    assert "4 of 4 boxes right, home in time" in text


def test_the_picture_shows_what_was_looked_at_with_its_outlines(tmp_path: Path) -> None:
    first = ours().verdicts[0]
    look = shown_look([look for look in ours().looks if look.box == first.box], first.reading.tag)
    assert look is not None
    photo = pictures(written(ours(), tmp_path))[0].astype(int)
    grey = np.abs(photo - look.image[:, :, None]).max(axis=2)
    coloured = (photo.max(axis=2) - photo.min(axis=2)) > 60
    assert np.median(grey) < 4 and 300 < np.count_nonzero(coloured) < 20_000


def test_the_report_s_sheets_show_its_matches_and_votes(tmp_path: Path) -> None:
    text = written(report(), tmp_path)
    assert text.count("first that can be reached") == 4 and "images that kept it" in text
    assert "good matches, kept" in text and len(pictures(text)) >= 6


def test_scores_are_of_all_looks_and_of_all_answers() -> None:
    for verdict, box in zip(ours().verdicts, (ours().boxes[v.box - 1] for v in ours().verdicts)):
        looks = [look for look in ours().looks if look.box == box.number]
        scores = scores_of(box, looks, TAGS)
        assert set(scores) == {*TAGS, BLANK, UNKNOWN} and abs(sum(scores.values()) - 1.0) < 1e-9
        assert scores[verdict.reading.tag] == verdict.reading.probability
    assert scores_of(ours().boxes[0], [], TAGS) == {}


def test_a_wrong_verdict_and_one_without_images_say_so(tmp_path: Path) -> None:
    truth = SMALL.tags[0]
    record = told(SMALL, "<b>yarm</b>", {1: truth % 15 + 1, 2: UNSEEN})
    text = written(record, tmp_path)
    assert f"it is {truth}" in text and "class='wrong'" in text and "no image of it could be judged" in text
    assert "<b>yarm" not in text and "&lt;b&gt;yarm" in text and "in doubt" in text


def test_the_look_that_speaks_most_is_shown() -> None:
    looks = [look for look in ours().looks if look.box == ours().looks[0].box]
    sure, tag = looks[-1], ours().verdicts[0].reading.tag
    assert sure.look is not None
    blind = dataclasses.replace(sure, look=dataclasses.replace(sure.look, probabilities={}))
    assert shown_look([sure, blind], tag) is sure and shown_look([blind], tag) is blind and shown_look([], tag) is None
