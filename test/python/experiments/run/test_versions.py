"""Versions of what a result was made with."""

from __future__ import annotations

import platform

import numpy as np

from yarm.experiments.run.versions import package_versions


def test_python_and_what_is_installed() -> None:
    found = package_versions()
    assert found["python"] == platform.python_version() and found["numpy"] == np.__version__
    assert "no_such_package" not in found and all(found.values())
