"""Files of a round: complete, plain, the result as it was published and as ours."""

from __future__ import annotations

import csv
import dataclasses
from pathlib import Path
from typing import Any, Dict, List

import numpy as np
import pytest
import yaml

from python.experiments.inspect_samples import SMALL, ours, report, told
from yarm.experiments.inspect.record import LookRecord
from yarm.experiments.inspect.writers import FILES, REPORT_FILES, write_inspection
from yarm.experiments.run.writers import inspect_folder
from yarm.geometry import Pose2
from yarm.inspection.model import PRINTED, REPORT, UNKNOWN, UNSEEN
from yarm.tags.printed import CONNECTOR, TAG_FROM_1
from yarm.tags.report import FOUND, Sighting


def rows_of(path: Path) -> List[Dict[str, Any]]:
    with path.open() as stream:
        return list(csv.DictReader(stream))


def test_everything_of_our_round_is_written(tmp_path: Path) -> None:
    folder = inspect_folder(tmp_path, "open_0", "yarm", 1)
    write_inspection(ours(), SMALL.arena, folder, {"round": {"views": 3}}, {"numpy": "1"})
    assert folder == tmp_path / "inspect" / "open_0" / "yarm" / "1"
    assert sorted(path.name for path in folder.iterdir()) == sorted(FILES)
    summary = yaml.safe_load((folder / "summary.yaml").read_text())
    assert summary["success"] is True and summary["right"] == 4 and summary["kept"] is True
    assert summary["parameters"] == {"round": {"views": 3}} and summary["versions"].keys() == {"opencv", "numpy"}
    assert all(text.endswith("right") for text in summary["verdicts"].values()) and summary["detector"] == "sift"
    boxes = yaml.safe_load((folder / "result.yaml").read_text())["boxes"]
    assert [row["box"] for row in boxes] == [verdict.box for verdict in ours().verdicts]
    assert [row["read"] for row in rows_of(folder / "result.csv")] == [row["read"] for row in boxes]
    lines = (folder / "result.txt").read_text().splitlines()
    assert lines[0] == "Tag is 0 means blank" and len(lines) == 5 and lines[1].startswith("boxNumber: ")


def test_every_image_has_a_row_for_every_answer(tmp_path: Path) -> None:
    write_inspection(ours(), SMALL.arena, tmp_path)
    rows = rows_of(tmp_path / "views.csv")
    assert len(rows) == 17 * len(ours().looks)
    first = [row for row in rows if row["t_s"] == rows[0]["t_s"]]
    assert sorted(int(row["answer"]) for row in first) == list(range(-1, 16))
    assert abs(sum(float(row["probability"]) for row in first) - 1.0) < 1e-4
    kinds = {row["kind"] for row in rows_of(tmp_path / "events.csv")}
    assert {"viewpoint", "verdict"} <= kinds
    assert len(rows_of(tmp_path / "path.csv")) == len(ours().path)


def test_the_report_leaves_its_own_files_in_its_own_spelling(tmp_path: Path) -> None:
    write_inspection(report(), SMALL.arena, tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*FILES, *REPORT_FILES])
    assert "boxNumber: " in (tmp_path / "result.txt").read_text()
    published = (tmp_path / "changeEngine.txt").read_text()
    assert published == (tmp_path / "result.txt").read_text().replace("boxNumber", "boxNumnber")
    assert (tmp_path / "MapText.txt").read_text().count("CONNECTOR") == len(report().looks) == 84
    rows = rows_of(tmp_path / "views.csv")
    assert len(rows) == 84 * 15 and {int(row["tag"]) for row in rows} == set(range(1, 16))
    kept = [row for row in rows if not row["rejection"]]
    assert kept and all(len(row["corners"].split()) == 8 and float(row["share"]) >= 0.1 for row in kept)


@pytest.mark.parametrize(("controller", "tags"), [(REPORT, ["1", "3"]), (PRINTED, ["2", "3"])])
def test_the_files_of_votes_hold_what_counts_by_the_rule_of_their_round(
    controller: str, tags: List[str], tmp_path: Path
) -> None:
    """The text asks for a tenth of the tag's keypoints, the printed program for more than 33 good matches."""
    corners = np.array([[200.0, 100.0], [400.0, 100.0], [400.0, 260.0], [200.0, 260.0]])
    sightings = tuple(
        Sighting(tag, 1, FOUND, 32000.0, share, corners, False, 300, good, (90.0,) * 4, 90.0, 32000.0, 90.0)
        for tag, share, good in ((1, 0.12, 20), (2, 0.05, 40), (3, 0.3, 90), (4, 0.05, 20))
    )
    look = LookRecord(1.0, 1, Pose2(0.0, 0.0), np.zeros((480, 640), np.uint8), None, sightings, controller == PRINTED)
    record = dataclasses.replace(told(SMALL, controller, {1: UNSEEN}), looks=(look,))
    write_inspection(record, SMALL.arena, tmp_path)
    lines = (tmp_path / "MapText.txt").read_text().splitlines()
    assert [line.split()[TAG_FROM_1] for line in lines[:-1]] == tags and lines[-1] == CONNECTOR
    assert (tmp_path / "LaserText.txt").read_text().splitlines() == lines[:-1]


def test_what_went_wrong_is_in_the_summary(tmp_path: Path) -> None:
    read = {1: SMALL.tags[0], 2: UNKNOWN, 3: UNSEEN, 4: SMALL.tags[3]}
    write_inspection(told(SMALL, "yarm", read), SMALL.arena, tmp_path, faults=["the camera fell silent"])
    summary = yaml.safe_load((tmp_path / "summary.yaml").read_text())
    assert summary["success"] is False and summary["faults"][0] == "the camera fell silent"
    assert len(summary["faults"]) == 3 and summary["verdicts"][3].startswith("none, it is")
    text = (tmp_path / "result.txt").read_text()
    assert "unmatched: 2\nunmatched: 3\n" in text and len(text.splitlines()) == 5


def test_a_file_s_layout_goes_into_a_folder_of_its_stem() -> None:
    assert inspect_folder(Path("r"), "some/where/mine.yaml", "yarm", 0) == Path("r/inspect/mine/yarm/0")
