#!/usr/bin/env python3
"""How perception finds and measures boxes that nobody registered: random places on part and table, Kinect noise on.

    python3 bench/strays.py [--rounds 5] [--seed 5] [--sizes 0.15,0.06,0.04 ...]

Four boxes a round, 75 sets (2.5 s) each. ``beside`` counts pieces where no box is, ``left`` those still there 45 sets
after the boxes have gone.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path
from typing import List, Tuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test"))

from support.piece_errors import calibrated_cell
from support.strays import Size, drop, errors, look, places, seen_at, strays, take_away

SIZES = ("0.15,0.06,0.04", "0.08,0.05,0.04", "0.06,0.04,0.04", "0.04,0.04,0.04", "0.03,0.03,0.03", "0.02,0.02,0.02")
SETS, GONE_SETS = 75, 45


def main() -> int:
    """Measure and print."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--rounds", type=int, default=5)
    options.add_argument("--seed", type=int, default=5)
    options.add_argument("--sizes", nargs="*", default=SIZES, help="length,width,height, metres")
    chosen = options.parse_args()
    print("| box, m | found | beside | left | middle, p50 / p90 mm | top | length | width | axis, deg |")
    print("|---|---|---|---|---|---|---|---|---|")
    for text in chosen.sizes:
        length, width, height = (float(edge) for edge in text.split(","))
        _tell((length, width, height), chosen.rounds, np.random.default_rng(chosen.seed))
    return 0


def _tell(size: Size, rounds: int, rng: np.random.Generator) -> None:
    off: List[Tuple[float, float, float, float, float]] = []
    dropped, beside, left, cell = 0, 0, 0, calibrated_cell()
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(rounds):
            at = places(rng)
            names = drop(cell, Path(folder), size, at, rng.uniform(-np.pi, np.pi, len(at)).tolist())
            found, truth = look(cell, SETS), cell.world.transforms()
            seen = [(seen_at(found, truth[name]), truth[name]) for name in names]
            off += [errors(piece, pose, size) for piece, pose in seen if piece is not None]
            dropped += len(names)
            beside += max(0, len(strays(found)) - sum(piece is not None for piece, _ in seen))
            left += len(strays(take_away(cell, names, GONE_SETS)))
    cell.close()
    scaled = np.array(off or [(np.nan,) * 5]) * (1e3, 1e3, 1e3, 1e3, np.degrees(1.0))
    cells = [f"{p50:.1f} / {p90:.1f}" for p50, p90 in np.percentile(scaled, (50, 90), axis=0).T]
    print(f"| {size} | {len(off)} of {dropped} | {beside} | {left} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    raise SystemExit(main())
