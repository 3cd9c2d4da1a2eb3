"""Arena files: what is right is read, what is wrong is named, all of it at once."""

from __future__ import annotations

import copy
import math

import pytest

from yarm.geometry import Pose2
from yarm.sim.scenes.arena import arena_from, load_arena
from yarm.yaml_fields import SceneError

GOOD = {
    "name": "small",
    "kind": "custom",
    "lower": [-1.0, -1.5],
    "upper": [1.0, 1.5],
    "start": {"x": 0.2, "y": 0.0, "yaw_deg": 90},
    "blocks": [{"name": "wall_1", "kind": "wall", "x": 1.025, "y": 0.0, "size": [0.05, 3.0, 0.6]}],
}


def test_a_right_file_is_read() -> None:
    arena = arena_from(GOOD, "small.yaml")
    assert arena.start == Pose2(0.2, 0.0, math.radians(90.0)) and arena.upper == (1.0, 1.5)
    assert arena.blocks[0].size == (0.05, 3.0, 0.6) and arena.blocks[0].pose == Pose2(1.025, 0.0, 0.0)


def test_every_fault_is_named() -> None:
    wrong = copy.deepcopy(GOOD)
    wrong["blocks"] = [*wrong["blocks"], {**wrong["blocks"][0], "size": [0.05, "long", 0.6]}]
    wrong["start"] = {"x": 5.0, "y": 0.0}
    wrong["colour"] = "red"
    with pytest.raises(SceneError) as caught:
        arena_from(wrong, "small.yaml")
    message = str(caught.value)
    for part in ("blocks[1].size", "blocks[1].name = 'wall_1'", "start = (5.0, 0.0)", "colour"):
        assert part in message


def test_sides_in_the_wrong_order_are_refused() -> None:
    with pytest.raises(SceneError, match="more than lower"):
        arena_from({**GOOD, "upper": [-2.0, 1.5]}, "small.yaml")


def test_an_unknown_arena_is_named() -> None:
    with pytest.raises(SceneError, match="no such arena"):
        load_arena("nowhere")
