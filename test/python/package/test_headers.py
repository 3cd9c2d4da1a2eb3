"""What a header declares says what it is: a Doxygen comment stands above every declaration that others may use."""

from __future__ import annotations

from pathlib import Path
from typing import Iterator, List, Tuple

import pytest

ROOT = Path(__file__).resolve().parents[3]
HEADERS = sorted((ROOT / "include" / "yarm").rglob("*.hpp"))
ELSE = ("#", "//", "}", "namespace", "template", "static_assert", "using", 'extern "C"', "inline constexpr char")
"""Beginnings of lines at the margin that declare nothing, or the name of a topic, which is its own description."""


def declarations(text: str) -> Iterator[Tuple[int, str, str]]:
    """Declarations at a header's margin, outside namespaces ``detail``: line number, line, and the line above it.

    Above means above its ``template`` line too.
    """
    above, open_statement, in_detail = "", False, False
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("namespace detail"):
            in_detail = True
        elif line.startswith("}  // namespace detail"):
            in_detail = False
        elif line and not line[0].isspace() and not open_statement and not in_detail and not line.startswith(ELSE):
            yield number, line, above
        if not line.startswith("template"):
            above = line
        if line.strip() and not line.lstrip().startswith(("//", "#", "template")):
            open_statement = not line.split("  //")[0].rstrip().endswith((";", "{", "}"))


def bare(text: str) -> List[str]:
    """Declarations without a comment above or beside them."""
    return [
        f"{number}: {line}"
        for number, line, above in declarations(text)
        if not above.startswith("///") and "///<" not in line
    ]


@pytest.mark.parametrize("header", HEADERS, ids=lambda path: str(path.relative_to(ROOT)))
def test_every_declaration_of_a_header_says_what_it_is(header: Path) -> None:
    assert bare(header.read_text(encoding="utf-8")) == []


def test_a_bare_declaration_is_found() -> None:
    text = """// A header.
namespace yarm {

/// Doubled.
template <class T>
T twice(const T& value,
        int times);
int halved(int value);

namespace detail {
struct Hidden {};
}  // namespace detail

struct Open {
  int a{0};
};
int told{0};  ///< said beside it
}  // namespace yarm
"""
    assert bare(text) == ["8: int halved(int value);", "14: struct Open {"]
