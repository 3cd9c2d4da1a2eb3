"""Figure 1: the published result on `practice`, line by line, beside whole rounds of `report` and `yarm`."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Sequence, Tuple

import numpy as np

from yarm.experiments.explore.pictures import BORDER_M, draw_arena
from yarm.experiments.inspect.pictures import draw_round
from yarm.experiments.inspect.record import RoundRecord
from yarm.experiments.run.plots import new_figure, save_figure
from yarm.experiments.run.tables import markdown_table
from yarm.experiments.study.tag_figures import write_rows
from yarm.inspection.model import BLANK, reading_words
from yarm.inspection.viewpoints import viewpoint
from yarm.sim.scenes.arena import Arena

PUBLISHED: Tuple[Tuple[int, int, bool], ...] = (
    (6, 14, False),
    (4, 8, False),
    (3, 10, False),
    (2, 11, False),
    (1, 5, False),
    (7, 5, True),
    (10, 2, False),
    (9, 11, True),
    (8, BLANK, False),
    (5, 15, False),
)
"""Box, tag, and whether it is marked as a duplicate, in the published order."""
PUBLISHED_S = 360.0
"""About six minutes, as the text says."""
FRONTAL_M = 0.5
"""Where the published order's straight lines are drawn: its real viewpoints are unknown."""


def write_practice(records: Sequence[RoundRecord], arena: Arena, folder: Path) -> str:
    """``inspect_practice.csv`` and ``.png``; the table to print.

    Args:
        records: a round of each controller in the practice world.
        arena: that world.
        folder: where to.
    """
    names = [record.info.controller for record in records]
    header = ["published order", "box", "published", *(f"{n}: {what}" for n in names for what in ("read", "place, s"))]
    rows = [_row(place, line, records) for place, line in enumerate(PUBLISHED, start=1)]
    ends = [f"{record.end_s:.0f}" for record in records]
    rows.append(["home, s", "", f"about {PUBLISHED_S:.0f}", *(cell for end in ends for cell in ("", end))])
    write_rows(folder / "inspect_practice.csv", header, rows)
    _plot(records, arena, folder / "inspect_practice.png")
    return markdown_table(header, rows)


def _row(place: int, line: Tuple[int, int, bool], records: Sequence[RoundRecord]) -> List[str]:
    box, tag, double = line
    row = [str(place), str(box), _word(tag, double)]
    for record in records:
        found = {verdict.box: (i, verdict) for i, verdict in enumerate(record.verdicts, start=1)}
        if box not in found:
            row += ["-", "-"]
            continue
        i, verdict = found[box]
        row += [_word(verdict.reading.tag, verdict.duplicate), f"{i}, {verdict.found_s:.0f}"]
    return row


def _word(tag: int, double: bool) -> str:
    return reading_words(tag) + (" (duplicate)" if double else "")


def _plot(records: Sequence[RoundRecord], arena: Arena, path: Path) -> None:
    figure, axes = new_figure(5.6 * (len(records) + 1), 5.8, len(records) + 1)
    _draw_published(axes[0], records[0], arena)
    for axis, record in zip(axes[1:], records):
        draw_round(axis, record, arena)
    save_figure(figure, path)


def _draw_published(axis: Any, record: RoundRecord, arena: Arena) -> None:
    """The published verdicts, and straight lines in the published order."""
    draw_arena(axis, arena)
    boxes: Dict[int, Any] = {box.number: box for box in record.boxes}
    places = [(arena.start.x, arena.start.y)]
    for number, tag, double in PUBLISHED:
        box = boxes[number]
        right = tag == record.truth[number]
        axis.fill(*box.corners().T, color="tab:green" if right else "tab:red", alpha=0.5)
        axis.annotate(f"{number}: {reading_words(tag)}{'*' if double else ''}", (box.pose.x, box.pose.y), fontsize=8)
        at = viewpoint(box, FRONTAL_M, 0).pose
        places.append((at.x, at.y))
    way = np.array([*places, places[0]])
    axis.plot(way[:, 0], way[:, 1], ":", color="tab:blue", lw=1.2)
    title = f"published: about {PUBLISHED_S:.0f} s (lines: its order at {FRONTAL_M} m)"
    axis.set(title=title, xlabel="x, m", ylabel="y, m", aspect="equal")
    axis.set(xlim=(arena.lower[0] - BORDER_M, arena.upper[0] + BORDER_M))
    axis.set(ylim=(arena.lower[1] - BORDER_M, arena.upper[1] + BORDER_M))
