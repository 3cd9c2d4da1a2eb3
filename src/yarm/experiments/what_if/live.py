"""The live cell as it is forked: from its newest map and where its stations are."""

from __future__ import annotations

from typing import List, Mapping, Tuple

import numpy as np

from yarm.experiments.what_if.cell import TUCKED, Cell, Placed, Settings
from yarm.geometry import CellMap, MappedObject, yaw_of_quaternion
from yarm.geometry.kinds import GOAL_KINDS, ObjectKind
from yarm.robots.bin import is_bin
from yarm.robots.hc10 import AT_ORIGIN, NAME, STATION_FIXTURES, Station


def arms_of(cell_map: CellMap) -> Tuple[str, ...]:
    """Names of the manipulators on a map, those too that stay folded and are obstacles to everybody.

    Of a scene's first one, whose fixtures have plain names, also where it is not told of beside others.
    """
    named = {name for name, found in cell_map.objects.items() if found.kind == ObjectKind.MANIPULATOR}
    obstacles = {name for name, found in cell_map.objects.items() if _is(found, ObjectKind.OBSTACLE, False)}
    folded = {name for name in obstacles if name.startswith(NAME) and not name.endswith(STATION_FIXTURES)}
    first = {NAME} if any(name.startswith(NAME) and name.endswith(STATION_FIXTURES) for name in obstacles) else set()
    return tuple(sorted(named | folded | first))


def cell_of_map(
    cell_map: CellMap, stations: Mapping[str, Station], settings: Settings = (), share: float = -1.0
) -> Cell:
    """The cell that a map shows.

    Args:
        cell_map: the newest map; a piece on a hand is left out, its robot has it.
        stations: of its manipulators, by name.
        settings: those of the live Commander that count in a fork.
        share: of the raster that is done, 0 to 1; negative when nobody knows.
    """
    objects = sorted(cell_map.objects.values(), key=lambda found: found.name)
    named = {found.name for found in objects}
    fixtures = _fixtures(stations, named) + [_placed(f, "bin") for f in objects if _is(f, ObjectKind.OBSTACLE, True)]
    known = {fixture.name for fixture in fixtures}
    rest = [f for f in objects if _is(f, ObjectKind.OBSTACLE, False) and f.name not in {*known, *stations}]
    goals = [f for f in objects if f.kind in GOAL_KINDS and f.carried is None]
    return Cell(
        f"the live cell at {cell_map.stamp_s:.1f} s",
        tuple(_placed(found, "") for found in objects if found.kind == ObjectKind.MOBILE),
        tuple(_arm(cell_map.objects[name], s) for name, s in sorted(stations.items()) if name in named),
        tuple(fixtures),
        tuple(_placed(found, found.kind) for found in goals),
        tuple(_box(cell_map, found) for found in rest if len(found.cells)),
        share,
        settings=settings,
    )


def _is(found: MappedObject, kind: str, bin_: bool) -> bool:
    return found.kind == kind and is_bin(found.name) is bin_


def _arm(found: MappedObject, station: Station) -> Placed:
    """A manipulator at its station, at work or folded."""
    tucked = found.kind != ObjectKind.MANIPULATOR
    kind, joints = (TUCKED, station.folded) if tucked else ("", ())
    return Placed(found.name, kind, station.x, station.y, 0.0, station.yaw_rad, tuple(joints))


def _fixtures(stations: Mapping[str, Station], named: set[str]) -> List[Placed]:
    """Tables and stands on the map, by the names that scenes give them: the first manipulator's are the plain ones."""
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
