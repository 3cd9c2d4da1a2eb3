"""What all tests share: the order in which they begin."""

from __future__ import annotations

from typing import List

import pytest

LONGEST = "test_catkin_workspace"
"""Builds the whole package once more. Begun last it would run alone for minutes, while the other core has nothing."""


def pytest_collection_modifyitems(items: List[pytest.Item]) -> None:
    """The longest test begins first; all others keep their order."""
    items.sort(key=lambda item: item.name != LONGEST)
