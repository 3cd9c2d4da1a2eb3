"""Tests mirror the sources, and are at least half as long."""

from __future__ import annotations

from pathlib import Path
from typing import Callable, Dict, List, Set

import pytest

ROOT = Path(__file__).resolve().parents[3]
SUFFIXES = {".py", ".cpp", ".hpp"}
LEAST_SHARE = 0.5
"""Lines of tests for a line of sources, Python and C++ together."""
LEAST_FOLDER_SHARE = 0.1
"""The same for the Python tests of one folder; what ROS or the contract suite tests is not counted there."""
ELSEWHERE: Dict[str, str] = {
    "ros": "test/ros starts nodes and talks to them",
    "planning/model": "test/contract asks every planner",
    "planning/baselines": "test/contract asks every planner",
    "planning/verification": "test/contract asks the checker and the brute force",
}
"""Folders of src/yarm whose tests are elsewhere, and where."""


def lines(folder: Path) -> int:
    """Lines of all Python and C++ files below a folder that are not empty."""
    files = [path for path in folder.rglob("*") if path.suffix in SUFFIXES and path.is_file()]
    return sum(1 for path in files for line in path.read_text(encoding="utf-8").splitlines() if line.strip())


def own_lines(folder: Path) -> int:
    """The same for the Python modules of one folder alone, without ``__init__`` files."""
    files = [path for path in folder.glob("*.py") if path.name != "__init__.py"]
    return sum(1 for path in files for line in path.read_text(encoding="utf-8").splitlines() if line.strip())


def strays(package: Path, tests: Path, parts: Set[str]) -> List[str]:
    """Folders of tests that mirror no folder of the package; ``parts`` are those that mirror none by intention."""
    folders = {path.parent.relative_to(tests) for path in tests.rglob("test_*.py")}
    return sorted(str(f) for f in folders if not parts & set(f.parts[:1]) and not (package / f).is_dir())


def thin(package: Path, tests: Path, elsewhere: Dict[str, str]) -> List[str]:
    """Folders of the package whose mirrored tests are too few, with their share."""
    found = []
    for folder in sorted({path.parent for path in package.rglob("*.py")}):
        name = folder.relative_to(package).as_posix()
        size = own_lines(folder)
        if size == 0 or any(name == other or name.startswith(f"{other}/") for other in elsewhere):
            continue
        share = own_lines(tests / name) / size
        if share < LEAST_FOLDER_SHARE:
            found.append(f"{name}: {share:.2f} lines of tests for a line, at least {LEAST_FOLDER_SHARE}")
    return found


def test_tests_are_half_as_long_as_the_sources(record_property: Callable[[str, object], None]) -> None:
    sources = lines(ROOT / "src") + lines(ROOT / "include")
    tests = lines(ROOT / "test")
    record_property("tests_per_source_line", round(tests / sources, 3))
    assert tests >= LEAST_SHARE * sources, f"{tests} lines of tests for {sources} of sources: {tests / sources:.3f}"


def test_every_folder_of_tests_mirrors_one_of_the_package() -> None:
    assert strays(ROOT / "src" / "yarm", ROOT / "test" / "python", {"package"}) == []


def test_every_folder_of_the_package_has_tests_of_its_own() -> None:
    assert thin(ROOT / "src" / "yarm", ROOT / "test" / "python", ELSEWHERE) == []


@pytest.mark.parametrize("name", sorted(ELSEWHERE))
def test_what_is_said_to_be_tested_elsewhere_is_there(name: str) -> None:
    assert (ROOT / "src" / "yarm" / name).is_dir()
    assert list((ROOT / ELSEWHERE[name].split()[0]).glob("*test*.py"))


def test_a_stray_folder_and_a_bare_one_are_found(tmp_path: Path) -> None:
    for path, text in (
        ("yarm/geometry/grid.py", "a = 1\n" * 40),
        ("yarm/sim/engine/world.py", "a = 1\n" * 40),
        ("yarm/ros/node.py", "a = 1\n" * 40),
        ("tests/geometry/test_grid.py", "b = 1\n" * 20),
        ("tests/motor/test_motor.py", "b = 1\n"),
        ("tests/package/test_docs.py", "b = 1\n"),
    ):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text(text)
    assert strays(tmp_path / "yarm", tmp_path / "tests", {"package"}) == ["motor"]
    (bare,) = thin(tmp_path / "yarm", tmp_path / "tests", {"ros": "elsewhere"})
    assert bare.startswith("sim/engine: 0.00")
