"""What the README says was measured is what the committed rows say."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Sequence, Tuple

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[3]
Row = Dict[str, str]
README = (ROOT / "README.md").read_text(encoding="utf-8")
TABLE = [line for line in README.partition("## What comes out")[2].splitlines() if line.startswith("| ")]
HEAD_ON = "corridors_head_on"


def rows(name: str, **wanted: str) -> List[Row]:
    """Rows of a file of bench/data that have these values."""
    with (ROOT / "bench" / "data" / f"{name}.csv").open(newline="", encoding="utf-8") as file:
        return [row for row in csv.DictReader(file) if all(row[key] == value for key, value in wanted.items())]


def values(found: Sequence[Row], column: str) -> List[float]:
    return [float(row[column]) for row in found]


def percentiles(numbers: Sequence[float], *wanted: float) -> List[float]:
    return [float(value) for value in np.percentile(numbers, wanted)]


def percent(part: float, whole: float) -> str:
    return f"{100.0 * part / whole:.0f}"


def missions() -> List[str]:
    found = [row for row in rows("missions", layout="seed") if row["case"] in ("1m1ma", "2m1ma", "3m")]
    solved = [row for row in found if row["success"] == "True"]
    two = [row for row in solved if row["case"] == "2m1ma"]
    rest = [fault for row in found for fault in row["faults"].split("; ") if fault]
    assert all("paths changed" in fault or "every robot has something to reach" in fault for fault in rest)
    least_m = min(values(found, "clearance_m"))
    said = f"every goal reached in {len(found)} of {len(found)}, no contact, never nearer than {least_m:.2f} m"
    return [said, f"{len(solved)} of {len(found)} (`2m1ma` {len(two)})"]


def missions_with_bins() -> List[str]:
    cases = ("1m1ma_bin", "2m1ma_bin", "3m6_bin")
    found = [row for row in rows("missions", layout="seed") if row["case"] in cases]
    assert all(sum(row["case"] == case for row in found) == 20 for case in cases)
    solved = sum(row["success"] == "True" and not row["faults"] for row in found)
    return [f"20 layouts each of {', '.join(f'`{case}`' for case in cases)}", f"in {solved} of {len(found)}"]


def promises() -> List[str]:
    found = rows("planning_promises")
    assert all(row["status"] == "SOLVED" for row in found)
    touches = int(sum(values(found, "touches")))
    return [f"{len(found)} random", f"all solved, {touches} of {int(sum(values(found, 'steps')))} steps touch"]


def fleets() -> List[str]:
    def solved(planner: str) -> str:
        own = rows("planning_fleets", planner=planner)
        easy = [row for row in own if row["family"] != HEAD_ON]
        shares = [percent(sum(row["status"] == "SOLVED" for row in some), len(some)) for some in (easy, own)]
        return f"{shares[0]} / {shares[1]} %"

    assert solved("yarm") == "100 / 100 %"
    return [
        f"{len(rows('planning_fleets', planner='yarm'))} other",
        f"LaCAM: {solved('lacam')}",
        f"RRTConnect in joint space: {solved('ompl_joint_rrtconnect')}",
        f"nobody giving way: {solved('ompl_rrtconnect simplified')}",
        f"multi-agent A*: {solved('ma_astar')}",
    ]


def least_ms(condition: str, planner: str) -> Dict[Tuple[str, str], float]:
    """Of each instance the least time of its repeats."""
    found: Dict[Tuple[str, str], float] = {}
    for row in rows("planning_first", condition=condition, planner=planner):
        key = (row["family"], row["seed"])
        found[key] = min(float(row["ms"]), found.get(key, np.inf))
    return found


def first_plans(condition: str, digits: int) -> List[str]:
    ours = least_ms(condition, "yarm")
    p50, p99 = percentiles(list(ours.values()), 50, 99)
    said, quicker = [f"{p50:.1f} / {p99:.{digits}f} ms"], []
    for planner in ("ompl_rrtconnect first", "ompl_rrtconnect simplified"):
        theirs = least_ms(condition, planner)
        assert set(theirs) == set(ours)
        p50, p99 = percentiles(list(theirs.values()), 50, 99)
        said.append(f"{p50:.1f} / {p99:.0f} ms")
        quicker.append(percent(sum(ours[key] < theirs[key] for key in ours), len(ours)))
    return [*said, f"{quicker[0]} % and {quicker[1]} %"]


def lengths() -> List[str]:
    def ratio(planner: str) -> str:
        own = [row for row in rows("planning_first", condition="warm", planner=planner, repeat="0") if row["length"]]
        return f"{np.median(np.array(values(own, 'length')) / np.array(values(own, 'optimum'))):.2f}"

    return [
        f"{len(least_ms('warm', 'yarm'))} such",
        f"{ratio('yarm')} of the grid's shortest way",
        f"and {ratio('ompl_rrtconnect first')}",
        f"and {ratio('ompl_rrtconnect simplified')}",
    ]


def perception() -> List[str]:
    found = {
        backend: values(
            rows("perception_nodes", backend=backend, nodelets="True", busy="True", visibility="False"), "ms"
        )
        for backend in ("fused", "pcl")
    }
    assert np.isfinite(found["fused"]).all(), "no set was lost"
    return ["{:.1f} / {:.1f} ms".format(*percentiles(numbers, 50, 99)) for numbers in found.values()]


def kinematics() -> List[str]:
    own = {method: rows("kinematics", method=method) for method in ("closed", "batch1000", "kdl", "tracik", "printed")}
    us = {method: np.median(values(found, "us")) for method, found in own.items()}
    poses = {method: int(sum(values(found, "poses"))) for method, found in own.items()}
    solved = {method: 100.0 * sum(values(found, "solved")) / poses[method] for method, found in own.items()}
    assert solved["closed"] == 100.0 and all(row["complete"] == "1" for row in own["closed"])
    return [
        f"{us['closed']:.0f} us one by one",
        f"{us['batch1000']:.1f} us in batches of thousands",
        f"{solved['kdl']:.0f} % of {poses['kdl']}, one branch, {us['kdl']:.0f} us",
        f"{solved['tracik']:.1f} % of {poses['tracik']}",
        f"formulas: {solved['printed']:.0f} %",
    ]


def exploration() -> List[str]:
    def told(controller: str) -> Tuple[str, str, float]:
        own = rows("explore_trials", controller=controller, without="")
        times = values(own, "t95_s")
        assert len(own) == 100
        return f"{np.median(times):.0f} s", str(int(np.isfinite(times).sum())), max(values(own, "fastest_bump"))

    ours, lite = told("yarm"), told("explore_lite")
    assert ours[2] < 0.1
    nearest, report = told("nearest"), told("report")
    return [
        f"{ours[0]}, {ours[1]} of 100 get there, no bump faster than 0.1 m/s",
        f"{lite[0]}, {lite[1]} of 100, bumps at up to {lite[2]:.1f} m/s",
        f"nearest frontier {nearest[0]}, {nearest[1]}",
        f"the report {report[0]}, {report[1]}",
    ]


def inspection() -> List[str]:
    def told(controller: str) -> Tuple[str, float, float, List[float]]:
        own = rows("inspect_physics", controller=controller)
        assert len(own) == 100
        full = str(sum(row["right"] == "10.0" for row in own))
        return full, sum(values(own, "named_wrong")), sum(values(own, "bumps")), values(own, "end_s")

    ours, theirs = told("yarm"), told("report")
    assert (ours[1], ours[2]) == (0.0, 0.0)
    p50, p95 = percentiles(ours[3], 50, 95)
    return [
        f"ten of ten in {ours[0]}",
        f"{p50:.0f} s median, {p95:.0f} s at most in 95 %",
        f"ten of ten in {theirs[0]}, {theirs[1]:.0f} boxes misnamed; {np.median(theirs[3]):.0f} s",
    ]


def clouds() -> List[str]:
    def ms(what: str) -> float:
        return float(np.median(values(rows("simulation_cameras", scene="3m", what=what), "cpu_ms")))

    peers = f"Python {ms('Embree (Python)'):.1f} ms", f"{ms('PyBullet TinyRenderer (no clouds, no noise)'):.0f} ms"
    return [f"{ms('C++ primitives (what runs)'):.1f} ms", *peers]


def real_time() -> List[str]:
    """Of this there are no rows, only the page of the benchmarks."""
    page = (ROOT / "bench" / "README.md").read_text(encoding="utf-8")
    factors = re.findall(
        r"--case (2m1ma|2m1ma_bin) --seed 3(?: --removal delete)?`,[^:]* in real time[^:]*: real-time factor (\S+)",
        page,
    )
    assert [case for case, _ in factors] == ["2m1ma", "2m1ma_bin"], factors
    (factor,) = {factor for _, factor in factors}
    return [f"real-time factor {factor}"]


FIGURES: Mapping[str, Callable[[], List[str]]] = {
    "whole missions in full physics": missions,
    "the same with hands and bins": missions_with_bins,
    "`2m1ma` in real time": real_time,
    "planning, ": promises,
    "the same, 70 other": fleets,
    "one robot's first plan": lambda: [*first_plans("warm", 1), *lengths()],
    "the same, cold": lambda: first_plans("cold", 0),
    "last depth cloud of a set": perception,
    "inverse kinematics": kinematics,
    "an unknown room": exploration,
    "ten boxes visited": inspection,
    "four 320 x 320": clouds,
}
OF_PICTURES = ("what", "the published variant and ours", "![")
"""Beginnings of the lines that have no figures."""


def test_every_line_has_its_figures() -> None:
    lines = [line[2:] for line in TABLE if not line[2:].startswith(OF_PICTURES)]
    lost = [line for line in lines if sum(line.startswith(begin) for begin in FIGURES) != 1]
    assert lost == []
    assert len(lines) == len(FIGURES)


@pytest.mark.parametrize("begin", FIGURES)
def test_a_line_says_what_its_rows_say(begin: Any) -> None:
    (line,) = [line for line in TABLE if line[2:].startswith(begin)]
    assert [said for said in FIGURES[begin]() if said not in line] == []
