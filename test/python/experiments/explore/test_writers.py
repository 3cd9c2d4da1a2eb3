"""Files of a run: complete, plain, and the same bytes for the same run."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from python.experiments.explore_samples import ROOM, path_row, perfect_map, record_of
from yarm.experiments.explore.cost import RunCost
from yarm.experiments.explore.judge import Judge
from yarm.experiments.explore.measures import measure
from yarm.experiments.explore.pictures import PICTURES, plot_exploration
from yarm.experiments.explore.record import CoverageRow, TouchRow
from yarm.experiments.explore.writers import FILES, success, summary_of, write_exploration
from yarm.experiments.run.record import NodeUsage
from yarm.experiments.run.writers import explore_folder
from yarm.exploration.model import Event
from yarm.geometry import Pose2
from yarm.navigation.map_file import read_map

JUDGE = Judge(ROOM)
GOOD = perfect_map(JUDGE)
RUN = record_of(
    GOOD,
    path=tuple(path_row(0.1 * i, -1.0 + 0.02 * i, 0.2) for i in range(5)),
    coverage=(CoverageRow(0.0, 1.0, 0.2), CoverageRow(1.0, 3.0, 1.0)),
    touches=(TouchRow(0.3, "low_1", True, 0.5, 0.1, 0.2, 0.08),),
    events=(Event(0.1, "draw", (("p", 0.123456789), ("n", 3))), Event(0.2, "done", (("why", math.inf),))),
    behaviours={"drive": 0.5},
    first_seen={"low_1": 0.2},
)


def test_everything_of_a_run_is_written_and_read_back(tmp_path: Path) -> None:
    measures = measure(RUN, JUDGE)
    folder = explore_folder(tmp_path, "room", "made_up", 3)
    write_exploration(RUN, measures, folder, {"controller": "made_up"}, {"yarm": "0"})
    assert folder == tmp_path / "explore" / "room" / "made_up" / "3"
    assert sorted(path.name for path in folder.iterdir()) == sorted(FILES)
    summary = yaml.safe_load((folder / "summary.yaml").read_text())
    assert summary["success"] is True and summary["faults"] == [] and summary["share"] == 1.0
    assert (summary["time_to_90_s"], summary["time_to_99_s"]) == (1.0, 1.0) and summary["bumps"] == 1
    assert summary["low"] == {"count": 1, "detected": 1, "untouched": 1} and summary["bump_list"][0]["block"] == "low_1"
    assert summary["parameters"] == {"controller": "made_up"} and summary["behaviours_s"] == {"drive": 0.5}
    assert (read_map(folder / "map.yaml").occupied == GOOD.occupied).all()
    with (folder / "events.csv").open() as stream:
        rows = list(csv.reader(stream))
    assert rows == [["t_s", "kind", "details"], ["0.1", "draw", "p=0.123457 n=3"], ["0.2", "done", "why=inf"]]
    with (folder / "path.csv").open() as stream:
        assert [row["true_x"] for row in csv.DictReader(stream)][:2] == ["-1", "-0.98"]


@pytest.mark.parametrize(
    ("done", "end_s", "outcome"), [(True, 12.0, "mapped"), (False, 60.0, "time over"), (False, 12.0, "broken off")]
)
def test_the_summary_says_how_it_ended(done: bool, end_s: float, outcome: str) -> None:
    run = replace(RUN, done=done, end_s=end_s, time_limit_s=60.0)
    assert summary_of(run, measure(run, JUDGE), {}, {})["outcome"] == outcome


def test_the_summary_holds_what_the_run_cost() -> None:
    nodes = (NodeUsage("explorer", 0.5, 6.0, 90.0, 95.0),)
    summary = summary_of(RUN, measure(RUN, JUDGE), {}, {}, (), RunCost(30.0, 20.0, nodes))
    cost = summary["cost"]
    assert (cost["real_time_factor"], cost["sim_s"], cost["wall_s"]) == (1.5, 30.0, 20.0)
    assert cost["cores"] == pytest.approx(1.0 / 3.0, abs=1e-5)
    assert cost["nodes"][0]["node"] == "explorer" and cost["nodes"][0]["memory_middle_mb"] is None
    assert yaml.safe_load(yaml.safe_dump(summary))["cost"] == cost
    assert summary_of(RUN, measure(RUN, JUDGE), {}, {})["cost"] is None


def test_a_run_that_mapped_too_little_says_so(tmp_path: Path) -> None:
    bare = record_of(None)
    measures = measure(bare, JUDGE)
    assert not success(measures)
    write_exploration(bare, measures, tmp_path)
    summary = yaml.safe_load((tmp_path / "summary.yaml").read_text())
    assert summary["faults"] == ["0.0 % of the mappable area, the target is 99 %"] and summary["time_to_95_s"] is None
    assert not (tmp_path / "map.pgm").exists()


def test_pictures_are_drawn_also_of_a_turned_map(tmp_path: Path) -> None:
    start = Pose2(-1.0, 0.2, 0.5)
    turned = record_of(perfect_map(JUDGE, start), world_from_map=start, coverage=RUN.coverage, path=RUN.path)
    written = plot_exploration(turned, ROOM, tmp_path)
    assert tuple(path.name for path in written) == PICTURES and all(path.stat().st_size > 5000 for path in written)


def test_an_arena_of_a_file_is_named_after_it(tmp_path: Path) -> None:
    assert explore_folder(tmp_path, "my/hall.yaml", "yarm", 0) == tmp_path / "explore" / "hall" / "yarm" / "0"
