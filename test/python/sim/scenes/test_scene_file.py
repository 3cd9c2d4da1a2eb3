"""What is written of a scene is read back as the same scene."""

from __future__ import annotations

from dataclasses import replace

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from yarm.sim.scenes.events import Event, Trigger
from yarm.sim.scenes.random_cell import KINDS, random_cell
from yarm.sim.scenes.scene import load_scene, scene_from
from yarm.sim.scenes.scene_file import scene_text
from yarm.sim.scenes.specs import ThingSpec


@settings(max_examples=12, deadline=None)
@given(st.sampled_from(KINDS), st.integers(0, 2**31 - 1))
def test_a_random_cell_is_read_back(kind: str, seed: int) -> None:
    cell = random_cell(kind, seed)
    read = scene_from(yaml.safe_load(scene_text(cell)), "written")
    assert scene_text(read) == scene_text(cell)
    assert (read.name, read.seed, read.arms, len(read.events)) == (cell.name, cell.seed, cell.arms, len(cell.events))
    places = {thing.name: (thing.x, thing.y, thing.z, thing.kind, thing.registered) for thing in cell.things}
    assert {thing.name for thing in read.things} == set(places)
    for thing in read.things:
        x, y, z, kind_there, registered = places[thing.name]
        assert (thing.x, thing.y, thing.z) == pytest.approx((x, y, z), abs=1e-6)
        assert (thing.kind, thing.registered) == (kind_there, registered)


@pytest.mark.parametrize("name", ["1m1ma", "2m1ma", "3m", "single", "person_crossing", "2m1ma_bin", "3m6_bin", "2m2ma"])
def test_a_shipped_scene_is_read_back_exactly(name: str) -> None:
    scene = replace(load_scene(name), vary=None)
    assert scene_from(yaml.safe_load(scene_text(scene)), "written") == scene


def test_every_trigger_and_action_is_written() -> None:
    scene = replace(
        load_scene("3m"),
        vary=None,
        events=(
            Event("a", Trigger(time_s=3.0), delete="target_1"),
            Event("b", Trigger(raster=0.5, arm="hc10_barc", after_s=1.0), camera=2, enabled=False),
            Event("c", Trigger(robots=("ankurbot_1",), near="target_1", below_m=0.5), push="target_1", dx_m=0.1),
            Event("d", Trigger(holding="ankurbot_1", after_s=0.5), vacuum="ankurbot_1", enabled=False),
        ),
    )
    assert scene_from(yaml.safe_load(scene_text(scene)), "written").events == scene.events


def test_what_would_be_lost_is_refused() -> None:
    with pytest.raises(ValueError, match="are not written"):
        scene_text(load_scene("2m1ma"))
    crate = ThingSpec("crate", "Obstacle", 1.0, 1.0, 0.2, model="crate.urdf")
    with pytest.raises(ValueError, match="are not written"):
        scene_text(replace(load_scene("single"), things=(crate,)))
