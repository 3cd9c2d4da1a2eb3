"""Every reader and every service of every node, told anything that can be sent: none raises, whatever was told before.

The readers are found by what the nodes subscribe to (``support.ears``); ``python3 bench/readers.py`` tells them more.
"""

from __future__ import annotations

import random
import sys
from pathlib import Path
from typing import Any, Callable

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from std_msgs.msg import Int8

from support.ears import NOW_S, Ear, Ears, arrived, sites
from support.listeners import BUILDERS, NAMES

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from random_messages import random_message

TRIES = 50
"""Messages a reader."""


def told_anything(ear: Ear, work: Callable[[], Any]) -> None:
    """Tell one reader so many messages; hypothesis shows the seed of one that raised."""

    @settings(max_examples=TRIES, deadline=None, database=None, derandomize=True, suppress_health_check=HealthCheck)
    @given(st.randoms(use_true_random=True))
    def tell(rng: random.Random) -> None:
        message = arrived(random_message(ear.sent_kind, rng, NAMES, NOW_S))
        try:
            ear.tell(message, work)
        except Exception as error:
            raise AssertionError(f"{ear.topic} ({ear.site}): {error!r} at {message}") from error

    tell()


@pytest.mark.parametrize("name", BUILDERS)
def test_a_node_lives_on_whatever_it_is_told(name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    ears = Ears()
    ears.put_on(monkeypatch)
    work = BUILDERS[name](ears, tmp_path)
    heard = list(ears.heard)
    assert heard, "it listens to nothing"
    for ear in heard:
        told_anything(ear, work)


def test_every_reader_of_the_sources_is_among_them(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    ears = Ears()
    ears.put_on(monkeypatch)
    for build in BUILDERS.values():
        build(ears, tmp_path)
    assert [site for site in sites() if site not in ears.sites] == []


def test_a_callback_that_raises_is_noticed() -> None:
    def fragile(message: Any) -> None:
        assert message.data != 0

    with pytest.raises(AssertionError, match=r"x .*at data: 0"):
        told_anything(Ear(("here", 1), "x", Int8, fragile), lambda: None)
