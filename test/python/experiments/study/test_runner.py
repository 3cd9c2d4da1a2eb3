"""What a trial leaves behind in its worker: nothing."""

from __future__ import annotations

import gc
import weakref
from typing import Iterator, List

import psutil
import pytest

from yarm.experiments.study.runner import attempt

PIECES, PIECE = 100_000, 2_000
"""So many pieces of so many bytes each, too small for pages of their own."""


class Knot:
    """Holds itself."""

    def __init__(self) -> None:
        self.me = self


@pytest.fixture
def no_collector() -> Iterator[None]:
    gc.disable()
    yield
    gc.enable()


@pytest.mark.usefixtures("no_collector")
def test_circles_of_references_are_freed_after_a_trial_even_when_it_fails() -> None:
    made: List[weakref.ref[Knot]] = []

    def run(fails: bool) -> int:
        made.append(weakref.ref(Knot()))
        if fails:
            raise ValueError("as asked")
        return 3

    assert attempt(run, False) == 3 and made[0]() is None
    assert isinstance(attempt(run, True), ValueError) and made[1]() is None


def test_freed_memory_goes_back_to_the_machine() -> None:
    """The last piece stays in use, so that what lies below it is not at the heap's end."""

    def run(_: int) -> bytes:
        pieces = [bytes(PIECE) for _ in range(PIECES)]
        return pieces[-1]

    process = psutil.Process()
    before = process.memory_info().rss
    last = attempt(run, 0)
    grown = process.memory_info().rss - before
    assert len(last) == PIECE
    assert grown < 0.5 * PIECES * PIECE, f"{grown / 1e6:.0f} MB more"
