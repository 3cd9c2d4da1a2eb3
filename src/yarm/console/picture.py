"""What a page is sent: bodies and cameras as a scene, and everything that moves as a state.

Positions are metres in the world; a pose is x, y, z and a quaternion x, y, z, w.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from yarm.console.wire import Array, encode
from yarm.geometry import CellMap, FloatArray
from yarm.geometry.solids import Solid

Pose = Tuple[float, ...]
"""x, y, z, metres, and a quaternion x, y, z, w."""
NOWHERE: Pose = (math.nan,) * 7
"""Of a frame that has not been heard of; a page leaves out what is there."""


@dataclass(frozen=True)
class BodyDrawing:
    """What is known of an object beforehand.

    Attributes:
        name: unique.
        kind: Mobile, Manipulator, Debris, Target or Obstacle.
        motion: static or dynamic.
        seed_frame: frame of its seed.
        solids: its solids, each with the frame it is fixed to.
    """

    name: str
    kind: str
    motion: str
    seed_frame: str
    solids: Sequence[Tuple[str, Solid]] = ()


@dataclass(frozen=True)
class CameraDrawing:
    """One overhead camera.

    Attributes:
        name: for people.
        frame: that it looks from, along z.
        source: what it is called where its health is told.
        half_across_rad: half its field of view across, rad.
        half_down_rad: the same down.
    """

    name: str
    frame: str
    source: str
    half_across_rad: float
    half_down_rad: float


@dataclass(frozen=True, eq=False)
class Area:
    """A box that is kept clear: what for, lower and upper corner, metres, world."""

    name: str
    lower: Tuple[float, ...]
    upper: Tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Line:
    """A line to draw: its layer, whose it is, and its points (n, 3)."""

    layer: str
    name: str
    points: FloatArray


@dataclass
class Scene:
    """Bodies, cameras, areas; ``frames`` are the frames whose poses a state brings, in order.

    ``around`` is what a page looks at: lower and upper corner on the floor, metres; empty for a whole cell.
    """

    bodies: Sequence[BodyDrawing] = ()
    cameras: Sequence[CameraDrawing] = ()
    areas: Sequence[Area] = ()
    around: Tuple[float, ...] = ()
    frames: List[str] = field(init=False)

    def __post_init__(self) -> None:
        """List the frames."""
        wanted = [body.seed_frame for body in self.bodies] + [camera.frame for camera in self.cameras]
        wanted += [frame for body in self.bodies for frame, _ in body.solids]
        self.frames = list(dict.fromkeys(wanted))

    def message(self, version: int) -> bytes:
        """As a page gets it; arrays ``solid_pose`` (n, 16), row by row, and ``solid_size`` (n, 3), full size."""
        index = {frame: number for number, frame in enumerate(self.frames)}
        solids = [(number, frame, solid) for number, body in enumerate(self.bodies) for frame, solid in body.solids]
        header = {
            "kind": "scene",
            "version": version,
            "frames": self.frames,
            "bodies": [
                {"name": body.name, "kind": str(body.kind), "motion": body.motion, "frame": index[body.seed_frame]}
                for body in self.bodies
            ],
            "solids": [
                {"body": number, "frame": index[frame], "shape": str(solid.shape)} for number, frame, solid in solids
            ],
            "cameras": [
                {
                    "name": camera.name,
                    "frame": index[camera.frame],
                    "source": camera.source,
                    "across": math.tan(camera.half_across_rad),
                    "down": math.tan(camera.half_down_rad),
                }
                for camera in self.cameras
            ],
            "around": list(self.around),
            "areas": [{"name": area.name, "lower": area.lower, "upper": area.upper} for area in self.areas],
        }
        poses = np.array([solid.pose for _, _, solid in solids], np.float32).reshape(-1, 16)
        sizes = np.array([2.0 * solid.half_extent for _, _, solid in solids], np.float32).reshape(-1, 3)
        return encode(header, {"solid_pose": poses, "solid_size": sizes})


def state_message(
    words: Mapping[str, Any],
    scene: Scene,
    version: int,
    poses: Mapping[str, Pose],
    cell_map: Optional[CellMap],
    lines: Sequence[Line],
) -> bytes:
    """As a page gets it.

    Args:
        words: what JSON can say: Commander, tasks, robots.
        scene: whose frames are meant.
        version: of the scene.
        poses: of frames, by name.
        cell_map: the occupancy grid; None before the first.
        lines: to draw.

    Returns:
        a message with arrays ``poses`` (frames, 7), ``cells`` (n, 3), of the objects in their order, and
        ``points`` (n, 3), of the lines in their order.
    """
    things = [] if cell_map is None else sorted(cell_map.objects.values(), key=lambda thing: thing.name)
    grid: Dict[str, Any] = {}
    if cell_map is not None:
        spec = cell_map.spec
        grid = {"shape": spec.shape, "lower": spec.lower, "upper": spec.upper, "stamp_s": cell_map.stamp_s}
    header = {
        **words,
        "kind": "state",
        "scene": version,
        "grid": grid,
        "objects": [
            {
                "name": thing.name,
                "kind": str(thing.kind),
                "cells": len(thing.cells),
                "at": list(thing.position_m),
                "seen_by": [] if thing.piece is None else list(thing.piece.cameras),
            }
            for thing in things
        ],
        "lines": [{"layer": line.layer, "name": line.name, "count": len(line.points)} for line in lines],
    }
    cells = [thing.cells for thing in things] or [np.empty((0, 3), np.int64)]
    points = [line.points for line in lines] or [np.empty((0, 3))]
    arrays: Dict[str, Array] = {
        "poses": np.array([poses.get(frame, NOWHERE) for frame in scene.frames], np.float32).reshape(-1, 7),
        "cells": np.concatenate(cells).astype(np.uint8),
        "points": np.concatenate(points).astype(np.float32),
    }
    return encode(header, arrays)
