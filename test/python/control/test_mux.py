"""Who drives: priority, silence, a clock that starts again."""

from __future__ import annotations

from typing import List, Optional

import pytest

from yarm.control.mux import Mux, MuxParams, mux_inputs
from yarm.params import ParamError, build


@pytest.fixture
def mux() -> Mux:
    return Mux(mux_inputs(MuxParams()))


def test_the_platforms_inputs() -> None:
    assert [(item.name, item.priority, item.timeout_s) for item in mux_inputs(MuxParams())] == [
        ("safety_controller", 10, 0.2), ("teleop", 7, 1.0), ("navi", 5, 1.0)
    ]  # fmt: skip


def test_one_source_alone_goes_through(mux: Mux) -> None:
    assert mux.active is None
    assert all(mux.take("navi", 0.1 * i) for i in range(50))
    assert mux.active == "navi"


def test_a_higher_source_takes_over_at_once_and_a_lower_one_waits_for_its_silence(mux: Mux) -> None:
    told: List[Optional[str]] = []
    for now_s, name, through in (
        (0.0, "navi", True), (0.1, "teleop", True), (0.2, "navi", False), (0.3, "safety_controller", True),
        (0.4, "teleop", False), (0.51, "navi", True), (0.52, "teleop", True), (1.52, "navi", False),
        (1.53, "navi", True),
    ):  # fmt: skip
        assert mux.take(name, now_s) is through, (now_s, name)
        told.append(mux.active)
    assert told[-2:] == ["teleop", "navi"]


def test_silence_of_all_is_idle(mux: Mux) -> None:
    mux.take("safety_controller", 1.0)
    mux.expire(1.2)
    assert mux.active == "safety_controller"
    mux.expire(1.21)
    assert mux.active is None


def test_a_clock_that_starts_again_frees_the_way(mux: Mux) -> None:
    mux.take("teleop", 100.0)
    assert mux.take("navi", 0.5)
    assert mux.active == "navi"


def test_lists_that_do_not_fit_are_refused_all_at_once() -> None:
    params = build(MuxParams, {"inputs": ["a", "a"], "priorities": [3, 3], "timeouts": [1.0]})
    with pytest.raises(ParamError) as refused:
        mux_inputs(params)
    for words in ("inputs has 2", "timeouts has 1", "inputs = ['a', 'a']", "priorities = [3, 3]"):
        assert words in str(refused.value)
    with pytest.raises(ParamError, match="at least one"):
        mux_inputs(MuxParams((), (), ()))
