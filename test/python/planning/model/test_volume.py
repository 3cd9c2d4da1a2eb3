"""Sets of cells as integers, against the same by arrays."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from yarm.planning.model.volume import Volume

SHAPES = ((1, 1, 1), (2, 5, 1), (7, 3, 4), (9, 8, 6))
AROUND = np.ones((3, 3, 3), dtype=bool)


def drawn(shape, share, seed):
    return np.random.default_rng(seed).random(shape) < share


def set_of(volume, image):
    return volume.of_numbers(np.flatnonzero(image))


def cases(margin=1):
    for shape in SHAPES:
        volume = Volume(shape, margin)
        for seed in range(40):
            yield volume, drawn(shape, (0.03, 0.1, 0.3, 0.7, 0.95)[seed % 5], seed), f"{shape}, seed {seed}"


def test_a_set_holds_the_cells_it_was_made_of():
    for volume, image, case in cases():
        cells = np.argwhere(image)
        parts = [cells[::2], cells[1::2], [[-1, 0, 0], [0, 0, volume.shape[2]]]]
        assert np.array_equal(np.sort(volume.numbers_of(parts)), np.flatnonzero(image)), case
        assert np.array_equal(volume.image(set_of(volume, image)), image), case
    assert volume.numbers_of([]).size == 0


def test_the_field_is_everything_and_the_border_all_but_the_inner_and_the_floor():
    for shape in SHAPES:
        volume = Volume(shape, 3)
        assert volume.image(volume.field).all()
        inner = np.zeros(shape, dtype=bool)
        inner[1:-1, 1:-1, :-1] = True
        assert np.array_equal(volume.image(volume.border), ~inner), shape


@pytest.mark.parametrize("margin", [1, 3])
def test_growing_and_shrinking(margin):
    for volume, image, case in cases(margin):
        cells = set_of(volume, image)
        assert volume.grown(cells) == set_of(volume, ndimage.binary_dilation(image, AROUND)), case
        assert volume.shrunk(cells) == set_of(volume, ndimage.binary_erosion(image, AROUND, border_value=1)), case


def test_cells_in_groups():
    for volume, image, case in cases():
        count = ndimage.convolve(image.astype(int), AROUND.astype(int), mode="constant")
        groups = ndimage.binary_dilation(image & (count > 2), AROUND) & image
        assert volume.clustered(set_of(volume, image)) == set_of(volume, groups), case


@pytest.mark.parametrize("sizes", [(1, 1, 1), (2, 2, 2), (3, 2, 4), (1, 4, 3), (4, 4, 4)])
def test_openings_may_reach_out_but_not_under_the_floor(sizes):
    for volume, image, case in cases(max(sizes)):
        n = max(sizes)
        around = np.pad(image, ((n, n), (n, n), (0, n)), constant_values=True)
        around = np.pad(np.pad(around, ((0, 0), (0, 0), (n, 0))), n)
        inner = slice(2 * n, -2 * n)
        opened = ndimage.binary_opening(around, np.ones(sizes))[inner, inner, inner]
        assert volume.opened(set_of(volume, image), sizes) == set_of(volume, opened), case
