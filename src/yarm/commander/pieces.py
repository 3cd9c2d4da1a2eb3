"""Pieces of debris for the hand: where each is seen, which hang on a hand, and which lie in a bin."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Deque, Dict, List, Mapping, Optional, Tuple

import numpy as np

from yarm.geometry import MappedObject, transform_matrix
from yarm.geometry.kinds import ObjectKind
from yarm.robots import bin as bins
from yarm.robots.shapes import PieceShape

VIEWS = 15
"""Newest views of a piece that its place is made of: half a second of them."""
MOVED_M = 0.01
"""A piece whose seed has gone farther has moved: what was seen of it before counts no more, metres."""
REFUSED_MOVED_M = 0.05
"""A piece that was given back is a goal again when it is so far from where it was, metres."""
BESIDE_M = 0.2
"""Pieces whose middles are nearer may hide or press each other, metres."""


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
    """A piece that no robot shall try again as it lies.

    Attributes:
        reason: why.
        xy: where it lay, metres, world.
        beside: the pieces beside it then; without one of them it may be seen, and taken, better.
    """

    reason: str
    xy: Tuple[float, float]
    beside: Tuple[str, ...] = ()

    def holds(self, name: str, objects: Mapping[str, MappedObject]) -> bool:
        """Whether the piece still lies so on a map, with everything that lay beside it."""
        places = {other: objects[other].position_m[:2] for other in (name, *self.beside) if other in objects}
        far = {name: REFUSED_MOVED_M, **dict.fromkeys(self.beside, BESIDE_M)}
        return all(other in places and math.dist(places[other], self.xy) <= limit for other, limit in far.items())


def pieces_beside(found: MappedObject, objects: Mapping[str, MappedObject]) -> Tuple[str, ...]:
    """Names of the other pieces that lie beside one, in order."""
    debris = (thing for thing in objects.values() if thing.kind == ObjectKind.DEBRIS and thing.name != found.name)
    return tuple(
        sorted(thing.name for thing in debris if math.dist(thing.position_m[:2], found.position_m[:2]) <= BESIDE_M)
    )


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


def shapes_seen(objects: Mapping[str, MappedObject]) -> Dict[str, PieceShape]:
    """The shapes of the pieces on a map that nobody registered, by name, as they are seen."""
    sizes = {name: found.size_m for name, found in objects.items()}
    return {
        name: PieceShape(0.5 * math.hypot(size[0], size[1]), size[2])
        for name, size in sizes.items()
        if size is not None
    }


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
