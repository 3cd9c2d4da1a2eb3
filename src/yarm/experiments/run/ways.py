"""Drawings of a mission as inline SVG: a way planned and driven, and a part's top square by square."""

from __future__ import annotations

import html
import math
from typing import Optional, Sequence, Tuple

from yarm.experiments.html import number
from yarm.experiments.run.record import PathRow, SquareRow
from yarm.geometry import BoolArray, GridSpec

CELL_PX, SQUARE_PX = 7, 26
NEVER, SANDED = "#f6d5d2", ((205, 226, 243), (22, 78, 135))
"""Fill of a square that was not sanded; of the first and the last one that was, red, green, blue."""


def way_svg(
    spec: GridSpec,
    obstacles: Optional[BoolArray],
    planned: Sequence[Sequence[Tuple[int, int]]],
    driven: Sequence[PathRow],
) -> str:
    """The cell from above: what never moves in grey, ways planned dashed, the way driven as a line.

    Args:
        spec: the grid.
        obstacles: (gx, gy) columns in which something never moves; None when nobody knows.
        planned: columns of each way.
        driven: end effector, in order.
    """
    width, height = spec.shape[0] * CELL_PX, spec.shape[1] * CELL_PX

    def point(x: float, y: float) -> str:
        return f"{CELL_PX * x:.1f},{height - CELL_PX * y:.1f}"

    parts = [f"<svg viewBox='0 0 {width} {height}' width='{width}' role='img' aria-label='way planned and driven'>"]
    parts.append(f"<rect width='{width}' height='{height}' fill='#fff' stroke='#888'/>")
    if obstacles is not None:
        cells = [f"M{point(i, j)}h{CELL_PX}v-{CELL_PX}h-{CELL_PX}z" for i, j in zip(*obstacles.nonzero())]
        parts.append(f"<path d='{''.join(cells)}' fill='#c4c4c4'/>")
    if driven:
        points = " ".join(point(row.column_x, row.column_y) for row in driven)
        parts.append(f"<polyline class='driven' points='{points}' fill='none' stroke='#16487f' stroke-width='4'/>")
        for row, fill in ((driven[0], "#fff"), (driven[-1], "#16487f")):
            x, y = point(row.column_x, row.column_y).split(",")
            parts.append(f"<circle cx='{x}' cy='{y}' r='5' fill='{fill}' stroke='#16487f' stroke-width='2'/>")
    for columns in planned:
        points = " ".join(point(x + 0.5, y + 0.5) for x, y in columns)
        line = "fill='none' stroke='#f0a050' stroke-width='2' stroke-dasharray='5 4'"
        parts.append(f"<polyline class='planned' points='{points}' {line}/>")
    return "".join([*parts, "</svg>"])


def part_svg(rows: Sequence[SquareRow]) -> str:
    """A part's top: every square with its time, the darker the later; what it says in full shows where one points."""
    times = [row.sanded_s for row in rows if math.isfinite(row.sanded_s)]
    first, last = (min(times), max(times)) if times else (0.0, 0.0)
    high = 1 + max(row.row for row in rows)
    wide = 1 + max(row.column for row in rows)
    size = f"viewBox='0 0 {wide * SQUARE_PX} {high * SQUARE_PX}' width='{wide * SQUARE_PX}'"
    parts = [f"<svg {size} role='img' aria-label='squares of the part'>"]
    for row in rows:
        x, y = SQUARE_PX * row.column, SQUARE_PX * (high - 1 - row.row)
        fill, ink, text = NEVER, "#222", "x"
        if math.isfinite(row.sanded_s):
            share = (row.sanded_s - first) / (last - first) if last > first else 0.0
            fill = "#" + "".join(f"{round(a + share * (b - a)):02x}" for a, b in zip(*SANDED))
            ink, text = "#fff" if share > 0.5 else "#222", f"{row.sanded_s:.0f}"
        box = f"<rect x='{x}' y='{y}' width='{SQUARE_PX}' height='{SQUARE_PX}' fill='{fill}' stroke='#fff'/>"
        label = f"<text x='{x + SQUARE_PX / 2}' y='{y + SQUARE_PX / 2 + 3}' font-size='9' fill='{ink}'"
        title = f"<title>{html.escape(square_words(row))}</title>"
        parts.append(f"<g>{box}{label} text-anchor='middle'>{text}</text>{title}</g>")
    return "".join([*parts, "</svg>"])


def square_words(row: SquareRow) -> str:
    """What became of a square."""
    where = f"({row.x_m:.3f}, {row.y_m:.3f}) m"
    if row.reason:
        return f"{where}: not sanded: {row.reason}"
    speed, tilt = number(row.speed_mps, 3, "m/s"), number(row.tilt_deg, 1, "deg")
    return f"{where}: sanded at {row.sanded_s:.1f} s, {speed}, tool {tilt} off the normal"
