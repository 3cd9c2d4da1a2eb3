"""The C++ scene factory and the C++ perception chain from Python: camera sets in, map out, no ROS between."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass, field
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from support.launched import DEVEL
from yarm.geometry import SeenPiece, Visibility

CAMERAS, EDGE = 4, 320
SHAPES = {"box": 0, "sphere": 1, "cylinder": 2, "capsule": 3}
GRID = (50, 50, 20)


def _library() -> ctypes.CDLL:
    library = ctypes.CDLL(str(DEVEL / "lib" / "libyarm_scene_factory_c.so"))
    for name in ("yarm_chain_new", "yarm_factory_new"):
        getattr(library, name).restype = ctypes.c_void_p
    library.yarm_chain_name.restype = ctypes.c_char_p
    library.yarm_chain_carrier.restype = ctypes.c_char_p
    return library


def _pointer(array: npt.NDArray[np.generic]) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def _pose(matrix: npt.ArrayLike) -> npt.NDArray[np.float64]:
    return np.ascontiguousarray(matrix, dtype=np.float64)


@dataclass(frozen=True)
class SyntheticSet:
    """One camera set with its truth.

    Attributes:
        clouds: (4, 320, 320, 4) float32: x, y, z, rgb, metres, optical frames; NaN where nothing is in range.
        truth: (4, 320, 320) index into bodies, -1 floor, -2 nothing.
        poses: (4, 4, 4) T_world_camera.
        bodies: names.
    """

    clouds: npt.NDArray[np.float32]
    truth: npt.NDArray[np.int16]
    poses: npt.NDArray[np.float64]
    bodies: Tuple[str, ...]


class SceneFactory:
    """Seeded synthetic sets of the standard cell."""

    def __init__(self, seed: int, noise: float = 1.0) -> None:
        """Make one; ``noise`` is a multiple of the Kinect's."""
        self._library = _library()
        self._handle = ctypes.c_void_p(self._library.yarm_factory_new(ctypes.c_ulonglong(seed), ctypes.c_double(noise)))

    def render(self, robots: int, debris: int) -> SyntheticSet:
        """The cell as it starts, with up to 3 robots and 3 debris."""
        clouds = np.empty((CAMERAS, EDGE, EDGE, 4), np.float32)
        truth = np.empty((CAMERAS, EDGE, EDGE), np.int16)
        poses = np.empty((CAMERAS, 4, 4), np.float64)
        self._library.yarm_factory_render(
            self._handle, robots, debris, _pointer(clouds), _pointer(truth), _pointer(poses)
        )
        bodies = ["table", "stand", "hc10_barc"]
        bodies += [f"ankurbot_{i + 1}" for i in range(robots)] + [f"debris_{i + 1}" for i in range(debris)]
        return SyntheticSet(clouds, truth, poses, tuple(bodies))

    def close(self) -> None:
        """Free it."""
        self._library.yarm_factory_free(self._handle)


@dataclass(frozen=True)
class KnownSolid:
    """A known solid: shape name, size as C++ ``Solid`` has it, its tf frame and pose (4, 4) there."""

    shape: str
    size: Tuple[float, float, float]
    frame: str
    T_frame_solid: npt.NDArray[np.float64]


@dataclass(frozen=True)
class KnownBody:
    """A registered object: name, kind, whether static, seed frame, link frames and known solids."""

    name: str
    kind: str
    static: bool
    seed_frame: str
    link_frames: Tuple[str, ...]
    solids: Tuple[KnownSolid, ...]


@dataclass(frozen=True)
class ChainMap:
    """The map of one set.

    Attributes:
        grid: (50, 50, 20) of 0, 1, 2.
        cells: (n, 3) of each object, by name.
        pieces: the debris that is seen, by name.
        carriers: robot that carries a piece, by the piece's name.
        visibility: what the cameras see of the cells, where the chain judges it.
    """

    grid: npt.NDArray[np.int8]
    cells: Dict[str, npt.NDArray[np.int64]]
    pieces: Dict[str, SeenPiece] = field(default_factory=dict)
    carriers: Dict[str, str] = field(default_factory=dict)
    visibility: Optional[Visibility] = None


class PerceptionChain:
    """Merge, association and grid, as the nodes run them."""

    def __init__(self, backend: str = "fused", associator: str = "yarm", visibility: bool = False) -> None:
        """Make one. ``visibility``: judge what the cameras see of the cells; all sets must have as many cameras."""
        self._judges = visibility
        self._library = _library()
        handle = self._library.yarm_chain_new(backend.encode(), associator.encode())
        if not handle:
            raise ValueError(f"backend {backend!r} or associator {associator!r} is not known")
        self._handle = ctypes.c_void_p(handle)

    def close(self) -> None:
        """Free it."""
        self._library.yarm_chain_free(self._handle)

    def process(
        self,
        clouds: Sequence[npt.NDArray[np.generic]],
        camera_poses: Sequence[npt.ArrayLike],
        bodies: Sequence[KnownBody],
        frames: Dict[str, npt.ArrayLike],
        calibrating: bool,
        stamp_ns: int = 0,
        grasping: Sequence[str] = (),
    ) -> ChainMap:
        """One set.

        Args:
            clouds: organised (h, w) clouds of 16-byte points; an empty one: that camera has no view.
            camera_poses: T_world_camera (4, 4) of each.
            bodies: registered objects.
            frames: T_world_frame (4, 4) of their frames.
            calibrating: whether the Commander calibrates.
            stamp_ns: capture time.
            grasping: robots that say that something hangs on their hand.
        """
        library, handle = self._library, self._handle
        kept = self._begin(clouds, camera_poses, stamp_ns)
        for body in bodies:
            self._add(body, frames)
        for robot in grasping:
            library.yarm_chain_grasping(handle, robot.encode())
        count = library.yarm_chain_run(handle, int(calibrating))
        visibility = self._see() if self._judges else None
        del kept
        grid = np.empty(GRID, np.int8)
        library.yarm_chain_grid(handle, _pointer(grid))
        names = [library.yarm_chain_name(handle, i).decode() for i in range(count)]
        pieces = {name: piece for i, name in enumerate(names) for piece in [self._piece(i)] if piece is not None}
        carriers = {name: library.yarm_chain_carrier(handle, i).decode() for i, name in enumerate(names)}
        cells = {name: self._cells(i) for i, name in enumerate(names)}
        loads = {name: robot for name, robot in carriers.items() if robot}
        return ChainMap(grid, cells, pieces, loads, visibility)

    def watch(
        self,
        clouds: Sequence[npt.NDArray[np.generic]],
        camera_poses: Sequence[npt.ArrayLike],
        bodies: Sequence[KnownBody],
        frames: Dict[str, npt.ArrayLike],
    ) -> None:
        """Show one set to the camera watch, in place of ``process``; arguments as there."""
        kept = self._begin(clouds, camera_poses, 0)
        for body in bodies:
            self._add(body, frames)
        self._library.yarm_chain_watch(self._handle)
        del kept

    def turns(self) -> Dict[int, float]:
        """The turn, degrees, that fits each camera's points (index from 0) best since the last call."""
        cameras, turned = np.empty(CAMERAS, np.int32), np.empty(CAMERAS, np.float64)
        count = self._library.yarm_chain_turns(self._handle, _pointer(cameras), _pointer(turned), CAMERAS)
        return {int(camera): float(turn) for camera, turn in zip(cameras[:count], turned[:count])}

    def owners(self) -> List[int]:
        """Owner of each point of the last set: index of the object in the map, -1 nobody."""
        owners = np.empty(self._library.yarm_chain_points(self._handle), np.int32)
        self._library.yarm_chain_owners(self._handle, _pointer(owners))
        return [int(owner) for owner in owners]

    def _begin(
        self, clouds: Sequence[npt.NDArray[np.generic]], camera_poses: Sequence[npt.ArrayLike], stamp_ns: int
    ) -> List[npt.NDArray[np.generic]]:
        """Start a set with its clouds; the chain reads the arrays given back, which must be kept as long."""
        kept = [np.ascontiguousarray(cloud) for cloud in clouds]
        self._library.yarm_chain_begin(self._handle)
        for cloud, pose in zip(kept, map(_pose, camera_poses)):
            self._library.yarm_chain_cloud(
                self._handle, _pointer(cloud), *cloud.shape[1::-1], _pointer(pose), ctypes.c_longlong(stamp_ns)
            )
        return kept

    def _add(self, body: KnownBody, frames: Dict[str, npt.ArrayLike]) -> None:
        library, handle, name = self._library, self._handle, body.name.encode()
        seed = _pose(frames[body.seed_frame])
        if not library.yarm_chain_object(
            handle, name, body.kind.encode(), int(body.static), body.seed_frame.encode(), _pointer(seed)
        ):
            raise ValueError(f"{body.name}: kind {body.kind!r} is not known")
        for frame in body.link_frames:
            library.yarm_chain_link(handle, name, frame.encode(), _pointer(_pose(frames[frame])))
        for frame in sorted({solid.frame for solid in body.solids} - set(body.link_frames)):
            library.yarm_chain_frame(handle, frame.encode(), _pointer(_pose(frames[frame])))
        for solid in body.solids:
            size, pose = np.array(solid.size, np.float64), _pose(solid.T_frame_solid)
            library.yarm_chain_solid(
                handle, name, solid.frame.encode(), SHAPES[solid.shape], _pointer(size), _pointer(pose)
            )

    def _piece(self, index: int) -> Optional[SeenPiece]:
        found = np.empty(7, np.float64)
        if not self._library.yarm_chain_piece(self._handle, index, _pointer(found)):
            return None
        points, x, y, z, axis_rad, length_m, width_m = found.tolist()
        return SeenPiece(int(points), (x, y, z), axis_rad, length_m, width_m)

    def _see(self) -> Visibility:
        states, hidden_by = np.empty(GRID, np.int8), np.empty(int(np.prod(GRID)), np.uint32)
        count = self._library.yarm_chain_see(self._handle, _pointer(states), _pointer(hidden_by))
        return Visibility(states, hidden_by[:count].copy())

    def _cells(self, index: int) -> npt.NDArray[np.int64]:
        flat = np.empty(int(np.prod(GRID)), np.int32)
        count = self._library.yarm_chain_cells(self._handle, index, _pointer(flat), flat.size)
        return np.stack(np.unravel_index(flat[:count], GRID), axis=-1)
