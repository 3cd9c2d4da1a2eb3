"""Scenes of the youBot's floor: what they hold, what another seed changes, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from yarm.geometry.solids import Solid
from yarm.resources import resource
from yarm.sim.scenes.youbot_floor import RIM_M, SPREAD_M, load_floor_scene
from yarm.yaml_fields import SceneError

FILE = resource("scenes", "manipulation", "youbot_floor.yaml")


def test_the_shipped_scene_is_what_the_file_says() -> None:
    scene = load_floor_scene(FILE)
    assert [piece.name for piece in scene.debris] == ["debris_1", "debris_2", "debris_3"]
    assert scene.bin.size[2] <= RIM_M
    assert [name for name, _ in scene.boxes()] == ["bin"] * 5 + ["post", "shelf"]


def test_the_bins_walls_stand_round_its_inside() -> None:
    scene = load_floor_scene(FILE)
    width, depth, height = scene.bin.size
    for wall in scene.bin.walls():
        assert isinstance(wall, Solid)
        low = wall.pose[2, 3] - wall.half_extent[2]
        assert low == pytest.approx(0.0, abs=1e-9)
        local = (np.linalg.inv(scene.bin.pose) @ wall.pose)[:3, 3]
        assert np.all(np.abs(local[:2]) + wall.half_extent[:2] <= np.array((width, depth)) / 2 + 1e-9)
    assert max(wall.size[2] for wall in scene.bin.walls()) == height


def test_a_seed_moves_the_debris_and_nothing_else() -> None:
    scene = load_floor_scene(FILE)
    assert scene.varied(0) is scene
    one, again, other = scene.varied(1), scene.varied(1), scene.varied(2)
    assert one.debris == again.debris != other.debris
    for piece, moved in zip(scene.debris, one.debris):
        assert abs(piece.x - moved.x) <= SPREAD_M
        assert abs(piece.y - moved.y) <= SPREAD_M
    assert (one.start, one.bin, one.obstacles) == (scene.start, scene.bin, scene.obstacles)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("0.40, 0.20]", "0.40, 0.31]", "a rim of 0.3 m at most"),
        ("debris_2", "debris_1", "a name of its own"),
        ("x: 1.6", "x: 9.0", "bin.x"),
        ("yaw_deg: 30", "turn: 30", "turn"),
    ],
)
def test_what_is_wrong_is_refused_by_name(tmp_path: Path, old: str, new: str, words: str) -> None:
    file = tmp_path / "floor.yaml"
    file.write_text(FILE.read_text(encoding="utf-8").replace(old, new, 1), encoding="utf-8")
    with pytest.raises(SceneError, match=words):
        load_floor_scene(file)
