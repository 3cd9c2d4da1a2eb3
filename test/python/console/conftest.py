"""A browser for the tests of a module."""

from __future__ import annotations

from typing import Iterator

import pytest

from support.page_desk import Desk


@pytest.fixture(name="desk", scope="module")
def desk_fixture() -> Iterator[Desk]:
    desk = Desk()
    yield desk
    desk.close()
