"""Layout files: the practice world is the published one; made layouts go by name; what is wrong is named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from yarm.resources import resource
from yarm.sim.checks.layout_check import sights
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.scenes.layout import BLANK
from yarm.sim.scenes.layout_file import find_layout, layout_from
from yarm.sim.scenes.layout_maker import make_layout
from yarm.yaml_fields import SceneError, load_yaml

PRACTICE = resource("scenes", "inspection", "practice.yaml")
POSES = "boxes:\n  - {number: 2, x: -0.5, y: 0.0, phi: 0.0}\n  - {number: 1, x: 0.5, y: 0.1, phi: 1.0}\n"


def test_the_practice_world_is_the_published_one() -> None:
    layout = find_layout("practice")
    assert layout.tags == (5, 11, 10, 8, 15, 14, 5, BLANK, 11, 2)
    assert [round(box.pose.x, 5) for box in layout.boxes[:2]] == [3.19425, 1.30965]
    assert layout.boxes[0].size == (0.16, 0.50, 0.40)
    assert layout.arena.lower == (-2.36, -4.83) and layout.arena.upper == (3.64, 1.17)


def test_the_practice_worlds_walls_stand_round_it_and_its_start_is_free() -> None:
    layout = find_layout("practice")
    walls = FlatBoxes([block for block in layout.arena.blocks if block.kind == "wall"])
    (x0, y0), (x1, y1) = layout.arena.lower, layout.arena.upper
    inside = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, 0.0), (x1, 0.0), (0.0, y0), (0.0, y1)])
    assert np.abs(walls.signed(inside).min(axis=1)).max() < 1e-9
    assert FlatBoxes(layout.arena.blocks).distances(layout.start.x, layout.start.y).min() > 0.3
    assert min(sight.share for sight in sights(layout)) > 0.6


def test_made_layouts_go_by_kind_and_seed() -> None:
    assert find_layout("corridor_4") == make_layout("corridor", 4)


def test_boxes_come_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    (tmp_path / "poses.yaml").write_text(POSES)
    layout = layout_from(small(), tmp_path / "small.yaml")
    assert [box.pose.x for box in layout.boxes] == [0.5, -0.5] and layout.tags == (3, 0)


def small() -> dict:
    return {
        "name": "small",
        "lower": [-1, -1],
        "upper": [1, 1],
        "start": {"x": 0, "y": 0.6},
        "boxes": "poses.yaml",
        "box_size": [0.5, 0.16, 0.4],
        "tags": [3, 0],
    }


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"tags": [3]}, "tags"),
        ({"tags": [3, -1]}, "tags"),
        ({"boxes": "none.yaml"}, "none.yaml"),
        ({"start": {"x": 5, "y": 0}}, "start"),
        ({"upper": [-1, 1]}, "upper"),
        ({"upper": [0.4, 1]}, "boxes[0]"),
        ({"colour": "red"}, "colour"),
        ({"box_size": [0.5, 0.16]}, "box_size"),
    ],
)
def test_faults_are_named(change: dict, named: str, tmp_path: Path) -> None:
    (tmp_path / "poses.yaml").write_text(POSES)
    with pytest.raises(SceneError, match=named.replace("[", r"\[").replace("]", r"\]")):
        layout_from({**small(), **change}, tmp_path / "small.yaml")


def test_numbers_with_a_gap_and_unknown_names_are_refused(tmp_path: Path) -> None:
    (tmp_path / "poses.yaml").write_text(POSES.replace("number: 2", "number: 3"))
    with pytest.raises(SceneError, match="numbers from 1 on"):
        layout_from(small(), tmp_path / "small.yaml")
    with pytest.raises(SceneError, match="no such layout"):
        find_layout("cupboard_3")


def test_the_shipped_file_is_what_is_tested() -> None:
    assert layout_from(load_yaml(PRACTICE), PRACTICE) == find_layout("practice")
