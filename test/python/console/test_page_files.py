"""The page's files: three.js as its authors ship it, with its licence, and nothing that is fetched from elsewhere."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

import pytest

WEB = Path(__file__).resolve().parents[3] / "web"
THREE = WEB / "vendor" / "three"
OWN = sorted(path for path in WEB.rglob("*") if path.is_file() and "vendor" not in path.parts)
LISTED = dict(re.findall(r"^\| `(\S+)` \| `([0-9a-f]{64})` \|$", (THREE / "README.md").read_text(), re.M))


def test_three_is_as_its_authors_ship_it():
    there = {path.name for path in THREE.iterdir()} - {"README.md"}
    assert there == set(LISTED)
    assert {name: hashlib.sha256((THREE / name).read_bytes()).hexdigest() for name in LISTED} == LISTED
    assert "three.js authors" in (THREE / "LICENSE").read_text()


@pytest.mark.parametrize("path", OWN, ids=lambda path: path.name)
def test_nothing_is_fetched_from_elsewhere(path):
    addresses = re.findall(r"(?:https?:)?//[\w.-]+\.\w+[^\s\"')]*", path.read_text())
    assert [each for each in addresses if each != "http://www.w3.org/2000/svg"] == []


@pytest.mark.parametrize("path", [path for path in OWN if path.suffix == ".js"], ids=lambda path: path.name)
def test_every_module_that_is_imported_is_there_and_texts_are_never_markup(path):
    text = path.read_text()
    for name in re.findall(r"^import .* from \"(\.[^\"]+)\";", text, re.M):
        assert (path.parent / name).is_file(), name
    assert not re.search(r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\(", text)
    assert len(text.splitlines()) <= 500
