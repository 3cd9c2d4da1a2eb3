"""When pictures are made, by a clock and a sleep of the test's own."""

from __future__ import annotations

import asyncio
from typing import List

import pytest

from yarm.console import pages
from yarm.console.film import Film
from yarm.console.pages import Filming, Pages


class Clock:
    """Seconds that pass only by sleeping and by work."""

    def __init__(self) -> None:
        self.now_s = 100.0

    def monotonic(self) -> float:
        return self.now_s


class SlowView:
    """Takes its time for each picture, and ends the loop after some."""

    def __init__(self, clock: Clock, takes_s: List[float]) -> None:
        self._clock, self._takes_s = clock, takes_s
        self.made_at: List[float] = []

    def now_s(self) -> float:
        return self._clock.now_s

    def parts(self) -> dict:
        return {}

    def state(self) -> bytes:
        if len(self.made_at) == len(self._takes_s):
            raise asyncio.CancelledError
        self.made_at.append(self._clock.now_s)
        self._clock.now_s += self._takes_s[len(self.made_at) - 1]
        return b"{}"


class KeptFilm(Film):
    """Remembers when pictures came."""

    def __init__(self) -> None:
        self.times: List[float] = []

    def add(self, time_s: float, parts: object, state: bytes) -> None:
        self.times.append(time_s)


def made(takes_s: List[float], film_period_s: float, monkeypatch: pytest.MonkeyPatch, late_s: float = 0.0):
    """When pictures were begun and which of them were filmed, s from the start."""
    clock = Clock()
    view, film = SlowView(clock, takes_s), KeptFilm()

    async def sleep(seconds: float) -> None:
        jitter = late_s if len(view.made_at) % 2 else 0.0
        clock.now_s += max(0.0, seconds) + jitter

    monkeypatch.setattr(pages.time, "monotonic", clock.monotonic)
    monkeypatch.setattr(pages.asyncio, "sleep", sleep)
    kept = Pages(view, 10.0, print, Filming(film, film_period_s))
    kept._open.append(pages.Page(None))  # type: ignore[arg-type] (nobody sends)
    with pytest.raises(asyncio.CancelledError):
        asyncio.run(kept.run())
    return [at - 100.0 for at in view.made_at], [at - 100.0 for at in film.times]


def test_pictures_keep_their_rate_whatever_each_takes(monkeypatch: pytest.MonkeyPatch) -> None:
    begun, filmed = made([0.06, 0.01, 0.08, 0.02, 0.0], 0.1, monkeypatch)
    assert begun == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5])
    assert filmed == pytest.approx(begun)


def test_a_picture_that_takes_too_long_leaves_time_for_everything_else(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    begun, _ = made([0.3, 0.3, 0.01, 0.01], 0.1, monkeypatch)
    assert begun == pytest.approx([0.1, 0.42, 0.74, 0.84])


def test_a_film_at_the_rate_of_the_pictures_has_each_though_they_come_a_little_late(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    begun, filmed = made([0.01] * 20, 0.1, monkeypatch, late_s=0.004)
    assert filmed == pytest.approx(begun)
    _, every_other = made([0.01] * 20, 0.2, monkeypatch, late_s=0.004)
    assert [b - a for a, b in zip(every_other[1:], every_other[2:])] == pytest.approx([0.2] * 9)
