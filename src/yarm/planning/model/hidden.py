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
from typing import Dict, Iterable, List, Optional

import numpy as np

from yarm.geometry import BoolArray, CellMap, CellState, FloatArray, GridSpec, IntArray, MappedObject, Visibility
from yarm.geometry.cell_map import NO_HIDER, OTHER_HIDERS
from yarm.geometry.kinds import ROBOT_KINDS
from yarm.planning.model.volume import Volume, VolumeSet

UNKNOWN = "unknown_"
"""What the names of things that nobody registered begin with, on the map."""
ROUNDING = 1e-6
"""Of a size in cells, and of a time, s."""
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
        fenced: nothing comes in from outside behind registered bodies that alone hide the border, and have since it
            was seen, nor while there is no map.
    """

    policy: HiddenPolicy = HiddenPolicy.FREE
    age_s: float = 5.0
    speed_m_s: float = 2.0
    least_m: float = 0.25
    starts_clear: bool = False
    fenced: bool = False


class HiddenSpace:
    """Follows the cells that no camera sees over the maps of a mission. Not thread safe."""

    def __init__(self, params: HiddenParams) -> None:
        """Nothing seen yet."""
        self.params = params
        self.forget()

    def forget(self) -> None:
        """The simulator was started again: nothing seen before is true any more."""
        self._unwatched = False
        self._spec: Optional[GridSpec] = None
        self._seen_s = math.nan
        self._occupied: Optional[BoolArray] = None
        self._unseen: IntArray = np.empty(0, dtype=np.int64)
        self._hidden_by = np.empty(0, dtype=np.uint32)
        self._objects: List[MappedObject] = []

    def start(self) -> None:
        """The mission starts here: maps from before the calibration had no names for what hides, and are forgotten."""
        if self._spec is not None:
            self._start(self._spec, self._seen_s)

    def begin_unwatched(self) -> None:
        """Nobody has followed the cell for a while: what the next map hides may hold something that has come since."""
        self.forget()
        self._unwatched = True

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
        spec, stamp_s = cell_map.spec, cell_map.stamp_s
        if spec != self._spec or not stamp_s >= self._seen_s:
            self._start(spec, stamp_s)
        volume = self._volume
        self._unseen, self._hidden_by = np.flatnonzero(sight.unseen), sight.hidden_by
        self._objects = list(cell_map.objects.values())
        bodies = volume.numbers_of([*_cells_of(cell_map, registered=True), *robots])
        unseen, solid = volume.of_numbers(self._unseen), volume.of_numbers(bodies)
        hidden = unseen & ~solid
        if self.params.starts_clear:
            hidden &= volume.of_numbers(self._unseen[self._hidden_by != 0])
        if self.params.policy is HiddenPolicy.KNOWN_BODIES:
            np.copyto(self._known_s, stamp_s, where=~sight.unseen)
            self._known_s.reshape(-1)[bodies] = stamp_s
            hidden = self._suspicious(cell_map, sight, hidden, solid, volume.field & ~unseen | solid)
        self._seen_s, self._occupied = stamp_s, volume.image(hidden)

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
        numbers = np.flatnonzero(self._occupied)
        values = self._hidden_by[np.searchsorted(self._unseen, numbers)]
        groups: Dict[str, List[IntArray]] = {}
        for value in np.unique(values):
            groups.setdefault(self._hider(int(value)), []).append(cells[values == value])
        return {who: np.concatenate(parts) for who, parts in groups.items()}

    def _hider(self, bits: int) -> str:
        """Name of who hides a cell, one that can move first; empty for nobody on the map."""
        named = [found for k, found in enumerate(self._objects) if bits & _bit(k)]
        movable = [found.name for found in named if found.kind in ROBOT_KINDS or found.name.startswith(UNKNOWN)]
        return min(movable or [found.name for found in named] or [""])

    def _start(self, spec: GridSpec, stamp_s: float) -> None:
        """Nothing is known of what was before the first map, but for the scene's word."""
        sizes = [max(1, math.ceil(self.params.least_m / step - ROUNDING)) for step in spec.resolution]
        self._spec, self._seen_s, self._least = spec, stamp_s, sizes
        self._volume = Volume(spec.shape, max(sizes))
        clear = self.params.starts_clear
        self._known_s: FloatArray = np.full(spec.shape, stamp_s if clear else -math.inf)
        self._ever = self._volume.field if clear else 0
        self._gap, self._things = 0, 0
        self._others_since_s: FloatArray = np.full(int(np.prod(spec.shape)), math.inf)
        self._possible = 0 if clear and not self._unwatched else self._volume.field
        self._unwatched = False

    def _suspicious(
        self, cell_map: CellMap, sight: Visibility, hidden: VolumeSet, solid: VolumeSet, known: VolumeSet
    ) -> VolumeSet:
        """Hidden cells that are not known to be free; the cells of bodies, and those with what is seen, are known."""
        stamp_s, volume = cell_map.stamp_s, self._volume
        seen = volume.of_numbers(np.flatnonzero(sight.states == CellState.OCCUPIED))
        stray = volume.clustered(seen & ~volume.grown(solid))
        things = volume.of_numbers(volume.numbers_of(_cells_of(cell_map, registered=False))) | stray
        skin = solid & ~volume.shrunk(solid)
        room = hidden & volume.opened(hidden | skin, self._least)
        steps = math.ceil(self.params.speed_m_s * (stamp_s - self._seen_s) / float(min(cell_map.spec.resolution)))
        self._ever |= known
        self._gap = self._gap & ~known | hidden & self._others_hide(stamp_s)
        entered = self._gap and self._gap & volume.opened(self._gap | skin, self._least)
        outside = volume.border & entered if self.params.fenced else volume.border
        reached = self._possible | self._things | things
        for _ in range(min(max(1, steps), max(volume.shape))):
            reached = volume.grown(reached) | outside
        self._possible, self._things = reached & room, things
        doubtful = room & entered
        if doubtful:
            doubtful &= ~volume.of_numbers(np.flatnonzero(stamp_s - self._known_s <= self.params.age_s))
        return self._possible | doubtful | room & ~self._ever

    def _others_hide(self, stamp_s: float) -> VolumeSet:
        """Cells that more than registered bodies have hidden for long enough for something to come in.

        What is looked for takes that long for its own length. Points that have no name for a moment hide cells, too.
        """
        others = NO_HIDER
        for k, found in enumerate(self._objects):
            others |= _bit(k) if found.name.startswith(UNKNOWN) else 0
        cells = self._unseen[(self._hidden_by == 0) | ((self._hidden_by & np.uint32(others)) != 0)]
        since_s = np.minimum(self._others_since_s[cells], stamp_s)
        self._others_since_s[:] = math.inf
        self._others_since_s[cells] = since_s
        enters_s = self.params.least_m / self.params.speed_m_s if self.params.speed_m_s else 0.0
        return self._volume.of_numbers(cells[stamp_s - since_s >= enters_s - ROUNDING])


def _bit(k: int) -> int:
    return 1 << k if k < NAMED_HIDERS else OTHER_HIDERS


def _label(who: str, objects: List[MappedObject], cells: IntArray) -> str:
    """What a person reads of a group of hidden cells (n, 3)."""
    moves = any(found.name == who and found.kind in ROBOT_KINDS for found in objects)
    why = f"behind {who}" + (", which would have to move" if moves else "") if who else "no camera sees it"
    return f"a hidden space of {len(cells)} cells from {tuple(int(v) for v in cells[0])} on ({why})"


def _cells_of(cell_map: CellMap, registered: bool) -> List[IntArray]:
    """Cells (n, 3) of each of the registered objects, or of the others."""
    return [found.cells for name, found in cell_map.objects.items() if name.startswith(UNKNOWN) != registered]
