"""What a mission was launched with is kept, and what cannot be repeated is refused with the reason."""

from __future__ import annotations

from pathlib import Path

import pytest

from python.experiments.run.test_results import made_up_record
from yarm.experiments.run.ledger import LedgerError
from yarm.experiments.run.repeat import decision_at, recorded_arguments, write_arguments
from yarm.experiments.run.writers import write_run

CALL = ["roslaunch", "-p", "1", "yarm", "experiment.launch", "case:=1m1ma", "seed:=3", "results:=/x", "rviz:=true"]


def test_what_decides_of_a_mission_is_kept_and_what_does_not_is_left_out(tmp_path: Path) -> None:
    write_arguments(tmp_path, [*CALL, "sync:=true", "turns_deg:=[0.0, 90.0]"])
    assert recorded_arguments(tmp_path) == ["case:=1m1ma", "seed:=3", "sync:=true", "turns_deg:=[0.0, 90.0]"]


def test_a_mission_that_does_not_repeat_and_a_folder_of_something_else_are_refused(tmp_path: Path) -> None:
    with pytest.raises(LedgerError, match="is this the folder of its results"):
        recorded_arguments(tmp_path)
    write_arguments(tmp_path, [*CALL, "sync:=false"])
    with pytest.raises(LedgerError, match=r"was not in lock-step.*--sync"):
        recorded_arguments(tmp_path)
    (tmp_path / "arguments.yaml").write_text("just words")
    with pytest.raises(LedgerError, match="not to be read"):
        recorded_arguments(tmp_path)


@pytest.mark.parametrize("number", [0, -1, 19, 10**9])
def test_a_decision_that_was_never_taken_is_refused_with_those_that_were(tmp_path: Path, number: int) -> None:
    write_run(made_up_record(), tmp_path)
    assert decision_at(tmp_path, 18) == 18
    with pytest.raises(LedgerError, match="has the decisions 1 to 18"):
        decision_at(tmp_path, number)
