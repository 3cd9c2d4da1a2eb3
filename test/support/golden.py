"""The golden recording: a few camera sets of a simulated cell with their frames, registry and the metadata they give.

Depths are kept in steps of 4 mm and only near the mapped volume, so that the file stays small; 0: nothing in range.
Messages are kept as they go over the wire.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from typing import Any, List, Sequence, Tuple, Type

import numpy as np

from yarm.sim.sensors.camera_model import CLOUD_DTYPE, CameraModel

FILE = Path(__file__).resolve().parents[1] / "data" / "golden_sets.npz"
DEPTH_STEP_M = 0.004
CAMERAS = (1, 2, 3, 4)
PIECE_TOLERANCE = 1e-5
"""Metres and rad: what is seen of a piece comes from single precision; a point more or less is a difference."""


@dataclass(frozen=True)
class GoldenSet:
    """One camera set.

    Attributes:
        stamp_ns: capture time, ns.
        calibrating: what the Commander said at that time.
        depth: (4, height, width) uint16, in steps of ``DEPTH_STEP_M``.
        frames: serialised TFMessage of the moving frames at that time.
        registry: serialised ObjectRegistry.
        metadata: serialised MapMetaData that the set must give; empty when not known yet.
    """

    stamp_ns: int
    calibrating: bool
    depth: np.ndarray
    frames: bytes
    registry: bytes
    metadata: bytes


@dataclass(frozen=True)
class Golden:
    """The recording; ``fixed_frames``: serialised TFMessage; ``fov_rad``: horizontal field of view of the cameras."""

    fixed_frames: bytes
    fov_rad: float
    sets: Tuple[GoldenSet, ...]


def load(path: Path = FILE) -> Golden:
    """Read a recording."""
    with np.load(path) as data:
        count = len(data["stamps"])
        sets = tuple(
            GoldenSet(
                int(data["stamps"][k]),
                bool(data["calibrating"][k]),
                data[f"depth_{k}"],
                data[f"frames_{k}"].tobytes(),
                data[f"registry_{k}"].tobytes(),
                data[f"metadata_{k}"].tobytes(),
            )
            for k in range(count)
        )
        return Golden(data["fixed_frames"].tobytes(), float(data["fov_rad"]), sets)


def save(golden: Golden, path: Path = FILE) -> None:
    """Write a recording, compressed."""
    arrays = {
        "stamps": np.array([s.stamp_ns for s in golden.sets], dtype=np.int64),
        "calibrating": np.array([s.calibrating for s in golden.sets]),
        "fixed_frames": np.frombuffer(golden.fixed_frames, np.uint8),
        "fov_rad": np.array(golden.fov_rad),
    }
    for k, golden_set in enumerate(golden.sets):
        arrays[f"depth_{k}"] = golden_set.depth
        arrays[f"frames_{k}"] = np.frombuffer(golden_set.frames, np.uint8)
        arrays[f"registry_{k}"] = np.frombuffer(golden_set.registry, np.uint8)
        arrays[f"metadata_{k}"] = np.frombuffer(golden_set.metadata, np.uint8)
    np.savez_compressed(path, **arrays)


def with_metadata(golden: Golden, metadata: Sequence[bytes]) -> Golden:
    """The recording with other expected metadata, one serialised message a set."""
    sets = tuple(replace(s, metadata=m) for s, m in zip(golden.sets, metadata))
    return replace(golden, sets=sets)


def quantised(cloud: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Depth steps (height, width) of a cloud (height, width, 3), optical frame, without what is far from the cell.

    Args:
        cloud: points, metres, NaN where nothing is in range.
        matrix: (4, 4) world <- optical frame.
    """
    world = cloud @ matrix[:3, :3].T + matrix[:3, 3]
    near = (np.abs(world[..., :2]).max(-1) < 2.6) & (world[..., 2] > -0.1) & (world[..., 2] < 1.4)
    return np.where(near, np.rint(cloud[..., 2] / DEPTH_STEP_M), 0.0).astype(np.uint16)


def points_of(golden: Golden, depth: np.ndarray) -> np.ndarray:
    """The cloud (height, width) of type ``CLOUD_DTYPE`` that a depth image stands for, optical frame, metres."""
    height, width = depth.shape
    rays = CameraModel(width, height, golden.fov_rad, 0.5, 10.0).directions()
    z = np.where(depth > 0, depth * np.float32(DEPTH_STEP_M), np.float32(np.nan)).astype(np.float32)
    cloud = np.zeros((height, width), dtype=CLOUD_DTYPE)
    cloud["x"], cloud["y"], cloud["z"] = rays[..., 0] * z, rays[..., 1] * z, z
    return cloud


def from_bytes(kind: Type[Any], data: bytes) -> Any:
    """A ROS message from its serialised form."""
    message = kind()
    message.deserialize(data)
    return message


def to_bytes(message: Any) -> bytes:
    """A ROS message as it goes over the wire."""
    buffer = BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def differences(expected: Any, got: Any) -> List[str]:
    """What differs between two MapMetaData, in words; empty when they say the same."""
    found = []
    for field in ("gx", "gy", "gz", "frames", "UIDs", "objects"):
        if getattr(expected, field) != getattr(got, field):
            found.append(f"{field}: {getattr(expected, field)} expected, {getattr(got, field)} found")
    if not found:
        for name, a, b in zip(expected.frames, expected.grid_indices, got.grid_indices):
            cells_a, cells_b = ({(i.x, i.y, i.z) for i in cells.indices} for cells in (a, b))
            if cells_a != cells_b:
                found.append(f"{name}: {len(cells_a - cells_b)} cells lost, {len(cells_b - cells_a)} cells new")
        if bytes(bytearray(x & 255 for x in expected.grid)) != bytes(bytearray(x & 255 for x in got.grid)):
            found.append("grid")
        carried_a, carried_b = ({c.name: c.robot for c in m.carried} for m in (expected, got))
        if carried_a != carried_b:
            found.append(f"carried: {carried_a} expected, {carried_b} found")
    return found + _piece_differences(expected, got)


def _piece_differences(expected: Any, got: Any) -> List[str]:
    """What differs between the pieces of debris that two MapMetaData see, in words."""
    seen, found = ({p.name: _piece_numbers(p) for p in m.pieces} for m in (expected, got))
    if set(seen) != set(found):
        return [f"pieces seen: {sorted(seen)} expected, {sorted(found)} found"]
    return [
        f"piece {name}: {numbers} expected, {found[name]} found"
        for name, numbers in seen.items()
        if not np.allclose(found[name], numbers, rtol=0.0, atol=PIECE_TOLERANCE)
    ]


def _piece_numbers(piece: Any) -> List[float]:
    """Points, bits of the cameras, top x, y, z (m), axis (rad), length, width (m) of a PieceView."""
    top = piece.top
    return [piece.points, piece.cameras, top.x, top.y, top.z, piece.axis, piece.length, piece.width]
