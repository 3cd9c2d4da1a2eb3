"""Verdicts on random cells: each single fault makes a failure, and a refusal must be one that cell_check confirms."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any, Dict, List

import pytest
import yaml

from yarm.experiments.cells.outcome import CellResult, CellSpec, cell_line, judge_cell, kind_of, read_cell
from yarm.sim.scenes.random_cell import KINDS, PERSON
from yarm.sim.scenes.scene import Scene, scene_from

WALLED = {"target_inside": "target_inside: no robot can get to column (43, 38)"}


def scene(*targets: str) -> Scene:
    robot = {"name": "ankurbot_1", "type": "ankurbot", "x": 1.9, "y": 1.9, "heading_deg": 180}
    placed = [{"name": name, "x": -2.0 + i, "y": -1.0} for i, name in enumerate(targets)]
    return scene_from({"name": "random_plain", "seed": 4, "robots": [robot], "targets": placed}, "made up")


def reached(robot: str = "ankurbot_1") -> Dict[str, Any]:
    return {"reached": True, "declared_s": 9.0, "distance_m": 0.01, "status": "reached", "reason": "", "robot": robot}


def open_goal(status: str, reason: str) -> Dict[str, Any]:
    return {"reached": False, "declared_s": None, "distance_m": None, "status": status, "reason": reason, "robot": ""}


def summary(outcome: str = "succeeded", contacts: Any = (), **goals: Any) -> Dict[str, Any]:
    return {"goals": goals, "contacts": list(contacts), "outcome": outcome, "reason": "", "sim_s": 14.5}


def contact(other: str, first_s: float = 5.0) -> Dict[str, Any]:
    links = ["arm", "base_link"]
    return {"pair": ["ankurbot_1", other], "links": links, "kind": "failure", "first_s": first_s, "depth_m": 0.002}


def path(speed_mps: float) -> List[Dict[str, str]]:
    times = [0.05 * i for i in range(200)]
    return [{"robot": "ankurbot_1", "time_s": f"{t}", "x_m": f"{speed_mps * t}", "y_m": "0"} for t in times]


def test_everything_reached_is_a_success() -> None:
    result = judge_cell(scene("target_1"), summary(target_1=reached()), path(0.1), {})
    assert result == CellResult(CellSpec("plain", 4), (), ("target_1",), robots=1, sim_s=14.5)
    assert cell_line(result) == "random_plain-0004: success (1 robots, 1 goals reached in 14 s)"


def test_a_refusal_that_cell_check_confirms_is_a_success() -> None:
    goals = {"target_1": reached(), "target_inside": open_goal("unreachable", "no way")}
    result = judge_cell(scene(*goals), summary("failed", **goals), path(0.1), WALLED)
    assert result.success, result.faults
    assert result.refused == ("target_inside",)
    assert "refused as cell_check expects: target_inside" in cell_line(result)


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        (open_goal("unreachable", "the table"), "target_1 was refused, and cell_check finds a way: the table"),
        (open_goal("moving", ""), "target_1 was not reached (moving): no reason"),
        ({**reached(), "reached": False, "distance_m": 0.3}, "while ankurbot_1 stood 0.30 m away"),
        (None, "target_1 was never seen by the Commander"),
    ],
)
def test_a_goal_that_could_be_reached_must_be(goal: Any, words: str) -> None:
    told = {} if goal is None else {"target_1": goal}
    result = judge_cell(scene("target_1"), summary(**told), path(0.1), {})
    assert not result.success
    assert words in result.faults[0]


def test_a_refused_goal_that_was_never_refused_with_a_reason_fails() -> None:
    goals = {"target_inside": open_goal("unreachable", "")}
    assert not judge_cell(scene(*goals), summary("failed", **goals), path(0.1), WALLED).success


@pytest.mark.parametrize("outcome", ["", "stopped", "failed"])
def test_a_mission_that_ended_otherwise_fails(outcome: str) -> None:
    result = judge_cell(scene("target_1"), summary(outcome, target_1=reached()), path(0.1), {})
    assert result.faults == (f"the mission ended {outcome or 'never'!r}: no reason",)


def test_a_touch_is_a_failure() -> None:
    result = judge_cell(scene("target_1"), summary(contacts=[contact("table")], target_1=reached()), path(0.1), {})
    assert result.faults == ("ankurbot_1 (arm) touched table (base_link) at 5.0 s, 2.0 mm deep",)


@pytest.mark.parametrize(("speed_mps", "fails"), [(0.0, False), (0.2, True)])
def test_a_person_may_walk_into_a_robot_that_stands_only(speed_mps: float, fails: bool) -> None:
    told = summary(contacts=[contact(PERSON)], target_1=reached())
    result = judge_cell(scene("target_1"), told, path(speed_mps), {})
    assert result.success is not fails
    assert result.walked_into == (() if fails else ("ankurbot_1",))


def test_a_person_met_before_any_pose_was_recorded_is_a_failure() -> None:
    told = summary(contacts=[contact(PERSON)], target_1=reached())
    assert not judge_cell(scene("target_1"), told, [], {}).success


def test_a_goal_reached_against_cell_check_is_told() -> None:
    told = summary(target_inside=reached())
    result = judge_cell(scene("target_inside"), told, path(0.1), WALLED)
    assert result.odd == ("target_inside",)
    assert "reached against cell_check: target_inside" in cell_line(result)


def test_results_are_read_and_kept_as_json(tmp_path: Path) -> None:
    (tmp_path / "summary.yaml").write_text(yaml.safe_dump(summary(contacts=[contact("table")], target_1=reached())))
    with (tmp_path / "path.csv").open("w", newline="") as stream:
        rows = csv.DictWriter(stream, ["robot", "time_s", "x_m", "y_m"])
        rows.writeheader()
        rows.writerows(path(0.1))
    result = read_cell(scene("target_1"), tmp_path, {})
    assert not result.success
    assert math.isclose(result.sim_s, 14.5)
    assert CellResult.from_json(result.to_json()) == result


def test_no_results_are_a_failure(tmp_path: Path) -> None:
    assert read_cell(scene("target_1"), tmp_path, {}).faults == ("no results: summary.yaml was not written",)


def test_seeds_stand_for_all_kinds_in_turn() -> None:
    assert [kind_of(seed) for seed in range(len(KINDS))] == list(KINDS)
    assert kind_of(len(KINDS)) == KINDS[0]
