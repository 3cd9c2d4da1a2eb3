"""Figure 2: greedy, exact and published order: lengths, and computing times for 4 to 15 boxes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from time import process_time
from typing import Any, Callable, List, Sequence, Tuple

import numpy as np

from yarm.experiments.inspect.practice_figure import FRONTAL_M, PUBLISHED
from yarm.experiments.run.plots import new_figure, save_figure
from yarm.experiments.run.tables import markdown_table
from yarm.experiments.statistics import percentile
from yarm.experiments.study.tag_figures import write_rows
from yarm.geometry import FloatArray
from yarm.inspection.boxes import Box
from yarm.inspection.tour import MOST_EXACT, Tour, brute_force_tour, exact_tour, greedy_tour, way_cost
from yarm.inspection.tour_search import searched_tour
from yarm.inspection.viewpoints import viewpoint

LEAST_BOXES = 4
MOST_BRUTE = 8
"""Boxes up to which every order is tried: nine take ten times as long as eight."""
DRAWS, SLOW_DRAWS = 20, 1
"""Layouts drawn for each number of boxes; of those, tried by brute force or with many views."""
HALF_M = 3.0
VIEWS = 12
"""Views a box in the second measurement, as in our round."""
MANY, MANY_DRAWS = (20, 30), 3
"""Boxes that are too many for the exact tour, and layouts drawn for each number."""
SEARCH_HEADER = ["boxes", "views_a_box", "layout", "searched_m", "greedy_m", "gap", "ms"]
HEADER = ["boxes", "views_a_box", "method", "layouts", "metres", "times_the_exact", "ms"]
Solver = Callable[[FloatArray, Sequence[int]], Tour]


@dataclass(frozen=True)
class OrderRow:
    """Some layouts of as many boxes, ordered by one method.

    Attributes:
        boxes: in each layout.
        views: of each box.
        method: greedy, exact or brute force.
        layouts: how many.
        metres: median length.
        ratio: median length, in lengths of the exact tour.
        milliseconds: median processor time.
    """

    boxes: int
    views: int
    method: str
    layouts: int
    metres: float
    ratio: float
    milliseconds: float


def practice_lengths(boxes: Sequence[Box]) -> List[Tuple[str, float, Tuple[int, ...]]]:
    """Name, length in metres and order of the practice world's three orders, over frontal views from (0, 0)."""
    places = [(view.x, view.y) for view in (viewpoint(box, FRONTAL_M, 0).pose for box in boxes)]
    costs = straight(np.array([*places, (0.0, 0.0)]))
    numbers = [box.number for box in boxes]
    published = [numbers.index(box) for box, _, _ in PUBLISHED]
    found = [("published", way_cost(costs, published), tuple(box for box, _, _ in PUBLISHED))]
    for name, solve in (("greedy", greedy_tour), ("exact", exact_tour)):
        tour = solve(costs, numbers)
        found.append((name, tour.cost, tuple(numbers[i] for i in tour.stops)))
    return found


def straight(places: FloatArray) -> FloatArray:
    """(n, n) straight distances between (n, 2) places."""
    lengths: FloatArray = np.linalg.norm(places[:, None] - places[None], axis=2)
    return lengths


def drawn_costs(boxes: int, views: int, seed: int) -> Tuple[FloatArray, List[int]]:
    """Distances between views of boxes drawn in a room of 6 x 6 m, home last, and the box of each view."""
    rng = np.random.default_rng((boxes, seed))
    middles = rng.uniform(-HALF_M, HALF_M, (boxes, 2))
    turns = rng.uniform(-math.pi, math.pi, boxes)
    spread = np.linspace(-1.0, 1.0, views) if views > 1 else np.zeros(1)
    places = [
        (x + FRONTAL_M * math.cos(turn + aside), y + FRONTAL_M * math.sin(turn + aside))
        for (x, y), turn in zip(middles, turns)
        for aside in spread
    ]
    home = rng.uniform(-HALF_M, HALF_M, 2)
    return straight(np.array([*places, tuple(home)])), [i // views for i in range(boxes * views)]


def measured(boxes: int, views: int, methods: Sequence[Tuple[str, Solver]], layouts: int) -> List[OrderRow]:
    """Methods in the same drawn layouts; the last one is the exact one's rival or itself."""
    lengths: List[List[float]] = [[] for _ in methods]
    times: List[List[float]] = [[] for _ in methods]
    for seed in range(layouts):
        costs, box_of = drawn_costs(boxes, views, seed)
        for i, (_, solve) in enumerate(methods):
            began = process_time()
            tour = solve(costs, box_of)
            times[i].append(1000.0 * (process_time() - began))
            lengths[i].append(tour.cost)
    exact = lengths[[name for name, _ in methods].index("exact")]
    return [
        OrderRow(
            boxes,
            views,
            name,
            layouts,
            percentile(lengths[i], 50),
            percentile([a / b for a, b in zip(lengths[i], exact)], 50),
            percentile(times[i], 50),
        )
        for i, (name, _) in enumerate(methods)
    ]


def write_searches(folder: Path, many: Sequence[int] = MANY, layouts: int = MANY_DRAWS) -> str:
    """``inspect_search.csv``: tours over more boxes than are solved exactly; a table to print.

    Args:
        folder: where to.
        many: numbers of boxes.
        layouts: drawn for each of them.
    """
    rows = []
    for count in many:
        for seed in range(layouts):
            costs, box_of = drawn_costs(count, VIEWS, seed)
            began = process_time()
            tour = searched_tour(costs, box_of, lambda cost, stops: True, dict.fromkeys(box_of, 1.0))
            taken_ms = 1000.0 * (process_time() - began)
            greedy = greedy_tour(costs, box_of).cost
            lengths = [f"{tour.cost:.2f}", f"{greedy:.2f}", f"{tour.gap:.4f}", f"{taken_ms:.0f}"]
            rows.append([str(count), str(VIEWS), str(seed), *lengths])
    write_rows(folder / "inspect_search.csv", SEARCH_HEADER, rows)
    return markdown_table(SEARCH_HEADER, rows)


def write_orders(boxes: Sequence[Box], folder: Path, most: int = MOST_EXACT) -> str:
    """``inspect_order.csv`` and ``.png``; the table of the practice world to print.

    Args:
        boxes: of the practice world.
        folder: where to.
        most: boxes up to which times are measured.
    """
    rows: List[OrderRow] = []
    plain: List[Tuple[str, Solver]] = [("greedy", greedy_tour), ("exact", exact_tour)]
    for count in range(LEAST_BOXES, most + 1):
        rows += measured(count, 1, plain, DRAWS)
        rows += measured(count, VIEWS, plain, SLOW_DRAWS)
        if count <= MOST_BRUTE:
            both = measured(count, 1, [("exact", exact_tour), ("brute force", brute_force_tour)], SLOW_DRAWS)
            rows.append(both[1])
    cells = [
        [r.boxes, r.views, r.method, r.layouts, f"{r.metres:.2f}", f"{r.ratio:.4f}", f"{r.milliseconds:.3f}"]
        for r in rows
    ]
    practice = practice_lengths(boxes)
    cells += [[len(boxes), 1, f"practice, {name}", 1, f"{metres:.2f}", "", ""] for name, metres, _ in practice]
    write_rows(folder / "inspect_order.csv", HEADER, cells)
    _plot(rows, folder / "inspect_order.png")
    lines = [(name, f"{metres:.2f}", " ".join(map(str, order))) for name, metres, order in practice]
    return markdown_table(("order", "m", "boxes"), lines)


def _plot(rows: Sequence[OrderRow], path: Path) -> None:
    figure, axes = new_figure(10.0, 4.0, 2)
    for name in ("greedy", "exact"):
        _line(axes[0], [r for r in rows if r.method == name and r.views == 1], "ratio", name)
    axes[0].set(xlabel="boxes", ylabel="length, times the exact tour's, median")
    for name, views in (("greedy", 1), ("exact", 1), ("brute force", 1), ("exact", VIEWS)):
        found = [r for r in rows if r.method == name and r.views == views]
        _line(axes[1], found, "milliseconds", f"{name}, {views} view{'s' if views > 1 else ''} a box")
    axes[1].set(xlabel="boxes", ylabel="processor time, ms", yscale="log")
    for axis in axes:
        axis.grid(True, which="both", alpha=0.3)
        axis.legend(fontsize="small")
    save_figure(figure, path)


def _line(axis: Any, rows: Sequence[OrderRow], field: str, label: str) -> None:
    axis.plot([row.boxes for row in rows], [getattr(row, field) for row in rows], "o-", ms=3, label=label)
