#!/usr/bin/env python3
"""Runs every benchmark, one after the other, and says how each ended: ``make bench``.

Their output goes to the screen and to results/bench/<name>.log; one that fails does not keep the others from running.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
from pathlib import Path
from typing import Dict, List

ROOT = Path(__file__).resolve().parents[1]
PYTHON = sys.executable
TARGETS = ("perception_core_bench", "robustness_bench", "association_fuzz_test", "scan_map_fuzz_test")
BENCHMARKS: Dict[str, List[List[str]]] = {
    "perception_core": [
        [str(ROOT / "devel" / "lib" / "yarm" / "perception_core_bench"), "200", "bench/data/perception_core.csv"],
        [PYTHON, "bench/perception_core_plot.py", "bench/data/perception_core.csv", "bench/perception_core.png"],
    ],
    "robustness": [
        [str(ROOT / "devel" / "lib" / "yarm" / "robustness_bench"), "3", "bench/data/robustness.csv"],
        [PYTHON, "bench/robustness_plot.py", "bench/data/robustness.csv", "bench/robustness.png"],
    ],
    "perception_nodes": [[PYTHON, "bench/perception_nodes.py", "--fuzz", "20000000"]],
    "simulation_cameras": [[PYTHON, "bench/simulation_cameras.py"]],
    "fuzz": [
        [str(ROOT / "devel" / "lib" / "yarm" / "association_fuzz_test"), "100000"],
        [str(ROOT / "devel" / "lib" / "yarm" / "scan_map_fuzz_test"), "10000000"],
        [PYTHON, "bench/readers.py", "--inputs", "50000"],
    ],
    "room": [[PYTHON, "bench/room.py"]],
    "slam": [[PYTHON, "bench/slam.py"]],
    "localisation": [[PYTHON, "bench/localisation.py"]],
    "planning": [
        [PYTHON, "bench/planning.py", "promises", "--count", "1000"],
        [PYTHON, "bench/planning.py", "first", "--count", "100"],
        [PYTHON, "bench/planning.py", "fleets", "--count", "40"],
        [PYTHON, "bench/planning.py", "growth"],
        [PYTHON, "bench/planning.py", "report"],
    ],
    "clutter": [[PYTHON, "bench/clutter.py"]],
    "why": [[PYTHON, "bench/why.py"]],
    "safety_monitor": [[PYTHON, "bench/safety_monitor.py"], [PYTHON, "bench/safety_monitor.py", "--case", "3m6_bin"]],
    "joint_search": [
        [PYTHON, "bench/joint_search.py", "run"],
        [PYTHON, "bench/joint_search.py", "run", "--crowded", "--count", "10", "--planners", "yarm"],
        [PYTHON, "bench/joint_search.py", "report"],
    ],
    "kinematics": [[PYTHON, "bench/kinematics.py", "--page", "bench/kinematics.md"]],
    "arm_obstacles": [[PYTHON, "bench/arm_obstacles.py"]],
    "pieces": [[PYTHON, "bench/pieces.py"]],
    "hidden_space": [[PYTHON, "bench/hidden_space.py", "--csv", "bench/data/hidden_space.csv"]],
    "hand_picks": [[PYTHON, "bench/hand_picks.py"]],
    "planning_hands": [[PYTHON, "bench/planning_hands.py", "--errands", "600", "--seed", "3"]],
    "missions": [[PYTHON, "bench/missions.py", "--seeds", "20"]],
    "cells": [[PYTHON, "bench/missions.py", "--cells", "1000"]],
    "continuous": [[PYTHON, "bench/continuous.py", "--seeds", "10"]],
    "faults": [[PYTHON, "bench/faults.py"]],
    "strangers": [[PYTHON, "bench/strangers.py", "--messages", "250000", "--requests", "1000"]],
    "person": [[PYTHON, "bench/person.py", "--seeds", "3"]],
}


def main() -> int:
    """Build what only benchmarks need, run them, print the verdicts; 1 when one has failed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", default=list(BENCHMARKS), help="only these: " + ", ".join(BENCHMARKS))
    chosen = parser.parse_args().names
    unknown = [name for name in chosen if name not in BENCHMARKS]
    if unknown:
        parser.error(f"no such benchmark: {', '.join(unknown)}; there are {', '.join(BENCHMARKS)}")
    subprocess.run(["make", "-C", str(ROOT / "build"), *TARGETS], check=True)
    logs = ROOT / "results" / "bench"
    logs.mkdir(parents=True, exist_ok=True)
    verdicts = []
    for name in chosen:
        started = time.monotonic()
        codes = [_run(command, logs / f"{name}.log") for command in BENCHMARKS[name]]
        verdicts.append((name, max(codes), time.monotonic() - started))
    print("\nbenchmark            ended   minutes   log")
    for name, code, seconds in verdicts:
        print(f"{name:20s} {'ok' if code == 0 else f'code {code}':7s} {seconds / 60:7.1f}   results/bench/{name}.log")
    return max((code for _, code, _ in verdicts), default=0) and 1


def _run(command: List[str], log: Path) -> int:
    print(f"\n== {' '.join(command)}", flush=True)
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    with log.open("a") as output, subprocess.Popen(command, cwd=str(ROOT), **pipes) as child:
        for line in child.stdout or ():
            print(line, end="", flush=True)
            output.write(line)
    return child.returncode


if __name__ == "__main__":
    sys.exit(main())
