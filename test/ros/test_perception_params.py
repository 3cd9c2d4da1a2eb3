"""config/ against the parameter structs of the C++ nodes, which their own executable prints."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
import yaml

from support.launched import DEVEL

ROOT = Path(__file__).resolve().parents[2]
PERCEPTION = ("perception_params", "cell")
NODES = {
    "merge_clouds": PERCEPTION,
    "cluster_assoc": PERCEPTION,
    "database": PERCEPTION,
    "slam_gmapping": ("slam_params", "exploration"),
    "amcl": ("slam_params", "inspection"),
}
"""For each node the program that prints its parameters, and the folder of its configuration."""


@pytest.fixture(scope="module")
def table():
    rows = {}
    for line in printed():
        node, name, default, *_ = line.split("\t")
        rows.setdefault(node, {})[name] = yaml.safe_load(default)
    return rows


def printed():
    lines = []
    for program in sorted({program for program, _ in NODES.values()}):
        binary = DEVEL / "lib" / "yarm" / program
        assert binary.is_file(), f"{binary} is not built: run `make build`"
        lines += subprocess.run(
            [str(binary)], capture_output=True, check=True, text=True, timeout=60
        ).stdout.splitlines()
    return lines


def configuration(node):
    return (ROOT / "config" / NODES[node][1] / f"{node}.yaml").read_text()


def test_every_node_prints_its_parameters(table):
    assert sorted(table) == sorted(NODES)


@pytest.mark.parametrize("node", NODES)
def test_yaml_holds_every_parameter_with_its_default(node, table):
    shipped = yaml.safe_load(configuration(node))
    assert shipped == table[node]


@pytest.mark.parametrize("node", NODES)
def test_every_parameter_has_a_comment(node):
    lines = configuration(node).splitlines()
    for before, line in zip(lines, lines[1:]):
        if line[:1].isalpha():
            assert "#" in line or before.startswith("#"), line


def test_every_line_has_unit_range_and_meaning():
    for line in printed():
        assert len(line.split("\t")) == 6, line
        assert line.split("\t")[5], line
