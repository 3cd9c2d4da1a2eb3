"""Surface from a scan, raster over it, coverage."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from python.control.arm_samples import PART_LOWER, PART_TOP_M, PART_UPPER, TOOL_RADIUS_M, scan
from yarm.control.arm.errors import ArmError
from yarm.control.sander.raster import coverage, lay_raster
from yarm.control.sander.surface import Surface, fit_surface

LEVEL = Surface(np.array([PART_TOP_M, 0, 0, 0, 0, 0]), PART_LOWER, PART_UPPER)


@pytest.mark.parametrize("debris", [False, True])
def test_the_part_is_found_whatever_lies_on_it(debris):
    surface = fit_surface(scan(debris=debris), 0.05)
    assert surface.lower == pytest.approx(PART_LOWER, abs=0.015)
    assert surface.upper == pytest.approx(PART_UPPER, abs=0.015)
    grid = np.stack(np.meshgrid(np.linspace(-0.45, -0.05, 9), np.linspace(-0.3, 0.3, 9)), axis=-1).reshape(-1, 2)
    assert surface.points(grid)[:, 2] == pytest.approx(PART_TOP_M, abs=0.002)
    assert np.degrees(np.arccos(surface.normals(grid)[:, 2])).max() < 1.0


def test_a_bent_part_is_followed():
    surface = fit_surface(scan(curvature=0.2, debris=False), 0.05)
    xy = np.array([[-0.25, 0.0], [-0.25, 0.25]])
    assert surface.points(xy)[:, 2] == pytest.approx([PART_TOP_M, PART_TOP_M + 0.1 * 0.25**2], abs=0.003)
    slope = -surface.normals(xy)[1, 1] / surface.normals(xy)[1, 2]
    assert slope == pytest.approx(0.2 * 0.25, abs=0.02)


def test_an_empty_scan_is_refused():
    with pytest.raises(ArmError, match="holds no points"):
        fit_surface(np.full((10, 3), np.nan), 0.05)


def test_too_small_a_surface_is_refused_with_its_area():
    points = scan(debris=False)
    with pytest.raises(ArmError, match=r"no level surface of 2 m\^2"):
        fit_surface(points, 2.0)


def test_passes_are_spaced_as_set_and_connected():
    raster = lay_raster(LEVEL, 0.04, 0.02)
    xs = np.unique(np.round([s.points[0, 0] for s in raster.strokes[::2]], 6))
    assert np.diff(xs).max() <= 0.04 + 1e-9
    for a, b in zip(raster.strokes[:-1], raster.strokes[1:]):
        assert a.points[-1] == pytest.approx(b.points[0])
        assert a.arc_m[-1] == b.arc_m[0]
    assert raster.length_m == pytest.approx(10 * 0.56 + 0.36)


@settings(max_examples=30, deadline=None)
@given(st.floats(0.02, 0.08), st.floats(0.0, 0.04), st.floats(0.1, 0.6), st.floats(0.1, 0.6))
def test_every_raster_covers_its_surface(spacing, inset, width, height):
    surface = Surface(np.array([0.7, 0, 0, 0, 0, 0]), (0.0, 0.0), (width, height))
    raster = lay_raster(surface, spacing, inset)
    share = coverage(raster.polyline, surface.lower, surface.upper, 0.7, TOOL_RADIUS_M)
    assert share >= 0.95
    steps = np.linalg.norm(np.diff(raster.polyline, axis=0), axis=1)
    assert steps.max() <= 0.0101


def test_a_raster_with_a_gap_does_not_cover():
    raster = lay_raster(LEVEL, 0.04, 0.02)
    half = raster.polyline[: len(raster.polyline) // 2]
    share = coverage(half, PART_LOWER, PART_UPPER, PART_TOP_M, TOOL_RADIUS_M)
    assert 0.4 < share < 0.75


def test_hovering_covers_nothing():
    raster = lay_raster(LEVEL, 0.04, 0.02, standoff_m=0.02)
    assert coverage(raster.polyline, PART_LOWER, PART_UPPER, PART_TOP_M, TOOL_RADIUS_M) == 0.0
