"""Raw rows of a benchmark beside its figures: ``bench/data/<name>.csv``, or another folder."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any, Mapping, Sequence

DATA = Path(__file__).resolve().parent / "data"


def save(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write rows that have the same columns, replacing what is there.

    Raises:
        ValueError: there are no rows, or one has another column than the first.
    """
    if not rows:
        raise ValueError(f"{path}: no rows were measured, so nothing is written")
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
