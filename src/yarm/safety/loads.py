"""What hangs on the robots' hands: part of the robot that carries it, and nothing that this robot must not touch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Mapping, Sequence, Tuple

import numpy as np

from yarm.geometry import CellMap, FloatArray, MappedObject, transform_matrix
from yarm.geometry.solids import Shape, Solid, surface_points


@dataclass(frozen=True, eq=False)
class Load:
    """A piece on a hand, as the map shows it there.

    Attributes:
        piece: its name.
        robot: that carries it.
        points: (n, 3) on its surface, metres, in the frame of the robot's end effector.
    """

    piece: str
    robot: str
    points: FloatArray


def loads_of(cell_map: CellMap, solids: Mapping[str, Sequence[Tuple[str, Solid]]], spacing_m: float) -> List[Load]:
    """Every piece that a map shows on a hand.

    Args:
        cell_map: the map.
        solids: by object, each with the frame it is fixed to; a piece has one frame, its seed's.
        spacing_m: largest distance of the points that its surface is seen as.
    """
    loads = []
    for name, found in sorted(cell_map.objects.items()):
        held = found.carried
        if held is not None:
            T_ee_piece = transform_matrix(held.position_m, held.quaternion)
            own = [solid.seen_from(T_ee_piece) for _, solid in solids.get(name, _as_seen(found))]
            loads.append(Load(name, held.robot, surface_points(own, spacing_m)))
    return loads


def _as_seen(found: MappedObject) -> Sequence[Tuple[str, Solid]]:
    """The box that is seen of a piece that nobody registered, in its frame; none of anything else."""
    size_m = found.size_m
    return () if size_m is None else ((found.name, Solid(Shape.BOX, size_m, np.eye(4))),)


def with_loads(robot: str, points: FloatArray, loads: Sequence[Load]) -> FloatArray:
    """The points (n, 3) of a robot and of what it carries."""
    return np.concatenate([points, *(load.points for load in loads if load.robot == robot)])
