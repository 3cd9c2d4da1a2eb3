"""House rules that a machine can see: sizes, unfinished marks, and that the sources parse as Python 3.8."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
CODE = [
    path
    for folder in ("src", "include", "scripts", "bench", "tools", "test")
    for path in sorted((ROOT / folder).rglob("*"))
    if path.is_file() and path.suffix in {".py", ".cpp", ".hpp", ""} and "__pycache__" not in path.parts
]
PYTHON = [path for path in CODE if path.suffix == ".py" or path.parent.name == "scripts"]


def name_of(path):
    return str(path.relative_to(ROOT))


def test_no_file_is_over_500_lines():
    assert [name_of(p) for p in CODE if len(p.read_text().splitlines()) > 500] == []


def test_no_python_function_is_over_60_lines():
    long = []
    for path in PYTHON:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and node.end_lineno - node.lineno >= 60:
                long.append(f"{name_of(path)}: {node.name}")
    assert long == []


def test_scripts_are_thin():
    assert [name_of(p) for p in PYTHON if p.parent.name == "scripts" and len(p.read_text().splitlines()) > 40] == []


def test_nothing_is_left_unfinished():
    mark = re.compile(r"\b(TO" + r"DO|FIX" + r"ME|XX" + r"X)\b")
    assert [name_of(p) for p in CODE if mark.search(p.read_text())] == []


@pytest.mark.parametrize("path", PYTHON, ids=name_of)
def test_parses_as_python_38(path):
    ast.parse(path.read_text(), feature_version=(3, 8))
