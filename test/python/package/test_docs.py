"""The documents against the code: quoted messages exist, links lead somewhere, commands name real things."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *ROOT.glob("bench/*.md")])
SOURCES = [
    path
    for folder in ("src", "include", "tools", "scripts")
    for path in (ROOT / folder).rglob("*")
    if path.is_file() and path.suffix in {".py", ".cpp", ".hpp", ".sh", ""} and "__pycache__" not in path.parts
] + [ROOT / "Makefile"]


def flat(text):
    """Source text without quotes, f-string marks and line breaks between adjacent strings, and without fields."""
    joined = re.sub(r'"\s*(?:\+\s*)?f?"', "", text).replace('\\"', '"')
    return re.sub(r"\{[^{}\"]*\}|%\.?\d*[dfgs]|\$\w+", "...", joined)


def test_every_message_of_troubleshooting_is_really_said():
    said = "\n".join(flat(path.read_text()) for path in SOURCES)
    page = (ROOT / "docs" / "troubleshooting.md").read_text()
    phrases = [row.split("`")[1] for row in page.splitlines() if row.startswith("| `")]
    assert len(phrases) > 20
    missing = [p for p in phrases if not all(part.strip() in said for part in p.split("...") if part.strip(' "'))]
    assert missing == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page):
    targets = re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", page.read_text())
    lost = [t for t in targets if "://" not in t and not (page.parent / t).exists()]
    assert lost == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_name_real_things(page):
    text = page.read_text()
    make = (ROOT / "Makefile").read_text()
    lost = [
        t
        for t in re.findall(r"\bmake ([a-z][a-z-]+)\b`?(?=[\s`|,;:.)]|$)", text)
        if not re.search(rf"^{t}:", make, re.M)
    ]
    lost += [n for n in re.findall(r"rosrun yarm (\w+)", text) if not (ROOT / "scripts" / n).is_file()]
    lost += [n for n in re.findall(r"roslaunch yarm (\w+\.launch)", text) if not list((ROOT / "launch").rglob(n))]
    lost += [s for s in re.findall(r"scenes/[\w/]+\.yaml", text) if not (ROOT / s).is_file()]
    assert lost == []


def test_the_topics_of_the_readme_are_those_of_the_interface():
    cells = [
        [cell.strip() for cell in row.strip("|\n").split("|")]
        for row in (ROOT / "README.md")
        .read_text()
        .partition("topics that matter most")[2]
        .partition("\n\n[docs/")[0]
        .splitlines()
        if row.startswith("| `")
    ]
    interface = re.findall(r"^\| `([^`]+)` \| (\S+) \|", (ROOT / "docs" / "ros_api.md").read_text(), re.M)
    assert len(cells) > 5
    for names, kind, _ in cells:
        first, *others = re.findall(r"`([^`]+)`", names)
        assert (first, kind.replace("Action", "")) in interface, first
        assert set(others) <= {name for name, _ in interface}


def test_every_page_is_on_the_map():
    linked = re.findall(r"\]\((\w+\.md)\)", (ROOT / "docs" / "README.md").read_text())
    assert sorted(set(linked)) == sorted(page.name for page in (ROOT / "docs").glob("*.md") if page.name != "README.md")
