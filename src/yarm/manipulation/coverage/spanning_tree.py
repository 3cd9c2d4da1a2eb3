"""Spanning-tree coverage: a closed way that enters every cell of a floor once.

Cells are taken in blocks of 2 x 2; a tree over the blocks, by depth-first search, is walked round, which passes through
each cell of each of its blocks exactly once and ends beside where it began: Y. Gabriely, E. Rimon, "Spanning-tree based
coverage of continuous areas by a mobile robot", Annals of Mathematics and Artificial Intelligence 31, 2001. Cells that
belong to no whole block are loose: they are named, and gone to one after the other once the round is closed.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Dict, List, Set, Tuple

import numpy as np

from yarm.geometry import BoolArray, IntArray

Cell = Tuple[int, int]
SIDES: Tuple[Cell, ...] = ((1, 0), (0, 1), (-1, 0), (0, -1))


class CoverageError(ValueError):
    """A floor that cannot be covered; the message says why."""


@dataclass(frozen=True, eq=False)
class Coverage:
    """A way over a floor.

    Attributes:
        round: (n, 2) cells of the closed way, each beside the one before, the first beside the last; empty without any
            whole block.
        loose: (m, 2) reachable cells that are in no block of the tree, in the order they are gone to.
        after: (k, 2) cells of the way from the round's end through all loose cells.
        unreachable: (u, 2) free cells that cannot be reached from the start.
    """

    round: IntArray
    loose: IntArray
    after: IntArray
    unreachable: IntArray

    @property
    def cells(self) -> IntArray:
        """All cells of the way in order (n + k, 2)."""
        return np.concatenate([self.round, self.after])


def cover(free: BoolArray, start: Cell) -> Coverage:
    """Cover all that can be reached, cell by cell over their sides.

    Args:
        free: (gx, gy).
        start: a free cell, where the way begins or, when no block holds it, from where the nearest is gone to.

    Raises:
        CoverageError: the start is not a free cell.
    """
    if not (0 <= start[0] < free.shape[0] and 0 <= start[1] < free.shape[1]) or not free[start]:
        raise CoverageError(f"start {start} is no free cell of a floor of {free.shape[0]} x {free.shape[1]}")
    reached = _flooded(free, start)
    best = max(
        (_blocks(reached, (x, y), start) for x in (0, 1) for y in (0, 1)), key=lambda found: (len(found[1]), found[2])
    )
    offset, blocks, _ = best
    closed = _round(offset, blocks, start) if blocks else []
    first = closed[-1] if closed else start
    done = set(closed) if closed else {start}
    cells = {(int(x), int(y)) for x, y in np.argwhere(reached)}
    loose, after = _rest(cells, done, first)
    if not closed:
        loose, after = [start, *loose], [start, *after]
    lost = [(int(x), int(y)) for x, y in np.argwhere(free & ~reached)]
    return Coverage(*(np.array(part, dtype=np.int64).reshape(-1, 2) for part in (closed, loose, after, lost)))


def _flooded(free: BoolArray, start: Cell) -> BoolArray:
    reached = np.zeros_like(free)
    reached[start] = True
    queue = deque([start])
    while queue:
        x, y = queue.popleft()
        for dx, dy in SIDES:
            a, b = x + dx, y + dy
            if 0 <= a < free.shape[0] and 0 <= b < free.shape[1] and free[a, b] and not reached[a, b]:
                reached[a, b] = True
                queue.append((a, b))
    return reached


def _blocks(free: BoolArray, offset: Cell, start: Cell) -> Tuple[Cell, Set[Cell], int]:
    """With blocks laid from an offset: those that hang together, most cells, and whether the start is in one."""
    ox, oy = offset
    wide, high = (free.shape[0] - ox) // 2, (free.shape[1] - oy) // 2
    part = free[ox : ox + 2 * wide, oy : oy + 2 * high].reshape(wide, 2, high, 2)
    left = {(int(x), int(y)) for x, y in np.argwhere(part.all(axis=(1, 3)))}
    largest: Set[Cell] = set()
    while left:
        seed = min(left)
        group, queue = {seed}, deque([seed])
        left.remove(seed)
        while queue:
            x, y = queue.popleft()
            for dx, dy in SIDES:
                neighbour = (x + dx, y + dy)
                if neighbour in left:
                    left.remove(neighbour)
                    group.add(neighbour)
                    queue.append(neighbour)
        largest = max(largest, group, key=len)
    own = ((start[0] - ox) // 2, (start[1] - oy) // 2)
    return offset, largest, int(own in largest)


def _tree(blocks: Set[Cell], root: Cell) -> List[Tuple[Cell, Cell]]:
    """Edges of a spanning tree, depth first, straight on before turning."""
    seen, edges = {root}, []
    stack: List[Tuple[Cell, Cell, Cell]] = [(root, root, SIDES[0])]
    while stack:
        block, parent, ahead = stack.pop()
        if block != parent:
            if block in seen:
                continue
            seen.add(block)
            edges.append((parent, block))
        turn = SIDES.index(ahead)
        # The last pushed is the first taken: straight on.
        for side in (SIDES[(turn + 2) % 4], SIDES[(turn + 3) % 4], SIDES[(turn + 1) % 4], SIDES[turn]):
            neighbour = (block[0] + side[0], block[1] + side[1])
            if neighbour in blocks and neighbour not in seen:
                stack.append((neighbour, block, side))
    return edges


def _round(offset: Cell, blocks: Set[Cell], start: Cell) -> List[Cell]:
    """The closed way round the tree: rings about each block, opened and joined at each edge of the tree."""
    joined: Dict[Cell, Set[Cell]] = {}

    def cell(block: Cell, x: int, y: int) -> Cell:
        return offset[0] + 2 * block[0] + x, offset[1] + 2 * block[1] + y

    def change(a: Cell, b: Cell, join: bool) -> None:
        for one, other in ((a, b), (b, a)):
            (joined.setdefault(one, set()).add if join else joined[one].remove)(other)

    for block in blocks:
        ring = [cell(block, 0, 0), cell(block, 1, 0), cell(block, 1, 1), cell(block, 0, 1)]
        for a, b in zip(ring, [*ring[1:], ring[0]]):
            change(a, b, True)
    own = ((start[0] - offset[0]) // 2, (start[1] - offset[1]) // 2)
    root = own if own in blocks else min(blocks, key=lambda block: _apart(cell(block, 0, 0), start))
    for a, b in _tree(blocks, root):
        low, high = min(a, b), max(a, b)
        across = (0, 1) if low[0] != high[0] else (1, 0)
        sides = [(cell(low, *_on(across, i, 1)), cell(high, *_on(across, i, 0))) for i in (0, 1)]
        change(sides[0][0], sides[1][0], False)
        change(sides[0][1], sides[1][1], False)
        for one, other in sides:
            change(one, other, True)
    begin = start if start in joined else min(joined, key=lambda c: (_apart(c, start), c))
    way, before, here = [begin], begin, min(joined[begin])
    while here != begin:
        way.append(here)
        before, here = here, next(other for other in sorted(joined[here]) if other != before)
    return way


def _on(across: Cell, along: int, side: int) -> Cell:
    """Corner of a block: ``along`` the edge that two blocks share, on its ``side``."""
    return (side, along) if across == (0, 1) else (along, side)


def _apart(a: Cell, b: Cell) -> int:
    return abs(a[0] - b[0]) + abs(a[1] - b[1])


def _rest(cells: Set[Cell], done: Set[Cell], here: Cell) -> Tuple[List[Cell], List[Cell]]:
    """Loose cells in the order of always the nearest one, and the way through them."""
    left = cells - done
    loose: List[Cell] = []
    way: List[Cell] = []
    while left:
        path = _nearest(cells, here, left)
        way += path
        for cell in path:
            if cell in left:
                left.remove(cell)
                loose.append(cell)
        here = path[-1]
    return loose, way


def _nearest(cells: Set[Cell], start: Cell, wanted: Set[Cell]) -> List[Cell]:
    """Way from a cell, itself not in it, to the nearest of those wanted."""
    came: Dict[Cell, Cell] = {start: start}
    queue = deque([start])
    while queue:
        here = queue.popleft()
        if here in wanted:
            way = []
            while here != start:
                way.append(here)
                here = came[here]
            return way[::-1]
        for dx, dy in SIDES:
            there = (here[0] + dx, here[1] + dy)
            if there in cells and there not in came:
                came[there] = here
                queue.append(there)
    raise CoverageError(f"no way from {start} to any of {len(wanted)} cells")


def visits(cells: IntArray, shape: Tuple[int, ...]) -> IntArray:
    """How often each cell of a floor (gx, gy) is among cells (n, 2)."""
    counted = np.zeros(shape, dtype=np.int64)
    np.add.at(counted, (cells[:, 0], cells[:, 1]), 1)
    return counted
