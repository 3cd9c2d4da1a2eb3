"""Which of the cells that no camera sees count as occupied (docs/planning.md, "What no camera sees").

Something that nobody registered can only be where no camera sees: seen, it would be on the map. So the cells in which
something may be are followed from map to map: they grow from where such things are seen, and from the border of the
volume, through cells that are not seen, no faster than anything moves; a cell that is seen, or that a registered body
has, is none of them. A cell counts as seen only when all of it is, so every body has a skin of cells that are not; what
is looked for is too large to fit into a skin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Dict, Iterable, List, Mapping, Optional

import numpy as np
import numpy.typing as npt

from yarm.geometry import BoolArray, CellMap, CellState, FloatArray, GridSpec, IntArray, MappedObject
from yarm.geometry.cell_map import NO_HIDER, OTHER_HIDERS
from yarm.geometry.kinds import ROBOT_KINDS

UNKNOWN = "unknown_"
"""What the names of things that nobody registered begin with, on the map."""
ROUNDING = 1e-6
"""Of a size in cells."""
NAMED_HIDERS = 30
"""Objects that have a bit of their own in ``Visibility.hidden_by``."""


class HiddenPolicy(str, Enum):
    """What a cell that no camera sees counts as, as parameter ``hidden`` writes it."""

    FREE = "free"
    KNOWN_BODIES = "known_bodies"
    """Free while nothing unregistered can be in it, and its last view is recent or only registered bodies hide it."""
    OCCUPIED = "occupied"


@dataclass(frozen=True)
class HiddenParams:
    """How cells that no camera sees are judged.

    Attributes:
        policy: what they count as.
        age_s: a cell hidden by more than registered bodies is free for this long after it was last seen, s.
        speed_m_s: nothing moves faster, m/s.
        least_m: what is hidden is at least this large in every direction, m; 0: it may have any size.
        starts_clear: nothing unregistered is in the cell at the start, nor ever where no camera looks.
    """

    policy: HiddenPolicy = HiddenPolicy.FREE
    age_s: float = 5.0
    speed_m_s: float = 2.0
    least_m: float = 0.25
    starts_clear: bool = False


class HiddenSpace:
    """Follows the cells that no camera sees over the maps of a mission. Not thread safe."""

    def __init__(self, params: HiddenParams) -> None:
        """Nothing seen yet."""
        self.params = params
        self.forget()

    def forget(self) -> None:
        """The simulator was started again: nothing seen before is true any more."""
        self._spec: Optional[GridSpec] = None
        self._seen_s = math.nan
        self._occupied: Optional[BoolArray] = None
        self._hidden_by = np.zeros(0, dtype=np.uint32)
        self._objects: List[MappedObject] = []

    @property
    def occupied(self) -> Optional[BoolArray]:
        """(gx, gy, gz) cells that no camera sees and that count as occupied; None when none can."""
        return self._occupied

    def fault(self, now_s: float, stale_s: float) -> str:
        """Why nothing can be said, at ``now_s``, when the last map that told is older than ``stale_s``; else empty."""
        if self.params.policy is HiddenPolicy.FREE or now_s - self._seen_s <= stale_s:
            return ""
        return (
            f"planning_metadata tells no visibility, which hidden: {self.params.policy.value} needs; "
            "set visibility of merge_clouds to true, or hidden of the commander to free"
        )

    def see(self, cell_map: CellMap, robots: Iterable[IntArray] = ()) -> None:
        """Take a new map in; one without visibility says nothing.

        Args:
            cell_map: as perceived.
            robots: cells (n, 3) of each robot by its drawing, also out of the grid: nothing else is within a robot,
                where no camera ever looks.
        """
        sight = cell_map.visibility
        if self.params.policy is HiddenPolicy.FREE or sight is None:
            return
        hidden_by = np.zeros(cell_map.spec.shape, dtype=np.uint32)
        unseen = sight.unseen
        hidden_by[unseen] = sight.hidden_by
        self._hidden_by, self._objects = hidden_by, list(cell_map.objects.values())
        bodies = _cells_of(cell_map, registered=True)
        for cells in robots:
            bodies[tuple(cells[cell_map.spec.contains(cells)].T)] = True
        hidden = unseen & ~bodies
        if self.params.starts_clear:
            hidden &= hidden_by != 0
        if self.params.policy is HiddenPolicy.KNOWN_BODIES:
            hidden = self._suspicious(cell_map, sight.states, hidden, bodies)
        self._seen_s, self._spec, self._occupied = cell_map.stamp_s, cell_map.spec, hidden

    @property
    def movable(self) -> Dict[str, str]:
        """For each robot that hides cells which count as occupied, the name that ``by_hider`` gives them."""
        robots = [found.name for found in self._objects if found.kind in ROBOT_KINDS]
        return {who: _label(who, self._objects, own) for who, own in self._groups().items() if who in robots}

    def by_hider(self) -> Dict[str, IntArray]:
        """The cells (n, 3) that count as occupied, in groups, each named by who hides them and would have to move."""
        return {_label(who, self._objects, own): own for who, own in self._groups().items()}

    def _groups(self) -> Dict[str, IntArray]:
        """The same by the name of who hides them alone; empty for nobody on the map."""
        if self._occupied is None or not self._occupied.any():
            return {}
        cells = np.argwhere(self._occupied)
        values = self._hidden_by[self._occupied]
        groups: Dict[str, List[IntArray]] = {}
        for value in np.unique(values):
            groups.setdefault(self._hider(int(value)), []).append(cells[values == value])
        return {who: np.concatenate(parts) for who, parts in groups.items()}

    def _hider(self, bits: int) -> str:
        """Name of who hides a cell, one that can move first; empty for nobody on the map."""
        named = [found for k, found in enumerate(self._objects) if bits & _bit(k)]
        movable = [found.name for found in named if found.kind in ROBOT_KINDS or found.name.startswith(UNKNOWN)]
        return min(movable or [found.name for found in named] or [""])

    def _suspicious(
        self, cell_map: CellMap, states: npt.NDArray[np.int8], hidden: BoolArray, bodies: BoolArray
    ) -> BoolArray:
        """Hidden cells that are not known to be free."""
        stamp_s, spec = cell_map.stamp_s, cell_map.spec
        stray = _clustered((states == CellState.OCCUPIED) & ~_grown(bodies))
        things = _cells_of(cell_map, registered=False) | stray
        room = hidden & _room(spec, hidden | (bodies & ~_shrunk(bodies)), self.params.least_m)
        known = (states >= CellState.FREE) | bodies
        if spec != self._spec or not stamp_s >= self._seen_s:
            self._known_s: FloatArray = np.full(spec.shape, stamp_s if self.params.starts_clear else -math.inf)
            self._gap: BoolArray = np.zeros(spec.shape, dtype=np.bool_)
            self._possible: BoolArray = room & ~known & (not self.params.starts_clear)
            self._things = things
            self._border = _border(spec)
            self._seen_s = stamp_s
        steps = math.ceil(self.params.speed_m_s * (stamp_s - self._seen_s) / float(min(spec.resolution)))
        reached = self._possible | self._things | things
        for _ in range(min(max(1, steps), max(spec.shape))):
            reached = _grown(reached) | self._border
        self._possible = reached & room
        self._things = things
        self._known_s[known] = stamp_s
        self._gap[known] = False
        self._gap |= hidden & ~self._by_registered()
        recent = stamp_s - self._known_s <= self.params.age_s
        return self._possible | (room & self._gap & ~recent) | (hidden & ~np.isfinite(self._known_s))

    def _by_registered(self) -> BoolArray:
        """Cells (gx, gy, gz) that registered bodies hide, and nothing else."""
        others = NO_HIDER
        for k, found in enumerate(self._objects):
            others |= _bit(k) if found.name.startswith(UNKNOWN) else 0
        by_registered: BoolArray = (self._hidden_by != 0) & ((self._hidden_by & np.uint32(others)) == 0)
        return by_registered


def _bit(k: int) -> int:
    return 1 << k if k < NAMED_HIDERS else OTHER_HIDERS


def _label(who: str, objects: List[MappedObject], cells: IntArray) -> str:
    """What a person reads of a group of hidden cells (n, 3)."""
    moves = any(found.name == who and found.kind in ROBOT_KINDS for found in objects)
    why = f"behind {who}" + (", which would have to move" if moves else "") if who else "no camera sees it"
    return f"a hidden space of {len(cells)} cells from {tuple(int(v) for v in cells[0])} on ({why})"


def _cells_of(cell_map: CellMap, registered: bool) -> BoolArray:
    """(gx, gy, gz) cells of the registered objects, or of the others."""
    taken = np.zeros(cell_map.spec.shape, dtype=np.bool_)
    objects: Mapping[str, MappedObject] = cell_map.objects
    for name, found in objects.items():
        if name.startswith(UNKNOWN) != registered:
            taken[tuple(found.cells.T)] = True
    return taken


def _grown(cells: BoolArray) -> BoolArray:
    """Cells with their 26 neighbours."""
    for axis in range(3):
        last = np.moveaxis(cells, axis, 0)
        grown = last.copy()
        grown[1:] |= last[:-1]
        grown[:-1] |= last[1:]
        cells = np.moveaxis(grown, 0, axis)
    return cells


def _shrunk(cells: BoolArray) -> BoolArray:
    """Cells all of whose 26 neighbours are among them, the border's outside included."""
    shrunk: BoolArray = ~_grown(~cells)
    return shrunk


def _clustered(cells: BoolArray) -> BoolArray:
    """Cells in groups: one with two more among its 26 neighbours, and those; fewer are noise."""
    count = cells.astype(np.int8)
    for axis in range(3):
        last = np.moveaxis(count, axis, 0)
        total = last.copy()
        total[1:] += last[:-1]
        total[:-1] += last[1:]
        count = np.moveaxis(total, 0, axis)
    clustered: BoolArray = cells & _grown(cells & (count > 2))
    return clustered


def _room(spec: GridSpec, free_of_sight: BoolArray, least_m: float) -> BoolArray:
    """Cells (gx, gy, gz) that are part of a box of such cells, edges ``least_m``; it may reach out of the volume.

    A morphological opening: the box shrinks the cells along each axis, then grows them. Nothing is under the floor.
    """
    sizes = [max(1, math.ceil(least_m / step - ROUNDING)) for step in spec.resolution]
    pads = [(n, n) for n in sizes[:2]] + [(0, sizes[2])]
    room: BoolArray = np.pad(free_of_sight, pads, constant_values=True)
    for axis, n in enumerate(sizes):
        last = np.moveaxis(room, axis, 0)
        room = np.moveaxis(np.logical_and.reduce([last[k : len(last) - n + 1 + k] for k in range(n)]), 0, axis)
    for axis, n in enumerate(sizes):
        last = np.moveaxis(room, axis, 0)
        grown = np.zeros((len(last) + n - 1, *last.shape[1:]), dtype=np.bool_)
        for k in range(n):
            grown[k : k + len(last)] |= last
        room = np.moveaxis(grown, 0, axis)
    gx, gy, gz = spec.shape
    return room[sizes[0] : sizes[0] + gx, sizes[1] : sizes[1] + gy, :gz]


def _border(spec: GridSpec) -> BoolArray:
    """Cells (gx, gy, gz) at the sides and the top of the volume: what is outside is not seen; nobody is below."""
    border = np.zeros(spec.shape, dtype=np.bool_)
    border[[0, -1]] = border[:, [0, -1]] = border[:, :, -1] = True
    return border
