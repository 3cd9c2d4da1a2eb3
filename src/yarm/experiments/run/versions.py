"""Versions of what a result was made with."""

from __future__ import annotations

import importlib.metadata
import platform
from typing import Dict

PACKAGES = ("yarm", "numpy", "scipy", "pybullet", "ompl", "ruckig", "embreex")


def package_versions() -> Dict[str, str]:
    """Of Python and those of PACKAGES that are installed."""
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            continue
    return found
