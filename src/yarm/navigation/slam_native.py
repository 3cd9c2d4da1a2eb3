"""The C++ map maker and localisation (src/slam) without ROS: what slam_gmapping and amcl work with, their defaults.

Everything happens within a call, in the caller's thread, so the same input gives the same output.
"""

from __future__ import annotations

import ctypes
import math
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache
from pathlib import Path
from typing import Any, Optional, Tuple

import numpy as np

from yarm.geometry import FloatArray, Pose2
from yarm.geometry.scans import Odometry, Scan
from yarm.navigation.grid_map import GridMap
from yarm.resources import built_library

LIBRARY = "libyarm_slam.so"
_REASON_CHARS = 512
_START = Pose2(0.0, 0.0)


class SlamError(RuntimeError):
    """The library is not built, or refused what it was given; the message says why."""


class ScanStatus(IntEnum):
    """What became of a scan; yarm::slam::ScanStatus."""

    DROPPED = 0
    PREDICTED = 1
    MATCHED = 2
    KEYFRAME = 3
    UNMATCHED = 4


class LocaliserState(IntEnum):
    """What the localiser is about; yarm::slam::LocaliserState."""

    SEARCHING = 0
    CHECKING = 1
    TRACKING = 2


@dataclass(frozen=True)
class Mapped:
    """The map maker's answer to a scan.

    Attributes:
        status: what became of it.
        reason: why it was dropped or not matched; empty otherwise.
        pose: of the base in the map at the scan's time.
        map_from_odom: pose of the odometry's frame in the map.
    """

    status: ScanStatus
    reason: str
    pose: Pose2
    map_from_odom: Pose2


@dataclass(frozen=True)
class MapperCounts:
    """What the map maker has done so far.

    Attributes:
        keyframes: scans that are kept.
        matched: matches that succeeded.
        unmatched: matches that were due and failed.
    """

    keyframes: int
    matched: int
    unmatched: int


@dataclass(frozen=True, eq=False)
class Localised:
    """The localiser's answer to a scan.

    Attributes:
        dropped: the scan was refused, for the reason.
        state: what the localiser is about.
        localised: the place is followed, surely enough, and the scans agree with the map.
        reason: why it is not localised, and what would help; empty when it is.
        pose: of the base in the map at the scan's time; None while none is believed.
        map_from_odom: pose of the odometry's frame in the map; None likewise.
        covariance: (3, 3) of the pose over x, y, yaw along the map's axes, m^2, m rad, rad^2.
        agreement: share of the last fitted scan's points that lie on surfaces of the map.
    """

    dropped: bool
    state: LocaliserState
    localised: bool
    reason: str
    pose: Optional[Pose2]
    map_from_odom: Optional[Pose2]
    covariance: FloatArray
    agreement: float

    @property
    def spread_m(self) -> float:
        """Standard deviation of the position along its least sure direction, metres."""
        return math.sqrt(max(0.0, float(np.linalg.eigvalsh(self.covariance[:2, :2])[-1])))

    @property
    def spread_rad(self) -> float:
        """Standard deviation of the heading, rad."""
        return math.sqrt(max(0.0, float(self.covariance[2, 2])))


class _Pose(ctypes.Structure):
    """YarmPose of include/yarm/slam/c_api.hpp."""

    _fields_ = (("x", ctypes.c_double), ("y", ctypes.c_double), ("yaw", ctypes.c_double))


class _Scan(ctypes.Structure):
    """YarmScan."""

    _fields_ = (
        ("stamp_ns", ctypes.c_int64),
        ("angle_min", ctypes.c_double),
        ("angle_increment", ctypes.c_double),
        ("range_min", ctypes.c_double),
        ("range_max", ctypes.c_double),
        ("beams", ctypes.c_int32),
        ("ranges", ctypes.c_void_p),
        ("T_base_sensor", _Pose),
        ("T_odom_base", _Pose),
    )


class _Grid(ctypes.Structure):
    """YarmGrid."""

    _fields_ = (
        ("width", ctypes.c_int32),
        ("height", ctypes.c_int32),
        ("resolution", ctypes.c_double),
        ("origin_x", ctypes.c_double),
        ("origin_y", ctypes.c_double),
        ("cells", ctypes.c_void_p),
    )


class _Mapped(ctypes.Structure):
    """YarmMapped."""

    _fields_ = (
        ("status", ctypes.c_int32),
        ("reason", ctypes.c_char_p),
        ("T_map_base", _Pose),
        ("T_map_odom", _Pose),
    )


class _Localised(ctypes.Structure):
    """YarmLocalised."""

    _fields_ = (
        ("dropped", ctypes.c_int32),
        ("state", ctypes.c_int32),
        ("localised", ctypes.c_int32),
        ("has_pose", ctypes.c_int32),
        ("reason", ctypes.c_char_p),
        ("T_map_base", _Pose),
        ("T_map_odom", _Pose),
        ("covariance", ctypes.c_double * 9),
        ("agreement", ctypes.c_double),
    )


def library_path() -> Optional[Path]:
    """The built library in a devel or install space, or None."""
    return built_library(LIBRARY)


@lru_cache(maxsize=None)
def _library() -> Any:
    path = library_path()
    if path is None:
        raise SlamError(f"{LIBRARY} is in no devel or install space: build the package first (make build)")
    library = ctypes.CDLL(str(path))
    for part, methods in (("Mapper", ("Add", "Draw", "Counts")), ("Localiser", ("Add", "Forget", "FitNext"))):
        getattr(library, f"yarm{part}Make").restype = ctypes.c_void_p
        for method in ("Free", *methods):
            getattr(library, f"yarm{part}{method}").restype = None
    library.yarmLocaliserBelieve.restype = ctypes.c_char_p
    return library


class Mapper:
    """Makes a map from scans and odometry by a graph of keyframes. Not thread-safe.

    Scans must come in the order of their stamps. One that cannot be used is answered by DROPPED and changes nothing.
    """

    def __init__(self, start: Pose2 = _START) -> None:
        """Nothing seen.

        Args:
            start: where the base stands in the map at the first scan.

        Raises:
            SlamError: the library is not built.
        """
        self._library = _library()
        self._mapper = ctypes.c_void_p(self._library.yarmMapperMake(ctypes.byref(_pose(start))))
        self._begun = False

    def __del__(self) -> None:
        if hasattr(self, "_mapper"):
            self._library.yarmMapperFree(self._mapper)

    def add(self, odometry: Odometry, scan: Scan) -> Mapped:
        """Take in a scan and the odometry of its moment."""
        packed, held = _scan(odometry, scan)
        answer = _Mapped()
        self._library.yarmMapperAdd(self._mapper, ctypes.byref(packed), ctypes.byref(answer))
        del held
        status = ScanStatus(answer.status)
        self._begun |= status is not ScanStatus.DROPPED
        return Mapped(status, _text(answer.reason), _pose2(answer.T_map_base), _pose2(answer.T_map_odom))

    def map(self) -> GridMap:
        """Draw the map of the scans so far.

        Raises:
            SlamError: no scan has been taken in yet.
        """
        if not self._begun:
            raise SlamError("there is no map before the first scan")
        grid = _Grid()
        self._library.yarmMapperDraw(self._mapper, ctypes.byref(grid))
        count = grid.width * grid.height
        cells = np.ctypeslib.as_array(ctypes.cast(grid.cells, ctypes.POINTER(ctypes.c_int8)), (count,)).copy()
        return GridMap(cells.reshape(grid.height, grid.width), grid.resolution, Pose2(grid.origin_x, grid.origin_y))

    @property
    def counts(self) -> MapperCounts:
        """What has been done so far."""
        counts = [ctypes.c_int32() for _ in range(3)]
        self._library.yarmMapperCounts(self._mapper, *(ctypes.byref(count) for count in counts))
        return MapperCounts(*(count.value for count in counts))


class Localiser:
    """Finds and follows a base in a known map. Not thread-safe.

    Begins with no pose: the whole map is searched once the robot has turned round or driven a way.
    """

    def __init__(self, grid_map: GridMap) -> None:
        """Take the map.

        Raises:
            SlamError: the library is not built, or the map has nothing to find a place by.
        """
        self._library = _library()
        cells = np.ascontiguousarray(grid_map.cells, dtype=np.int8)
        grid = _Grid(grid_map.columns, grid_map.rows, grid_map.resolution_m, 0.0, 0.0, cells.ctypes.data)
        why = ctypes.create_string_buffer(_REASON_CHARS)
        origin = _pose(grid_map.origin)
        made = self._library.yarmLocaliserMake(ctypes.byref(grid), ctypes.byref(origin), why, _REASON_CHARS)
        if not made:
            raise SlamError(_text(why.value))
        self._localiser = ctypes.c_void_p(made)

    def __del__(self) -> None:
        if hasattr(self, "_localiser"):
            self._library.yarmLocaliserFree(self._localiser)

    def believe(self, pose: Pose2, deviations: Tuple[float, float, float] = (0.5, 0.5, 0.26)) -> None:
        """Take over a rough pose; it is looked for around it, and from then on followed.

        Args:
            pose: of the base in the map.
            deviations: standard deviations of its x, y, metres, and yaw, rad.

        Raises:
            SlamError: something is not finite.
        """
        covariance = np.ascontiguousarray(np.diag(np.square(deviations)))
        at = ctypes.c_void_p(covariance.ctypes.data)
        refused = _text(self._library.yarmLocaliserBelieve(self._localiser, ctypes.byref(_pose(pose)), at))
        if refused:
            raise SlamError(refused)

    def forget(self) -> None:
        """Forget the pose: the whole map is searched as soon as enough has been seen."""
        self._library.yarmLocaliserForget(self._localiser)

    def fit_next(self) -> None:
        """Have the next scan fitted even when the robot stands."""
        self._library.yarmLocaliserFitNext(self._localiser)

    def add(self, odometry: Odometry, scan: Scan) -> Localised:
        """Take in a scan and the odometry of its moment."""
        packed, held = _scan(odometry, scan)
        answer = _Localised()
        self._library.yarmLocaliserAdd(self._localiser, ctypes.byref(packed), ctypes.byref(answer))
        del held
        covariance: FloatArray = np.array(answer.covariance, dtype=float).reshape(3, 3)
        return Localised(
            bool(answer.dropped),
            LocaliserState(answer.state),
            bool(answer.localised),
            _text(answer.reason),
            _pose2(answer.T_map_base) if answer.has_pose else None,
            _pose2(answer.T_map_odom) if answer.has_pose else None,
            covariance,
            float(answer.agreement),
        )


def _pose(pose: Pose2) -> _Pose:
    return _Pose(pose.x, pose.y, pose.yaw_rad)


def _pose2(pose: _Pose) -> Pose2:
    return Pose2(float(pose.x), float(pose.y), float(pose.yaw))


def _scan(odometry: Odometry, scan: Scan) -> Tuple[_Scan, object]:
    """The scan as the library takes it, and what must live as long."""
    ranges = np.ascontiguousarray(scan.ranges, dtype=np.float32)
    packed = _Scan(
        round(1e9 * scan.stamp_s),
        scan.angle_min_rad,
        scan.angle_increment_rad,
        scan.range_min_m,
        scan.range_max_m,
        len(ranges),
        ranges.ctypes.data,
        _pose(scan.sensor),
        _pose(odometry.pose),
    )
    return packed, ranges


def _text(text: Optional[bytes]) -> str:
    return (text or b"").decode()
