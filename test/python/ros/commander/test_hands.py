"""What hands say counts for the map of its own time, whichever comes first."""

from __future__ import annotations

import threading
from typing import List, Tuple

from yarm.commander.events import Grasp
from yarm.ros.commander.hands import HandWords


def words(limit_s: float = 0.0) -> Tuple[HandWords, List[Grasp]]:
    handed: List[Grasp] = []
    return HandWords(handed.append, limit_s), handed


def test_a_word_of_a_later_tick_waits_for_the_map_of_its_time() -> None:
    hands, handed = words()
    hands.say(1.0, Grasp("a", False))
    hands.say(1.0167, Grasp("a", True))
    hands.say(1.0333, Grasp("a", True))
    assert hands.take(1.0)
    assert handed == [Grasp("a", False)]
    assert hands.take(1.0333)
    assert handed == [Grasp("a", False), Grasp("a", True)]


def test_a_map_waits_for_every_hand_that_ever_spoke() -> None:
    hands, handed = words(60.0)
    hands.say(1.0, Grasp("a", False))
    hands.say(1.1, Grasp("b", True))
    speaker = threading.Thread(target=hands.say, args=(1.1, Grasp("a", True)))
    speaker.start()
    assert hands.take(1.1)
    speaker.join()
    assert sorted(handed, key=str) == [Grasp("a", False), Grasp("a", True), Grasp("b", True)]


def test_a_hand_that_is_silent_is_told_of_and_one_that_is_gone_not_waited_for() -> None:
    hands, handed = words()
    hands.say(1.0, Grasp("a", True))
    assert not hands.take(1.1)
    assert handed == [Grasp("a", True)]
    hands.follow(["b"])
    assert hands.take(1.2)
    hands.forget()
    hands.say(0.1, Grasp("a", True))
    assert hands.take(0.1)
    assert len(handed) == 2
