#!/usr/bin/env python3
"""How well and how cheaply a robot is found in a known map and followed: rooms with ten boxes, against the truth.

    source tools/env.sh && python3 bench/localisation.py [--sets one_turn tours ...] [--rooms 5] [--count N]

Builds `localisation_bench` (bench/localisation.cpp), runs one process a room and set, and prints a table for the starts
and one for the tours; the raw rows go to ``bench/data/localisation_starts.csv`` and ``localisation_tours.csv``. Every
number of the library that the bench names can be changed: ``--with NAME=VALUE``. ``--peer mrpt`` measures MRPT's KLD
particle filter in its place (bench/localisation_mrpt.cpp; built where ``libmrpt-slam-dev`` is installed), with the
numbers that did best for it, into files that end in ``_mrpt``.
"""

from __future__ import annotations

import argparse
import csv
import os
import subprocess
import sys
from pathlib import Path
from typing import Dict, List, NamedTuple, Sequence, Tuple

import numpy as np
import raw_rows

ROOT = Path(__file__).resolve().parents[1]
BUILD = Path(os.environ.get("YARM_BUILD", ROOT / "build"))
DEVEL = BUILD / "devel" if "YARM_BUILD" in os.environ else ROOT / "devel"
Row = Dict[str, str]


class Set(NamedTuple):
    """Options of the bench, and starts or tours in each room."""

    options: Tuple[str, ...]
    count: int
    is_tour: bool = False


SETS: Dict[str, Set] = {
    "one_turn": Set(("turns=1",), 50),
    "walls": Set(("turns=1", "walls=3"), 20),
    "odo2": Set(("turns=2", "odo=2"), 50),
    "slip4": Set(("turns=2", "slip=4"), 50),
    "one_turn_fine": Set(("turns=1", "cell=0.025"), 50),
    "walls_fine": Set(("turns=1", "walls=3", "cell=0.025"), 20),
    "given": Set(("mode=given", "turns=1"), 20),
    "given_fine": Set(("mode=given", "turns=1", "cell=0.025"), 20),
    "given_odo2": Set(("mode=given", "turns=1", "odo=2"), 20),
    "tours": Set(("mode=tour",), 6, True),
    "tours_odo2": Set(("mode=tour", "odo=2"), 6, True),
    "tours_fine": Set(("mode=tour", "cell=0.025"), 6, True),
}
"""What is measured, by name; ``fine``: map cells of 0.025 m, as a round has, instead of 0.05 m."""
MRPT = "mrpt"
PEER_SETS = ("one_turn", "walls", "tours", "tours_odo2")
PEER_TOUR = ("power=0.2", "sigma=0.05", "particles=500", "bin_m=0.05")
"""What suits the peer for following; its defaults are those for finding."""


def rows_of(room: int, name: str, count: int, options: Sequence[str], peer: str = "") -> List[Row]:
    """The rows of one set in one room, of ours or of a peer.

    Raises:
        subprocess.CalledProcessError: the bench failed; its message is on standard error.
    """
    command = [str(DEVEL / "lib" / "yarm" / bench_of(peer)), f"arena={room}", f"count={count}"]
    command += [*SETS[name].options, *(PEER_TOUR if peer and SETS[name].is_tour else ()), *options]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True, timeout=1800.0)
    return [{"set": name, **row} for row in csv.DictReader(done.stdout.splitlines())]


def bench_of(peer: str) -> str:
    """Name of the program that measures ours, or a peer."""
    return f"localisation_{peer}_bench" if peer else "localisation_bench"


def numbers(rows: List[Row], key: str) -> np.ndarray:
    """A column as numbers."""
    return np.array([float(row[key]) for row in rows])


def start_line(name: str, rows: List[Row]) -> str:
    """One line of the table of starts."""
    counts = [sum(row["outcome"] == outcome for row in rows) for outcome in ("right", "wrong", "doubtful")]
    right = [row for row in rows if row["outcome"] == "right"]
    off, turned, cpu = (numbers(right, key) for key in ("off_m", "turned_deg", "cpu_s"))
    cells = [
        *counts,
        f"{1e3 * off.mean():.1f} ({1e3 * np.percentile(off, 95):.1f}, {1e3 * off.max():.1f})",
        f"{turned.mean():.2f} ({np.percentile(turned, 95):.2f})",
        f"{numbers(right, 'score').min():.2f}, {numbers(right, 'margin').min():.2f}",
        f"{numbers(right, 'scans').mean() / 10.0:.1f}",
        f"{cpu.mean():.3f} ({cpu.max():.3f})",
    ]
    return f"| {name}, {len(rows)} | " + " | ".join(str(cell) for cell in cells) + " |"


def tour_line(name: str, rows: List[Row]) -> str:
    """One line of the table of tours."""
    rmse = 1e3 * numbers(rows, "rmse_m")
    heading = numbers(rows, "heading_rms_deg")
    p95, heading_p95 = 1e3 * numbers(rows, "p95_m"), numbers(rows, "heading_p95_deg")
    cells = [
        f"{rmse.mean():.1f} ({rmse.max():.1f})",
        f"{p95.mean():.1f} ({p95.max():.1f})",
        f"{1e3 * numbers(rows, 'max_m').max():.0f}",
        f"{heading.mean():.2f} ({heading.max():.2f})",
        f"{heading_p95.mean():.2f} ({heading_p95.max():.2f})",
        f"{numbers(rows, 'update_us').mean():.0f}",
        f"{numbers(rows, 'update_p99_us').max():.0f}",
        f"{int(numbers(rows, 'doubtful').sum())}",
        f"{int(numbers(rows, 'lost').sum())}",
    ]
    return f"| {name}, {len(rows)} | " + " | ".join(cells) + " |"


STARTS_HEAD = (
    "starts | right | wrong | doubtful | off mean (p95, max) mm | heading mean (p95) deg | least score, margin"
    " | after s | CPU s a start, mean (max)"
)
TOURS_HEAD = (
    "tours | RMSE mean (worst) mm | p95 mean (worst) mm | worst moment mm | heading RMS mean (worst) deg"
    " | heading p95 mean (worst) deg | us an update, mean | p99 (worst) | doubtful scans | scans lost"
)


def main() -> int:
    """Run the sets asked for and print their tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rooms", type=int, default=5, help="rooms 1 to this")
    parser.add_argument("--sets", nargs="+", choices=sorted(SETS))
    parser.add_argument("--peer", choices=("", MRPT), default="")
    parser.add_argument("--count", type=int, default=0, help="starts or tours a room instead of the set's own")
    parser.add_argument("--with", dest="options", nargs="*", default=[], metavar="NAME=VALUE", help="for every run")
    given = parser.parse_args()
    sets = given.sets or list(PEER_SETS if given.peer else SETS)
    unknown = set(sets) - set(PEER_SETS) if given.peer else set()
    if unknown:
        parser.error(f"{given.peer} is measured in {', '.join(PEER_SETS)}; not in {', '.join(sorted(unknown))}")
    subprocess.run(["make", "-C", str(BUILD), bench_of(given.peer)], check=True, stdout=subprocess.DEVNULL)
    ending = f"_{given.peer}" if given.peer else ""
    for is_tour, head, line, file in (
        (False, STARTS_HEAD, start_line, f"localisation_starts{ending}.csv"),
        (True, TOURS_HEAD, tour_line, f"localisation_tours{ending}.csv"),
    ):
        names = [name for name in sets if SETS[name].is_tour == is_tour]
        table: List[Row] = []
        if names:
            print(f"\n| {head} |\n" + "|---" * (head.count("|") + 1) + "|")
        for name in names:
            count = given.count or SETS[name].count
            rooms = range(1, given.rooms + 1)
            rows = [row for room in rooms for row in rows_of(room, name, count, given.options, given.peer)]
            print(line(name, rows), flush=True)
            table += rows
        if table:
            raw_rows.save(raw_rows.DATA / file, table)
    return 0


if __name__ == "__main__":
    sys.exit(main())
