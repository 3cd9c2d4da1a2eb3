"""The bin's measures are those of its description, and inside is inside."""

from __future__ import annotations

import numpy as np
import pytest

from yarm.geometry.urdf import expand_xacro, parse_urdf
from yarm.resources import resource
from yarm.robots import bin as bins


def test_the_measures_are_those_of_the_description() -> None:
    model = parse_urdf(expand_xacro(resource("urdf", "cell", "cell.urdf.xacro"), part=bins.NAME))
    poses = [(model.rigid_group(solid.link)[1] @ solid.pose, solid.half_extent) for solid in model.solids]
    low = np.min([pose[:3, 3] - half for pose, half in poses], axis=0)
    high = np.max([pose[:3, 3] + half for pose, half in poses], axis=0)
    assert low == pytest.approx([-0.5 * bins.WIDTH_M, -0.5 * bins.WIDTH_M, 0.0])
    assert high == pytest.approx([0.5 * bins.WIDTH_M, 0.5 * bins.WIDTH_M, bins.RIM_M])
    assert min(float(half.min()) for _, half in poses) == pytest.approx(0.5 * bins.WALL_M)


@pytest.mark.parametrize(
    ("point", "within"),
    [
        ((0.0, 0.0, 0.3), True),
        ((0.17, -0.17, 0.05), True),
        ((0.19, 0.0, 0.3), False),
        ((0.0, -0.19, 0.3), False),
        ((0.0, 0.0, 0.61), False),
        ((0.0, 0.0, -0.01), False),
    ],
)
def test_inside(point: tuple[float, float, float], within: bool) -> None:
    assert bins.inside(np.array(point)) is within


def test_bins_are_known_by_their_names() -> None:
    assert bins.is_bin("bin_1")
    assert not bins.is_bin("table")
