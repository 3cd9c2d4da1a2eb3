"""Ray casting in C++ (src/rays): exact primitives, about a millisecond for four cameras."""

from __future__ import annotations

import ctypes
from functools import lru_cache
from pathlib import Path
from typing import Any, Optional

import numpy as np

from yarm.geometry import FloatArray
from yarm.resources import built_library
from yarm.sim.sensors.camera_model import FLOOR_RGB, CameraModel, Cloud, DepthImage, SolidSet
from yarm.sim.sensors.noise import FloatImage

LIBRARY = "libyarm_rays.so"


class _Camera(ctypes.Structure):
    """YarmCamera of include/yarm/rays/rays.hpp."""

    _fields_ = (
        ("width", ctypes.c_int32),
        ("height", ctypes.c_int32),
        ("focal_px", ctypes.c_double),
        ("near_m", ctypes.c_double),
        ("far_m", ctypes.c_double),
    )


def library_path() -> Optional[Path]:
    """The built library in a devel or install space, or None."""
    return built_library(LIBRARY)


@lru_cache(maxsize=None)
def _library(path: Path) -> Any:
    library = ctypes.CDLL(str(path))
    library.yarmRaysFloor.restype = None
    library.yarmRaysAdd.restype = None
    library.yarmRaysCloud.restype = None
    library.yarmRaysSigma.restype = ctypes.c_float
    library.yarmRaysSigma.argtypes = [ctypes.c_double, ctypes.c_double]
    return library


class NativeRays:
    """Rays cast by the C++ library; the interpreter's lock is free meanwhile."""

    def __init__(self, path: Path) -> None:
        """Load the library."""
        self._library = _library(path)

    def floor(self, model: CameraModel, image: DepthImage, T_world_optical: FloatArray) -> None:
        """Fill an image with the bare floor."""
        pose = np.ascontiguousarray(T_world_optical, dtype=np.float64)
        self._library.yarmRaysFloor(
            ctypes.byref(_camera(model)),
            _at(pose),
            ctypes.c_uint32(FLOOR_RGB),
            _at(image.depth),
            _at(image.sigma),
            _at(image.rgb),
        )

    def add(
        self,
        model: CameraModel,
        image: DepthImage,
        T_optical_world: FloatArray,
        solids: SolidSet,
        T_world_solid: FloatArray,
    ) -> None:
        """Put solids in front of what the image shows already."""
        view = np.ascontiguousarray(T_optical_world, dtype=np.float64)
        poses = np.ascontiguousarray(T_world_solid, dtype=np.float64)
        self._library.yarmRaysAdd(
            ctypes.byref(_camera(model)),
            _at(view),
            ctypes.c_int32(len(solids.items)),
            _at(solids.shapes),
            _at(solids.sizes),
            _at(poses),
            _at(solids.colours),
            _at(image.depth),
            _at(image.sigma),
            _at(image.rgb),
        )

    def cloud(self, model: CameraModel, image: DepthImage, normals: Optional[FloatImage], out: Cloud) -> None:
        """Write organised points."""
        self._library.yarmRaysCloud(
            ctypes.byref(_camera(model)),
            _at(image.depth),
            _at(image.sigma),
            _at(image.rgb),
            None if normals is None else _at(normals),
            _at(out),
        )


@lru_cache(maxsize=8)
def _camera(model: CameraModel) -> _Camera:
    return _Camera(model.width, model.height, model.focal_px, model.near_m, model.far_m)


def _at(array: Any) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
