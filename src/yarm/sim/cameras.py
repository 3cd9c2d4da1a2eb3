"""Depth cameras by ray casting (Embree).

Every rigid body is its own ray-casting scene in its own frame, built once; a moved body costs nothing but turning the
rays into its frame. Rays are cast only at pixels its projected bounds cover. The floor is a formula, and what never
moves is cast once for each camera.

Optical frames: x right, y down, z forward. Depth is the coordinate along z. Rays have z component 1, so a ray's
parameter at a hit is the depth in any frame.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, Iterable, List, Mapping, Optional, Tuple

import numpy as np
import numpy.typing as npt
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

from yarm.geometry import FloatArray
from yarm.sim.bodies import Body, FramedSolid
from yarm.sim.meshes import solid_triangles
from yarm.sim.noise import FloatImage, NormalPool, axial_sigma

FAR = np.float32(1e30)
NEAR_PLANE_M = 0.05
FLOOR_RGB = 0x8A8A86


@dataclass(frozen=True)
class CameraModel:
    """A pinhole depth camera with square pixels.

    Attributes:
        width: pixels along x.
        height: pixels along y.
        fov_rad: horizontal field of view, rad.
        near_m: least depth it measures, metres.
        far_m: greatest depth it measures, metres.
    """

    width: int
    height: int
    fov_rad: float
    near_m: float
    far_m: float

    @property
    def focal_px(self) -> float:
        """Focal length, pixels."""
        return 0.5 * self.width / math.tan(0.5 * self.fov_rad)

    def directions(self) -> FloatImage:
        """(height, width, 3) ray directions through the pixel centres, optical frame, z component 1."""
        u = (np.arange(self.width) + 0.5 - 0.5 * self.width) / self.focal_px
        v = (np.arange(self.height) + 0.5 - 0.5 * self.height) / self.focal_px
        grid_u, grid_v = np.meshgrid(u, v)
        return np.stack([grid_u, grid_v, np.ones_like(grid_u)], axis=-1).astype(np.float32)


KINECT = CameraModel(320, 320, math.radians(135.0), 0.5, 10.0)
WRIST = CameraModel(320, 240, math.radians(69.0), 0.2, 2.0)
OVERHEAD_POSITIONS_M = ((3.0, 0.0, 2.0), (0.0, 3.0, 2.0), (0.0, -3.0, 2.0), (-3.0, 0.0, 2.0))
OVERHEAD_AIM_M = (0.0, 0.0, 0.3)


def looking_at(position: npt.ArrayLike, target: npt.ArrayLike) -> FloatArray:
    """T_world_optical (4, 4) of a camera at a position that looks at a target, its image upright; metres."""
    eye = np.asarray(position, dtype=float)
    forward = np.asarray(target, dtype=float) - eye
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, 0], pose[:3, 1], pose[:3, 2], pose[:3, 3] = right, np.cross(forward, right), forward, eye
    return pose


def overhead_poses() -> Tuple[FloatArray, ...]:
    """T_world_optical (4, 4) of overhead cameras 1 to 4."""
    return tuple(looking_at(position, OVERHEAD_AIM_M) for position in OVERHEAD_POSITIONS_M)


class RayBody:
    """One or more solids rigidly fixed to a tf frame, ready to be seen.

    Attributes:
        frame: that frame.
        corners: (8, 3) corners of its bounds, metres, in that frame.
    """

    def __init__(self, solids: Iterable[FramedSolid]) -> None:
        """Build from solids of one frame."""
        items = list(solids)
        self.frame = items[0].frame
        parts = [solid_triangles(item.solid, item.T_frame_solid) for item in items]
        triangles = np.concatenate(parts).astype(np.float32)
        colours = [np.full(len(part), packed_rgb(item.solid.colour), np.uint32) for part, item in zip(parts, items)]
        self._rgb = np.concatenate(colours)
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        self._normals = (normals / np.maximum(length, 1e-12)).astype(np.float32)
        points = triangles.reshape(-1, 3)
        low, high = points.min(axis=0), points.max(axis=0)
        self.corners = np.array([[(low, high)[i >> k & 1][k] for k in range(3)] for i in range(8)], dtype=float)
        self._scene = rtcore_scene.EmbreeScene()
        self._mesh = TriangleMesh(self._scene, triangles)

    def cast(self, origin: FloatArray, directions: FloatImage) -> Tuple[npt.NDArray[np.int64], FloatImage]:
        """First hits of rays from one origin (3,) along directions (n, 3), all in the body's frame.

        Returns:
            triangle of each hit (n,), -1 for none, and ray parameter (n,).
        """
        origins = np.empty_like(directions)
        origins[:] = origin
        hits = self._scene.run(origins, directions, output=1)
        return hits["primID"], hits["tfar"]

    def surface(self, triangles: npt.NDArray[np.int64]) -> Tuple[FloatImage, npt.NDArray[np.uint32]]:
        """Normals (n, 3), body frame, and packed colours (n,) of hit triangles."""
        return self._normals[triangles], self._rgb[triangles]


def packed_rgb(colour: Tuple[float, float, float]) -> int:
    """0x00RRGGBB of red, green, blue from 0 to 1."""
    red, green, blue = (round(255.0 * min(max(part, 0.0), 1.0)) for part in colour)
    return red << 16 | green << 8 | blue


def ray_bodies(body: Body) -> List[RayBody]:
    """What is seen of a body: one RayBody a solid group; a long thin arm apart from a round body keeps culling tight."""
    groups: Dict[Tuple[str, bool], List[FramedSolid]] = {}
    for solid in body.solids:
        high = body.kind == "Mobile" and solid.solid.link in ("arm", "ee")
        groups.setdefault((solid.frame, high), []).append(solid)
    return [RayBody(group) for group in groups.values()]


@dataclass(eq=False)
class DepthImage:
    """What a camera sees, without noise; FAR where nothing is.

    Attributes:
        depth: (height, width) depth along the optical axis, metres.
        sigma: standard deviation of its noise, metres.
        rgb: packed colour 0x00RRGGBB.
    """

    depth: FloatImage
    sigma: FloatImage
    rgb: npt.NDArray[np.uint32]

    def copy_from(self, other: DepthImage) -> None:
        """Take over another image of the same size."""
        np.copyto(self.depth, other.depth)
        np.copyto(self.sigma, other.sigma)
        np.copyto(self.rgb, other.rgb)

    def copy(self) -> DepthImage:
        """An image of its own."""
        return DepthImage(self.depth.copy(), self.sigma.copy(), self.rgb.copy())


class DepthCamera:
    """One camera with its buffers; not thread-safe. Images and clouds it returns are its own and are overwritten."""

    def __init__(self, model: CameraModel) -> None:
        """Prepare the rays."""
        self.model = model
        self._directions = model.directions()
        self._lengths: FloatImage = np.linalg.norm(self._directions, axis=-1).astype(np.float32)
        self._image = self._blank()
        self._static: Optional[DepthImage] = None
        self._cloud = np.zeros((model.height, model.width), dtype=CLOUD_DTYPE)
        self._scratch: FloatImage = np.empty((model.height, model.width), dtype=np.float32)

    def prepare_static(self, T_world_optical: FloatArray, bodies: Iterable[Tuple[RayBody, FloatArray]]) -> None:
        """Cast once what never moves, for a camera that never moves either: the floor and (body, T_world_body)."""
        self._static = self._fresh(T_world_optical)
        self._add_all(self._static, T_world_optical, bodies)

    def render(self, T_world_optical: FloatArray, bodies: Iterable[Tuple[RayBody, FloatArray]]) -> DepthImage:
        """See bodies (body, T_world_body) on top of the static image, or of the bare floor without one."""
        if self._static is not None:
            self._image.copy_from(self._static)
        else:
            self._image = self._fresh(T_world_optical)
        self._add_all(self._image, T_world_optical, bodies)
        return self._image

    def cloud(self, image: DepthImage, normals: Optional[FloatImage]) -> npt.NDArray[np.void]:
        """Organised points (height, width) of x, y, z, rgb, optical frame, metres.

        Args:
            image: what is seen.
            normals: standard normal number of each pixel (height * width,), or None for no noise.
        """
        depth, z = image.depth, self._scratch
        if normals is None:
            np.copyto(z, depth)
        else:
            np.multiply(normals.reshape(depth.shape), image.sigma, out=z)
            z += depth
        outside = (z < self.model.near_m) | (z > self.model.far_m)
        z[outside] = np.nan
        np.multiply(self._directions[..., 0], z, out=self._cloud["x"])
        np.multiply(self._directions[..., 1], z, out=self._cloud["y"])
        self._cloud["z"] = z
        self._cloud["rgb"] = image.rgb
        return self._cloud

    def _blank(self) -> DepthImage:
        shape = (self.model.height, self.model.width)
        return DepthImage(
            np.full(shape, FAR, np.float32), np.zeros(shape, np.float32), np.zeros(shape, dtype=np.uint32)
        )

    def _fresh(self, T_world_optical: FloatArray) -> DepthImage:
        """The floor, z = 0, as far as the camera measures (and three noise widths on)."""
        image = self._blank()
        down = self._directions @ T_world_optical[2, :3].astype(np.float32)
        with np.errstate(divide="ignore"):
            depth = np.where(down < 0.0, -np.float32(T_world_optical[2, 3]) / down, FAR)
        seen = (depth > 0.0) & (depth < self.model.far_m + 1.0)
        image.depth[seen] = depth[seen]
        image.sigma[seen] = axial_sigma(depth[seen], (down / self._lengths)[seen])
        image.rgb[seen] = FLOOR_RGB
        return image

    def _add_all(
        self, image: DepthImage, T_world_optical: FloatArray, bodies: Iterable[Tuple[RayBody, FloatArray]]
    ) -> None:
        T_optical_world = np.linalg.inv(T_world_optical)
        for body, T_world_body in bodies:
            self._add(image, T_optical_world @ T_world_body, body)

    def _add(self, image: DepthImage, T_optical_body: FloatArray, body: RayBody) -> None:
        window = self._window(T_optical_body, body)
        if window is None:
            return
        rotation = T_optical_body[:3, :3]
        origin = -rotation.T @ T_optical_body[:3, 3]
        rays = self._directions[window]
        shape = rays.shape[:2]
        local = (rays.reshape(-1, 3) @ rotation.astype(np.float32)).astype(np.float32, copy=False)
        triangles, depth = body.cast(origin.astype(np.float32), local)
        view = image.depth[window]
        nearer = (triangles >= 0).reshape(shape) & (depth.reshape(shape) < view)
        chosen = nearer.reshape(-1)
        if not chosen.any():
            return
        normals, rgb = body.surface(triangles[chosen])
        cosines = np.einsum("ij,ij->i", normals, local[chosen]) / self._lengths[window].reshape(-1)[chosen]
        view[nearer] = depth[chosen]
        image.sigma[window][nearer] = axial_sigma(depth[chosen], cosines)
        image.rgb[window][nearer] = rgb

    def _window(self, T_optical_body: FloatArray, body: RayBody) -> Optional[Tuple[slice, slice]]:
        """Rows and columns of the pixels the body's bounds may cover; None when out of sight."""
        corners = body.corners @ T_optical_body[:3, :3].T + T_optical_body[:3, 3]
        z = corners[:, 2]
        if z.max() < self.model.near_m - 0.3:
            return None
        if z.min() < NEAR_PLANE_M:
            return slice(0, self.model.height), slice(0, self.model.width)
        focal = self.model.focal_px
        u = corners[:, 0] / z * focal + 0.5 * self.model.width
        v = corners[:, 1] / z * focal + 0.5 * self.model.height
        left, right = max(int(u.min()) - 1, 0), min(int(u.max()) + 2, self.model.width)
        top, bottom = max(int(v.min()) - 1, 0), min(int(v.max()) + 2, self.model.height)
        if left >= right or top >= bottom:
            return None
        return slice(top, bottom), slice(left, right)


CLOUD_DTYPE = np.dtype([("x", np.float32), ("y", np.float32), ("z", np.float32), ("rgb", np.uint32)])


class Eyes:
    """The cell's cameras: overhead 1 to 4, and one on an arm's wrist."""

    def __init__(self, seed: int, noise: bool) -> None:
        """Nothing is seen before ``look_at``."""
        self._pool = NormalPool(seed) if noise else None
        self._overhead = [DepthCamera(KINECT) for _ in OVERHEAD_POSITIONS_M]
        self.overhead_poses = overhead_poses()
        self._wrist = DepthCamera(WRIST)
        self._static: List[Tuple[RayBody, FloatArray]] = []
        self._moving: List[RayBody] = []

    def look_at(self, bodies: Mapping[str, Body], poses: Mapping[str, FloatArray]) -> None:
        """Learn which bodies exist; call again whenever one comes or goes."""
        self._static, self._moving = [], []
        for body in bodies.values():
            for rays in ray_bodies(body):
                if rays.frame in body.static_frames:
                    self._static.append((rays, poses[rays.frame]))
                else:
                    self._moving.append(rays)
        for camera, pose in zip(self._overhead, self.overhead_poses):
            camera.prepare_static(pose, self._static)

    def overhead_image(self, camera: int, poses: Mapping[str, FloatArray]) -> DepthImage:
        """What overhead camera 1, 2, ... sees, without noise."""
        moving = [(body, poses[body.frame]) for body in self._moving]
        return self._overhead[camera - 1].render(self.overhead_poses[camera - 1], moving)

    def overhead_cloud(self, camera: int, poses: Mapping[str, FloatArray], frame: int) -> npt.NDArray[np.void]:
        """Cloud of overhead camera 1, 2, ... in its optical frame; ``frame`` numbers the images."""
        image = self.overhead_image(camera, poses)
        return self._overhead[camera - 1].cloud(image, self._normals(KINECT, camera, frame))

    def wrist_cloud(
        self, T_world_optical: FloatArray, poses: Mapping[str, FloatArray], frame: int
    ) -> npt.NDArray[np.void]:
        """Cloud of the wrist camera in its optical frame."""
        bodies = self._static + [(body, poses[body.frame]) for body in self._moving]
        image = self._wrist.render(T_world_optical, bodies)
        return self._wrist.cloud(image, self._normals(WRIST, 0, frame))

    def _normals(self, model: CameraModel, camera: int, frame: int) -> Optional[FloatImage]:
        return None if self._pool is None else self._pool.take(model.width * model.height, camera, frame)
