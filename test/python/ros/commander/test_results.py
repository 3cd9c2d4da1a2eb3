"""In lock-step a map finds every result of the ticks before it."""

from __future__ import annotations

import threading

from yarm.ros.commander.results import ResultCount

SHORT_S = 0.05
"""Long enough to be sure that nothing comes: nobody sends anything."""


def test_nothing_is_waited_for_while_nobody_serves_actions():
    count = ResultCount(SHORT_S)
    count.acknowledged(5.0, 0)
    assert count.take(5.0)


def test_a_result_that_was_sent_is_waited_for_and_its_tick_too():
    count = ResultCount(SHORT_S)
    count.acknowledged(5.0, 1)
    assert not count.take(5.0)
    count.came()
    assert count.take(5.0) and count.take(5.0 + 1 / 60.0)
    assert not count.take(5.0 + 2 / 60.0)
    count.acknowledged(5.0 + 1 / 60.0, 1)
    assert count.take(5.0 + 2 / 60.0)


def test_a_late_result_lets_the_map_go_on():
    count = ResultCount(30.0)
    count.acknowledged(5.0, 1)
    waits = threading.Thread(target=count.came)
    waits.start()
    assert count.take(5.0)
    waits.join()


def test_a_new_run_counts_from_nothing():
    count = ResultCount(SHORT_S)
    count.acknowledged(5.0, 3)
    count.forget()
    assert count.take(0.1)
    count.acknowledged(0.1, 1)
    count.came()
    assert count.take(0.1)
