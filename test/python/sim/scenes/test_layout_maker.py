"""Made layouts: the same for the same kind and seed, ten boxes apart from each other, every tag to be seen."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from yarm.geometry import Pose2
from yarm.sim.checks.layout_check import LEAST_SHARE, sights
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.scenes.layout import BLANK, Layout
from yarm.sim.scenes.layout_maker import HALF_M, KINDS, TAGS, make_layout

CASES = list(itertools.product(KINDS, (0, 7, 24)))


def gaps(layout: Layout) -> np.ndarray:
    """(n, n) least gap between the outlines of the boxes by their corners, inf to themselves."""
    boxes = FlatBoxes(layout.boxes)
    corners = boxes.corners()
    found = np.full((len(boxes), len(boxes)), np.inf)
    for i, own in enumerate(corners):
        sides = np.concatenate([own + s * (np.roll(own, -1, axis=0) - own) for s in np.linspace(0.0, 1.0, 12)])
        found[i] = boxes.signed(sides).min(axis=0)
        found[i, i] = np.inf
    return found


@pytest.mark.parametrize("kind, seed", CASES)
def test_every_tag_can_be_seen_and_every_box_stands_free(kind: str, seed: int) -> None:
    layout = make_layout(kind, seed)
    assert len(layout.boxes) == 10 == len(layout.tags), f"{kind}_{seed}"
    assert min(sight.share for sight in sights(layout)) >= LEAST_SHARE
    assert gaps(layout).min() > 0.0
    assert np.abs(FlatBoxes(layout.boxes).corners()).max() <= HALF_M
    assert FlatBoxes(layout.arena.blocks).distances(layout.start.x, layout.start.y).min() > 0.2


@pytest.mark.parametrize("kind, seed", CASES)
def test_one_or_two_are_blank_and_one_or_two_are_doubles(kind: str, seed: int) -> None:
    tags = make_layout(kind, seed).tags
    named = [tag for tag in tags if tag != BLANK]
    assert 1 <= len(tags) - len(named) <= 2 and 1 <= len(named) - len(set(named)) <= 2
    assert all(1 <= tag <= TAGS for tag in named)


def test_the_same_kind_and_seed_give_the_same_layout() -> None:
    assert make_layout("cluster", 3) == make_layout("cluster", 3)
    assert make_layout("cluster", 3) != make_layout("cluster", 4)


@pytest.mark.parametrize("seed", range(4))
def test_walls_are_half_a_metre_before_the_tags_of_a_wall_layout(seed: int) -> None:
    layout = make_layout("wall", seed)
    near = 0
    for box in layout.boxes:
        face = box.pose.compose(Pose2(0.5 * box.size[0], 0.0))
        ahead = HALF_M - max(abs(face.x), abs(face.y))
        straight = min(abs(math.remainder(box.pose.yaw_rad, math.pi / 2)), 1.0) < 1e-6
        near += straight and 0.45 - 1e-6 <= ahead <= 0.60 + 1e-6
    assert near >= 4


@pytest.mark.parametrize("seed", range(4))
def test_rows_of_a_corridor_face_each_other(seed: int) -> None:
    yaws = [box.pose.yaw_rad for box in make_layout("corridor", seed).boxes]
    assert all(abs(math.remainder(a - b - math.pi, 2 * math.pi)) < 1e-6 for a, b in zip(yaws[:5], yaws[5:]))


@pytest.mark.parametrize("seed", range(4))
def test_boxes_of_a_cluster_stand_close(seed: int) -> None:
    middles = np.array([(box.pose.x, box.pose.y) for box in make_layout("cluster", seed).boxes])
    apart = np.linalg.norm(middles[:, None] - middles[None], axis=2) + np.eye(10) * 9.0
    assert int((apart.min(axis=1) <= 0.70 + 1e-6).sum()) >= 6


def test_an_unknown_kind_is_named() -> None:
    with pytest.raises(ValueError, match="'round' is not known"):
        make_layout("round", 0)
