"""config/ against the parameter structs of the C++ nodes, which their own executable prints."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
import yaml

from support.launched import DEVEL

ROOT = Path(__file__).resolve().parents[2]
NODES = ("merge_clouds", "cluster_assoc", "database")


@pytest.fixture(scope="module")
def table():
    rows = {}
    for line in printed().splitlines():
        node, name, default, *_ = line.split("\t")
        rows.setdefault(node, {})[name] = yaml.safe_load(default)
    return rows


def printed():
    binary = DEVEL / "lib" / "yarm" / "perception_params"
    assert binary.is_file(), f"{binary} is not built: run `make build`"
    return subprocess.run([str(binary)], capture_output=True, check=True, text=True, timeout=60).stdout


def test_every_node_prints_its_parameters(table):
    assert sorted(table) == sorted(NODES)


@pytest.mark.parametrize("node", NODES)
def test_yaml_holds_every_parameter_with_its_default(node, table):
    shipped = yaml.safe_load((ROOT / "config" / f"{node}.yaml").read_text())
    assert shipped == table[node]


@pytest.mark.parametrize("node", NODES)
def test_every_parameter_has_a_comment(node):
    lines = (ROOT / "config" / f"{node}.yaml").read_text().splitlines()
    for before, line in zip(lines, lines[1:]):
        if line[:1].isalpha():
            assert "#" in line or before.startswith("#"), line


def test_every_line_has_unit_range_and_meaning():
    for line in printed().splitlines():
        assert len(line.split("\t")) == 6, line
        assert line.split("\t")[5], line
