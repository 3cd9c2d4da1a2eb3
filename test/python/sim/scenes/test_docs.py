"""The scene and the program shown in docs/simulation.md are true."""

from __future__ import annotations

import re

import yaml

from yarm.resources import resource
from yarm.sim.scene import scene_from

TEXT = resource("docs", "simulation.md").read_text(encoding="utf-8")


def test_the_example_scene_is_good() -> None:
    block = re.search(r"```yaml\n(.*?)```", TEXT, re.S)
    assert block is not None
    scene = scene_from(yaml.safe_load(block.group(1)), "docs/simulation.md")
    assert len(scene.events) == 3


def test_the_example_program_runs() -> None:
    block = re.search(r"```python\n(.*?)```", TEXT, re.S)
    assert block is not None
    exec(compile(block.group(1), "docs/simulation.md", "exec"), {})
