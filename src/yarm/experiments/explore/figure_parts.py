"""What the study's figures share: points over boxes, CSV files, numbers in them."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any, Dict, List, Sequence

import numpy as np

from yarm.experiments.run.plots import new_figure, save_figure


def box_figure(groups: Dict[str, List[float]], label: str, path: Path) -> Path:
    """A box and all its points for each group; a group without values keeps its place."""
    figure, axes = new_figure(max(5.0, 1.5 * len(groups)), 4.4)
    axis = axes[0]
    for i, (name, values) in enumerate(groups.items()):
        if values:
            axis.boxplot([values], positions=[i], widths=0.5, showfliers=False)
        spread = 0.12 * np.sin(np.arange(len(values)) * 2.4)
        axis.plot(i + spread, values, "o", ms=3, alpha=0.5, color="tab:blue", label=name)
    axis.set_xticks(range(len(groups)))
    labels = [name.replace(" without ", "\nwithout ").replace("+", "\n+ ") for name in groups]
    axis.set_xticklabels(labels, fontsize="small")
    axis.set(ylabel=label, xlim=(-0.6, max(1, len(groups)) - 0.4))
    axis.grid(True, axis="y", alpha=0.3)
    return save_figure(figure, path)


def number_text(value: float, digits: int = 1) -> str:
    """A number for a CSV file; empty when it is not finite."""
    return f"{value:.{digits}f}" if math.isfinite(value) else ""


def write_csv(path: Path, header: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """A header and rows."""
    with path.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(header)
        writer.writerows(rows)
