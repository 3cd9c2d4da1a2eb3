"""How much of the raster is done, what of it may be done now, and which piece of that comes next."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional, Sequence, Tuple

import numpy as np
from scipy.spatial import cKDTree

from yarm.control.sander.planner import RasterPlan
from yarm.control.sander.raster import Raster
from yarm.geometry.grid import FloatArray

ARC_TOLERANCE_M = 1e-3
"""A piece of the raster that is shorter counts as done."""
LEAST_PIECE_M = 0.05
"""A shorter piece beside what must be kept off waits until all about it may be done."""
Piece = Tuple[float, float]
"""From one way along the raster to another, metres."""


@dataclass(frozen=True, eq=False)
class KeepOff:
    """What the tip must stay away from.

    Attributes:
        points: (n, 2) metres, in the station's frame.
        distance_m: horizontal distance of the tip from each of them.
    """

    points: FloatArray
    distance_m: float

    def pieces(self, raster: Raster) -> Tuple[Piece, ...]:
        """The pieces of a raster on which the tip would be too near, each as far as its neighbouring points."""
        if len(self.points) == 0:
            return ()
        arc = np.concatenate([stroke.arc_m for stroke in raster.strokes])
        near = cKDTree(self.points).query(raster.polyline[:, :2])[0] <= self.distance_m
        edges = np.flatnonzero(np.diff(np.concatenate([[False], near, [False]]).astype(np.int8)))
        starts, ends = np.maximum(edges[::2] - 1, 0), np.minimum(edges[1::2], len(arc) - 1)
        return joined(list(zip(arc[starts].tolist(), arc[ends].tolist())))


class RasterProgress:
    """The plan, what of it is done, and where on it the tip is.

    Attributes:
        plan: None while there is none.
        arc_m: way along it, metres, at which the tip sands, or will go on.
        share: of it that is done, as shown, 0 to 1.
        done: what is done, in order and apart.
        kept_off: what must not be done now, in order and apart.
    """

    def __init__(self) -> None:
        """No plan."""
        self._keep_off: Optional[KeepOff] = None
        self.begin(None)

    def begin(self, plan: Optional[RasterPlan], done: Sequence[Piece] = (), arc_m: float = 0.0) -> None:
        """Start with a plan of which something may be done; None while there is none yet."""
        self.plan, self.arc_m, self.done = plan, arc_m, joined(done)
        self._look()
        self._count()

    def keep_off(self, what: Optional[KeepOff]) -> None:
        """From now on keep the tip off this; None: off nothing."""
        self._keep_off = what
        self._look()

    def note(self, arc_m: float) -> None:
        """The tip has sanded up to here, metres; it never goes back."""
        if arc_m > self.arc_m:
            self.done = joined([*self.done, (self.arc_m, arc_m)])
            self.arc_m = arc_m
            self._count()

    def next_piece(self) -> Optional[Piece]:
        """What comes next: on from where the tip is, else the first piece after it, else the first of all.

        None when nothing is left, or nothing that may be done now.
        """
        pieces = self._open_pieces()
        on = [(max(self.arc_m, a), b) for a, b in pieces if a - ARC_TOLERANCE_M <= self.arc_m < b - ARC_TOLERANCE_M]
        return next(iter([*on, *(piece for piece in pieces if piece[0] > self.arc_m), *pieces]), None)

    def may_go_to(self, arc_m: float) -> bool:
        """Whether nothing between the tip and a way further along, metres, must be kept off."""
        return all(b <= self.arc_m or a >= arc_m - ARC_TOLERANCE_M for a, b in self.kept_off)

    def begins_here(self, piece: Piece) -> bool:
        """Whether a piece begins where the tip is."""
        return abs(piece[0] - self.arc_m) <= ARC_TOLERANCE_M

    def go_to(self, piece: Piece) -> None:
        """The tip goes on at the beginning of a piece."""
        self.arc_m = piece[0]

    @property
    def finished(self) -> bool:
        """Whether nothing is left of the plan."""
        return self.plan is not None and not self._left()

    def _look(self) -> None:
        found = None if self.plan is None or self._keep_off is None else self._keep_off.pieces(self.plan.raster)
        self.kept_off: Tuple[Piece, ...] = found or ()

    def _count(self) -> None:
        length_m = 0.0 if self.plan is None else self.plan.raster.length_m
        self.share = min(sum(b - a for a, b in self.done) / length_m, 1.0) if length_m > 0.0 else 0.0

    def _left(self) -> List[Piece]:
        length_m = 0.0 if self.plan is None else self.plan.raster.length_m
        return without((0.0, length_m), self.done, ARC_TOLERANCE_M)

    def _open_pieces(self) -> List[Piece]:
        found = []
        for left in self._left():
            pieces = without(left, self.kept_off, ARC_TOLERANCE_M)
            found += [piece for piece in pieces if piece == left or piece[1] - piece[0] >= LEAST_PIECE_M]
        return found


def joined(pieces: Sequence[Piece]) -> Tuple[Piece, ...]:
    """Pieces in order; those that meet or overlap are one."""
    found: List[Piece] = []
    for a, b in sorted((float(a), float(b)) for a, b in pieces):
        if found and a <= found[-1][1] + 1e-9:
            found[-1] = (found[-1][0], max(found[-1][1], b))
        else:
            found.append((a, b))
    return tuple(found)


def without(piece: Piece, others: Sequence[Piece], least_m: float) -> List[Piece]:
    """What of a piece is in none of several others, which are in order and apart; nothing as short as the least."""
    found, at = [], piece[0]
    for a, b in others:
        if b <= piece[0] or a >= piece[1]:
            continue
        found.append((at, a))
        at = b
    found.append((at, piece[1]))
    return [(a, b) for a, b in found if b - a > least_m]
