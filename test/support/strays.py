"""Boxes that nobody registered, put down in a simulated cell, and how perception measures them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import List, Optional, Sequence, Tuple

import numpy as np

from support.perception_chain import ChainMap
from support.piece_errors import SURFACES
from support.simulated_cell import SimulatedCell
from yarm.geometry import STRAY, FloatArray, SeenPiece
from yarm.sim.scenes.specs import ThingSpec

BOX = """<robot name="box"><link name="base_link">
  <inertial><mass value="0.2"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>
  <visual><geometry><box size="{size}"/></geometry></visual>
  <collision><geometry><box size="{size}"/></geometry></collision>
</link></robot>"""
APART_M = 0.06
"""A piece seen so far from a box is another one."""
Size = Tuple[float, float, float]
Place = Tuple[float, float, float]


def strays(found: ChainMap) -> List[str]:
    """Names of the debris on a map that nobody registered."""
    return sorted(name for name in found.cells if name.startswith(STRAY))


def places(rng: np.random.Generator) -> List[Place]:
    """One random place on each surface, x, y and the height of the surface, metres; all at least 0.3 m apart."""
    near, apart = rng.uniform(-0.05, 0.05, len(SURFACES)), rng.uniform(0.18, 0.24, len(SURFACES))
    return [
        (float(np.mean(x) + dx), float(np.copysign(dy, y[0])), height)
        for (height, x, y), dx, dy in zip(SURFACES, near, apart)
    ]


def drop(
    cell: SimulatedCell, folder: Path, size: Size, at: Sequence[Place], yaws_rad: Optional[Sequence[float]] = None
) -> List[str]:
    """Let boxes that nobody registered fall at places; their names."""
    file = folder / "box.urdf"
    file.write_text(BOX.format(size=" ".join(map(str, size))))
    names = [f"loose_{i}" for i in range(len(at))]
    for i, (name, (x, y, height)) in enumerate(zip(names, at)):
        yaw_rad = 0.7 * i if yaws_rad is None else yaws_rad[i]
        z = height + size[2] / 2 + 0.01
        cell.world.spawn(ThingSpec(name, "Debris", x, y, z, yaw_rad, (), False, str(file)))
    cell.tell()
    return names


def look(cell: SimulatedCell, sets: int) -> ChainMap:
    """The last of so many maps."""
    for _ in range(sets - 1):
        cell.next_set(calibrating=False)
    return cell.next_set(calibrating=False)


def take_away(cell: SimulatedCell, names: Sequence[str], sets: int) -> ChainMap:
    """Take things away, and look at so many sets."""
    for name in names:
        cell.world.delete(name)
    cell.tell()
    return look(cell, sets)


def seen_at(found: ChainMap, pose: FloatArray) -> Optional[SeenPiece]:
    """The piece seen at a pose (4, 4); None when none is near."""
    pieces = [found.pieces[name] for name in strays(found) if name in found.pieces]
    near = [piece for piece in pieces if math.dist(piece.top_m[:2], pose[:2, 3]) < APART_M]
    return min(near, key=lambda piece: math.dist(piece.top_m[:2], pose[:2, 3]), default=None)


def errors(piece: SeenPiece, pose: FloatArray, size: Size) -> Tuple[float, float, float, float, float]:
    """How far a piece is off: middle, top, length, width, metres, and axis, rad; none is negative."""
    turned = math.remainder(piece.axis_rad - math.atan2(pose[1, 0], pose[0, 0]), math.pi)
    return (
        math.dist(piece.top_m[:2], pose[:2, 3]),
        abs(piece.top_m[2] - float(pose[2, 3]) - 0.5 * size[2]),
        abs(piece.length_m - size[0]),
        abs(piece.width_m - size[1]),
        abs(turned),
    )
