"""docs/architecture.md shows the house as it is: its tree the folders, its table the floors that a test enforces."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Dict, List, Set

from support.boundaries import CPP_ALLOWED, FLOORS

ROOT = Path(__file__).resolve().parents[3]
PACKAGE = ROOT / "src" / "yarm"
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")


def tree() -> Dict[str, str]:
    """What the tree says of each part of src/yarm, by the part's folder."""
    block = re.search(r"```\n(src/yarm/.*?)```", PAGE, re.S)
    assert block is not None
    return dict(re.findall(r"^  (\w+)/ +(.*)$", block.group(1), re.M))


def table(column: int) -> List[Set[str]]:
    """Parts named in each row of the table of floors, from the lowest: column 2 for Python, 3 for C++."""
    rows = [line.split("|") for line in PAGE.splitlines() if re.match(r"\| \d, ", line)]
    return [set(re.findall(r"`(\w+)`", row[column])) for row in rows]


def folders(parent: Path) -> Set[str]:
    """Folders with Python modules below a folder, without those below them."""
    return {path.parent.name for path in parent.glob("*/__init__.py")}


def test_the_tree_names_every_part() -> None:
    assert set(tree()) == folders(PACKAGE)


def test_the_tree_names_the_rooms_of_every_part_that_has_some() -> None:
    wrong = {
        part: sorted(folders(PACKAGE / part) ^ set(said.split()))
        for part, said in tree().items()
        if folders(PACKAGE / part) and folders(PACKAGE / part) != set(said.split())
    }
    assert wrong == {}


def test_the_table_is_the_floors_that_are_enforced() -> None:
    there = {path.stem for path in PACKAGE.iterdir()}
    assert table(2) == [set(parts) & there for parts in FLOORS]


def test_every_cpp_part_stands_above_those_it_includes() -> None:
    floor_of = {part: floor for floor, parts in enumerate(table(3)) for part in parts}
    assert set(floor_of) == set(CPP_ALLOWED)
    for part, allowed in CPP_ALLOWED.items():
        assert all(floor_of[below] < floor_of[part] for below in allowed), part


def test_the_trees_other_folders_exist() -> None:
    block = re.search(r"```\n(src/yarm/.*?)```", PAGE, re.S)
    assert block is not None
    named = [
        word for line in block.group(1).splitlines() if line[0] != " " for word in re.findall(r"^(?:\S+/ )*\S+/", line)
    ]
    missing = [name for words in named for name in words.split() if not (ROOT / name).is_dir()]
    assert missing == []
