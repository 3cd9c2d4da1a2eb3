"""Scenes: every fault is named with file, key, value and what was expected, all at once."""

from __future__ import annotations

import copy
import math
from pathlib import Path
from typing import Any, Dict

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from yarm.sim.engine.world import SimWorld
from yarm.sim.scenes.bodies import SpawnError
from yarm.sim.scenes.scene import MOST_MODEL_BYTES, SceneError, load_scene, scene_from, shipped_scenes

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
        (changed("fixtures", value=["table", "stand", "table"]), ["fixtures", "each once"]),
        (changed("manipulators", value=[GOOD["manipulators"][0]] * 9), ["manipulators", "9 entries", "at most 8"]),
        (changed("fixtures", value=["table"]), ["manipulators", "stand"]),
        (changed("bins", value=[{"name": "box_1", "x": 0, "y": -1.5}]), ["bins[0].name", "'box_1'", "begins with bin"]),
        (changed("bins", value=[{"name": "bin_1", "x": 9, "y": -1.5}]), ["bins[0].x", "9", "-2.5 to 2.5"]),
        (changed("bins", value=[{"name": "bin_1", "x": 1, "y": 1}] * 2), ["'bin_1'", "unique names", "bins, bins"]),
        (changed("bins", value=[{"name": "bin_1", "x": 1, "y": 1}] * 9), ["bins", "9 entries", "at most 8"]),
        (changed("manipulators", 0, "name", value="arm"), ["manipulators[0].name", "'arm'", "begins with hc10_barc"]),
        (changed("manipulators", 0, "station", value={"x": 9}), ["manipulators[0].station.x", "9", "-2.5 to 2.5"]),
        (
            changed("manipulators", 0, "station", value={"z": 1}),
            ["manipulators[0].station.z", "no such key", "yaw_deg"],
        ),
        (
            changed("manipulators", 0, "station", value={"storage_deg": [0, 1]}),
            ["manipulators[0].station.storage_deg", "6 numbers"],
        ),
        (changed("events", 2, "when", value={"raster": 0.5, "manipulator": "hc10"}), ["'hc10'", "an object"]),
        (changed("manipulators", 0, "tucked", value="yes, please"), ["manipulators[0].tucked", "true or false"]),
        (changed("debris", 0, "name", value="ankurbot_1"), ["'ankurbot_1'", "unique"]),
        (changed("debris", 0, "name", value="floor"), ["'floor'", "unique"]),
        (changed("debris", 0, "name", value="a b"), ["debris[0].name", "'a b'", "letters"]),
        (changed("obstacles", 0, "size", value=[1, 1]), ["obstacles[0].size", "[1, 1]", "3 numbers"]),
        (changed("obstacles", 0, "size", value=[1, 1, -1]), ["obstacles[0].size", "-1"]),
        (changed("events", 0, "do", value={"push": "nobody"}), ["'nobody'", "an object of the scene", "debris_1"]),
        (changed("events", 0, "do", value={}), ["events[0].do", "exactly one of spawn, delete, push, move, camera"]),
        (changed("events", 0, "when", value={"time": 1, "raster": 0}), ["events[0].when", "exactly one of time"]),
        (changed("events", 1, "when", value={"state": "LUNCH"}), ["events[1].when.state", "LUNCH", "BOUNDLESS"]),
        (changed("events", 1, "do", "camera", value=7), ["events[1].do.camera", "7", "1 to 4"]),
        (changed("robots", 0, "x", value=None), ["robots[0].x", "None", "-2.5 to 2.5"]),
        (changed("robots", 0, "x", value=10**400), ["robots[0].x", "-2.5 to 2.5"]),
        (changed("robots", value=[GOOD["robots"][0]] * 21), ["robots", "21 entries", "at most 20"]),
        (changed("debris", value=[GOOD["debris"][0]] * 101), ["debris", "101 entries", "at most 100"]),
        (changed("events", 0, "do", value={1: 2, "push": "a", "delete": "b"}), ["events[0].do", "exactly one of"]),
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


PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=6),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.sampled_from(["name", "x", "size", "when", "do", "push", 7]), inner, max_size=4)
    ),
    max_leaves=12,
)
PLACES = [(key,) for key in GOOD] + [
    (key, 0, field)
    for key in ("robots", "manipulators", "debris", "targets", "obstacles", "events")
    for field in ("name", "type", "x", "z", "yaw_deg", "size", "when", "do")
]


@settings(max_examples=300, deadline=None, derandomize=True)
@given(st.lists(st.tuples(st.sampled_from(PLACES), PLAIN), min_size=1, max_size=3))
def test_any_value_anywhere_gives_a_scene_or_a_scene_error(changes: Any) -> None:
    scene = copy.deepcopy(GOOD)
    for path, value in changes:
        place = scene
        for key in path[:-1]:
            inside = isinstance(place, dict) or (isinstance(place, list) and len(place) > 0)
            place = place[key] if inside and (isinstance(place, list) or key in place) else {}
        if isinstance(place, dict):
            place[path[-1]] = value
    try:
        assert scene_from(scene, "fuzz.yaml").name
    except SceneError as error:
        assert "fuzz.yaml: " in str(error)


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
        SimWorld(scene_from(scene, "bad.yaml"))
    assert "ankurbot_1 overlaps ankurbot_2" in str(raised.value)
    assert "table overlaps box" in str(raised.value)


CYLINDER = """<robot name="drum"><link name="base_link"><inertial><mass value="1"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
<collision><origin xyz="0 0 0.1"/><geometry><cylinder radius="0.1" length="0.2"/></geometry></collision>
</link>{more}</robot>"""
LID = """<link name="lid"/><joint name="hinge" type="revolute"><parent link="base_link"/><child link="lid"/>
<limit lower="0" upper="1" effort="1" velocity="1"/></joint>"""


def drawn(folder: Path, key: str, model: str = CYLINDER.format(more="")) -> Dict[str, Any]:
    """A scene with one thing drawn by a file in the folder."""
    (folder / "drum.urdf").write_text(model, encoding="utf-8")
    thing = {"name": "drum", "x": 0.5, "y": -1.5, "z": 0.0, "yaw_deg": 30, "model": "drum.urdf"}
    return {"name": "drawn", "fixtures": [], key: [thing]}


@pytest.mark.parametrize(("key", "dynamic", "below"), [("debris", True, 0.0), ("obstacles", False, 0.2)])
def test_a_thing_drawn_by_a_file_beside_the_scene(tmp_path: Path, key: str, dynamic: bool, below: float) -> None:
    with SimWorld(scene_from(drawn(tmp_path, key), str(tmp_path / "scene.yaml"))) as world:
        body = world.bodies["drum"]
        (item,) = body.solids
        assert (body.dynamic, item.solid.shape, item.solid.size) == (dynamic, "cylinder", (0.1, 0.2))
        assert item.T_frame_solid[2, 3] == pytest.approx(0.1 - below)
        world.run(0.5)
        place = world.transforms()["drum"] @ item.T_frame_solid
        assert place[:3, 3] == pytest.approx([0.5, -1.5, 0.1], abs=2e-3)


def test_a_model_that_is_not_there_is_named_with_where_it_was_looked_for(tmp_path: Path) -> None:
    scene = drawn(tmp_path, "obstacles")
    (tmp_path / "drum.urdf").unlink()
    with pytest.raises(SceneError, match=r"obstacles\[0\].model = 'drum.urdf': expected .* there is no .*drum.urdf"):
        scene_from(scene, str(tmp_path / "scene.yaml"))


def test_a_model_has_a_greatest_size(tmp_path: Path) -> None:
    scene = drawn(tmp_path, "obstacles", CYLINDER.format(more=" " * MOST_MODEL_BYTES))
    with pytest.raises(SceneError, match=r"obstacles\[0\].model = 'drum.urdf': .*at most 100000 bytes, not 100\d\d\d"):
        scene_from(scene, str(tmp_path / "scene.yaml"))


def test_an_obstacle_has_a_model_or_a_size_and_a_target_neither(tmp_path: Path) -> None:
    both = drawn(tmp_path, "obstacles")
    both["obstacles"][0]["size"] = [0.1, 0.1, 0.1]
    for scene, words in ((both, "size"), (drawn(tmp_path, "targets"), "model")):
        with pytest.raises(SceneError, match=words):
            scene_from(scene, str(tmp_path / "scene.yaml"))


@pytest.mark.parametrize(
    ("model", "words"),
    [
        (CYLINDER.format(more=LID), "drum: .*must be one rigid thing.*joints that move: hinge"),
        ("<robot name='drum'><link name='base_link'/></robot>", "drum: .*it has 0"),
        ("<robot", "drum: "),
        (CYLINDER.format(more="").replace("cylinder", "cone"), "drum: .*box, a cylinder or a sphere"),
    ],
)
def test_a_model_that_cannot_stand_is_refused_with_the_things_name(tmp_path: Path, model: str, words: str) -> None:
    scene = scene_from(drawn(tmp_path, "obstacles", model), str(tmp_path / "scene.yaml"))
    with pytest.raises(SpawnError, match=words):
        SimWorld(scene)


def test_bins_are_placed_with_the_fixtures() -> None:
    scene = scene_from(changed("bins", value=[{"name": "bin_1", "x": 0.5, "y": -1.5, "yaw_deg": 90}]), "bins.yaml")
    assert [(spec.name, spec.type) for spec in scene.placed_fixtures] == [
        ("table", "table"),
        ("stand", "stand"),
        ("bin_1", "bin"),
    ]
    assert scene.bins[0].station.yaw_rad == pytest.approx(math.pi / 2)


def test_each_manipulator_has_fixtures_at_its_own_station() -> None:
    second = {"name": "hc10_barc_2", "type": "hc10", "station": {"x": 1.0, "y": -1.1, "yaw_deg": 180}}
    scene = scene_from(changed("manipulators", value=[*GOOD["manipulators"], second]), "two.yaml")
    assert [arm.name for arm in scene.arms] == ["hc10_barc", "hc10_barc_2"]
    placed = [(spec.name, spec.type, spec.station.x, spec.station.y) for spec in scene.placed_fixtures]
    assert placed == [
        ("table", "table", 0.0, 0.0),
        ("stand", "stand", 0.0, 0.0),
        ("hc10_barc_2_table", "table", 1.0, -1.1),
        ("hc10_barc_2_stand", "stand", 1.0, -1.1),
    ]
    assert scene.fixtures_of("nobody") == ()
    assert scene.working_arms == ("hc10_barc", "hc10_barc_2")
    with pytest.raises(SceneError, match=r"'hc10_barc_2_table'.*unique"):
        things = {"obstacles": [{"name": "hc10_barc_2_table", "x": 2, "y": 2, "z": 0.1, "size": [0.1, 0.1, 0.1]}]}
        scene_from({**changed("manipulators", value=[*GOOD["manipulators"], second]), **things}, "two.yaml")


def test_stations_in_one_place_overlap() -> None:
    second = {"name": "hc10_barc_2", "type": "hc10", "station": {"x": 0.3}}
    with pytest.raises(SpawnError, match="table overlaps hc10_barc_2_table"):
        SimWorld(scene_from({"name": "heap", "manipulators": [*GOOD["manipulators"], second]}, "heap.yaml"))
