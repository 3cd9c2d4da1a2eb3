"""Messages to core types and back. The occupancy grid is parsed from its bytes, without one object a cell."""

from __future__ import annotations

import math
import struct
import threading
import time
from typing import Callable, Dict, List, Optional, Tuple

import numpy as np
import numpy.typing as npt
import rospy
from geometry_msgs.msg import Pose, Transform

from yarm.geometry import (
    CarriedPiece,
    CellMap,
    CellState,
    FloatArray,
    GridSpec,
    MappedObject,
    Pose2,
    SeenPiece,
    Visibility,
    transform_matrix,
    yaw_of_quaternion,
)
from yarm.ros.common import names
from yarm.ros.common.checks import Doorkeeper, map_fault, present_s

SPEAKS_S = 1.0
"""Wall time for which the newest map binds those that follow to its grid and order, s."""


class _Reader:
    """Walks through the little-endian bytes of a serialised message."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 0

    def unpack(self, layout: str) -> Tuple[float, ...]:
        values = struct.unpack_from("<" + layout, self._data, self._at)
        self._at += struct.calcsize("<" + layout)
        return values

    def count(self) -> int:
        return int(self.unpack("I")[0])

    def text(self) -> str:
        n = self.count()
        self._at += n
        return self._data[self._at - n : self._at].decode("utf-8", "replace")

    def array(self, dtype: str, n: int) -> npt.NDArray[np.generic]:
        values = np.frombuffer(self._data, dtype=dtype, count=n, offset=self._at)
        self._at += values.nbytes
        return values

    @property
    def left(self) -> int:
        """Bytes that have not been read."""
        return len(self._data) - self._at

    def header(self) -> float:
        _, secs, nsecs = self.unpack("III")
        self.text()
        return float(secs) + 1e-9 * float(nsecs)


def parse_map_metadata(data: bytes) -> CellMap:
    """The live grid from the bytes of a serialised MapMetaData message.

    Arrays are views of ``data`` where they can be; a 50 x 50 x 20 grid with 3 000 cells takes about 0.1 ms.
    Bytes that end after the carried pieces are of a recording from before there was visibility.

    Raises:
        ValueError: the bytes end too early or contradict themselves; the message says where.
    """
    try:
        return _parse(_Reader(data))
    except (struct.error, ValueError) as error:
        raise ValueError(f"planning_metadata of {len(data)} bytes cannot be read: {error}") from error


def _parse(reader: _Reader) -> CellMap:
    stamp_s = reader.header()
    shape = reader.unpack("iii")
    bounds = reader.unpack("6d")
    spec = GridSpec(
        (int(shape[0]), int(shape[1]), int(shape[2])),
        (bounds[0], bounds[2], bounds[4]),
        (bounds[1], bounds[3], bounds[5]),
    )
    names_ = [reader.text() for _ in range(reader.count())]
    uids = reader.array("<i4", reader.count())
    kinds = [reader.text() for _ in range(reader.count())]
    poses = [_transform(reader) for _ in range(reader.count())]
    cells = [_cells(reader) for _ in range(reader.count())]
    grid = reader.array("i1", reader.count())
    reader.array("<i4", 3 * reader.count())
    pieces = dict(_piece(reader) for _ in range(reader.count()))
    carried = dict(_carried(reader) for _ in range(reader.count()))
    if not len(names_) == len(uids) == len(kinds) == len(poses) == len(cells):
        raise ValueError("the arrays of objects differ in length")
    if len(grid) != spec.n_cells:
        raise ValueError(f"the grid has {len(grid)} values, its shape {spec.shape} needs {spec.n_cells}")
    visibility = _visibility(reader, spec) if reader.left else None
    _check_contents(spec, names_, cells, grid)
    _check_pieces(names_, pieces)
    _check_carried(names_, carried)
    objects: Dict[str, MappedObject] = {
        name: _mapped(name, kind, int(uid), pose, own, pieces.get(name), carried.get(name))
        for name, kind, uid, pose, own in zip(names_, kinds, uids, poses, cells)
    }
    return CellMap(stamp_s, spec, grid.reshape(spec.shape), objects, visibility)  # type: ignore[arg-type]


def _visibility(reader: _Reader, spec: GridSpec) -> Optional[Visibility]:
    """What the cameras see of the cells; None when nothing is told.

    Raises:
        ValueError: the arrays do not fit the grid, or each other.
    """
    states: npt.NDArray[np.int8] = reader.array("i1", reader.count())  # type: ignore[assignment]
    hidden_by: npt.NDArray[np.uint32] = reader.array("<u4", reader.count())  # type: ignore[assignment]
    age_s: npt.NDArray[np.float32] = reader.array("<f4", reader.count())  # type: ignore[assignment]
    for name, array in (("visibility", states), ("age_s", age_s)):
        if len(array) not in (0, spec.n_cells):
            raise ValueError(f"{name} has {len(array)} values, the grid of {spec.shape} needs {spec.n_cells} or none")
    if len(states) and (states.min() < 0 or states.max() > CellState.OCCUPIED):
        raise ValueError(f"visibility's values {states.min()} to {states.max()} must be 0 to {CellState.OCCUPIED:d}")
    unseen = np.count_nonzero(states < CellState.FREE)
    if len(hidden_by) != unseen:
        raise ValueError(f"hidden_by has {len(hidden_by)} values for {unseen} cells that are not seen")
    if len(age_s) and not (age_s >= 0.0).all():
        raise ValueError("age_s must be 0 or more in every cell")
    if not len(states):
        return None
    ages = age_s.reshape(spec.shape) if len(age_s) else None
    return Visibility(states.reshape(spec.shape), hidden_by, ages)


def _mapped(
    name: str,
    kind: str,
    uid: int,
    pose: Tuple[float, ...],
    cells: npt.NDArray[np.int64],
    piece: Optional[SeenPiece],
    carried: Optional[CarriedPiece],
) -> MappedObject:
    x, y, z, qx, qy, qz, qw = pose
    return MappedObject(name, kind, uid, (x, y, z), (qx, qy, qz, qw), cells, piece, carried)


def _check_contents(
    spec: GridSpec, object_names: List[str], cells: List[npt.NDArray[np.int64]], grid: npt.NDArray[np.generic]
) -> None:
    """Refuse names that are used twice, cells outside the grid and values that mean nothing.

    Raises:
        ValueError: the first fault.
    """
    doubled = sorted({name for name in object_names if object_names.count(name) > 1})
    if doubled:
        raise ValueError(f"more than one object is called {', '.join(doubled)}")
    for name, own in zip(object_names, cells):
        if len(own) and (own.min() < 0 or np.any(own.max(axis=0) >= spec.shape)):
            raise ValueError(f"{name} has cells outside the grid of {spec.shape}")
    if len(grid) and (grid.min() < 0 or grid.max() > 2):
        raise ValueError(f"the grid's values {grid.min()} to {grid.max()} must be 0, 1 or 2")


def _check_pieces(object_names: List[str], pieces: Dict[str, SeenPiece]) -> None:
    """Refuse pieces of nothing on the map, and numbers that are not finite.

    Raises:
        ValueError: the first fault.
    """
    for name, piece in pieces.items():
        if name not in object_names:
            raise ValueError(f"a piece of {name!r} is seen, which is not on the map")
        if not np.isfinite((*piece.top_m, piece.axis_rad, piece.length_m, piece.width_m)).all():
            raise ValueError(f"what is seen of {name} must be finite numbers, not {piece}")


def _piece(reader: _Reader) -> Tuple[str, SeenPiece]:
    name = reader.text()
    points = int(reader.unpack("i")[0])
    x, y, z, axis_rad, length_m, width_m = reader.unpack("6d")
    mask = int(reader.unpack("I")[0])
    cameras = tuple(bit + 1 for bit in range(32) if mask >> bit & 1)
    return name, SeenPiece(points, (x, y, z), axis_rad, length_m, width_m, cameras)


def _check_carried(object_names: List[str], carried: Dict[str, CarriedPiece]) -> None:
    """Refuse what is carried and not on the map, robots that are not, and poses that are not finite.

    Raises:
        ValueError: the first fault.
    """
    for name, how in carried.items():
        for needed in (name, how.robot):
            if needed not in object_names:
                raise ValueError(f"{name!r} is carried by {how.robot!r}, and {needed!r} is not on the map")
        if not np.isfinite((*how.position_m, *how.quaternion)).all():
            raise ValueError(f"how {name} is carried must be finite numbers, not {how}")


def _carried(reader: _Reader) -> Tuple[str, CarriedPiece]:
    name, robot = reader.text(), reader.text()
    x, y, z, qx, qy, qz, qw = reader.unpack("7d")
    return name, CarriedPiece(robot, (x, y, z), (qx, qy, qz, qw))


def _cells(reader: _Reader) -> npt.NDArray[np.int64]:
    return reader.array("<i4", 3 * reader.count()).reshape(-1, 3).astype(np.int64)


def _transform(reader: _Reader) -> Tuple[float, ...]:
    reader.header()
    reader.text()
    return reader.unpack("7d")


class MapSubscriber:
    """Keeps the newest occupancy grid of a topic; a faulty or older one is left out, its sender named. Thread-safe."""

    def __init__(self, on_map: Optional[Callable[[CellMap], None]] = None, lock_step: bool = False) -> None:
        """Subscribe.

        Args:
            on_map: called with each good map as it arrives, from the subscriber's thread.
            lock_step: the simulation waits for every map to be taken, so that none comes too early.
        """
        self._lock_step = lock_step
        self._lock = threading.Lock()
        self._map: Optional[CellMap] = None
        self._taken_s = -math.inf
        self._on_map = on_map
        self._door = Doorkeeper(names.PLANNING_METADATA)
        self._subscriber = rospy.Subscriber(
            names.PLANNING_METADATA, rospy.AnyMsg, self._on_message, queue_size=1, buff_size=2**22, tcp_nodelay=True
        )

    def _on_message(self, message: rospy.AnyMsg) -> None:
        now_s = time.monotonic()
        with self._lock:
            before = self._map if now_s - self._taken_s < SPEAKS_S else None
        try:
            cell_map = parse_map_metadata(message._buff)
            fault = map_fault(cell_map, present_s(self._lock_step), before)
        except ValueError as error:
            fault = str(error)
        if self._door.refuses(message, fault):
            return
        with self._lock:
            self._map, self._taken_s = cell_map, now_s
        if self._on_map is not None:
            self._on_map(cell_map)

    def newest(self) -> Optional[CellMap]:
        """The newest good grid; None before the first."""
        with self._lock:
            return self._map

    def clear(self) -> None:
        """Forget the newest grid (clock gone backwards)."""
        with self._lock:
            self._map, self._taken_s = None, -math.inf


def matrix_of_pose(pose: Pose) -> FloatArray:
    """Homogeneous matrix (4, 4) of a pose message."""
    p, q = pose.position, pose.orientation
    return transform_matrix((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))


def matrix_of_transform(transform: Transform) -> FloatArray:
    """Homogeneous matrix (4, 4) of a transform message."""
    t, q = transform.translation, transform.rotation
    return transform_matrix((t.x, t.y, t.z), (q.x, q.y, q.z, q.w))


def pose2_of_transform(transform: Transform) -> Pose2:
    """x, y, metres, and yaw, rad, of a transform message."""
    q = transform.rotation
    return Pose2(transform.translation.x, transform.translation.y, yaw_of_quaternion((q.x, q.y, q.z, q.w)))


def pose2_of_pose(pose: Pose) -> Pose2:
    """x, y, metres, and yaw, rad, of a pose message."""
    q = pose.orientation
    return Pose2(pose.position.x, pose.position.y, yaw_of_quaternion((q.x, q.y, q.z, q.w)))


def pose_message(x: float, y: float, z: float, yaw_rad: float) -> Pose:
    """Pose message at x, y, z, metres, heading yaw, rad."""
    message = Pose()
    message.position.x, message.position.y, message.position.z = x, y, z
    message.orientation.z, message.orientation.w = float(np.sin(yaw_rad / 2)), float(np.cos(yaw_rad / 2))
    return message
