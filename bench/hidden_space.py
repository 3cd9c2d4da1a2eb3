#!/usr/bin/env python3
"""Whether planned ways lead into things that no camera sees, under each policy of ``hidden``, against the simulator.

    python3 bench/hidden_space.py [--trials 40] [--goals 6] [--silent 0 1 2] [--seed 1] [--csv rows.csv]

Trials with none, one and two of the four cameras silent, in turns (test/support/hidden_truth.py); a row each.
"""

from __future__ import annotations

import argparse
import csv
import sys
from pathlib import Path
from typing import Dict, List, Optional

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test"))

from support.hidden_truth import COUNTED, Tally, run_trial

SILENT = (0, 1, 2)


def main() -> int:
    """Measure, write and print."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--trials", type=int, default=40, help="for each number of silent cameras")
    options.add_argument("--goals", type=int, default=6, help="for each robot")
    options.add_argument("--silent", type=int, nargs="*", default=SILENT, choices=SILENT, help="silent cameras")
    options.add_argument("--seed", type=int, default=1, help="of the first trial")
    options.add_argument("--csv", type=Path, default=None, help="rows go there; trials that are in it already are kept")
    chosen = options.parse_args()
    rows = _kept(chosen.csv)
    done = {(row["seed"], row["silent"]) for row in rows}
    for seed in range(chosen.seed, chosen.seed + chosen.trials):
        for silent in chosen.silent:
            if (str(seed), str(silent)) not in done:
                tally = Tally()
                run_trial(seed, silent, chosen.goals, tally)
                rows += [
                    {
                        **{"seed": str(seed), "silent": str(silent), "policy": policy.value},
                        **{name: str(getattr(count, name)) for name in COUNTED},
                    }
                    for policy, count in tally.counts.items()
                ]
                _write(chosen.csv, rows)
    _tell(rows)
    return 0


def _kept(path: Optional[Path]) -> List[Dict[str, str]]:
    if path is None or not path.exists():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def _write(path: Optional[Path], rows: List[Dict[str, str]]) -> None:
    if path is not None:
        with path.open("w", newline="") as file:
            writer = csv.DictWriter(file, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)


def _tell(rows: List[Dict[str, str]]) -> None:
    print("| silent cameras | policy | things hidden | driven into | goals with a way under `free` | reached |")
    print("|---|---|---|---|---|---|")
    for silent in sorted({row["silent"] for row in rows}):
        for policy in dict.fromkeys(row["policy"] for row in rows):
            mine = [row for row in rows if (row["silent"], row["policy"]) == (silent, policy)]
            numbers = [sum(int(row[name]) for row in mine) for name in COUNTED]
            print(f"| {silent} | `{policy}` | " + " | ".join(map(str, numbers)) + " |")


if __name__ == "__main__":
    sys.exit(main())
