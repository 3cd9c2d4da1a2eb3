"""Sets of the cells of a volume as one big integer each: a whole map grows, shrinks and is opened in microseconds.

Bit ``((x + margin) * width + y + margin) * height + z + 1`` stands for cell (x, y, z), ``width`` and ``height`` being
those of the volume with what is about it: ``margin`` cells beyond each side and the top, and one layer below the floor.
A shift by one cell therefore never takes a cell of the volume to another one of the volume that is not its neighbour.
"""

from __future__ import annotations

from typing import Any, Iterator, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from yarm.geometry import BoolArray, IntArray

VolumeSet = int
"""A set of cells, one bit for each, as ``Volume`` says."""

Count = Tuple[VolumeSet, VolumeSet, VolumeSet]
"""The cells with at least one, two and three of what is counted."""


class Volume:
    """How the cells of a volume are laid out in a set."""

    def __init__(self, shape: Tuple[int, int, int], margin: int) -> None:
        """For cells (gx, gy, gz), and sets that may reach so many cells (one at least) beyond the sides and the top."""
        self.shape, self.margin = shape, margin
        self._whole = (shape[0] + 2 * margin, shape[1] + 2 * margin, shape[2] + 1 + margin)
        self._size = int(np.prod(self._whole))
        self._steps = (self._whole[1] * self._whole[2], self._whole[2], 1)
        """By so many bits a set is shifted for one cell along x, y, z."""
        numbers = np.arange(self._size).reshape(self._whole)
        self._bits: IntArray = np.ascontiguousarray(self._inner(numbers)).reshape(-1)
        self.field: VolumeSet = self._pack(self._bits)
        sides = np.ones(self._whole, dtype=np.bool_)
        self._inner(sides)[...] = False
        sides[:, :, 0] = False
        self._beside = self._pack(numbers[sides])
        border = np.zeros(shape, dtype=np.bool_)
        border[[0, -1]] = border[:, [0, -1]] = border[:, :, -1] = True
        self.border: VolumeSet = self.of_numbers(np.flatnonzero(border))
        """The cells at the sides and the top."""

    def of_numbers(self, numbers: IntArray) -> VolumeSet:
        """The cells with some numbers (n,), counted in the order of an array (gx, gy, gz)."""
        return self._pack(self._bits[numbers])

    def numbers_of(self, cells: Sequence[IntArray]) -> IntArray:
        """Numbers (m,) of the cells of some arrays (n, 3); those that are not in the volume are left out."""
        x, y, z = np.concatenate([np.empty((0, 3), dtype=np.int64), *cells]).T
        gx, gy, gz = self.shape
        inside = (x >= 0) & (x < gx) & (y >= 0) & (y < gy) & (z >= 0) & (z < gz)
        numbers: IntArray = ((x * gy + y) * gz + z)[inside]
        return numbers

    def image(self, cells: VolumeSet) -> BoolArray:
        """Boolean grid (gx, gy, gz) of a set."""
        if not cells:
            return np.zeros(self.shape, dtype=np.bool_)
        raw = np.frombuffer(cells.to_bytes((self._size + 7) // 8, "little"), dtype=np.uint8)
        bits = np.unpackbits(raw, count=self._size, bitorder="little").view(np.bool_)
        image: BoolArray = bits[self._bits].reshape(self.shape)
        return image

    def grown(self, cells: VolumeSet) -> VolumeSet:
        """Cells of the volume with their 26 neighbours in it."""
        for step in self._steps:
            cells |= cells << step | cells >> step
        return cells & self.field

    def shrunk(self, cells: VolumeSet) -> VolumeSet:
        """Cells all of whose 26 neighbours in the volume are among them."""
        return self.field & ~self.grown(self.field & ~cells)

    def clustered(self, cells: VolumeSet) -> VolumeSet:
        """Cells in groups: one with two more among its 26 neighbours, and those; fewer are noise."""
        if not cells:
            return 0
        count = (cells, 0, 0)
        for step in self._steps:
            count = _sum(_sum(count, _moved(count, step)), _moved(count, -step))
        return cells & self.grown(cells & count[2])

    def opened(self, cells: VolumeSet, sizes: Sequence[int]) -> VolumeSet:
        """Cells that are part of a box of them, so many along x, y, z (``margin`` at most).

        The box may reach out of the volume, but not under the floor. A morphological opening: the box shrinks the cells
        along each axis, then grows them.
        """
        cells |= self._beside
        for step, size in zip(self._steps, sizes):
            for more in _doublings(size):
                cells &= cells >> more * step
        for step, size in zip(self._steps, sizes):
            for more in _doublings(size):
                cells |= cells << more * step
        return cells & self.field

    def _inner(self, whole: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Of an array of everything, what is in the volume."""
        m, (gx, gy, gz) = self.margin, self.shape
        return whole[m : m + gx, m : m + gy, 1 : 1 + gz]

    def _pack(self, bits: IntArray) -> VolumeSet:
        flags = np.zeros(self._size, dtype=np.uint8)
        flags[bits] = 1
        return int.from_bytes(np.packbits(flags, bitorder="little").tobytes(), "little")


def _doublings(length: int) -> Iterator[int]:
    """By how much a set is shifted, and joined to itself, until it was joined to each shift below a length."""
    done = 1
    while done < length:
        more = min(done, length - done)
        yield more
        done += more


def _moved(count: Count, bits: int) -> Count:
    """A count moved up by a number of bits (down when negative)."""
    one, two, three = count
    if bits < 0:
        return one >> -bits, two >> -bits, three >> -bits
    return one << bits, two << bits, three << bits


def _sum(a: Count, b: Count) -> Count:
    """Two counts of different things as one."""
    return a[0] | b[0], a[1] | b[1] | a[0] & b[0], a[2] | b[2] | a[1] & b[0] | a[0] & b[1]
