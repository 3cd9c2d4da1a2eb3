"""What the page colours differ in, for who sees red, green or blue otherwise than most."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import numpy as np
import pytest

TEXT = (Path(__file__).resolve().parents[3] / "web" / "colours.js").read_text()
SEEN = {
    "as most": np.eye(3),
    "without red": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "without green": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
    "without blue": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039]],
}
"""How linear red, green and blue are seen (Machado, Oliveira and Fernandes 2009, severity 1)."""
TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
WHITE = np.array([0.9505, 1.0, 1.089])
LEAST = 15.0
"""Distance in CIELAB; side by side a distance of 2.3 is just noticed."""
ROBOTS = 4


def colours():
    """Of so many robots, each kind of object, and what nobody registered; by name."""
    robots = re.findall(r"#[0-9a-f]{6}", re.search(r"ROBOTS = \[(.*?)\]", TEXT).group(1))
    kinds = dict(re.findall(r"(\w+): \"(#[0-9a-f]{6})\"", re.search(r"KINDS = \{(.*?)\}", TEXT).group(1)))
    unknown = re.search(r"UNKNOWN = \"(#[0-9a-f]{6})\"", TEXT).group(1)
    return {**{f"robot {i + 1}": robots[i] for i in range(ROBOTS)}, **kinds, "unknown": unknown}


def lab(colour, seen):
    """CIELAB of a colour as it is seen."""
    coded = np.array([int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)])
    linear = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)
    x = TO_XYZ @ np.clip(np.asarray(seen) @ linear, 0.0, 1.0) / WHITE
    f = np.where(x > 0.008856, np.cbrt(x), 7.787 * x + 16.0 / 116.0)
    return np.array([116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])])


@pytest.mark.parametrize("how", SEEN)
def test_no_two_colours_are_taken_for_each_other(how):
    found = {name: lab(colour, SEEN[how]) for name, colour in colours().items()}
    assert len(found) == ROBOTS + 5
    near = {(a, b): round(float(np.linalg.norm(found[a] - found[b])), 1) for a, b in itertools.combinations(found, 2)}
    assert {pair: gap for pair, gap in near.items() if gap < LEAST} == {}
