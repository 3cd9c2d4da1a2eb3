"""Whole missions are run in both ways of carrying a plan out."""

from __future__ import annotations

import pytest

from python.commander.fake_cell import FakeCell

EXECUTIONS = ("steps", "continuous")


@pytest.fixture(params=EXECUTIONS)
def execution(request, monkeypatch):
    """Run a test once with each ``execution``."""
    monkeypatch.setattr(FakeCell, "execution", request.param)
    return request.param
