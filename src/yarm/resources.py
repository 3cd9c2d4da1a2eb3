"""Where the package's data files are: in a source checkout or in an install space."""

from __future__ import annotations

import os
from pathlib import Path
from typing import List, Optional


def package_root() -> Path:
    """Folder that holds ``scenes/``, ``config/``, ``urdf/`` and ``launch/``.

    Raises:
        FileNotFoundError: neither a checkout nor an install space surrounds this file.
    """
    here = Path(__file__).resolve()
    checkout = here.parents[2]
    if (checkout / "package.xml").is_file():
        return checkout
    prefixes = [Path(p) for p in os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep) if p]
    for prefix in [*here.parents, *prefixes]:
        if (prefix / "share" / "yarm" / "package.xml").is_file():
            return prefix / "share" / "yarm"
    raise FileNotFoundError(f"no package.xml of yarm above {here}: source the workspace's setup.bash first")


def resource(*parts: str) -> Path:
    """Path of a data file, for instance ``resource("scenes", "2m1ma.yaml")``; it need not exist."""
    return package_root().joinpath(*parts)


def built_library(name: str) -> Optional[Path]:
    """A library that the build made, for instance "libyarm_rays.so", in a devel or install space; None without one."""
    prefixes: List[Path] = [Path(p) for p in os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep) if p]
    root = package_root()
    prefixes += [root / "devel", *list(root.parents)[:2]]
    return next((prefix / "lib" / name for prefix in prefixes if (prefix / "lib" / name).is_file()), None)
