"""Every C++ unit test binary; `make build-tests` (part of `make test`) makes them."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.launched import DEVEL, run

NAMES = sorted(path.stem for path in Path(__file__).parent.rglob("*_test.cpp"))
LIMIT_S = 600.0


@pytest.mark.parametrize("name", NAMES)
def test_gtest(name):
    binary = DEVEL / "lib" / "yarm" / name
    assert binary.is_file(), f"{binary} is not built: run `make test`, or `make -C build tests`"
    run([str(binary)], name, LIMIT_S)
