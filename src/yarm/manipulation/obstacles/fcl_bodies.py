"""Primitive solids as FCL's objects, and trees of them."""

from __future__ import annotations

from typing import Any, Sequence

import fcl

from yarm.geometry import FloatArray
from yarm.geometry.solids import Shape, Solid


def fcl_geometry(solid: Solid, more_m: float = 0.0) -> Any:
    """FCL's shape of a solid, thicker by ``more_m``, metres, on every side."""
    if solid.shape == Shape.BOX:
        return fcl.Box(*(size + 2.0 * more_m for size in solid.size))
    if solid.shape == Shape.CYLINDER:
        return fcl.Cylinder(solid.size[0] + more_m, solid.size[1] + 2.0 * more_m)
    return fcl.Sphere(solid.size[0] + more_m)


def fcl_object(geometry: Any, pose: FloatArray) -> Any:
    """A shape where it stands, pose (4, 4)."""
    return fcl.CollisionObject(geometry, fcl.Transform(pose[:3, :3], pose[:3, 3]))


def fcl_manager(items: Sequence[Any]) -> Any:
    """A tree of bounding boxes over objects."""
    manager = fcl.DynamicAABBTreeCollisionManager()
    manager.registerObjects(list(items))
    manager.setup()
    return manager
