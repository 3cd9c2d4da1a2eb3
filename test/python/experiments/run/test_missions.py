"""Missions for the figures: what is run and what is said of it (nothing is launched)."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from yarm.experiments.run import missions
from yarm.experiments.run.writers import CUT_SHORT, is_finished


def leave_results(own: Path, success: bool) -> None:
    own.mkdir(parents=True, exist_ok=True)
    faults = [] if success else ["ankurbot_1 (arm) touched table (table)"]
    (own / "summary.yaml").write_text(yaml.safe_dump({"success": success, "faults": faults}))
    (own / "map.png").write_bytes(b"")


def test_a_run_that_was_cut_short_is_not_finished(tmp_path: Path) -> None:
    assert not is_finished(tmp_path)
    leave_results(tmp_path, success=False)
    assert is_finished(tmp_path)
    fault = f"the Commander's mission ended 'failed': {CUT_SHORT}"
    (tmp_path / "summary.yaml").write_text(yaml.safe_dump({"success": False, "faults": [fault]}))
    assert not is_finished(tmp_path)


def test_missions_with_results_are_not_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ran = []

    def fake(call: list, _: object) -> None:
        ran.append(call[call.index("--case") + 1])
        if ran[-1] == "3m":
            leave_results(tmp_path / "3m" / "3", success=False)

    monkeypatch.setattr(missions, "launch", fake)
    leave_results(tmp_path / "2m1ma" / "3", success=True)
    text = missions.run_missions(tmp_path, lambda done, total, key: None, ("2m1ma", "3m", "single"))
    assert ran == ["3m", "single"]
    first, second, third = text.splitlines()
    assert first.startswith("2m1ma: success") and first.endswith("map.png")
    assert "3m: FAILED: ankurbot_1 (arm) touched table" in second
    assert third.startswith("single: no results; see")
