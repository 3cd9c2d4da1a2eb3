#!/usr/bin/env python3
"""Where perception sees pieces of debris, against where they are: random places on part and table, Kinect noise on.

    python3 bench/pieces.py [--rounds 25] [--sets 15]

Four pieces a round. One line for single views, one for the median of a piece's views (half a second of them). A row a
view and a median goes to ``bench/data/pieces.csv``; ``hand_picks.py`` draws from the medians.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Dict, List, Sequence

import numpy as np
import raw_rows

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test"))

from support.piece_errors import Error, calibrated_cell, looked_at

VIEW, MEDIAN = "view", "median"


def main() -> int:
    """Measure, print and keep the rows."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--rounds", type=int, default=25)
    options.add_argument("--sets", type=int, default=15, help="views of each piece")
    options.add_argument("--seed", type=int, default=1)
    chosen = options.parse_args()
    rng, cell = np.random.default_rng(chosen.seed), calibrated_cell()
    pieces = [views for _ in range(chosen.rounds) for views in looked_at(cell, rng, chosen.sets)]
    cell.close()
    views = [view for seen in pieces for view in seen]
    asked = chosen.sets * len(pieces)
    print(
        f"{len(pieces)} pieces, {chosen.sets} sets each: {len(views)} of {asked} views; the others had too few points"
    )
    medians = [median(seen) for seen in pieces if seen]
    tell("single views", views)
    tell("median of a piece's views", medians)
    raw_rows.save(
        raw_rows.DATA / "pieces.csv",
        [row(of, error) for of, kept in ((VIEW, views), (MEDIAN, medians)) for error in kept],
    )
    return 0


def row(of: str, error: Error) -> Dict[str, object]:
    """A row of the file."""
    return {"of": of, **{name: round(value, 5) for name, value in asdict(error).items()}}


def median(views: Sequence[Error]) -> Error:
    """Of each number by itself."""
    return Error(*np.median([(v.along_m, v.across_m, v.top_m, v.axis_rad) for v in views], axis=0).tolist())


def tell(name: str, errors: List[Error]) -> None:
    """Print the percentiles of the errors' sizes."""
    numbers = {
        "middle, mm": [1e3 * np.hypot(e.along_m, e.across_m) for e in errors],
        "along, mm": [1e3 * abs(e.along_m) for e in errors],
        "across, mm": [1e3 * abs(e.across_m) for e in errors],
        "top, mm": [1e3 * abs(e.top_m) for e in errors],
        "axis, deg": [np.degrees(abs(e.axis_rad)) for e in errors],
    }
    for what, sizes in numbers.items():
        p50, p90, most = np.percentile(sizes, (50, 90, 100))
        print(f"{name}: {what}: p50 {p50:.1f}, p90 {p90:.1f}, at most {most:.1f}")


if __name__ == "__main__":
    raise SystemExit(main())
