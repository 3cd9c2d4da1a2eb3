"""The scene in docs/simulation.md and the programs there and in docs/exploration.md are true."""

from __future__ import annotations

import re

import pytest
import yaml

from yarm.resources import resource
from yarm.sim.scenes.scene import scene_from

TEXT = resource("docs", "simulation.md").read_text(encoding="utf-8")


def test_the_example_scene_is_good() -> None:
    block = re.search(r"```yaml\n(.*?)```", TEXT, re.S)
    assert block is not None
    scene = scene_from(yaml.safe_load(block.group(1)), "docs/simulation.md")
    assert len(scene.events) == 5


@pytest.mark.parametrize("page", ["simulation.md", "exploration.md"])
def test_the_example_program_runs(page: str) -> None:
    block = re.search(r"```python\n(.*?)```", resource("docs", page).read_text(encoding="utf-8"), re.S)
    assert block is not None
    exec(compile(block.group(1), f"docs/{page}", "exec"), {})
