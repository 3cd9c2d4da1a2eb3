"""Triangles of the primitives: closed, of the right size and place; and rays that meet them where they should."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest

from yarm.geometry import FloatArray, quaternion_from_rpy, transform_matrix, transform_points
from yarm.geometry.solids import Shape, Solid
from yarm.sim.sensors.meshes import CYLINDER_SIDES, SPHERE_RINGS, solid_triangles
from yarm.sim.sensors.rays_embree import EmbreeSolid

SOLIDS = [
    (Solid(Shape.BOX, (0.4, 0.6, 0.8), np.eye(4)), 0.4 * 0.6 * 0.8, 1e-9),
    (Solid(Shape.CYLINDER, (0.3, 0.5), np.eye(4)), math.pi * 0.09 * 0.5, 2.0 / CYLINDER_SIDES**2 * math.pi**2),
    (Solid(Shape.SPHERE, (0.3,), np.eye(4)), 4.0 / 3.0 * math.pi * 0.027, 2.0 * (math.pi / (2 * SPHERE_RINGS)) ** 2),
]
IDS = [solid.shape for solid, _, _ in SOLIDS]
POSE = transform_matrix((1.0, -2.0, 0.5), quaternion_from_rpy(0.3, -0.5, 1.1))


def volume(triangles: FloatArray) -> float:
    """Volume inside closed triangles (n, 3, 3), of either sign."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


@pytest.mark.parametrize(("solid", "true", "share"), SOLIDS, ids=IDS)
def test_the_volume_is_the_solids(solid: Solid, true: float, share: float) -> None:
    found = abs(volume(solid_triangles(solid, np.eye(4))))
    assert found <= true * (1.0 + 1e-9)
    assert found == pytest.approx(true, rel=share + 1e-9)


@pytest.mark.parametrize(("solid", "true", "share"), SOLIDS, ids=IDS)
def test_a_moved_solid_has_the_same_triangles_elsewhere(solid: Solid, true: float, share: float) -> None:
    here, there = solid_triangles(solid, np.eye(4)), solid_triangles(solid, POSE)
    assert there == pytest.approx(transform_points(POSE, here))


@pytest.mark.parametrize(("solid", "true", "share"), SOLIDS, ids=IDS)
def test_the_surface_is_closed(solid: Solid, true: float, share: float) -> None:
    triangles = solid_triangles(solid, np.eye(4)).round(9)
    edges: Counter = Counter()
    for corners in triangles:
        points = [tuple(point) for point in (corners + 0.0).tolist()]
        if len(set(points)) == 3:  # at a sphere's poles every second triangle is a line
            edges.update(frozenset(pair) for pair in zip(points, points[1:] + points[:1]))
    assert set(edges.values()) == {2}


@pytest.mark.parametrize(("solid", "true", "share"), SOLIDS, ids=IDS)
def test_corners_lie_on_the_surface_and_fill_the_bounding_box(solid: Solid, true: float, share: float) -> None:
    corners = solid_triangles(solid, np.eye(4)).reshape(-1, 3)
    assert np.abs(corners).max(axis=0) == pytest.approx(solid.half_extent)


@pytest.mark.parametrize(("solid", "true", "share"), SOLIDS, ids=IDS)
def test_rays_from_outside_meet_the_surface(solid: Solid, true: float, share: float) -> None:
    """Rays along the axes meet it where its bounds are; rays past it meet nothing."""
    body = EmbreeSolid(solid)
    for axis in range(3):
        start = np.zeros(3)
        start[axis] = 2.0
        start[(axis + 1) % 3] = start[(axis + 2) % 3] = 1e-3  # beside the edges between triangles
        ahead, past = -np.eye(3)[axis], -np.eye(3)[axis] + 2.0 * np.eye(3)[(axis + 1) % 3]
        triangles, distances = body.cast(start.astype(np.float32), np.array([ahead, past], dtype=np.float32))
        assert triangles[0] >= 0 and triangles[1] == -1
        assert distances[0] == pytest.approx(2.0 - solid.half_extent[axis], abs=0.01 * solid.half_extent[axis])
        assert abs(body.normals[triangles[0]] @ ahead) > 0.95
