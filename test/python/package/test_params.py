"""Parameters are refused all at once, by name, value and what is allowed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

import pytest

from yarm.params import ParamError, build, infos, param


@dataclass(frozen=True)
class DemoParams:
    """Parameters for the tests below."""

    cap_mps: float = param(1.0, "m/s", "largest speed", low=0.1, high=5.0)
    rounds: int = param(500, "", "most rounds", low=1)
    kind: str = param("yarm", "", "planner", choices=("yarm", "original"))
    turns_deg: Tuple[float, ...] = param((0.0, 90.0), "deg", "allowed turns", low=-180, high=180)
    sync: bool = param(False, "", "lock-step")


def test_defaults_and_values():
    params = build(DemoParams, {"cap_mps": 2, "turns_deg": [45, -45.0]})
    assert params == DemoParams(cap_mps=2.0, turns_deg=(45.0, -45.0))
    assert [name for name, _, _ in infos(DemoParams)] == ["cap_mps", "rounds", "kind", "turns_deg", "sync"]


def test_every_fault_is_listed_with_value_and_allowed():
    with pytest.raises(ParamError) as error:
        build(
            DemoParams,
            {"cap": 1.0, "cap_mps": 9.0, "rounds": 1.5, "kind": "x", "turns_deg": [200.0], "sync": 1},
            "node",
        )
    text = str(error.value)
    for expected in (
        "node:",
        "cap: unknown parameter",
        "cap_mps = 9.0: must be finite and within 0.1 to 5 m/s",
        "rounds = 1.5: must be of type int",
        "kind = 'x': must be one of 'yarm', 'original'",
        "turns_deg = [200.0]",
        "sync = 1: must be of type bool",
    ):
        assert expected in text


@dataclass(frozen=True)
class SwitchParams:
    """One that has more than two settings."""

    check: str = param("true", "", "what to check", choices=("true", "false", "report"))


@pytest.mark.parametrize(("value", "read"), [(True, "true"), (False, "false"), ("true", "true"), ("report", "report")])
def test_a_plain_true_or_false_is_a_choice_of_that_name(value, read):
    assert build(SwitchParams, {"check": value}).check == read


def test_a_bool_is_no_choice_where_none_has_its_name():
    with pytest.raises(ParamError, match="kind = True: must be of type str"):
        build(DemoParams, {"kind": True})


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_not_finite_is_refused(value):
    with pytest.raises(ParamError, match="finite"):
        build(DemoParams, {"cap_mps": value})


def test_a_string_may_have_a_form_besides_the_choices():
    @dataclass(frozen=True)
    class FormParams:
        planner: str = param("yarm", "", "planner", choices=("yarm",), form="module:Class")

    for good in ("yarm", "my_cell.wavefront:Wavefront", "wavefront:Wavefront"):
        assert build(FormParams, {"planner": good}).planner == good
    for bad in ("best", "my_cell.:Wavefront", "my cell:Wavefront", "a:b:c", "a:", ":b", "a:b()"):
        with pytest.raises(ParamError, match="must be one of 'yarm', or module:Class"):
            build(FormParams, {"planner": bad})
