"""Reading YAML: what costs too much, or is no plain value, is refused with a sentence; every fault is listed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from yarm.yaml_fields import (
    DEEPEST,
    MOST_BYTES,
    MOST_FAULTS,
    MOST_TEXT,
    Faults,
    Fields,
    SceneError,
    load_yaml,
    parse_yaml,
)

settings.register_profile("yaml", deadline=None, derandomize=True)
settings.load_profile("yaml")

PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers(-(10**50), 10**50) | st.floats(allow_nan=False) | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text(max_size=5), inner, max_size=5),
    max_leaves=20,
)
BOMB = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 20)
)


def fields(raw: Any) -> Fields:
    return Fields(raw, "", Faults("file.yaml"))


@given(PLAIN)
def test_plain_values_are_read_as_yaml_itself_reads_them(value: Any) -> None:
    text = yaml.safe_dump(value)
    assert parse_yaml(text) == yaml.safe_load(text)


@settings(max_examples=500)
@given(st.text(alphabet="ab01-+._:, \n[]{}&*!?|>'\"#%@`~=<x\t", max_size=60))
def test_any_text_is_read_or_refused(text: str) -> None:
    try:
        parse_yaml(text)
    except SceneError as error:
        assert str(error)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (BOMB, "more than 60000 values, counting what is repeated by aliases"),
        ("[" * 100_000, f"nested deeper than {DEEPEST}"),
        ("a: " * (DEEPEST + 1), "mapping values are not allowed here"),
        ("x: " + "9" * 1000, "a number of 1000 characters"),
        ("x: " + "[1]," * 3, "expected"),
        ("- &a [1, *a]", "line 1: *a stands inside what it repeats"),
        ("a: !!python/object/apply:os.system [ls]", "the tag tag:yaml.org,2002:python/object/apply:os.system"),
        ("a: !!float abc", "the tag tag:yaml.org,2002:float"),
        ("? [1, 2]\n: 3", "a key must be a word"),
        ("a: 1\na: 2", "line 2: key 'a' given twice"),
        ("a: 1\n---\nb: 2", "single document"),
        ("a: 2001-99-99", "month"),
        ("a: 0b_", "invalid literal"),
        ("a: \x07", "special characters are not allowed"),
    ],
)
def test_what_is_refused(text: str, words: str) -> None:
    with pytest.raises(SceneError) as raised:
        parse_yaml(text)
    assert words in str(raised.value)


def test_an_alias_that_repeats_little_is_read() -> None:
    assert parse_yaml("a: &size [1, 2]\nb: *size") == {"a": [1, 2], "b": [1, 2]}


def test_files_that_are_refused_before_they_are_parsed(tmp_path: Path) -> None:
    large = tmp_path / "large.yaml"
    large.write_text("# " + "x" * MOST_BYTES)
    with pytest.raises(SceneError, match=rf"large.yaml: is {MOST_BYTES + 2} bytes; a scene has at most {MOST_BYTES}"):
        load_yaml(large)
    with pytest.raises(SceneError, match="no such file"):
        load_yaml(tmp_path)
    binary = tmp_path / "binary.yaml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(SceneError, match=r"binary\.yaml: not readable as YAML"):
        load_yaml(binary)


@pytest.mark.parametrize("value", [None, "1", True, float("nan"), float("inf"), 10**400, -1, [1]])
def test_a_number_that_is_none(value: Any) -> None:
    read = fields({"x": value})
    read.number("x", 0.0, 5.0, "m")
    with pytest.raises(SceneError, match=r"file.yaml: x = .*: expected a number within 0 to 5 m"):
        read.faults.raise_if_any()


def test_a_missing_key_is_said_once() -> None:
    read = fields({})
    assert read.section("grid").wholes("shape", 3, 1, 9) is None
    with pytest.raises(SceneError) as raised:
        read.faults.raise_if_any()
    assert str(raised.value) == "file.yaml: grid is missing: expected a mapping of keys to values"


def test_rows_keep_the_good_and_name_the_bad() -> None:
    read = fields({"boxes": [[1, 2.0], [1], [1, 2.5], "12", [1, 99]]})
    assert read.rows("boxes", 2, 0, 9, 10) == [("boxes[0]", (1, 2))]
    with pytest.raises(SceneError) as raised:
        read.faults.raise_if_any()
    assert [line.split(" = ")[0] for line in str(raised.value).splitlines()] == [
        f"file.yaml: boxes[{i}]" for i in (1, 2, 3, 4)
    ]


def test_lists_and_texts_have_a_longest_length() -> None:
    read = fields({"robots": [{}] * 6, "name": "n" * (MOST_TEXT + 1), "about": "a" * MOST_TEXT})
    assert read.entries("robots", 5) == []
    assert read.text("name") == "" and len(read.text("about")) == MOST_TEXT
    with pytest.raises(SceneError) as raised:
        read.faults.raise_if_any()
    assert "robots = '6 entries': expected at most 5" in str(raised.value)
    assert f"expected at most {MOST_TEXT} characters, not {MOST_TEXT + 1}" in str(raised.value)


def test_a_thousand_faults_are_counted_and_a_long_value_is_cut() -> None:
    read = fields({"boxes": ["x" * 500] * 1000})
    read.rows("boxes", 2, 0, 9, 1000)
    with pytest.raises(SceneError) as raised:
        read.faults.raise_if_any()
    lines = str(raised.value).splitlines()
    assert len(lines) == MOST_FAULTS + 1 and lines[-1] == f"file.yaml: and {1000 - MOST_FAULTS} faults more"
    assert max(map(len, lines)) < 250


def test_optional_keys_are_no_unknown_ones() -> None:
    read = fields({"a": 1, "b": 2, "c": 3})
    read.number("a", 0.0, 9.0, "")
    read.finish("b")
    with pytest.raises(SceneError, match=r"file.yaml: c = 3: expected no such key; known: a, b"):
        read.faults.raise_if_any()
