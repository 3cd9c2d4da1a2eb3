"""Distances to solids against many points on their surfaces."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from yarm.calibration.surfaces import nearest_surface
from yarm.geometry import quaternion_from_rpy, transform_matrix
from yarm.geometry.solids import Shape, Solid, surface_points

POSE = transform_matrix((0.3, -0.2, 0.6), quaternion_from_rpy(0.2, -0.4, 1.1))
SOLIDS = {
    "box": Solid(Shape.BOX, (0.6, 0.4, 0.3), POSE),
    "cylinder": Solid(Shape.CYLINDER, (0.2, 0.5), POSE),
    "sphere": Solid(Shape.SPHERE, (0.25,), POSE),
}
SPACING_M = 0.01


@pytest.mark.parametrize("name", sorted(SOLIDS))
def test_distance_and_normal_of_a_solid(name):
    solid = SOLIDS[name]
    rng = np.random.default_rng(1)
    points = POSE[:3, 3] + rng.uniform(-0.5, 0.5, size=(400, 3))
    near = nearest_surface(points, [solid], floor=False)
    nearest, _ = cKDTree(surface_points([solid], SPACING_M)).query(points)
    assert np.abs(near.distance) == pytest.approx(nearest, abs=SPACING_M)
    assert (near.distance < 0).any()
    assert (near.distance > 0).any()
    assert np.linalg.norm(near.normal, axis=1) == pytest.approx(1.0)
    onto = points - near.distance[:, None] * near.normal
    again = nearest_surface(onto, [solid], floor=False)
    assert np.abs(again.distance).max() < 1e-9


def test_the_nearer_of_floor_and_solids_counts():
    box = Solid(Shape.BOX, (1.0, 1.0, 0.7), transform_matrix((0.0, 0.0, 0.35), (0.0, 0.0, 0.0, 1.0)))
    points = np.array([[0.0, 0.0, 0.75], [2.0, 0.0, 0.1], [0.6, 0.0, 0.4], [0.6, 0.0, 0.02]])
    near = nearest_surface(points, [box])
    assert near.distance == pytest.approx([0.05, 0.1, 0.1, 0.02])
    assert near.normal == pytest.approx(np.array([[0, 0, 1], [0, 0, 1], [1, 0, 0], [0, 0, 1]], dtype=float))
    assert (nearest_surface(points, [], floor=False).distance > 100.0).all()
