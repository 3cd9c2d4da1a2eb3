"""The cell's depth cameras: rays only where bodies can be, the floor by formula, what never moves cast once."""

from __future__ import annotations

from typing import List, Mapping, Optional

import numpy as np

from yarm.geometry import FloatArray
from yarm.sim.scenes.bodies import Body, FramedSolid
from yarm.sim.sensors.camera_model import (
    CLOUD_DTYPE,
    KINECT,
    OVERHEAD_POSITIONS_M,
    WRIST,
    CameraModel,
    Cloud,
    DepthImage,
    Rays,
    SolidSet,
    overhead_poses,
)
from yarm.sim.sensors.noise import FloatImage, NormalPool
from yarm.sim.sensors.rays_embree import EmbreeRays
from yarm.sim.sensors.rays_native import NativeRays, library_path


def best_rays() -> Rays:
    """The C++ library where it is built, else Embree."""
    path = library_path()
    return EmbreeRays() if path is None else NativeRays(path)


class DepthCamera:
    """One camera with its buffers; not thread-safe. Images and clouds it returns are its own and are overwritten."""

    def __init__(self, model: CameraModel, rays: Rays) -> None:
        """Allocate the buffers."""
        self.model = model
        self._rays = rays
        self._image = DepthImage.blank(model)
        self._static: Optional[DepthImage] = None
        self._cloud = np.zeros((model.height, model.width), dtype=CLOUD_DTYPE)

    def prepare_static(self, T_world_optical: FloatArray, solids: SolidSet, T_world_solid: FloatArray) -> None:
        """For a camera that never moves: see the floor and what never moves once and for all."""
        self._static = DepthImage.blank(self.model)
        self._rays.floor(self.model, self._static, T_world_optical)
        self._rays.add(self.model, self._static, np.linalg.inv(T_world_optical), solids, T_world_solid)

    def render(self, T_world_optical: FloatArray, solids: SolidSet, T_world_solid: FloatArray) -> DepthImage:
        """See solids on top of the static image, or of the bare floor when there is none."""
        if self._static is None:
            self._rays.floor(self.model, self._image, T_world_optical)
        else:
            self._image.copy_from(self._static)
        self._rays.add(self.model, self._image, np.linalg.inv(T_world_optical), solids, T_world_solid)
        return self._image

    def cloud(self, image: DepthImage, normals: Optional[FloatImage]) -> Cloud:
        """Organised points (height, width) of CLOUD_DTYPE, optical frame, metres.

        Args:
            image: what is seen.
            normals: a standard normal number a pixel (height * width,), or None for no noise.
        """
        self._rays.cloud(self.model, image, normals, self._cloud)
        return self._cloud


class Eyes:
    """The cell's cameras: overhead 1 to 4, and one on each arm's wrist."""

    def __init__(self, seed: int, noise: bool, rays: Optional[Rays] = None) -> None:
        """Nothing is seen before ``look_at``."""
        rays = rays or best_rays()
        self._pool = NormalPool(seed) if noise else None
        self._overhead = [DepthCamera(KINECT, rays) for _ in OVERHEAD_POSITIONS_M]
        self.overhead_poses = overhead_poses()
        self._wrist = DepthCamera(WRIST, rays)
        self._moving = SolidSet(())
        self._all = SolidSet(())

    def look_at(self, bodies: Mapping[str, Body], transforms: Mapping[str, FloatArray]) -> None:
        """Learn which bodies exist; call again whenever one comes or goes."""
        static: List[FramedSolid] = []
        moving: List[FramedSolid] = []
        for body in bodies.values():
            for item in body.solids:
                (static if item.frame in body.static_frames else moving).append(item)
        self._moving, self._all = SolidSet(moving), SolidSet(static + moving)
        fixed = SolidSet(static)
        for camera, pose in zip(self._overhead, self.overhead_poses):
            camera.prepare_static(pose, fixed, fixed.poses(transforms))

    def overhead_image(self, camera: int, transforms: Mapping[str, FloatArray]) -> DepthImage:
        """What overhead camera 1, 2, ... sees, without noise."""
        pose = self.overhead_poses[camera - 1]
        return self._overhead[camera - 1].render(pose, self._moving, self._moving.poses(transforms))

    def overhead_cloud(self, camera: int, transforms: Mapping[str, FloatArray], frame: int) -> Cloud:
        """Cloud of overhead camera 1, 2, ... in its optical frame; ``frame`` numbers the images."""
        image = self.overhead_image(camera, transforms)
        return self._overhead[camera - 1].cloud(image, self._normals(KINECT, camera, frame))

    def wrist_cloud(
        self, T_world_optical: FloatArray, transforms: Mapping[str, FloatArray], frame: int, arm: int = 0
    ) -> Cloud:
        """Cloud of a wrist camera in its optical frame; ``arm`` numbers the arms from 0: each has noise of its own."""
        image = self._wrist.render(T_world_optical, self._all, self._all.poses(transforms))
        number = 0 if arm == 0 else len(self._overhead) + arm
        return self._wrist.cloud(image, self._normals(WRIST, number, frame))

    def _normals(self, model: CameraModel, camera: int, frame: int) -> Optional[FloatImage]:
        return None if self._pool is None else self._pool.take(model.pixels, camera, frame)
