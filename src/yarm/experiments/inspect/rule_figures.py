"""Figures 9 and 10: what the report's rules for overlapping tags choose, and its angle predicted, measured and true."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import List, Optional, Tuple

import numpy as np

from yarm.experiments.run.plots import new_figure, save_figure
from yarm.experiments.run.tables import markdown_table
from yarm.experiments.statistics import Proportion
from yarm.experiments.study.tag_figures import plain_view, write_rows
from yarm.experiments.study.tag_views import picture_of, report_recogniser, staged
from yarm.geometry import Pose2
from yarm.geometry.pinhole import BoxSize, level_camera
from yarm.inspection.report_round import ReportRoundParams
from yarm.robots.turtlebot import CAMERA_Z_M, RGB_MOUNT
from yarm.sim.sensors.rgb_camera import Imaging, RgbCamera, Room, TaggedBox
from yarm.tags.quads import bottom_left_angle_deg
from yarm.tags.report import Sighting, edge_case, predicted_angle_deg

PAIRS = 40
FIRST_PAIR_SEED = 400
"""Boxes of a pair are those of drawn numbers from here on."""
RULES = ("by_angle", "by_area", "together")
ANGLES_DEG = (-60, -45, -30, -15, 0, 15, 30, 45, 60)
DISTANCES_M = (0.5, 0.8)
ANGLE_TAG = 4
ROOM = Room((-3.0, -3.0), (3.0, 3.0))


@dataclass(frozen=True)
class Pair:
    """Two boxes that stand against each other, and how one of them is looked at.

    Attributes:
        number: of the draw.
        tags: of the box that is looked at, and of the other.
        other: where the other stands, seen from the first.
        distance_m: from the robot to the first.
        angle_deg: from its face's normal.
    """

    number: int
    tags: Tuple[int, int]
    other: Pose2
    distance_m: float
    angle_deg: float


def drawn_pair(number: int) -> Pair:
    """The pair of a number: side by side or at an angle, as boxes 9 and 10 of the practice world stand."""
    rng = np.random.default_rng((FIRST_PAIR_SEED, number))
    first, second = (int(tag) for tag in rng.permutation(15)[:2] + 1)
    side = 1.0 if rng.random() < 0.5 else -1.0
    turn = float(rng.uniform(0.0, 1.6)) * side
    other = Pose2(float(rng.uniform(-0.05, 0.15)), side * float(rng.uniform(0.40, 0.52)), -turn)
    return Pair(
        number, (first, second), other, float(rng.choice([0.5, 0.6, 0.7, 0.8])), float(rng.choice([0, 30, -30]))
    )


def sightings_of(pair: Pair) -> List[Sighting]:
    """What survives of three images of a pair, at the report's three headings."""
    box, size = Pose2(0.0, 0.0), BoxSize()
    pictures = [picture_of(tag, "") for tag in pair.tags]
    room = Room(ROOM.lower, ROOM.upper, ROOM.wall_m, (
        TaggedBox(box, size, pictures[0]), TaggedBox(box.compose(pair.other), size, pictures[1])
    ))  # fmt: skip
    step = ReportRoundParams().heading_step
    bearing = math.radians(pair.angle_deg)
    found: List[Sighting] = []
    for i, heading in enumerate((step, 0.0, -step)):
        place = (pair.distance_m * math.cos(bearing), pair.distance_m * math.sin(bearing))
        camera = level_camera(Pose2(*place, bearing + math.pi + heading), RGB_MOUNT, CAMERA_Z_M)
        frame = RgbCamera(seed=pair.number).render(room, camera, Imaging(), i)
        predicted = predicted_angle_deg(pair.angle_deg, math.degrees(heading))
        found += [s for s in report_recogniser().look(frame.grey, 1, predicted) if not s.rejection]
    return found


def write_edge_cases(folder: Path, count: int = PAIRS) -> str:
    """Figure 9, ``inspect_edge.csv`` and ``.png``: over pairs of which both tags survive; the table to print."""
    rows, hits, pairs = [], dict.fromkeys(RULES, 0), 0
    for number in range(count):
        pair = drawn_pair(number)
        survivors = sightings_of(pair)
        row = [number, *pair.tags, f"{pair.other.y:.3f}", f"{math.degrees(pair.other.yaw_rad):.0f}"]
        row += [pair.distance_m, pair.angle_deg, *(sum(s.tag == tag for s in survivors) for tag in pair.tags)]
        if {s.tag for s in survivors} >= set(pair.tags):
            chosen = edge_case(survivors, list(pair.tags))
            right = [getattr(chosen, rule) == pair.tags[0] for rule in RULES]
            pairs += 1
            for rule, hit in zip(RULES, right):
                hits[rule] += hit
            row += [int(hit) for hit in right]
        rows.append(row)
    header = ["pair", "tag", "neighbour", "across_m", "turned_deg", "distance_m", "angle_deg"]
    header += ["seen_tag", "seen_neighbour", *(f"{rule}_right" for rule in RULES)]
    write_rows(folder / "inspect_edge.csv", header, rows)
    shares = [Proportion(hits[rule], pairs) for rule in RULES]
    names = ("least angle difference", "largest area", "both together")
    figure, axes = new_figure(6.4, 3.8)
    rates = np.array([share.rate if pairs else 0.0 for share in shares])
    bounds = np.array([share.interval for share in shares])
    bars = np.abs(np.stack([rates - bounds[:, 0], bounds[:, 1] - rates]))
    axes[0].bar(range(len(names)), rates, yerr=bars, capsize=4)
    axes[0].set_xticks(range(len(names)))
    axes[0].set_xticklabels(names)
    axes[0].axhline(0.5, color="tab:grey", ls=":")
    axes[0].set(ylabel="the box that is looked at, 95 %", ylim=(0, 1.05), title=f"{pairs} of {count} pairs")
    save_figure(figure, folder / "inspect_edge.png")
    return markdown_table(
        ("rule", "right"), [(n, f"{s.hits} of {s.trials}: {s.text()}") for n, s in zip(names, shares)]
    )


def write_angles(folder: Path) -> Path:
    """Figure 10, ``inspect_angle.csv`` and ``.png``: the bottom left angle predicted, measured and true."""
    rows: List[Tuple[float, float, float, float, Optional[float]]] = []
    for distance in DISTANCES_M:
        for angle in ANGLES_DEG:
            frame, _, corners = staged(plain_view(distance, angle, ANGLE_TAG))
            seen = next(s for s in report_recogniser().look(frame.grey) if s.tag == ANGLE_TAG)
            measured = None if seen.rejection else seen.bottom_left_deg
            rows.append((distance, angle, predicted_angle_deg(angle), bottom_left_angle_deg(corners), measured))
    header = ["distance_m", "angle_deg", "predicted_deg", "true_deg", "measured_deg"]
    cells = [[d, a, f"{p:.1f}", f"{t:.1f}", "" if m is None else f"{m:.1f}"] for d, a, p, t, m in rows]
    write_rows(folder / "inspect_angle.csv", header, cells)
    figure, axes = new_figure(10.0, 4.0, 2)
    for axis, distance in zip(axes, DISTANCES_M):
        mine = [row for row in rows if row[0] == distance]
        axis.plot([row[1] for row in mine], [row[2] for row in mine], "--", color="tab:grey", label="predicted")
        axis.plot([row[1] for row in mine], [row[3] for row in mine], "-", color="tab:green", label="true")
        kept = [(row[1], row[4]) for row in mine if row[4] is not None]
        axis.plot([a for a, _ in kept], [m for _, m in kept], "o", color="tab:blue", label="measured, where kept")
        axis.set(xlabel="viewpoint, deg", ylabel="angle at the bottom left corner, deg", title=f"{distance} m")
        axis.grid(True, alpha=0.3)
        axis.legend(fontsize="small")
    return save_figure(figure, folder / "inspect_angle.png")
