"""Which files of the package a module depends on: what it imports, and what that imports, and so on."""

from __future__ import annotations

import ast
from functools import lru_cache
from pathlib import Path
from typing import AbstractSet, Dict, FrozenSet, Iterator, List, Optional, Sequence

PACKAGE = Path(__file__).resolve().parents[2]


def files_of(modules: Sequence[str], without: AbstractSet[str] = frozenset(), package: Path = PACKAGE) -> List[Path]:
    """Sources of modules and of all that they import from their package, wherever in a file, in order of their paths.

    Args:
        modules: dotted names that begin with the package's.
        without: modules that are left out, with whatever is imported by them alone.
        package: folder of the package.

    Raises:
        FileNotFoundError: one of the modules is not there.
    """
    found: Dict[str, Path] = {}
    left = list(modules)
    while left:
        name = left.pop()
        if name in found or name in without:
            continue
        file = _file_of(name, package)
        if file is None:
            raise FileNotFoundError(f"there is no module {name} in {package}")
        found[name] = file
        parents = name.split(".")
        left += [".".join(parents[:depth]) for depth in range(1, len(parents))]
        left += _imported(file, package)
    return sorted(found.values())


@lru_cache(maxsize=None)
def _imported(file: Path, package: Path) -> FrozenSet[str]:
    names = _names(ast.parse(file.read_text(encoding="utf-8")))
    return frozenset(name for name in names if _file_of(name, package) is not None)


def _names(tree: ast.AST) -> Iterator[str]:
    """Everything that is imported and may be a module; imports are absolute in this package."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def _file_of(name: str, package: Path) -> Optional[Path]:
    parts = name.split(".")
    if parts[0] != package.name:
        return None
    place = package.joinpath(*parts[1:])
    for file in (place.with_suffix(".py"), place / "__init__.py"):
        if file.is_file():
            return file
    return None
