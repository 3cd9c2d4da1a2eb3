"""Pieces of debris for the hand: where each is seen, which hang on a hand, and which lie in a bin."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Deque, Dict, List, Mapping, Optional, Tuple

import numpy as np

from yarm.commander.shapes import PieceShape
from yarm.geometry import MappedObject, transform_matrix
from yarm.geometry.kinds import ObjectKind
from yarm.robots import bin as bins

VIEWS = 15
"""Newest views of a piece that its place is made of: half a second of them."""
MOVED_M = 0.01
"""A piece whose seed has gone farther has moved: what was seen of it before counts no more, metres."""
REFUSED_MOVED_M = 0.05
"""A piece that was given back is a goal again when it is so far from where it was, metres."""


@dataclass(frozen=True)
class Load:
    """What hangs on a robot's hand.

    Attributes:
        piece: its name.
        shape: its shape, where it is known.
        seen: the map has shown it there; False while only the hand's word is known.
    """

    piece: str
    shape: Optional[PieceShape] = None
    seen: bool = False


@dataclass(frozen=True)
class Refusal:
    """A piece that no robot shall try again: why, and where it lay, metres, world."""

    reason: str
    xy: Tuple[float, float]


@dataclass
class _Sight:
    seed: Tuple[float, float, float]
    tops: Deque[Tuple[float, float, float]]


class Sights:
    """Where the cameras see each piece."""

    def __init__(self) -> None:
        """Nothing seen."""
        self._sights: Dict[str, _Sight] = {}

    def see(self, objects: Mapping[str, MappedObject]) -> None:
        """Take in a new map."""
        debris = {name: found for name, found in objects.items() if found.kind == ObjectKind.DEBRIS}
        self._sights = {name: sight for name, sight in self._sights.items() if name in debris}
        for name, found in debris.items():
            sight = self._sights.get(name)
            if sight is None or math.dist(sight.seed, found.position_m) > MOVED_M:
                sight = self._sights[name] = _Sight(found.position_m, deque(maxlen=VIEWS))
            if found.piece is not None:
                sight.tops.append(found.piece.top_m)

    def top_of(self, found: MappedObject) -> Tuple[float, float, float]:
        """Over the middle of a piece at the height of its top, metres: the median of its views, unseen its seed."""
        sight = self._sights.get(found.name)
        if sight is None or not sight.tops:
            return found.position_m
        x, y, z = np.median(np.asarray(sight.tops), axis=0).tolist()
        return (x, y, z)


def bins_of(objects: Mapping[str, MappedObject]) -> List[MappedObject]:
    """The bins on a map, ordered by name; their seeds are amid their rims."""
    return [
        objects[name] for name in sorted(objects) if objects[name].kind == ObjectKind.OBSTACLE and bins.is_bin(name)
    ]


def height_in(found: MappedObject, thing: MappedObject) -> float:
    """How high over the floor the middle of something lies in a bin, metres; NaN when it is not in it."""
    pose = transform_matrix(found.position_m, found.quaternion)
    pose[2, 3] -= bins.RIM_M
    point = np.linalg.inv(pose) @ np.array([*thing.position_m, 1.0])
    return float(point[2]) if bins.inside(point[:3]) else math.nan
