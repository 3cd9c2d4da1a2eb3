"""The diagram of docs/architecture.md against the documented interface: nodes exist, arrows carry something."""

from __future__ import annotations

import re
from pathlib import Path
from typing import List, Tuple

import pytest

from yarm.ros.common import api

PAGE = Path(__file__).resolve().parents[2] / "docs" / "architecture.md"


def arrows() -> List[Tuple[str, str]]:
    """Pairs of nodes with an arrow from one to the other."""
    found = re.search(r"```mermaid\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)
    assert found is not None
    pairs: List[Tuple[str, str]] = []
    for line in found.group(1).splitlines():
        nodes = re.split(r"\s*--\s*\w*\s*-->\s*|\s*-->\s*", re.sub(r'"[^"]*"', "label", line.strip()))
        pairs += zip(nodes, nodes[1:])
    return pairs


def test_every_node_is_in_it() -> None:
    drawn = {name for pair in arrows() for name in pair}
    senders = {name.strip() for topic in api.TOPICS for name in topic.sender.split(",")}
    assert {name for name in drawn if name not in senders} == set()
    assert len(drawn) == 9


@pytest.mark.parametrize("pair", arrows(), ids="->".join)
def test_every_arrow_carries_something(pair: Tuple[str, str]) -> None:
    sender, receiver = pair
    topics = [t.name for t in api.TOPICS if sender in t.sender and (receiver in t.receivers or t.receivers == "all")]
    calls = [s.name for s in (*api.SERVICES, *api.ACTIONS) if s.server == receiver]
    assert topics or calls
