"""Distances of an arm in C++ (src/clearance): the same FCL, some microseconds a configuration."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Optional, Sequence

import numpy as np
import numpy.typing as npt

from yarm.geometry import FloatArray, IntArray
from yarm.geometry.solids import Solid
from yarm.resources import built_library

LIBRARY = "libyarm_clearance.so"
SHAPES = {"box": 0, "cylinder": 1, "sphere": 2}


class _Solids(ctypes.Structure):
    """YarmSolids of include/yarm/clearance/clearance.hpp."""

    _fields_ = (
        ("n", ctypes.c_int32),
        ("shapes", ctypes.c_void_p),
        ("sizes", ctypes.c_void_p),
        ("poses", ctypes.c_void_p),
    )


@dataclass(frozen=True, eq=False)
class ArmBody:
    """A serial arm of n revolute joints with the solids it carries.

    Attributes:
        T_parent_child: (n, 4, 4), each joint's child link at angle 0 in the link before.
        axes: (n, 3), of length 1, in the child's frame.
        solids: of the links, each in the frame of the link that carries it.
        carriers: (m,) for each solid 0 for the fixed frame, i for what joint i moves.
        pairs: (k, 2) solids that must not touch.
    """

    T_parent_child: FloatArray
    axes: FloatArray
    solids: Sequence[Solid]
    carriers: IntArray
    pairs: IntArray


def library_path() -> Optional[Path]:
    """The built library in a devel or install space, or None."""
    return built_library(LIBRARY)


@lru_cache(maxsize=None)
def _library(path: Path) -> Any:
    library = ctypes.CDLL(str(path))
    library.yarmArmMake.restype = ctypes.c_void_p
    library.yarmArmFree.argtypes = [ctypes.c_void_p]
    library.yarmArmFree.restype = None
    library.yarmArmClearance.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double]
    library.yarmArmClearance.restype = ctypes.c_double
    return library


class NativeClearance:
    """An arm among obstacles that stay where they are. Not thread-safe."""

    def __init__(self, path: Path, body: ArmBody, obstacles: Sequence[Solid]) -> None:
        """Build it.

        Args:
            path: of the library.
            body: the arm.
            obstacles: in the arm's fixed frame.

        Raises:
            KeyError: a solid is no box, cylinder or sphere.
        """
        self._library = _library(path)
        joints, axes = _doubles(body.T_parent_child), _doubles(body.axes)
        carriers, pairs = _ints(body.carriers), _ints(body.pairs)
        links, standing = _Packed(body.solids), _Packed(obstacles)
        self._arm = self._library.yarmArmMake(
            ctypes.c_int32(len(axes)),
            _at(joints),
            _at(axes),
            ctypes.byref(links.struct),
            _at(carriers),
            ctypes.c_int32(len(pairs)),
            _at(pairs),
            ctypes.byref(standing.struct),
        )
        self._angles = np.zeros(len(axes))
        self._angles_at = self._angles.ctypes.data

    def __del__(self) -> None:
        if getattr(self, "_arm", None):
            self._library.yarmArmFree(self._arm)

    def clearance(self, angles: FloatArray, within_m: float) -> float:
        """Least distance, metres, at joint angles (n,), rad: 0 where something overlaps, at most ``within_m``."""
        self._angles[:] = angles
        return float(self._library.yarmArmClearance(self._arm, self._angles_at, within_m))


class _Packed:
    """Solids as the library takes them; holds the arrays that the structure points to."""

    def __init__(self, solids: Sequence[Solid]) -> None:
        self.shapes = _ints([SHAPES[solid.shape] for solid in solids])
        self.sizes = _doubles([[*solid.size, 0.0, 0.0][:3] for solid in solids])
        self.poses = _doubles([solid.pose for solid in solids])
        self.struct = _Solids(len(solids), _at(self.shapes), _at(self.sizes), _at(self.poses))


def _doubles(values: npt.ArrayLike) -> FloatArray:
    return np.ascontiguousarray(values, dtype=np.float64)


def _ints(values: npt.ArrayLike) -> npt.NDArray[np.int32]:
    return np.ascontiguousarray(values, dtype=np.int32)


def _at(array: npt.NDArray[Any]) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
