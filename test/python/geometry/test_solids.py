"""Solids: their bounds, other frames, and points that cover their surfaces."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from yarm.geometry import FloatArray, quaternion_from_rpy, transform_matrix, transform_points
from yarm.geometry.solids import Shape, Solid, surface_points

POSE = transform_matrix((0.3, -0.2, 1.1), quaternion_from_rpy(0.4, -0.7, 2.0))
lengths = st.floats(0.01, 0.6)


def solid(shape: str, a: float, b: float, c: float) -> Solid:
    """A solid of any shape, turned and moved."""
    return Solid(shape, {"box": (a, b, c), "cylinder": (a, b), "sphere": (a,)}[shape], POSE)


def on_surface(body: Solid, n: int, rng: np.random.Generator) -> FloatArray:
    """Points (n, 3) anywhere on a solid's surface, its own frame: by rays from its centre and their ends."""
    rays = rng.normal(size=(n, 3))
    if body.shape == "sphere":
        return rays * (body.size[0] / np.linalg.norm(rays, axis=1, keepdims=True))
    half = body.half_extent
    if body.shape == "box":
        return rays / np.abs(rays / half).max(axis=1, keepdims=True)
    reach = np.maximum(np.hypot(rays[:, 0], rays[:, 1]) / half[0], np.abs(rays[:, 2]) / half[2])
    return rays / reach[:, None]


def off_surface(body: Solid, points: FloatArray) -> FloatArray:
    """How far points (n, 3), the solid's own frame, lie from its surface along the worst of its axes, metres (n,)."""
    half = body.half_extent
    if body.shape == "sphere":
        return np.abs(np.linalg.norm(points, axis=1) - half[0])
    if body.shape == "cylinder":
        points, half = np.column_stack([np.hypot(points[:, 0], points[:, 1]), points[:, 2]]), half[[0, 2]]
    return np.abs((np.abs(points) - half).max(axis=1))


@given(st.sampled_from(Shape), lengths, lengths, lengths, st.floats(0.02, 0.2), st.integers(0, 2**32 - 1))
def test_the_points_lie_on_the_surface_and_none_of_it_is_farther_than_the_spacing(
    shape: str, a: float, b: float, c: float, spacing_m: float, seed: int
) -> None:
    body = solid(shape, a, b, c)
    points = surface_points([body], spacing_m)
    own = transform_points(np.linalg.inv(body.pose), points)
    assert off_surface(body, own).max() < 1e-9
    for probe in on_surface(body, 30, np.random.default_rng(seed)):
        assert np.linalg.norm(own - probe, axis=1).min() <= spacing_m + 1e-9


def test_points_of_several_solids_come_one_after_the_other() -> None:
    box, ball = solid("box", 0.1, 0.2, 0.3), solid("sphere", 0.1, 0.0, 0.0)
    both = surface_points([box, ball], 0.1)
    assert np.array_equal(both, np.concatenate([surface_points([box], 0.1), surface_points([ball], 0.1)]))
    assert surface_points([], 0.1).shape == (0, 3)


@pytest.mark.parametrize(
    ("shape", "size", "half"),
    [
        ("box", (0.2, 0.4, 0.6), (0.1, 0.2, 0.3)),
        ("cylinder", (0.35, 0.45), (0.35, 0.35, 0.225)),
        ("sphere", (0.3,), (0.3, 0.3, 0.3)),
    ],
)
def test_half_extents_hold_the_solid(shape: str, size: tuple, half: tuple) -> None:
    assert Solid(shape, size, np.eye(4)).half_extent == pytest.approx(half)


def test_a_solid_seen_from_another_frame_keeps_its_shape() -> None:
    body = Solid(Shape.CYLINDER, (0.35, 0.45), POSE)
    there = body.seen_from(np.linalg.inv(POSE))
    assert (there.shape, there.size) == (body.shape, body.size)
    assert there.pose == pytest.approx(np.eye(4))


@pytest.mark.parametrize("use", [lambda body: body.half_extent, lambda body: surface_points([body], 0.1)])
def test_an_unknown_shape_is_refused_by_name(use) -> None:
    with pytest.raises(ValueError, match="solid 'cone' must be one of box, cylinder, sphere"):
        use(Solid("cone", (1.0,), POSE))
