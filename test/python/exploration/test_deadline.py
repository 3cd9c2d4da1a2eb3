"""The end of the time: braking so as to rest, and the gate that every command passes."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from yarm.exploration.deadline import (
    BRAKE_MPS2,
    COMMAND_AGE_S,
    LEASE_AGE_S,
    SETTLE_S,
    Gate,
    Lease,
    Passed,
    faded,
)
from yarm.exploration.model import LOOP_S, Command

FAST = Command(0.3, 0.8)
DEADLINE_S = 900.0


def lease(stamp_s, moving=True, started_s=0.0, deadline_s=DEADLINE_S):
    return Lease(stamp_s, started_s, deadline_s, moving)


def opened(now_s, command=FAST):
    gate = Gate()
    assert gate.hear(lease(now_s), now_s)
    gate.want(command, now_s)
    return gate


def test_far_from_the_deadline_nothing_changes():
    assert faded(FAST, 100.0, DEADLINE_S) == FAST
    assert faded(FAST, 1e6, math.inf) == FAST


@given(st.floats(-0.7, 0.7), st.floats(-3.2, 3.2), st.floats(0.0, 0.1))
def test_the_base_hears_zeros_in_time_and_never_brakes_harder(v, w, phase_s):
    """Passes of the loop at any phase against the deadline; each command is held until the next."""
    now_s, last = DEADLINE_S - 5.0 + phase_s, Command(v, w)
    while now_s < DEADLINE_S + 1.0:
        command = faded(Command(v, w), now_s, DEADLINE_S)
        assert abs(last.v_mps) - abs(command.v_mps) <= BRAKE_MPS2 * LOOP_S + 1e-9
        assert command.v_mps * v >= 0.0 and command.w_radps * w >= 0.0
        if now_s >= DEADLINE_S - SETTLE_S - LOOP_S:
            assert command == Command()
        now_s, last = now_s + LOOP_S, command


def test_a_person_stops_it_over_every_lease_and_reset_until_the_release():
    gate = opened(1.0)
    gate.stop("stopped by somebody")
    for at_s in (1.0, 1.2):
        gate.hear(lease(at_s), at_s)
        gate.want(FAST, at_s)
        assert gate.step(at_s) == Passed(Command(), "stands: stopped by somebody")
    gate.reset()
    gate.hear(lease(0.5), 0.5)
    gate.want(FAST, 0.5)
    assert gate.step(0.5).command == Command()
    gate.stop("")
    assert gate.step(0.5) == Passed(FAST)


def test_the_time_runs_out_while_a_person_holds_it():
    gate = opened(DEADLINE_S)
    gate.stop("stopped by somebody")
    assert "stopped by somebody" in gate.step(DEADLINE_S).reason
    gate.stop("")
    assert "the time is over" in gate.step(DEADLINE_S).reason


def test_a_gate_that_hears_nobody_is_closed():
    gate = Gate()
    gate.want(FAST, 1.0)
    passed = gate.step(1.0)
    assert passed.command == Command()
    assert "nothing heard from the explorer yet" in passed.reason


def test_a_granted_command_passes_unchanged():
    passed = opened(1.0).step(1.0)
    assert passed.command == FAST
    assert passed.reason == ""


def test_a_dead_explorer_means_zero_though_commands_still_come():
    gate = opened(1.0)
    late_s = 1.0 + LEASE_AGE_S + 0.01
    gate.want(FAST, late_s)
    passed = gate.step(late_s)
    assert passed.command == Command()
    assert "nothing heard from the explorer for 0.3 s" in passed.reason
    gate.hear(lease(late_s), late_s)
    assert gate.step(late_s).command == FAST


def test_an_old_command_means_zero():
    gate = opened(1.0)
    late_s = 1.0 + COMMAND_AGE_S + 0.01
    gate.hear(lease(late_s), late_s)
    assert gate.step(late_s).command == Command()
    assert "no command" in gate.step(late_s).reason


def test_who_is_not_exploring_is_not_moved():
    gate = opened(1.0)
    gate.hear(lease(1.1, moving=False), 1.1)
    gate.want(FAST, 1.1)
    assert gate.step(1.1).command == Command()
    assert "not exploring" in gate.step(1.1).reason


def test_after_the_deadline_nothing_opens_it_again():
    gate = opened(DEADLINE_S - SETTLE_S)
    assert "the time is over" in gate.step(DEADLINE_S - SETTLE_S).reason
    for later_s in (DEADLINE_S, DEADLINE_S + 10.0):
        gate.hear(lease(later_s, started_s=later_s, deadline_s=later_s + 900.0), later_s)
        gate.want(FAST, later_s)
        assert gate.step(later_s).command == Command()


def test_a_run_that_ended_early_may_be_followed_by_another():
    gate = opened(1.0)
    gate.hear(lease(300.0, started_s=300.0, deadline_s=1200.0), 300.0)
    gate.want(FAST, 300.0)
    assert gate.step(300.0).command == FAST


def test_an_explorer_cannot_put_off_its_own_deadline():
    gate = opened(1.0)
    now_s = DEADLINE_S - SETTLE_S
    gate.hear(lease(now_s, deadline_s=2000.0), now_s)
    gate.want(FAST, now_s)
    assert gate.step(now_s).command == Command()


@pytest.mark.parametrize("stamp_s", [2.0, math.inf, math.nan])
def test_a_lease_from_the_future_opens_nothing(stamp_s):
    gate = Gate()
    assert not gate.hear(lease(stamp_s), 1.0)
    gate.want(FAST, 1.0)
    assert gate.step(1.0).command == Command()


def test_an_older_lease_does_not_replace_a_newer_one():
    gate = opened(1.0)
    assert gate.hear(lease(0.9, moving=False), 1.0)
    assert gate.step(1.0).command == FAST


@pytest.mark.parametrize("command", [Command(math.nan, 0.0), Command(0.1, math.inf)])
def test_a_command_that_is_no_number_is_zero(command):
    assert opened(1.0, command).step(1.0).command == Command()


def test_near_the_end_it_brakes_and_says_so():
    now_s = DEADLINE_S - SETTLE_S - 0.3
    passed = opened(now_s).step(now_s)
    assert 0.0 < passed.command.v_mps < FAST.v_mps
    assert "brakes" in passed.reason


def test_what_the_explorer_has_faded_itself_passes_unchanged():
    now_s = DEADLINE_S - SETTLE_S - 0.4
    command = faded(FAST, now_s, DEADLINE_S)
    assert opened(now_s, command).step(now_s + 0.01).command == command


def test_time_going_backwards_closes_it_until_the_explorer_is_heard_again():
    gate = opened(DEADLINE_S)
    gate.step(DEADLINE_S)
    gate.reset()
    gate.want(FAST, 1.0)
    assert "nothing heard" in gate.step(1.0).reason
    gate.hear(lease(1.0), 1.0)
    assert gate.step(1.0).command == FAST
