"""The live cell as it is forked: from its newest map and where its stations are."""

from __future__ import annotations

from typing import List, Mapping, Tuple

import numpy as np

from yarm.experiments.what_if.cell import Cell, Placed, Settings
from yarm.geometry import CellMap, MappedObject, yaw_of_quaternion
from yarm.geometry.kinds import GOAL_KINDS, ObjectKind
from yarm.robots.bin import is_bin
from yarm.robots.hc10 import AT_ORIGIN, NAME, STATION_FIXTURES, Station


def cell_of_map(
    cell_map: CellMap, stations: Mapping[str, Station], settings: Settings = (), share: float = -1.0
) -> Cell:
    """The cell that a map shows.

    Args:
        cell_map: the newest map; a piece on a hand is left out, its robot has it.
        stations: of the manipulators at work, by name.
        settings: those of the live Commander that count in a fork.
        share: of the raster that is done, 0 to 1; negative when nobody knows.
    """
    objects = sorted(cell_map.objects.values(), key=lambda found: found.name)
    named = {found.name for found in objects}
    fixtures = _fixtures(stations, named) + [_placed(f, "bin") for f in objects if _is(f, ObjectKind.OBSTACLE, True)]
    known = {fixture.name for fixture in fixtures}
    folded = [f for f in objects if f.name.startswith(NAME) and f.kind == ObjectKind.OBSTACLE]
    rest = [f for f in objects if _is(f, ObjectKind.OBSTACLE, False) and f.name not in known and f not in folded]
    goals = [f for f in objects if f.kind in GOAL_KINDS and f.carried is None]
    return Cell(
        f"the live cell at {cell_map.stamp_s:.1f} s",
        tuple(_placed(found, "") for found in objects if found.kind == ObjectKind.MOBILE),
        tuple(Placed(name, "", s.x, s.y, 0.0, s.yaw_rad) for name, s in sorted(stations.items()) if name in named),
        tuple(fixtures),
        tuple(_placed(found, found.kind) for found in goals),
        tuple(_box(cell_map, found) for found in (*rest, *folded) if len(found.cells)),
        share,
        settings=settings,
    )


def _is(found: MappedObject, kind: str, bin_: bool) -> bool:
    return found.kind == kind and is_bin(found.name) is bin_


def _fixtures(stations: Mapping[str, Station], named: set[str]) -> List[Placed]:
    """Tables and stands on the map, by the names that scenes give them."""
    first = min(stations, default=NAME)
    places = {first: AT_ORIGIN, **stations}
    found = []
    for arm, station in sorted(places.items()):
        for kind in STATION_FIXTURES:
            name = kind if arm == first else f"{arm}_{kind}"
            if name in named:
                found.append(Placed(name, kind, station.x, station.y, 0.0, station.yaw_rad))
    return found


def _placed(found: MappedObject, kind: str) -> Placed:
    x, y, _ = found.piece.top_m if found.piece is not None else found.position_m
    z = found.position_m[2]
    return Placed(found.name, str(kind), x, y, z, yaw_of_quaternion(found.quaternion))


def _box(cell_map: CellMap, found: MappedObject) -> Placed:
    """The upright box about an object's cells."""
    spec = cell_map.spec
    low = np.asarray(spec.lower) + found.cells.min(axis=0) * spec.resolution
    high = np.asarray(spec.lower) + (found.cells.max(axis=0) + 1) * spec.resolution
    size: Tuple[float, ...] = tuple((high - low).tolist())
    x, y, z = (0.5 * (low + high)).tolist()
    return Placed(found.name, str(ObjectKind.OBSTACLE), x, y, z, 0.0, size)
