"""What goes to a page, there and back, and what is refused."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from yarm.console.limits import Bucket, Rate
from yarm.console.wire import MAGIC, decode, encode

SHAPES = arrays.array_shapes(max_dims=2, min_side=0, max_side=7)
ARRAYS = st.one_of(
    arrays.arrays(np.float32, SHAPES, elements=st.floats(-1e3, 1e3, width=32)),
    arrays.arrays(np.uint16, SHAPES),
    arrays.arrays(np.uint8, SHAPES),
)


@given(st.dictionaries(st.text(max_size=5), ARRAYS, max_size=4), st.text())
def test_what_is_sent_arrives(sent, text):
    header, got = decode(encode({"kind": "state", "text": text}, sent))
    assert header == {"kind": "state", "text": text}
    assert list(got) == list(sent)
    for name, array in sent.items():
        assert got[name].dtype == array.dtype
        np.testing.assert_array_equal(got[name], array)


@given(st.dictionaries(st.text(max_size=5), ARRAYS, max_size=4), st.text())
def test_every_array_begins_where_a_browser_may_look_at_it(sent, text):
    """A Float32Array must begin at a multiple of 4 bytes of the message."""
    message = encode({"text": text}, sent)
    assert len(message) % 4 == 0
    (length,) = struct.unpack_from("<I", message, 4)
    listed = json.loads(message[8 : 8 + length])["arrays"]
    begins = [8 + length + (-length) % 4 + entry["at"] for entry in listed]
    assert [at % 4 for at in begins] == [0] * len(sent)


def test_what_json_or_the_page_cannot_say_is_refused():
    with pytest.raises(ValueError, match="not JSON compliant"):
        encode({"distance_m": float("nan")}, {})
    with pytest.raises(ValueError, match=r"array cells: type int64 must be one of f4, u2, u1"):
        encode({}, {"cells": np.zeros(3, np.int64)})
    with pytest.raises(ValueError, match="expected"):
        decode(b"nothing of ours")
    assert encode({}, {}).startswith(MAGIC)


def test_big_endian_numbers_are_turned():
    _, got = decode(encode({}, {"a": np.array([1.0, 2.0], ">f4")}))
    assert got["a"].tolist() == [1.0, 2.0]


def test_a_bucket_lets_through_a_burst_and_then_its_rate():
    now = [5.0]
    bucket = Bucket(Rate(2.0, 3.0), lambda: now[0])
    assert [bucket.take() for _ in range(5)] == [True, True, True, False, False]
    now[0] += 0.5
    assert [bucket.take() for _ in range(2)] == [True, False]
    now[0] += 100.0
    assert [bucket.take() for _ in range(5)] == [True, True, True, False, False]
