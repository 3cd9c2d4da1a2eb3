"""The complete joint search in C++ (src/joint): a fleet's tables handed over, and the plan handed back."""

from __future__ import annotations

import ctypes
from enum import IntEnum
from functools import lru_cache
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

import numpy as np

from yarm.planning.cspace.footprint import Shape, columns_of
from yarm.planning.cspace.robot_space import Pose, RobotSpace, margin_around
from yarm.planning.fleet.fleet import Fleet
from yarm.planning.roadmap.search import Target, turn_costs
from yarm.resources import built_library

LIBRARY = "libyarm_joint.so"
_WORD = 64


class Outcome(IntEnum):
    """How a search stands; YarmJointOutcome of include/yarm/joint/joint.hpp."""

    OPEN = 0
    FOUND = 1
    IMPOSSIBLE = 2
    FULL = 3


class _Shapes(ctypes.Structure):
    """YarmJointShapes."""

    _fields_ = (
        ("n", ctypes.c_int32),
        ("words", ctypes.c_int32),
        ("first", ctypes.c_void_p),
        ("columns", ctypes.c_void_p),
        ("bits", ctypes.c_void_p),
    )


class _Robot(ctypes.Structure):
    """YarmJointRobot."""

    _fields_ = (
        ("n_headings", ctypes.c_int32),
        ("n_turns", ctypes.c_int32),
        ("blocked", ctypes.c_void_p),
        ("turn_blocked", ctypes.c_void_p),
        ("turns", ctypes.c_void_p),
        ("shapes", ctypes.c_void_p),
        ("turn_shapes", ctypes.c_void_p),
        ("start", ctypes.c_int32 * 3),
        ("goal", ctypes.c_int32 * 3),
    )


class _Near(ctypes.Structure):
    """YarmJointNear."""

    _fields_ = (
        ("robot", ctypes.c_int32),
        ("other", ctypes.c_int32),
        ("blocked", ctypes.c_void_p),
        ("turn_blocked", ctypes.c_void_p),
    )


def library_path() -> Optional[Path]:
    """The built library in a devel or install space, or None."""
    return built_library(LIBRARY)


@lru_cache(maxsize=None)
def _library(path: Path) -> Any:
    library = ctypes.CDLL(str(path))
    library.yarmJointMake.restype = ctypes.c_void_p
    library.yarmJointFree.argtypes = [ctypes.c_void_p]
    library.yarmJointFree.restype = None
    library.yarmJointRun.argtypes = [ctypes.c_void_p, ctypes.c_int64]
    library.yarmJointImprove.argtypes = [ctypes.c_void_p, ctypes.c_int64]
    library.yarmJointImprove.restype = None
    library.yarmJointPlan.argtypes = [ctypes.c_void_p, ctypes.c_void_p]
    library.yarmJointPlan.restype = None
    library.yarmJointLength.argtypes = [ctypes.c_void_p]
    library.yarmJointByExchange.argtypes = [ctypes.c_void_p]
    for name in ("yarmJointCost", "yarmJointVisited", "yarmJointWork"):
        getattr(library, name).argtypes = [ctypes.c_void_p]
        getattr(library, name).restype = ctypes.c_int64
    return library


class _Tables:
    """What the library is given, and the arrays it points into."""

    def __init__(self, fleet: Fleet) -> None:
        self._numbers: Dict[object, int] = {}
        self._shapes: List[Shape] = []
        self._kept: List[Any] = []
        layout = fleet.spaces[0].layout
        self.robots = [self._robot(space, fleet.targets[i]) for i, space in enumerate(fleet.spaces)]
        self.near = [self._near(fleet, i, j) for i, j in fleet.close_pairs]
        self.shapes = self._all_shapes(-(-layout.shape[2] // _WORD))

    def _robot(self, space: RobotSpace, target: Optional[Target]) -> _Robot:
        headings = range(len(space.headings))
        turns = [(h, k, max(1, round(cost))) for h in headings for k, cost in turn_costs(space, h)]
        goal = (-1, -1, -1) if target is None else (*target.column, -1 if target.heading is None else target.heading)
        return _Robot(
            len(space.headings),
            len(turns),
            self._images(space, [space.blocked(h) for h in headings]),
            self._images(space, [space.turn_blocked(h, k) for h, k, _ in turns]),
            self._at(np.array(turns, dtype=np.int32)),
            self._at(np.array([self._number(space.shape(h)) for h in headings], dtype=np.int32)),
            self._at(np.array([self._number(space.turn_shape(h, k)) for h, k, _ in turns], dtype=np.int32)),
            (ctypes.c_int32 * 3)(*space.start),
            (ctypes.c_int32 * 3)(*goal),
        )

    def _near(self, fleet: Fleet, i: int, j: int) -> _Near:
        space = fleet.spaces[i]
        cells = margin_around(space, fleet.spaces[j])
        headings = range(len(space.headings))
        turns = [(h, k) for h in headings for k, _ in turn_costs(space, h)]
        return _Near(
            i,
            j,
            self._images(space, [space.shape(h).blocked_by(cells) for h in headings]),
            self._images(space, [space.turn_shape(h, k).blocked_by(cells) for h, k in turns]),
        )

    def _number(self, shape: Shape) -> int:
        if shape.groups not in self._numbers:
            self._numbers[shape.groups] = len(self._shapes)
            self._shapes.append(shape)
        return self._numbers[shape.groups]

    def _all_shapes(self, words: int) -> _Shapes:
        first, columns, bits = [0], [], []
        for shape in self._shapes:
            for heights, column_set in shape.groups:
                own = [heights >> (_WORD * w) & (2**_WORD - 1) for w in range(words)]
                for column in columns_of(column_set, shape.layout):
                    columns.append(column)
                    bits.append(own)
            first.append(len(columns))
        return _Shapes(
            len(self._shapes),
            words,
            self._at(np.array(first, dtype=np.int32)),
            self._at(np.array(columns, dtype=np.int32)),
            self._at(np.array(bits, dtype=np.uint64)),
        )

    def _images(self, space: RobotSpace, column_sets: List[int]) -> int:
        layout = space.layout
        images = [layout.image_of_set(column_set & layout.field) for column_set in column_sets]
        return self._at(np.ascontiguousarray(np.array(images, dtype=np.uint8)))

    def _at(self, array: Any) -> int:
        self._kept.append(array)
        return int(array.ctypes.data)


class NativeJoint:
    """A search over the configurations of a fleet; the interpreter's lock is free while it runs. Not thread safe."""

    def __init__(self, path: Path, fleet: Fleet, memory_bytes: int) -> None:
        """Hand over a fleet as it stands, with its targets.

        Args:
            path: the library.
            fleet: spaces and targets, one robot at least.
            memory_bytes: what the configurations visited may take.
        """
        self._library = _library(path)
        tables = _Tables(fleet)
        gx, gy, _ = fleet.spaces[0].layout.shape
        self._joint = self._library.yarmJointMake(
            ctypes.c_int32(gx),
            ctypes.c_int32(gy),
            ctypes.byref(tables.shapes),
            ctypes.c_int32(len(tables.robots)),
            (_Robot * len(tables.robots))(*tables.robots),
            ctypes.c_int32(len(tables.near)),
            (_Near * len(tables.near))(*tables.near),
            ctypes.c_int64(memory_bytes),
        )

    def __del__(self) -> None:
        """Free the library's memory."""
        if getattr(self, "_joint", None):
            self._library.yarmJointFree(self._joint)

    def run(self, work: int) -> Outcome:
        """Search on for about ``work`` look-ups."""
        return Outcome(self._library.yarmJointRun(self._joint, work))

    @property
    def by_exchange(self) -> bool:
        """Whether what is impossible is so by the exchanges of robots of one kind that can be made."""
        return bool(self._library.yarmJointByExchange(self._joint))

    def improve(self, work: int) -> None:
        """Make the plan found cheaper, with about ``work`` look-ups."""
        self._library.yarmJointImprove(self._joint, work)

    def plan(self) -> List[Tuple[int, Pose]]:
        """The plan found: each robot's next pose, one column or one turn from its last, in order."""
        moves = np.zeros((self._library.yarmJointLength(self._joint), 4), dtype=np.int32)
        self._library.yarmJointPlan(self._joint, moves.ctypes.data)
        return [(robot, (x, y, h)) for robot, x, y, h in moves.tolist()]

    @property
    def cost(self) -> int:
        """Cost of the plan found: columns, and turns at their cost rounded to whole cells."""
        return int(self._library.yarmJointCost(self._joint))

    @property
    def visited(self) -> int:
        """Configurations visited."""
        return int(self._library.yarmJointVisited(self._joint))

    @property
    def work(self) -> int:
        """Look-ups made."""
        return int(self._library.yarmJointWork(self._joint))
