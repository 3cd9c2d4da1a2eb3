"""Dataclasses become plain values and come back, and whatever is no record of theirs is refused with its place."""

from __future__ import annotations

import contextlib
import json
import math
from dataclasses import dataclass, field
from enum import Enum
from typing import Dict, Optional, Tuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from yarm.records import RecordError, plain, read

settings.register_profile("records", deadline=None, derandomize=True)
settings.load_profile("records")


class Colour(Enum):
    """Something with two values."""

    RED = "red"
    BLUE = "blue"


@dataclass(frozen=True)
class Inner:
    """A record inside another."""

    place: Tuple[int, int]
    colour: Colour = Colour.RED


@dataclass(frozen=True)
class Outer:
    """Every kind of field."""

    name: str
    on: bool
    count: int
    size: float
    maybe: Optional[float] = None
    inner: Tuple[Inner, ...] = ()
    by_name: Dict[str, Inner] = field(default_factory=dict)


INNERS = st.builds(Inner, st.tuples(st.integers(), st.integers()), st.sampled_from(Colour))
OUTERS = st.builds(
    Outer,
    st.text(),
    st.booleans(),
    st.integers(),
    st.floats(allow_nan=False),
    st.none() | st.floats(allow_nan=False),
    st.lists(INNERS, max_size=3).map(tuple),
    st.dictionaries(st.text(), INNERS, max_size=3),
)
GOOD = plain(Outer("a", True, 1, 2.0, None, (Inner((1, 2)),), {"b": Inner((3, 4), Colour.BLUE)}))
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(sorted(GOOD)), inner, max_size=7),
    max_leaves=10,
)


@given(record=OUTERS)
def test_what_is_written_as_json_is_read_back(record):
    assert read(Outer, json.loads(json.dumps(plain(record)))) == record


def test_a_float_that_is_no_number_stays_none():
    assert math.isnan(read(Outer, json.loads(json.dumps(plain(Outer("", True, 0, math.nan))))).size)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("name", 1, "Outer.name = '1': expected str"),
        ("on", 1, "Outer.on = '1': expected bool"),
        ("count", True, "Outer.count = 'True': expected int"),
        ("size", "x", "Outer.size = 'x': expected float"),
        ("inner", {}, "Outer.inner = '{}': expected a list"),
        ("inner", [{"place": [1], "colour": "red"}], "Outer.inner[0].place = '[1]': expected 2 values"),
        (
            "by_name",
            {"b": {"place": [1, 2], "colour": "green"}},
            "Outer.by_name['b'].colour = 'green': expected one of",
        ),
        ("by_name", {"b": {"place": [1, 2]}}, "Outer.by_name['b']: the fields of Inner differ in colour"),
        ("by_name", [], "Outer.by_name = '[]': expected a mapping"),
        ("more", 1, "Outer: the fields of Outer differ in more"),
    ],
)
def test_a_wrong_value_is_refused_with_its_place(key, value, words):
    with pytest.raises(RecordError) as error:
        read(Outer, {**GOOD, key: value})
    assert words in str(error.value)


@given(value=JSON)
def test_anything_else_is_refused_and_never_crashes(value):
    with pytest.raises(RecordError):
        read(Outer, value)


@given(key=st.sampled_from(sorted(GOOD)), value=JSON)
def test_one_field_of_anything_is_a_record_or_is_refused(key, value):
    with contextlib.suppress(RecordError):
        assert isinstance(read(Outer, {**GOOD, key: value}), Outer)
