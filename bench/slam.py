#!/usr/bin/env python3
"""How well and how cheaply the map maker works: tours of simulated rooms, scored against the truth.

    source tools/env.sh && python3 bench/slam.py [--rooms 8] [--sets nominal odo2 ...] [--pictures docs/images]

Builds `slam_bench` (bench/slam.cpp), runs one process a tour, and prints one table a set of runs; the raw rows go to
``bench/data/slam.csv``. Every number of the library can be changed: ``--with NAME=VALUE``.
"""

from __future__ import annotations

import argparse
import csv
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Dict, List, Tuple

import numpy as np
import raw_rows

ROOT = Path(__file__).resolve().parents[1]
BUILD = Path(os.environ.get("YARM_BUILD", ROOT / "build"))
DEVEL = BUILD / "devel" if "YARM_BUILD" in os.environ else ROOT / "devel"
Row = Dict[str, str]

SETS: Dict[str, List[str]] = {
    "nominal": [],
    "odo2": ["odo=2", "v=0.3", "w=0.6"],
    "slip4": ["slip=4"],
    "biased": ["bias_slope=0"],
    "refined": ["refine=1"],
    "true_poses": ["true_poses=1"],
    "odometry_only": ["odometry_only=1"],
    "old0": ["old=0"],
    "keyframes_coarse": ["distance=0.4", "angle=0.35"],
    "no_blur_rule": ["blur_share=0"],
}
"""Options of the tours of each set."""

COLUMNS: Tuple[Tuple[str, str], ...] = (
    ("acc mean mm", "acc_mean_mm"),
    ("acc p95 mm", "acc_p95_mm"),
    ("acc max mm", "acc_max_mm"),
    ("5 cm %", "within_5cm_pct"),
    ("10 cm %", "within_10cm_pct"),
    ("spur %", "spur_pct"),
    ("unaligned mean mm", "raw_mean_mm"),
    ("traj RMSE m", "traj_rmse_m"),
    ("traj max m", "traj_max_m"),
    ("heading RMS deg", "heading_rms_deg"),
    ("CPU/scan ms", "scan_ms"),
    ("p99 ms", "scan_p99_ms"),
    ("real time %", "realtime_pct"),
    ("RSS MB", "resident_mb"),
    ("keyframes", "keyframes"),
)
LEAST_IS_WORST = {"within_5cm_pct", "within_10cm_pct"}


def tour(room: int, options: List[str]) -> Row:
    """The row of one tour.

    Raises:
        subprocess.CalledProcessError: the bench failed; its message is on standard error.
    """
    command = [str(DEVEL / "lib" / "yarm" / "slam_bench"), f"arena={room}", *options]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True, timeout=1800.0)
    return next(iter(csv.DictReader(done.stdout.splitlines())))


def markdown(name: str, rows: List[Row]) -> List[str]:
    """Mean and worst of a set as two rows of a table."""
    lines = []
    for label, pick in (("mean", lambda values, _: sum(values) / len(values)), ("worst", worst)):
        cells = [format(pick([float(row[key]) for row in rows], key), ".4g") for _, key in COLUMNS]
        lines.append(f"| {name}, {len(rows)} rooms, {label} | " + " | ".join(cells) + " |")
    return lines


def worst(values: List[float], key: str) -> float:
    """The least value where more is better, else the greatest."""
    return min(values) if key in LEAST_IS_WORST else max(values)


def draw(room: int, options: List[str], path: Path) -> Row:
    """Picture of a room's map over its true surfaces; gives the tour's row."""
    import matplotlib  # noqa: PLC0415

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt  # noqa: PLC0415

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "map.txt"
        row = tour(room, [*options, f"picture={file}"])
        head, cells, *surfaces = file.read_text().splitlines()
    width, height, *numbers = head.split()[1:]
    resolution, x0, y0, dx, dy, yaw = (float(number) for number in numbers)
    grid = np.array(cells.split(), dtype=int).reshape(int(height), int(width))
    rows, columns = np.mgrid[0 : grid.shape[0] + 1, 0 : grid.shape[1] + 1]
    x, y = x0 + columns * resolution, y0 + rows * resolution
    shade = np.select([grid > 50, grid >= 0], [0.15, 1.0], 0.75)
    figure, axes = plt.subplots(figsize=(6.0, 6.0))
    axes.pcolormesh(
        dx + np.cos(yaw) * x - np.sin(yaw) * y,
        dy + np.sin(yaw) * x + np.cos(yaw) * y,
        shade,
        cmap="gray",
        vmin=0.0,
        vmax=1.0,
    )
    for surface in surfaces:
        ax, ay, bx, by = (float(number) for number in surface.split())
        axes.plot([ax, bx], [ay, by], color="tab:red", linewidth=0.8)
    axes.set(xlim=(-0.4, 6.4), ylim=(-0.4, 6.4), aspect="equal", xlabel="x, m", ylabel="y, m")
    axes.set_title(f"room {room} after 15 min: map (black, grey unknown) and true walls (red)", fontsize=9)
    figure.tight_layout()
    figure.savefig(path, dpi=90)
    plt.close(figure)
    return row


def main() -> int:
    """Run the sets asked for and print their table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rooms", type=int, default=8, help="rooms 1 to this")
    parser.add_argument("--first", type=int, default=1, help="first room")
    parser.add_argument("--sets", nargs="+", choices=sorted(SETS), default=["nominal", "odo2", "slip4"])
    parser.add_argument("--with", dest="options", nargs="*", default=[], metavar="NAME=VALUE", help="for every tour")
    parser.add_argument(
        "--jobs", type=int, default=1, help="tours at a time; CPU times are honest with free cores only"
    )
    parser.add_argument("--pictures", type=Path, help="only draw rooms FIRST to ROOMS into this folder")
    given = parser.parse_args()
    subprocess.run(["make", "-C", str(BUILD), "slam_bench"], check=True, stdout=subprocess.DEVNULL)
    rooms = list(range(given.first, given.rooms + 1))
    if given.pictures:
        for room in rooms:
            draw(room, given.options, given.pictures / f"slam_room_{room}.png")
        return 0
    table: List[Row] = []
    print("| runs | " + " | ".join(title for title, _ in COLUMNS) + " |")
    print("|---" * (len(COLUMNS) + 1) + "|")
    for name in given.sets:
        options = [*SETS[name], *given.options]
        with ThreadPoolExecutor(given.jobs) as pool:
            rows = list(pool.map(lambda room, options=options: tour(room, options), rooms))
        print("\n".join(markdown(name, rows)), flush=True)
        table += [{"set": name, **row} for row in rows]
    raw_rows.save(raw_rows.DATA / "slam.csv", table)
    return 0


if __name__ == "__main__":
    sys.exit(main())
