"""Figures of the inspection: the published result, the order, the report's rules, the cost of its faults."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Dict, List

import pytest

from python.experiments.inspect_samples import SMALL, told
from yarm.experiments.inspect import fault_trial, order_figure
from yarm.experiments.inspect.eyes import boxes_of
from yarm.experiments.inspect.fault_figure import write_faults
from yarm.experiments.inspect.fault_trial import KEPT, VARIANTS, FaultResult, FaultSpec, fault_specs, run_fault
from yarm.experiments.inspect.order_figure import drawn_costs, measured, practice_lengths, write_orders, write_searches
from yarm.experiments.inspect.practice_figure import PUBLISHED, write_practice
from yarm.experiments.inspect.rule_figures import drawn_pair, sightings_of, write_angles, write_edge_cases
from yarm.experiments.inspect.runner import run_round
from yarm.experiments.inspect.switches import FAULTS, FAULTS_IN_PHYSICS, PLAIN
from yarm.experiments.inspect.trial import KINEMATIC, PHYSICS
from yarm.experiments.inspect.viewpoint_figure import write_viewpoints
from yarm.inspection.tour import brute_force_tour, exact_tour, greedy_tour
from yarm.sim.scenes.layout_file import find_layout

PRACTICE = find_layout("practice")


def rows_of(path: Path) -> List[Dict[str, str]]:
    with path.open() as stream:
        return list(csv.DictReader(stream))


def test_the_published_result_agrees_with_the_practice_world() -> None:
    assert {box: tag for box, tag, _ in PUBLISHED} == dict(enumerate(PRACTICE.tags, start=1))
    tags = [tag for _, tag, _ in PUBLISHED]
    assert [double for _, _, double in PUBLISHED] == [tag > 0 and tag in tags[:i] for i, tag in enumerate(tags)]


def test_the_published_result_stands_beside_ours_line_by_line(tmp_path: Path) -> None:
    report = told(PRACTICE, "report", {1: 5, 5: 0, 7: 5})
    ours = told(PRACTICE, "yarm", dict(enumerate(PRACTICE.tags, start=1)))
    text = write_practice([report, ours], PRACTICE.arena, tmp_path)
    rows = rows_of(tmp_path / "inspect_practice.csv")
    assert [row["box"] for row in rows] == [*(str(box) for box, _, _ in PUBLISHED), ""]
    by_box = {row["box"]: row for row in rows}
    assert by_box["5"]["published"] == "15" and by_box["5"]["report: read"] == "blank"
    assert by_box["7"]["report: read"] == "5 (duplicate)" and by_box["7"]["yarm: place, s"] == "7, 2"
    assert by_box["6"]["report: read"] == "-" and by_box[""]["published"] == "about 360"
    assert "| 8 | blank | - | - | blank |" in text and (tmp_path / "inspect_practice.png").stat().st_size > 10_000


def test_viewpoints_of_the_practice_world_are_written_for_both_depths(tmp_path: Path) -> None:
    text = write_viewpoints(boxes_of(PRACTICE), PRACTICE.arena, tmp_path)
    rows = rows_of(tmp_path / "inspect_viewpoints.csv")
    assert [row["box"] for row in rows] == [str(number) for number in range(1, 11)] * 2 and text.count("| 0.32 |") == 10
    turned = {(row["depth_m"], row["box"]): float(row["angle_deg"]) for row in rows if row["angle_deg"] != "0"}
    shallow, deep = {"5": -30.0, "10": 30.0}, {"2": 30.0, "5": -30.0, "9": -30.0, "10": 30.0}
    assert {box: angle for (depth, box), angle in turned.items() if depth == "0.16"} == shallow
    assert {box: angle for (depth, box), angle in turned.items() if depth == "0.32"} == deep
    assert {row["distance_m"] for row in rows} == {"0.5"} and all(float(row["room_m"]) >= 0.0 for row in rows)
    assert (tmp_path / "inspect_viewpoints.png").stat().st_size > 10_000


def test_lengths_of_the_practice_world() -> None:
    found = {name: (round(metres, 2), order) for name, metres, order in practice_lengths(boxes_of(PRACTICE))}
    assert found["published"][0] == 18.66 and found["greedy"] == (16.43, (6, 9, 10, 8, 7, 1, 3, 2, 4, 5))
    assert found["exact"] == (15.76, (6, 5, 4, 3, 2, 1, 7, 10, 8, 9))


def test_methods_are_measured_in_the_same_layouts() -> None:
    methods = [("greedy", greedy_tour), ("exact", exact_tour), ("brute force", brute_force_tour)]
    greedy, exact, brute = measured(5, 1, methods, 3)
    assert exact.ratio == 1.0 == pytest.approx(brute.ratio) and greedy.ratio >= 1.0 and brute.metres > 5.0
    costs, box_of = drawn_costs(4, 12, 0)
    assert costs.shape == (49, 49) and [box_of.count(i) for i in range(4)] == [12] * 4
    assert (costs == drawn_costs(4, 12, 0)[0]).all() and (costs != drawn_costs(4, 12, 1)[0]).any()


def test_the_order_s_figure_holds_every_number_of_boxes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(order_figure, "DRAWS", 2)
    monkeypatch.setattr(order_figure, "MOST_BRUTE", 5)
    assert "16.43" in write_orders(boxes_of(PRACTICE), tmp_path, most=6)
    rows = rows_of(tmp_path / "inspect_order.csv")
    assert {row["boxes"] for row in rows if row["method"] == "exact"} == {"4", "5", "6"}
    assert {row["boxes"] for row in rows if row["method"] == "brute force"} == {"4", "5"}
    assert (tmp_path / "inspect_order.png").is_file()


def test_both_tags_of_a_pair_can_survive_and_the_rules_are_asked(tmp_path: Path) -> None:
    assert drawn_pair(0) == drawn_pair(0) != drawn_pair(1)
    seen = {sighting.tag for sighting in sightings_of(drawn_pair(0))}
    assert seen >= set(drawn_pair(0).tags)
    text = write_edge_cases(tmp_path, count=1)
    (row,) = rows_of(tmp_path / "inspect_edge.csv")
    assert row["by_area_right"] in "01" and int(row["seen_tag"]) > 0 and int(row["seen_neighbour"]) > 0
    assert text.count("of 1") == 3


def test_searched_tours_are_shorter_than_greedy_ones_and_tell_their_gap(tmp_path: Path) -> None:
    assert "searched_m" in write_searches(tmp_path, (16,), 1)
    (row,) = csv.DictReader((tmp_path / "inspect_search.csv").open())
    assert float(row["searched_m"]) < float(row["greedy_m"]) and 0.0 < float(row["gap"]) < 0.5


def test_the_predicted_angle_is_off_and_the_measured_one_is_not(tmp_path: Path) -> None:
    write_angles(tmp_path)
    rows = {(row["distance_m"], row["angle_deg"]): row for row in rows_of(tmp_path / "inspect_angle.csv")}
    for place, true in ((("0.5", "30"), 109.0), (("0.5", "60"), 140.0), (("0.8", "30"), 102.0), (("0.8", "60"), 125.0)):
        assert float(rows[place]["true_deg"]) == pytest.approx(true, abs=0.6)
    for row in rows.values():
        if row["measured_deg"]:
            assert float(row["measured_deg"]) == pytest.approx(float(row["true_deg"]), abs=1.5)
    assert abs(float(rows["0.5", "30"]["predicted_deg"]) - float(rows["0.5", "30"]["true_deg"])) > 10.0
    assert sum(bool(row["measured_deg"]) for row in rows.values()) >= 12


def result(fault: str, right: float, end_s: float) -> FaultResult:
    numbers = {**dict.fromkeys(KEPT, 0.0), "right": right, "end_s": end_s}
    return FaultResult(FaultSpec("practice", fault, 0), 10, numbers)


def test_faults_stand_beside_the_plain_round(tmp_path: Path) -> None:
    results = [result(fault, 9.0 if fault == PLAIN else 5.0, 200.0 + i) for i, fault in enumerate(FAULTS)]
    text = write_faults([*results, *results], tmp_path)
    assert f"| {PLAIN} | 18 of 20 | 0 | 200 |" in text and text.count("10 of 20") == len(FAULTS) - 1
    assert len(rows_of(tmp_path / "inspect_faults.csv")) == 2 * len(FAULTS)
    assert FaultResult.from_json(json.loads(json.dumps(results[1].to_json()))) == results[1]
    specs = [*fault_specs(5), *fault_specs(5, PHYSICS)]
    assert len({spec.key for spec in specs}) == 5 * (len(FAULTS) + len(FAULTS_IN_PHYSICS))


@pytest.mark.parametrize("world, name", [(KINEMATIC, "run_round"), (PHYSICS, "run_physics_round")])
def test_a_trial_runs_the_round_with_its_fault(monkeypatch: pytest.MonkeyPatch, world: str, name: str) -> None:
    asked = []

    def round_of(layout: object, controller: str, seed: int, switches: object) -> object:
        asked.append((controller, seed, switches))
        return told(SMALL, "report", {1: SMALL.tags[0]})

    monkeypatch.setattr(fault_trial, name, round_of)
    fault = list(VARIANTS[world])[1]
    found = run_fault(FaultSpec("open_0", fault, 3, world))
    assert asked == [("report", 3, VARIANTS[world][fault])] and found.numbers["right"] == 1.0 and found.boxes == 4


def test_only_the_report_has_its_faults() -> None:
    with pytest.raises(ValueError, match="none of the report's faults"):
        run_round(SMALL, "yarm", 1, FAULTS["sleeps"])
