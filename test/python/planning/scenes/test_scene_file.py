"""Planning scenes: what is shipped loads, what is wrong is refused with every fault named."""

from __future__ import annotations

import math
from typing import Any, Dict

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from yarm.planning.scenes.scene_file import SceneError, dump_scene, load_scene, parse_scene
from yarm.resources import resource

GOOD = """
grid: {shape: [12, 10, 4], min: [0, 0, 0], max: [1.2, 1.0, 0.4]}
boxes: [[5, 7, 0, 4, 0, 4]]
robots:
  - {name: cart, cell: [2, 2], yaw_deg: 90, cells: [[0, 0, 0], [0, -1, 0]]}
goals:
  - {cell: [9, 2], kind: Target, robot: cart}
  - {cell: [9, 8], kind: Debris, name: handle, yaw_deg: 0}
"""
SHIPPED = sorted(resource("scenes", "planning").glob("*.yaml"))


def content(**changes):
    return {**yaml.safe_load(GOOD), **changes}


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_scene_loads_and_survives_writing(path):
    scene = load_scene(path)
    assert scene.robots and scene.goals
    text = dump_scene(scene)
    assert dump_scene(parse_scene(yaml.safe_load(text))) == text


def test_there_are_shipped_scenes():
    assert len(SHIPPED) >= 5


def test_what_is_read():
    scene = parse_scene(content())
    assert scene.spec.shape == (12, 10, 4)
    assert scene.occupied().sum() == 2 * 4 * 4
    cart = scene.robots[0]
    assert cart.start.column == (2, 2) and cart.start.yaw_rad == pytest.approx(math.pi / 2)
    assert scene.assignments == {"cart": "goals[0]"}
    assert scene.goals["handle"].kind == "Debris" and scene.goals["handle"].yaw_rad == 0.0


def test_cells_turn_with_the_robot():
    scene = parse_scene(content())
    turned = scene.robots[0].mask(scene.spec, math.pi)
    assert turned.cells.tolist() == [[0, 0, 0], [1, 0, 0]]


def test_request_holds_the_map_without_robots_and_names_boxes():
    request = parse_scene(content(boxes=[[5, 7, 0, 4, 0, 4], [2, 4, 2, 3, 0, 1]])).request()
    assert request.occupied[5, 0, 0] and request.occupied[3, 2, 0]
    assert not request.occupied[2, 2, 0] and not request.occupied[0, 0, 0]
    assert np.array_equal(np.unique(request.objects["boxes[0]"][:, 0]), [5, 6])


FAULTS = [
    ({"grid": {"shape": [12, 10], "min": [0, 0, 0], "max": [1, 1, 1]}}, "grid.shape"),
    ({"grid": {"shape": [12, 10, 4], "min": [0, 0, 0]}}, "grid.max is missing"),
    ({"grid": {"shape": [12, 10, 4], "min": [0, 0, 9], "max": [1, 1, 1]}}, "grid"),
    ({"grid": {"shape": [12, 10, 99], "min": [0, 0, 0], "max": [1, 1, 1]}}, "grid"),
    ({"grid": {"shape": [99999, 99999, 9], "min": [0, 0, 0], "max": [1, 1, 1]}}, "grid.shape"),
    ({"grid": 7}, "grid = 7"),
    ({"boxes": [[0, 1, 2]]}, "boxes[0]"),
    ({"boxes": [[0, 99, 0, 4, 0, 4]]}, "boxes[0]"),
    ({"boxes": [[3, 3, 0, 4, 0, 4]]}, "boxes[0]"),
    ({"boxes": "none"}, "boxes"),
    ({"robots": []}, "robots"),
    ({"robots": [{"cell": [2, 2], "shape": "ankurbot"}]}, "robots[0].name is missing"),
    ({"robots": [{"name": "cart", "cell": [2, 2]}]}, "robots[0]"),
    ({"robots": [{"name": "cart", "cell": [99, 2], "cells": [[0, 0, 0]]}]}, "robots[0].cell"),
    ({"robots": [{"name": "cart", "cell": [2.5, 2], "cells": [[0, 0, 0]]}]}, "robots[0].cell"),
    ({"robots": [{"name": "cart", "cell": [2, 2], "cells": []}]}, "robots[0].cells"),
    ({"robots": [{"name": "cart", "cell": [2, 2], "cells": [[0, 0, 9]]}]}, "robots[0].cells"),
    ({"robots": [{"name": "cart", "cell": [2, 2], "cells": [[0, 0, 0], [50, 0, 0]]}]}, "robots[0].cells"),
    (
        {
            "grid": {"shape": [12, 10, 20], "min": [0, 0, 0], "max": [1.2, 1.0, 1.3]},
            "robots": [{"name": "cart", "cell": [2, 2], "shape": "ankurbot"}],
        },
        "robots[0].shape",
    ),
    ({"robots": [{"name": "cart", "cell": [2, 2], "shape": "tank"}]}, "robots[0].shape"),
    ({"robots": [{"name": "cart", "cell": [2, 2], "yaw_deg": float("nan"), "cells": [[0, 0, 0]]}]}, "yaw_deg"),
    ({"robots": [{"name": "cart", "cell": [2, 2], "colour": "red", "cells": [[0, 0, 0]]}]}, "robots[0].colour"),
    ({"goals": [{"cell": [9, 2], "kind": "Lunch"}]}, "goals[0].kind"),
    ({"goals": [{"cell": [-1, 2], "kind": "Target"}]}, "goals[0].cell"),
    ({"goals": [{"cell": [9, 2], "kind": "Target", "robot": "ghost"}]}, "goals[0].robot"),
    ({"goals": [{"cell": [9, 2], "kind": "Target", "robot": "cart"}] * 2}, "goals[1].robot"),
    ({"goal": []}, "goal"),
    ({"goals": [{"cell": [9, 2], "kind": "Target", "yaw_deg": 10**400}]}, "goals[0].yaw_deg"),
    ({"robots": None}, "robots"),
    ({"grid": {"shape": [2000, 2, 2], "min": [0, 0, 0], "max": [9, 9, 9]}}, "grid.shape"),
    ({"grid": {"shape": [12, 10, 4], "min": [0, 0, 0], "max": [0.012, 0.01, 0.004]}}, "cells of 0.02 to 10 m"),
    ({"boxes": [[0, 12, 0, 10, 0, 4]] * 1001}, "boxes = '1001 entries': expected at most 1000"),
    ({"boxes": [[0, 12, 0, 10, 4, 9]]}, "boxes[0] = [0, 12, 0, 10, 4, 9]: expected 0 <= z0 < z1 <= 4"),
    ({"robots": [{"name": f"r{i}", "cell": [2, 2], "cells": [[0, 0, 0]]} for i in range(51)]}, "at most 50"),
    ({"robots": [{"name": "r", "cell": [2, 2], "cells": [[0, 0, 0]] * 10_001}]}, "at most 10000"),
    ({"robots": [{"name": "r", "cell": [2, 2], "cells": [[0, 0, 10**9]]}]}, "robots[0].cells[0]"),
    ({"goals": [{"cell": [9, 2], "kind": "Target"}] * 201}, "goals = '201 entries': expected at most 200"),
    (
        {
            "grid": {"shape": [12, 10, 4], "min": [0, 0, 5], "max": [12, 10, 6]},
            "robots": [{"name": "r", "cell": [2, 2], "shape": "ankurbot"}],
        },
        "robots[0].shape",
    ),
    (
        {
            "grid": {"shape": [500, 500, 4], "min": [0, 0, 0], "max": [50, 50, 0.4]},
            "boxes": [[0, 500, 0, 500, 0, 4]] * 3,
        },
        "boxes = '3000000 cells in all boxes': expected at most 2000000",
    ),
]


@pytest.mark.parametrize("changes,key", FAULTS)
def test_fault_is_named_by_file_key_and_value(changes, key):
    with pytest.raises(SceneError) as caught:
        parse_scene(content(**changes), "bad.yaml")
    assert any(line.startswith("bad.yaml: ") and key in line for line in str(caught.value).splitlines())
    assert "expected" in str(caught.value)


def test_every_fault_is_listed_at_once():
    bad = content(boxes=[[0, 1, 2]], goals=[{"cell": [9, 2], "kind": "Lunch"}], extra=1)
    with pytest.raises(SceneError) as caught:
        parse_scene(bad)
    assert len(str(caught.value).splitlines()) == 3


@pytest.mark.parametrize("whole", [None, [], 3, "text"])
def test_a_file_that_is_no_mapping(whole):
    with pytest.raises(SceneError, match="mapping"):
        parse_scene(whole)


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(SceneError, match="no such file"):
        load_scene(tmp_path / "none.yaml")
    broken = tmp_path / "broken.yaml"
    broken.write_text("grid: [1, 2", encoding="utf-8")
    with pytest.raises(SceneError, match="not readable as YAML"):
        load_scene(broken)
    binary = tmp_path / "binary.yaml"
    binary.write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(SceneError, match="not readable as YAML"):
        load_scene(binary)


def test_the_limits_admit_the_largest_grid_that_is_benchmarked():
    grid = {"shape": [200, 200, 20], "min": [-10, -10, 0.01], "max": [10, 10, 1.3]}
    assert parse_scene(content(grid=grid)).spec.n_cells == 800_000


def plain_values(depth: int = 3) -> st.SearchStrategy[Any]:
    """Whatever YAML can hold, in small."""
    leaves = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=6)
    keys = st.sampled_from(["grid", "shape", "min", "max", "cell", "cells", "name", "kind", "robot", 7])
    return st.recursive(
        leaves, lambda v: st.lists(v, max_size=6) | st.dictionaries(keys, v, max_size=4), max_leaves=3**depth
    )


PLACES = [
    ("grid",),
    ("grid", "shape"),
    ("grid", "min"),
    ("grid", "max"),
    ("boxes",),
    ("boxes", 0),
    ("robots",),
    ("robots", 0),
    *(("robots", 0, key) for key in ("name", "cell", "yaw_deg", "cells", "shape")),
    ("goals",),
    ("goals", 0),
    *(("goals", 0, key) for key in ("name", "cell", "kind", "yaw_deg", "robot")),
]


@settings(max_examples=400)
@given(st.lists(st.tuples(st.sampled_from(PLACES), plain_values()), min_size=1, max_size=3))
def test_any_value_anywhere_gives_a_scene_or_a_scene_error(changes):
    scene: Dict[str, Any] = content()
    for path, value in changes:
        place: Any = scene
        for key in path[:-1]:
            inside = isinstance(place, dict) and key in place
            inside = inside or (isinstance(place, list) and isinstance(key, int) and key < len(place))
            place = place[key] if inside else {}
        if isinstance(place, dict) or (isinstance(place, list) and path[-1] == 0 and place):
            place[path[-1]] = value
    try:
        read = parse_scene(scene, "fuzz.yaml")
    except SceneError as error:
        assert all(line.startswith("fuzz.yaml: ") for line in str(error).splitlines() if line.strip())
        return
    assert dump_scene(parse_scene(yaml.safe_load(dump_scene(read)))) == dump_scene(read)
    read.request()
