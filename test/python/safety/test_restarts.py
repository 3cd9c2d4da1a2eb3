"""When a program that has died is started again, and when not."""

from __future__ import annotations

from yarm.safety.restarts import LIMIT, LONGEST_DELAY_S, SETTLED_S, STARTED_S, WITHIN_S, Restarts

KILLED = -9


def test_pauses_grow_to_a_greatest_one():
    restarts = Restarts()
    delays = [restarts.died(KILLED, float(i), float(i) + 0.1).delay_s for i in range(LIMIT - 1)]
    assert delays == [0.1, 0.2, 0.4, 0.8, 1.6, 1.6, 1.6]
    assert max(delays) == LONGEST_DELAY_S
    assert restarts.count == LIMIT - 1
    assert restarts.last == "killed by SIGKILL"


def test_too_many_deaths_within_a_while_end_it_with_a_reason():
    restarts = Restarts()
    for i in range(LIMIT - 1):
        assert restarts.died(KILLED, 0.0, float(i)).again
    verdict = restarts.died(KILLED, 0.0, float(LIMIT))
    assert not verdict.again
    assert f"{LIMIT} times within {WITHIN_S:g} s" in verdict.reason
    assert "SIGKILL" in verdict.reason


def test_deaths_far_apart_never_end_it_and_begin_with_the_first_pause():
    restarts = Restarts()
    for i in range(10 * LIMIT):
        now_s = i * (SETTLED_S + 1.0)
        verdict = restarts.died(KILLED, now_s - SETTLED_S, now_s)
        assert verdict.again
        assert verdict.delay_s == 0.1


def test_who_ends_in_good_order_stays_away():
    assert not Restarts().died(0, 0.0, 100.0).again


def test_who_refuses_its_parameters_is_not_asked_again():
    verdict = Restarts().died(1, 0.0, STARTED_S - 1.0)
    assert not verdict.again
    assert "refuses to run" in verdict.reason


def test_who_has_run_before_is_tried_again_whatever_its_exit_code():
    restarts = Restarts()
    assert restarts.died(1, 0.0, STARTED_S + 1.0).again
    assert restarts.died(1, 10.0, 10.5).again


def test_an_exit_code_that_is_a_verdict_is_no_death():
    restarts = Restarts(verdict=True)
    assert not restarts.died(1, 0.0, STARTED_S + 1.0).again
    assert restarts.died(KILLED, 0.0, STARTED_S + 1.0).again


def test_who_is_killed_at_its_start_is_tried_again():
    assert Restarts().died(KILLED, 0.0, 0.1).again
