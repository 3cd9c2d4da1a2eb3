"""Fields of a mapping: every fault is gathered with file, key, value and what was expected."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Callable, Dict

import pytest

from yarm.yaml_fields import Faults, Fields, SceneError, load_yaml


def fields(**raw: Any) -> Fields:
    return Fields(raw, "robot", Faults("cell.yaml"))


Read = Callable[[Fields], Any]


@pytest.mark.parametrize(
    ("raw", "read", "value"),
    [
        ({"a": 1}, lambda f: f.number("a", 0.0, 2.0, "m"), 1.0),
        ({}, lambda f: f.number("a", 0.0, 2.0, "m", 1.5), 1.5),
        ({"a": 3}, lambda f: f.whole("a", 0, 5, 1), 3),
        ({"a": False}, lambda f: f.flag("a", default=True), False),
        ({}, lambda f: f.flag("a", default=True), True),
        ({"a": "x"}, lambda f: f.text("a"), "x"),
        ({"a": "x"}, lambda f: f.text("a", choices=("x", "y")), "x"),
        ({"a": [1, 2.5]}, lambda f: f.numbers("a", 2, 0.0, 3.0), (1.0, 2.5)),
        ({}, lambda f: f.entries("a"), []),
    ],
)
def test_good_values_are_read(raw: Dict[str, Any], read: Read, value: object) -> None:
    given = fields(**raw)
    assert read(given) == value
    given.finish()
    assert given.faults.lines == []


@pytest.mark.parametrize(
    ("raw", "read", "words"),
    [
        ({"a": "1"}, lambda f: f.number("a", 0.0, 2.0, "m"), ["robot.a", "'1'", "a number within 0 to 2 m"]),
        ({"a": True}, lambda f: f.number("a", 0.0, 2.0, "m"), ["True", "a number"]),
        ({"a": float("nan")}, lambda f: f.number("a", 0.0, 2.0, "m"), ["nan"]),
        ({"a": 2.1}, lambda f: f.number("a", 0.0, 2.0, "m"), ["2.1", "0 to 2"]),
        ({}, lambda f: f.number("a", 0.0, 2.0, "m"), ["robot.a is missing"]),
        ({"a": 1.0}, lambda f: f.whole("a", 0, 5, 1), ["1.0", "a whole number within 0 to 5"]),
        ({"a": True}, lambda f: f.whole("a", 0, 5, 1), ["True"]),
        ({"a": "yes"}, lambda f: f.flag("a"), ["'yes'", "true or false"]),
        ({"a": None}, lambda f: f.flag("a", default=True), ["None", "true or false"]),
        ({"a": ""}, lambda f: f.text("a"), ["''", "a text"]),
        ({"a": "z"}, lambda f: f.text("a", choices=("x", "y")), ["'z'", "one of x, y"]),
        ({}, lambda f: f.text("a"), ["robot.a is missing"]),
        ({"a": [1]}, lambda f: f.numbers("a", 2, 0.0, 3.0), ["[1]", "a list of 2 numbers within 0 to 3"]),
        ({"a": [1, 9]}, lambda f: f.numbers("a", 2, 0.0, 3.0), ["[1, 9]"]),
        ({"a": {}}, lambda f: f.entries("a"), ["a list"]),
        ({"a": [3]}, lambda f: f.entries("a"), ["robot.a[0]", "a mapping of keys to values"]),
        ({"a": 3}, lambda f: f.section("a"), ["robot.a", "a mapping"]),
        ({"b": 3, "a": 1}, lambda f: f.number("a", 0.0, 2.0, "m"), ["robot.b", "no such key; known: a"]),
    ],
)
def test_a_fault_names_file_key_value_and_what_was_expected(raw: Dict[str, Any], read: Read, words: list) -> None:
    given = fields(**raw)
    read(given)
    given.finish()
    with pytest.raises(SceneError) as error:
        given.faults.raise_if_any()
    for word in ["cell.yaml", *words]:
        assert word in str(error.value)


def test_all_faults_are_told_at_once() -> None:
    given = fields(a="x", b="y", c=1)
    given.number("a", 0.0, 1.0, "m")
    given.flag("b")
    given.finish()
    assert len(given.faults.lines) == 3


def test_a_key_given_twice_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "twice.yaml"
    file.write_text("x: 1\nrobots:\n  - {name: a, name: b}\n")
    with pytest.raises(SceneError, match="line 3: key 'name' given twice"):
        load_yaml(file)


def test_files_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"nothing\.yaml: no such file"):
        load_yaml(tmp_path / "nothing.yaml")
    (tmp_path / "bad.yaml").write_text("a: [1,")
    with pytest.raises(SceneError, match=r"bad\.yaml: not readable as YAML"):
        load_yaml(tmp_path / "bad.yaml")
