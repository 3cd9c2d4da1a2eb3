"""Where the registered objects' seeds are, from the transforms heard so far; no ROS here.

Every frame remembers its newest transform to its parent. A frame that is no direct child of the world is found by
walking up its parents, so any tree serves, but the cell's tree (children of ``world`` only) is the cheap case.
Stamps are integers, nanoseconds; a stamp of a fixed frame is ``STATIC_STAMP``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Optional, Sequence, Tuple

Vector = Tuple[float, float, float]
Quaternion = Tuple[float, float, float, float]

STATIC_STAMP = -1
"""Stamp of a transform that always holds."""

MAX_DEPTH = 64
"""Longest chain of parents followed; a longer one is a loop."""


@dataclass(frozen=True)
class Link:
    """Transform parent <- child: metres, quaternion (x, y, z, w), stamp in ns."""

    parent: str
    translation: Vector
    rotation: Quaternion
    stamp_ns: int


@dataclass(frozen=True)
class RegisteredSeed:
    """One object of the registry, as far as its seed goes."""

    name: str
    kind: str
    label: str
    seed_frame: str


@dataclass(frozen=True)
class Seed:
    """Where a seed is: transform world <- seed with its true stamp, ns (``STATIC_STAMP`` for a fixed frame)."""

    registered: RegisteredSeed
    translation: Vector
    rotation: Quaternion
    stamp_ns: int


class SeedTracker:
    """Newest transform of each frame and, from these, of each registered seed. Not thread-safe."""

    def __init__(self, world: str) -> None:
        self._world = world
        self._fixed: Dict[str, Link] = {}
        self._moving: Dict[str, Link] = {}
        self._registered: List[RegisteredSeed] = []
        self._newest_ns: Optional[int] = None

    @property
    def registered(self) -> Sequence[RegisteredSeed]:
        """The objects of the newest registry."""
        return tuple(self._registered)

    def set_registry(self, registered: Sequence[RegisteredSeed]) -> None:
        """Replace the objects whose seeds are wanted: objects come and go."""
        self._registered = list(registered)

    def add_fixed(self, child: str, link: Link) -> None:
        """Remember a transform that always holds."""
        self._fixed[child] = link

    def add_moving(self, transforms: Sequence[Tuple[str, Link]]) -> Optional[int]:
        """Remember one message of moving transforms, (child, link) each.

        Returns:
            The newest stamp, ns, when it is newer than every stamp before: a new tick. Else None.
        """
        for child, link in transforms:
            known = self._moving.get(child)
            if known is None or link.stamp_ns >= known.stamp_ns:
                self._moving[child] = link
        newest = max((link.stamp_ns for _, link in transforms), default=None)
        if newest is None or (self._newest_ns is not None and newest <= self._newest_ns):
            return None
        self._newest_ns = newest
        return newest

    def went_back(self, stamp_ns: int, tolerance_ns: int) -> bool:
        """Whether a stamp lies so far before the newest one that time has started again."""
        return self._newest_ns is not None and stamp_ns + tolerance_ns < self._newest_ns

    def forget_after(self, stamp_ns: int) -> None:
        """Time has gone back to this stamp: drop every moving transform of its future."""
        self._moving = {child: link for child, link in self._moving.items() if link.stamp_ns <= stamp_ns}
        newest = max((link.stamp_ns for link in self._moving.values()), default=None)
        self._newest_ns = newest

    def seeds(self) -> Tuple[List[Seed], List[RegisteredSeed]]:
        """The seeds that can be placed, and the registered objects whose frame cannot be joined to the world."""
        placed: List[Seed] = []
        missing: List[RegisteredSeed] = []
        for registered in self._registered:
            link = self._to_world(registered.seed_frame)
            if link is None:
                missing.append(registered)
            else:
                placed.append(Seed(registered, link.translation, link.rotation, link.stamp_ns))
        return placed, missing

    def _to_world(self, frame: str) -> Optional[Link]:
        if frame == self._world:
            return Link(self._world, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), STATIC_STAMP)
        link = self._moving.get(frame) or self._fixed.get(frame)
        for _ in range(MAX_DEPTH):
            if link is None or link.parent == self._world:
                return link
            above = self._moving.get(link.parent) or self._fixed.get(link.parent)
            link = None if above is None else _joined(above, link)
        return None


def _joined(above: Link, below: Link) -> Link:
    """The transform grandparent <- child; as old as its oldest moving part."""
    x, y, z = _rotated(above.rotation, below.translation)
    ax, ay, az = above.translation
    stamps = [stamp for stamp in (above.stamp_ns, below.stamp_ns) if stamp != STATIC_STAMP]
    return Link(
        above.parent,
        (ax + x, ay + y, az + z),
        _product(above.rotation, below.rotation),
        min(stamps, default=STATIC_STAMP),
    )


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def _rotated(q: Quaternion, v: Vector) -> Vector:
    x, y, z, _ = _product(_product(q, (v[0], v[1], v[2], 0.0)), (-q[0], -q[1], -q[2], q[3]))
    return x, y, z
