"""Results below a folder: which runs there are, and which files of them may be looked at."""

from __future__ import annotations

import os

import pytest

from yarm.console.results import LARGEST_SUMMARY, MOST_RUNS, ResultError, Results


@pytest.fixture
def root(tmp_path):
    for number, (name, text) in enumerate(
        (
            ("2m1ma/3", "case: 2m1ma\nseed: 3\nsuccess: true\nfaults: []\noutcome: succeeded\nsim_s: .nan\n"),
            ("explore/arena/yarm/1", "case: explore\nsuccess: false\nfaults: [95 % of the area]\n"),
            ("broken/1", "case: [\n"),
        )
    ):
        folder = tmp_path / "results" / name
        folder.mkdir(parents=True)
        (folder / "summary.yaml").write_text(text)
        os.utime(folder / "summary.yaml", (100.0 + number, 100.0 + number))
    run = tmp_path / "results/2m1ma/3"
    for name in ("map.png", "path.csv", "run.log", "run.bag", "proof.html", "other.html", ".hidden.png"):
        (run / name).write_text(name)
    (run / "run.film").write_bytes(b"")
    (run / "link.png").symlink_to("/etc/passwd")
    (tmp_path / "secret.png").write_text("secret")
    return tmp_path / "results"


def test_runs_are_listed_newest_first_with_what_came_of_them(root):
    broken, explore, cell = Results(root).runs()
    assert (cell["run"], cell["success"], cell["film"], cell["seed"]) == ("2m1ma/3", True, True, 3)
    assert (explore["run"], explore["success"], explore["faults"]) == (
        "explore/arena/yarm/1",
        False,
        ["95 % of the area"],
    )
    assert broken["success"] is None
    assert "cannot be read" in broken["faults"][0]


def test_a_run_that_is_written_again_is_read_again(root):
    results = Results(root)
    results.runs()
    path = root / "2m1ma/3/summary.yaml"
    path.write_text("success: false\n")
    os.utime(path, (500.0, 500.0))
    assert results.runs()[0] == {"run": "2m1ma/3", "written_s": 500.0, "film": True, "success": False, "faults": []}


def test_a_folder_that_is_not_there_has_no_runs(tmp_path):
    assert Results(tmp_path / "none").runs() == []


def test_so_many_runs_and_no_more(tmp_path):
    for i in range(MOST_RUNS + 5):
        (tmp_path / f"case/{i}").mkdir(parents=True)
        (tmp_path / f"case/{i}/summary.yaml").write_text("success: true\n")
    assert len(Results(tmp_path).runs()) == MOST_RUNS


def test_one_run_has_all_its_summary_and_its_files(root):
    found = Results(root).run("2m1ma/3")
    assert found["summary"]["sim_s"] is None, "what JSON cannot say"
    assert found["files"] == [".hidden.png", "map.png", "path.csv", "proof.html", "run.log"]
    assert found["film"]


@pytest.mark.parametrize(
    "name", ["", "..", "../results/2m1ma/3", "2m1ma", "2m1ma/3/", "/etc", "2m1ma/../2m1ma/3", "a/" * 9]
)
def test_what_is_no_run_is_refused(root, name):
    for ask in (Results(root).run, Results(root).film, lambda run: Results(root).file(run, "map.png")):
        with pytest.raises(ResultError, match="there is no run"):
            ask(name)


@pytest.mark.parametrize(
    "file", ["run.bag", "other.html", "link.png", "../../../secret.png", "none.png", "", ".", "summary.yaml"]
)
def test_files_of_other_kinds_and_places_are_not_given(root, file):
    assert Results(root).file("2m1ma/3", file) is None


def test_a_summary_that_is_too_large_is_not_read(root):
    (root / "2m1ma/3/summary.yaml").write_text("#" * (LARGEST_SUMMARY + 1))
    with pytest.raises(ResultError, match="bytes: it is not read"):
        Results(root).run("2m1ma/3")
