"""Ray casting with Embree on triangles: where the C++ library is not built, and as its independent check.

Every solid is its own Embree scene in its own frame, built once; a moved solid costs nothing but turning the rays into
its frame. Rays are cast only at pixels its projected bounds cover.
"""

from __future__ import annotations

import itertools
from typing import Dict, Optional, Tuple

import numpy as np
import numpy.typing as npt
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

from yarm.geometry import FloatArray
from yarm.geometry.solids import Solid
from yarm.sim.sensors.camera_model import FAR, FLOOR_RGB, CameraModel, Cloud, DepthImage, SolidSet
from yarm.sim.sensors.meshes import solid_triangles
from yarm.sim.sensors.noise import FloatImage, axial_sigma

NEAR_PLANE_M = 0.05
Window = Tuple[slice, slice]


class EmbreeSolid:
    """One solid as triangles about its centre, ready to be hit."""

    def __init__(self, solid: Solid, triangles: Optional[FloatArray] = None) -> None:
        """Build from a primitive, or from triangles (n, 3, 3) given instead."""
        corners = solid_triangles(solid, np.eye(4)) if triangles is None else triangles
        mesh = np.ascontiguousarray(corners, dtype=np.float32)
        normals = np.cross(mesh[:, 1] - mesh[:, 0], mesh[:, 2] - mesh[:, 0])
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        self.normals = (normals / np.maximum(length, 1e-12)).astype(np.float32)
        self._scene = rtcore_scene.EmbreeScene()
        self._mesh = TriangleMesh(self._scene, mesh)

    def cast(self, origin: FloatArray, directions: FloatImage) -> Tuple[npt.NDArray[np.int32], FloatImage]:
        """First hits of rays from one origin (3,) along directions (n, 3), solid's frame.

        Returns:
            triangle of each hit (n,), -1 for none, and ray parameter (n,).
        """
        origins = np.empty_like(directions)
        origins[:] = origin
        hits = self._scene.run(origins, directions, output=1)
        return hits["primID"], hits["tfar"]


class EmbreeRays:
    """Rays cast by Embree."""

    def __init__(self) -> None:
        """Nothing is built before it is first seen."""
        self._built: Dict[Solid, EmbreeSolid] = {}
        self._directions: Dict[CameraModel, FloatImage] = {}

    def floor(self, model: CameraModel, image: DepthImage, T_world_optical: FloatArray) -> None:
        """Fill an image with the bare floor."""
        directions = self._rays(model)
        down = directions @ T_world_optical[2, :3].astype(np.float32)
        with np.errstate(divide="ignore"):
            depth = np.where(down < 0.0, -np.float32(T_world_optical[2, 3]) / down, FAR)
        seen = (depth > 0.0) & (depth < model.far_m + 1.0)
        lengths = np.linalg.norm(directions, axis=-1)
        image.depth[:], image.sigma[:], image.rgb[:] = FAR, 0.0, 0
        image.depth[seen] = depth[seen]
        image.sigma[seen] = axial_sigma(depth[seen], (down / lengths)[seen])
        image.rgb[seen] = FLOOR_RGB

    def add(
        self,
        model: CameraModel,
        image: DepthImage,
        T_optical_world: FloatArray,
        solids: SolidSet,
        T_world_solid: FloatArray,
    ) -> None:
        """Put solids in front of what the image shows already."""
        for i, (item, pose) in enumerate(zip(solids.items, T_world_solid)):
            if item.solid not in self._built:
                self._built[item.solid] = EmbreeSolid(item.solid)
            T_optical_solid = T_optical_world @ pose
            window = _window(model, T_optical_solid, item.solid.half_extent)
            if window is not None:
                self._add_one(model, image, window, T_optical_solid, self._built[item.solid], solids.colours[i])

    def cloud(self, model: CameraModel, image: DepthImage, normals: Optional[FloatImage], out: Cloud) -> None:
        """Write organised points."""
        directions = self._rays(model)
        z = image.depth.copy() if normals is None else image.depth + image.sigma * normals.reshape(image.depth.shape)
        z[(z < model.near_m) | (z > model.far_m)] = np.nan
        out["x"] = directions[..., 0] * z
        out["y"] = directions[..., 1] * z
        out["z"] = z
        out["rgb"] = image.rgb

    def _rays(self, model: CameraModel) -> FloatImage:
        if model not in self._directions:
            self._directions[model] = model.directions()
        return self._directions[model]

    def _add_one(
        self,
        model: CameraModel,
        image: DepthImage,
        window: Window,
        T_optical_solid: FloatArray,
        solid: EmbreeSolid,
        rgb: np.uint32,
    ) -> None:
        rotation = T_optical_solid[:3, :3]
        origin = -rotation.T @ T_optical_solid[:3, 3]
        rays = self._rays(model)[window].reshape(-1, 3)
        local = rays @ rotation.astype(np.float32)
        triangles, depth = solid.cast(origin.astype(np.float32), local)
        view = image.depth[window]
        chosen = (triangles >= 0) & (depth < view.reshape(-1))
        if not chosen.any():
            return
        nearer = chosen.reshape(view.shape)
        cosines = np.einsum("ij,ij->i", solid.normals[triangles[chosen]], local[chosen])
        cosines /= np.linalg.norm(rays[chosen], axis=1)
        view[nearer] = depth[chosen]
        image.sigma[window][nearer] = axial_sigma(depth[chosen], cosines)
        image.rgb[window][nearer] = rgb


def _window(model: CameraModel, T_optical_solid: FloatArray, half_extent: FloatArray) -> Optional[Window]:
    """Rows and columns of the pixels the solid's bounds may cover; None when out of sight."""
    corners = np.array(list(itertools.product((-1.0, 1.0), repeat=3))) * half_extent
    x, y, z = (corners @ T_optical_solid[:3, :3].T + T_optical_solid[:3, 3]).T
    if z.max() < 0.0:
        return None
    if z.min() < NEAR_PLANE_M:
        return slice(0, model.height), slice(0, model.width)
    u = x / z * model.focal_px + 0.5 * model.width
    v = y / z * model.focal_px + 0.5 * model.height
    left, right = max(int(u.min()) - 1, 0), min(int(u.max()) + 2, model.width)
    top, bottom = max(int(v.min()) - 1, 0), min(int(v.max()) + 2, model.height)
    return None if left >= right or top >= bottom else (slice(top, bottom), slice(left, right))
