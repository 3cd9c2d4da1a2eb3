"""Planners by name: the shipped ones, and somebody's own."""

from __future__ import annotations

from pathlib import Path

import pytest

from yarm.planning import registry
from yarm.planning.fleet.yarm_planner import YarmPlanner
from yarm.planning.model.params import PlannerParams
from yarm.planning.registry import PlannerUnavailableError, make_planner

OWN = """
class Own:
    def __init__(self, params):
        self.params = params

    def plan(self, request, rng):
        raise NotImplementedError

    def reset(self):
        pass


class Half:
    def __init__(self, params):
        pass

    def plan(self, request, rng):
        pass


NUMBER = 3
"""


@pytest.fixture(name="module")
def module_fixture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Name of a module with somebody's planners."""
    (tmp_path / "somebodys_planner.py").write_text(OWN, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    return "somebodys_planner"


def test_a_shipped_planner_by_its_name() -> None:
    assert isinstance(make_planner("yarm"), YarmPlanner)


def test_an_own_planner_is_made_with_the_parameters(module: str) -> None:
    planner = make_planner(f"{module}:Own", PlannerParams(particles=42))
    assert type(planner).__name__ == "Own"
    assert planner.params.particles == 42  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("no_such_module:Own", "no_such_module"),
        ("somebodys_planner:Other", "no class 'Other' with the methods plan and reset"),
        ("somebodys_planner:Half", "no class 'Half'"),
        ("somebodys_planner:NUMBER", "no class 'NUMBER'"),
        (":Own", "no class 'Own'"),
    ],
)
def test_what_cannot_be_made_is_named(module: str, name: str, words: str) -> None:
    with pytest.raises(PlannerUnavailableError, match=words):
        make_planner(name)


def test_neither_a_name_nor_a_module_and_class() -> None:
    with pytest.raises(KeyError, match=r"'psychic' is none of yarm, .*, nor module:Class"):
        make_planner("psychic")


def test_a_planner_whose_package_is_missing_is_left_out_and_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(params: PlannerParams) -> YarmPlanner:
        raise ImportError("No module named 'ompl'")

    monkeypatch.setitem(registry._PLANNERS, "ompl_bitstar", missing)
    with pytest.raises(PlannerUnavailableError, match="planner ompl_bitstar cannot be made: No module named"):
        make_planner("ompl_bitstar")
    assert "ompl_bitstar" not in registry.available_planners() and "yarm" in registry.available_planners()
