"""Depth cameras: optics, poses, images, and the solids they look at."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Iterable, List, Mapping, Optional, Protocol, Tuple

import numpy as np
import numpy.typing as npt

from yarm.geometry import FloatArray, IntArray
from yarm.geometry.solids import Shape
from yarm.sim.scenes.bodies import FramedSolid
from yarm.sim.sensors.noise import FloatImage

ColourImage = npt.NDArray[np.uint32]
Cloud = npt.NDArray[np.void]

FAR = np.float32(1e30)
FLOOR_RGB = 0x8A8A86
SHAPE_CODES = {Shape.BOX: 0, Shape.CYLINDER: 1, Shape.SPHERE: 2}
CLOUD_DTYPE = np.dtype([("x", np.float32), ("y", np.float32), ("z", np.float32), ("rgb", np.uint32)])


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

    @property
    def pixels(self) -> int:
        """Number of pixels."""
        return self.width * self.height

    def directions(self) -> FloatImage:
        """(height, width, 3) ray directions through the pixel centres, optical frame, z component 1."""
        u = (np.arange(self.width) + 0.5 - 0.5 * self.width) / self.focal_px
        v = (np.arange(self.height) + 0.5 - 0.5 * self.height) / self.focal_px
        grid_u, grid_v = np.meshgrid(u, v)
        rays: FloatImage = np.stack([grid_u, grid_v, np.ones_like(grid_u)], axis=-1).astype(np.float32)
        return rays


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
    rgb: ColourImage

    @staticmethod
    def blank(model: CameraModel) -> DepthImage:
        """An image in which nothing is."""
        shape = (model.height, model.width)
        return DepthImage(np.full(shape, FAR, np.float32), np.zeros(shape, np.float32), np.zeros(shape, np.uint32))

    def copy_from(self, other: DepthImage) -> None:
        """Take over another image of the same size."""
        np.copyto(self.depth, other.depth)
        np.copyto(self.sigma, other.sigma)
        np.copyto(self.rgb, other.rgb)


class SolidSet:
    """Solids, each fixed to a tf frame, as arrays.

    Attributes:
        items: the solids.
        shapes: (n,) SHAPE_CODES.
        sizes: (n, 3), metres; see yarm.geometry.solids.Solid.
        colours: (n,) packed 0x00RRGGBB.
    """

    def __init__(self, items: Iterable[FramedSolid]) -> None:
        """Gather solids; there may be none."""
        self.items: Tuple[FramedSolid, ...] = tuple(items)
        n = len(self.items)
        self.shapes = np.array([SHAPE_CODES[item.solid.shape] for item in self.items], dtype=np.int32)
        self.sizes = np.zeros((n, 3))
        for row, item in zip(self.sizes, self.items):
            row[: len(item.solid.size)] = item.solid.size
        self.colours = np.array([packed_rgb(item.solid.colour) for item in self.items], dtype=np.uint32)
        self._frames: List[str] = sorted({item.frame for item in self.items})
        self._frame_of: IntArray = np.array([self._frames.index(item.frame) for item in self.items], dtype=np.int64)
        self._local = np.array([item.T_frame_solid for item in self.items]).reshape(n, 4, 4)

    def poses(self, transforms: Mapping[str, FloatArray]) -> FloatArray:
        """T_world_solid (n, 4, 4) from T_world_frame of every frame."""
        if not self.items:
            return np.zeros((0, 4, 4))
        frames = np.array([transforms[frame] for frame in self._frames])
        result: FloatArray = np.matmul(frames[self._frame_of], self._local)
        return result


def packed_rgb(colour: Tuple[float, float, float]) -> int:
    """0x00RRGGBB of red, green, blue from 0 to 1."""
    red, green, blue = (round(255.0 * min(max(part, 0.0), 1.0)) for part in colour)
    return red << 16 | green << 8 | blue


class Rays(Protocol):
    """A way to cast rays; one instance belongs to one camera's images at a time."""

    def floor(self, model: CameraModel, image: DepthImage, T_world_optical: FloatArray) -> None:
        """Fill an image with the bare floor, z = 0, 1 m further than the camera measures, for the noise's sake."""

    def add(
        self,
        model: CameraModel,
        image: DepthImage,
        T_optical_world: FloatArray,
        solids: SolidSet,
        T_world_solid: FloatArray,
    ) -> None:
        """Put solids in front of what the image shows already."""

    def cloud(self, model: CameraModel, image: DepthImage, normals: Optional[FloatImage], out: Cloud) -> None:
        """Write organised points (height, width) of CLOUD_DTYPE; NaN where the noisy depth is out of range."""
