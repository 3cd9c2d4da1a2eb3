"""Scenes: every fault is named with file, key, value and what was expected, all at once."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any, Dict

import pytest

from yarm.sim.scene import SceneError, load_scene, scene_from, shipped_scenes
from yarm.sim.things import SpawnError
from yarm.sim.world import World

GOOD: Dict[str, Any] = {
    "name": "test",
    "seed": 3,
    "fixtures": ["table", "stand"],
    "robots": [{"name": "ankurbot_1", "type": "ankurbot", "x": 1.9, "y": 1.9, "heading_deg": 180}],
    "manipulators": [{"name": "hc10_barc", "type": "hc10"}],
    "debris": [{"name": "debris_1", "x": -0.2, "y": 0.1, "z": 0.75, "yaw_deg": 10}],
    "targets": [{"name": "target_1", "x": -2.0, "y": -1.0}],
    "obstacles": [{"name": "box", "x": 0.0, "y": -2.0, "z": 0.2, "size": [0.3, 0.3, 0.4]}],
    "events": [
        {"name": "slip", "when": {"time": 3.0}, "do": {"push": "debris_1", "dx": 0.1}},
        {"when": {"state": "BOUNDLESS", "after": 1.0}, "do": {"camera": 2, "enabled": False}},
        {"when": {"raster": 0.5}, "do": {"delete": "debris_1"}},
        {
            "when": {"robot": "ankurbot_1", "near": "debris_1", "below": 0.5},
            "do": {"spawn": {"type": "Obstacle", "name": "late", "x": 1, "y": -1, "z": 0.1, "size": [0.1, 0.1, 0.2]}},
        },
    ],
}


def changed(*path: Any, value: Any) -> Dict[str, Any]:
    scene = copy.deepcopy(GOOD)
    place = scene
    for key in path[:-1]:
        place = place[key]
    if value is KeyError:
        del place[path[-1]]
    else:
        place[path[-1]] = value
    return scene


def test_a_good_scene_is_read_in_full() -> None:
    scene = scene_from(GOOD, "good.yaml")
    assert [spec.name for spec in scene.things] == ["debris_1", "target_1", "box"]
    assert scene.things_of("Target")[0].z == pytest.approx(0.89)
    assert len(scene.events) == 4
    assert scene.events[3].spawn is not None and scene.events[3].spawn.size == (0.1, 0.1, 0.2)


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        (changed("robots", 0, "x", value=float("nan")), ["robots[0].x", "nan", "-2.5 to 2.5"]),
        (changed("robots", 0, "x", value=9), ["robots[0].x", "9", "-2.5 to 2.5"]),
        (changed("robots", 0, "x", value="left"), ["robots[0].x", "'left'", "a number"]),
        (changed("robots", 0, "y", value=KeyError), ["robots[0].y", "missing"]),
        (changed("robots", 0, "type", value="tank"), ["robots[0].type", "'tank'", "ankurbot"]),
        (changed("robots", 0, "speed", value=3), ["robots[0].speed", "no such key", "heading_deg"]),
        (changed("robots", value={"a": 1}), ["robots", "a list"]),
        (changed("wheels", value=4), ["wheels", "no such key"]),
        (changed("name", value=KeyError), ["name", "missing"]),
        (changed("seed", value=-1), ["seed", "-1", "whole number"]),
        (changed("fixtures", value=["table", "sofa"]), ["fixtures", "sofa", "table, stand"]),
        (changed("fixtures", value=["table"]), ["manipulators", "stand"]),
        (changed("manipulators", 0, "tucked", value="yes, please"), ["manipulators[0].tucked", "true or false"]),
        (changed("debris", 0, "name", value="ankurbot_1"), ["'ankurbot_1'", "unique"]),
        (changed("debris", 0, "name", value="floor"), ["'floor'", "unique"]),
        (changed("debris", 0, "name", value="a b"), ["debris[0].name", "'a b'", "letters"]),
        (changed("obstacles", 0, "size", value=[1, 1]), ["obstacles[0].size", "[1, 1]", "3 numbers"]),
        (changed("obstacles", 0, "size", value=[1, 1, -1]), ["obstacles[0].size", "-1"]),
        (changed("events", 0, "do", value={"push": "nobody"}), ["'nobody'", "an object of the scene", "debris_1"]),
        (changed("events", 0, "do", value={}), ["events[0].do", "exactly one of spawn, delete, push, camera"]),
        (changed("events", 0, "when", value={"time": 1, "raster": 0}), ["events[0].when", "exactly one of time"]),
        (changed("events", 1, "when", value={"state": "LUNCH"}), ["events[1].when.state", "LUNCH", "BOUNDLESS"]),
        (changed("events", 1, "do", "camera", value=7), ["events[1].do.camera", "7", "1 to 4"]),
    ],
)
def test_each_fault_is_named(scene: Dict[str, Any], words: Any) -> None:
    with pytest.raises(SceneError) as raised:
        scene_from(scene, "bad.yaml")
    for word in ["bad.yaml", *words]:
        assert word in str(raised.value)


def test_all_faults_are_listed_at_once() -> None:
    scene = changed("robots", 0, "x", value=float("inf"))
    scene["debris"][0]["z"] = "high"
    scene["extra"] = 1
    with pytest.raises(SceneError) as raised:
        scene_from(scene, "bad.yaml")
    assert len(str(raised.value).splitlines()) == 3


def test_files_that_are_no_scenes(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"no such scene; shipped: .*2m1ma"):
        load_scene("nowhere")
    file = tmp_path / "scene.yaml"
    file.write_text("name: a\nname: b\n")
    with pytest.raises(SceneError, match="line 2: key 'name' given twice"):
        load_scene(file)
    file.write_text("name: [")
    with pytest.raises(SceneError, match="not readable as YAML"):
        load_scene(file)
    file.write_text("- just\n- a list\n")
    with pytest.raises(SceneError, match="a mapping of keys to values"):
        load_scene(file)


@pytest.mark.parametrize("name", shipped_scenes())
def test_every_shipped_scene_loads(name: str) -> None:
    assert load_scene(name).name == name


def test_overlapping_bodies_are_all_named() -> None:
    scene = copy.deepcopy(GOOD)
    scene["robots"].append({"name": "ankurbot_2", "type": "ankurbot", "x": 1.7, "y": 1.9, "heading_deg": 180})
    scene["obstacles"][0].update(x=0.4, y=0.5)
    with pytest.raises(SpawnError) as raised:
        World(scene_from(scene, "bad.yaml"))
    assert "ankurbot_1 overlaps ankurbot_2" in str(raised.value)
    assert "table overlaps box" in str(raised.value)
