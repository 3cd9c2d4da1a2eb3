"""Where the pieces that a person has named are seen; no ROS here."""

from __future__ import annotations

from collections import deque
from typing import Deque, Dict, Iterable, Iterator, List, Tuple

import numpy as np

from yarm.geometry import CellMap, FloatArray, quaternion_from_rpy, transform_matrix
from yarm.geometry.kinds import ObjectKind
from yarm.sim.scenes.bodies import Body
from yarm.sim.scenes.specs import ThingSpec

VIEWS = 15
"""Of the newest views the median counts: half a second of 30 a second."""
Place = Tuple[float, float, float]


class NamedPieces:
    """The newest views of each named piece. Not thread-safe."""

    def __init__(self) -> None:
        """None named yet."""
        self._views: Dict[str, Deque[Place]] = {}
        self._seen_s: Dict[str, float] = {}

    def keep(self, names: Iterable[str], now_s: float) -> None:
        """These are named, and no others; a new one counts as seen now, s."""
        wanted = set(names)
        for name in [name for name in self._views if name not in wanted]:
            del self._views[name], self._seen_s[name]
        for name in wanted - set(self._views):
            self._views[name], self._seen_s[name] = deque(maxlen=VIEWS), now_s

    def see(self, cell_map: CellMap) -> Iterator[Tuple[str, Place]]:
        """Take a map; where each piece of it that has enough views is: middle and top, metres, world."""
        for name, views in self._views.items():
            found = cell_map.objects.get(name)
            if found is None or found.piece is None:
                continue
            self._seen_s[name] = cell_map.stamp_s
            views.append(found.piece.top_m)
            if len(views) == VIEWS:
                x, y, z = np.median(np.array(views), axis=0).tolist()
                yield name, (x, y, z)

    def unseen(self, now_s: float, limit_s: float) -> List[Tuple[str, float]]:
        """The pieces that have not been seen for longer than a limit, and for how long, s."""
        silent = {name: now_s - seen_s for name, seen_s in self._seen_s.items()}
        return sorted((name, passed_s) for name, passed_s in silent.items() if passed_s > limit_s)


def named_piece(spec: ThingSpec) -> Body:
    """A piece that a person says lies somewhere: what is seen there is it, whatever its shape."""
    pose: FloatArray = transform_matrix((spec.x, spec.y, spec.z), quaternion_from_rpy(0.0, 0.0, spec.yaw_rad))
    frames = {spec.name: pose}
    return Body(spec.name, ObjectKind.DEBRIS, True, spec.name, (spec.name,), static_frames=frames, drawn=False)
