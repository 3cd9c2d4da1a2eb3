"""Scripts are carried out step by step: computations, motions with an end of their own or not, waits."""

from __future__ import annotations

from typing import Any, Callable, List

import numpy as np
import pytest

from yarm.control.arm.errors import ArmError
from yarm.control.arm.motion import ArmMotion
from yarm.control.sander.follower import MotionFollower
from yarm.control.sander.runner import ScriptRunner
from yarm.control.sander.steps import Compute, DoneJob, Follow, Script, Wait

TICK_S = 0.05


def line() -> ArmMotion:
    """A second on all joints from 0 to 1 rad, the tip a metre."""
    times = np.linspace(0.0, 1.0, 11)
    return ArmMotion(times, np.outer(times, np.ones(6)), times)


class Late:
    """A computation that is done when the test says so."""

    ready = False

    def __init__(self, function: Callable[[], Any]) -> None:
        self._function = function

    def done(self) -> bool:
        return self.ready

    def result(self) -> Any:
        return self._function()


class Bench:
    """A runner and an arm that is where its motion is."""

    def __init__(self, run_job: Callable[[Callable[[], Any]], Any] = DoneJob) -> None:
        self.follower = MotionFollower(0.15)
        self.runner = ScriptRunner(self.follower, run_job)
        self.q = np.zeros(6)
        self.now_s = 0.0
        self.sent: List[ArmMotion] = []
        self._since_s = 0.0

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / TICK_S)):
            self.now_s += TICK_S
            if self.sent:
                self.q = self.sent[-1].at(self.now_s - self._since_s)
            self.runner.advance(self.q, self.now_s)
            new = self.follower.take()
            if new:
                self.sent += new
                self._since_s = self.now_s


def test_results_are_sent_back_in_order() -> None:
    got: List[object] = []

    def script() -> Script:
        got.append((yield Compute(lambda: 42)))
        got.append((yield Follow(line())))
        yield Wait(lambda: len(got) == 2)
        got.append("end")

    bench = Bench()
    bench.runner.begin(script())
    bench.run(0.5)
    assert got == [42]
    assert bench.runner.moving
    bench.run(1.0)
    assert got == [42, True, "end"]
    assert bench.runner.idle
    assert not bench.runner.moving


def test_a_motion_that_is_cut_short_sends_back_false_and_notes_the_way_while_it_brakes() -> None:
    got: List[bool] = []
    noted: List[float] = []

    def script() -> Script:
        got.append((yield Follow(line(), until=lambda: bool(noted) and noted[-1] > 0.4, note=noted.append)))

    bench = Bench()
    bench.runner.begin(script())
    bench.run(2.0)
    assert got == [False]
    assert len(bench.sent) == 2
    assert noted == sorted(noted)
    assert 0.45 < noted[-1] < 0.6


def test_a_wait_holds_until_it_is_true() -> None:
    free: List[bool] = []
    done: List[bool] = []

    def script() -> Script:
        yield Wait(lambda: bool(free))
        done.append(True)

    bench = Bench()
    bench.runner.begin(script())
    bench.run(1.0)
    assert not done
    free.append(True)
    bench.run(TICK_S)
    assert done == [True]


def test_nothing_moves_before_a_computation_is_done() -> None:
    def script() -> Script:
        yield Follow((yield Compute(line)))

    Late.ready = False
    bench = Bench(Late)
    bench.runner.begin(script())
    bench.run(1.0)
    assert bench.sent == []
    assert bench.runner.moving
    Late.ready = True
    bench.run(TICK_S)
    assert len(bench.sent) == 1


def test_a_new_script_begins_when_the_old_motion_is_at_rest() -> None:
    log: List[str] = []

    def first() -> Script:
        yield Follow(line())
        log.append("first")

    def second() -> Script:
        log.append("second")
        yield Wait(lambda: False)

    bench = Bench()
    bench.runner.begin(first())
    bench.run(0.3)
    bench.runner.begin(second())
    bench.run(0.3)
    assert log == []
    bench.run(1.0)
    assert log == ["second"]


def test_a_failing_computation_is_raised_to_whoever_runs_it() -> None:
    def fail() -> None:
        raise ArmError("no way")

    def script() -> Script:
        yield Compute(fail)

    bench = Bench()
    bench.runner.begin(script())
    with pytest.raises(ArmError, match="no way"):
        bench.run(TICK_S)
    assert not bench.runner.idle
    bench.runner.drop()
    bench.run(TICK_S)
    assert bench.runner.idle


def test_a_script_that_never_waits_is_a_fault() -> None:
    def script() -> Script:
        while True:
            yield Wait(lambda: True)

    bench = Bench()
    bench.runner.begin(script())
    with pytest.raises(RuntimeError, match="without ever waiting"):
        bench.run(TICK_S)
