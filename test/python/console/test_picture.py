"""What a page is sent holds what the system holds: every body, frame, cell and line, in one order."""

from __future__ import annotations

import math

import numpy as np

from yarm.console.picture import Area, BodyDrawing, CameraDrawing, Line, Scene, state_message
from yarm.console.trails import POINTS, STEP_M, Trails
from yarm.console.wire import decode
from yarm.geometry import CellMap, GridSpec, MappedObject
from yarm.geometry.solids import Shape, Solid

SPEC = GridSpec()


def scene():
    pose = np.eye(4)
    pose[:3, 3] = 1.0, 2.0, 3.0
    base = ("r/base_link", Solid(Shape.CYLINDER, (0.3, 0.5), pose))
    robot = BodyDrawing(
        "r", "Mobile", "dynamic", "r/ee", [base, ("r/arm", Solid(Shape.BOX, (0.1, 0.2, 0.3), np.eye(4)))]
    )
    debris = BodyDrawing("d", "Debris", "dynamic", "d")
    camera = CameraDrawing("camera 1", "eye", "points_1", math.radians(45.0), math.radians(30.0))
    return Scene([robot, debris], [camera], [Area("arm", (0.0, 0.0, 0.0), (1.0, 2.0, 0.1))])


def thing(name, cells):
    return MappedObject(name, "Debris", 1, (0.0, 0.0, 0.5), (0.0, 0.0, 0.0, 1.0), np.array(cells).reshape(-1, 3))


def test_a_scene_says_where_each_solid_hangs_and_how_big_it_is():
    header, arrays = decode(scene().message(7))
    assert (header["kind"], header["version"]) == ("scene", 7)
    frames = header["frames"]
    assert sorted(frames) == ["d", "eye", "r/arm", "r/base_link", "r/ee"]
    assert [frames[body["frame"]] for body in header["bodies"]] == ["r/ee", "d"]
    assert [(frames[s["frame"]], s["body"], s["shape"]) for s in header["solids"]] == [
        ("r/base_link", 0, "cylinder"),
        ("r/arm", 0, "box"),
    ]
    np.testing.assert_allclose(arrays["solid_size"], [[0.6, 0.6, 0.5], [0.1, 0.2, 0.3]], atol=1e-6)
    assert arrays["solid_pose"].reshape(-1, 4, 4)[0, :3, 3].tolist() == [1.0, 2.0, 3.0]
    (camera,) = header["cameras"]
    assert (frames[camera["frame"]], camera["source"]) == ("eye", "points_1")
    assert math.isclose(camera["across"], 1.0)
    assert header["areas"] == [{"name": "arm", "lower": [0.0, 0.0, 0.0], "upper": [1.0, 2.0, 0.1]}]


def test_a_state_brings_poses_cells_and_lines_in_the_order_it_names():
    drawn = scene()
    cell_map = CellMap(
        4.5,
        SPEC,
        np.zeros(SPEC.shape, np.int8),
        {"b": thing("b", [[1, 2, 3]]), "a": thing("a", [[4, 5, 6], [7, 8, 9]])},
    )
    lines = [Line("path", "r", np.ones((2, 3))), Line("driven", "r", np.zeros((3, 3)))]
    poses = {"r/ee": (1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0)}
    header, arrays = decode(state_message({"time_s": 4.6}, drawn, 7, poses, cell_map, lines))
    assert (header["time_s"], header["scene"], header["grid"]["stamp_s"]) == (4.6, 7, 4.5)
    assert header["grid"]["shape"] == list(SPEC.shape)
    known = arrays["poses"][drawn.frames.index("r/ee")]
    assert known.tolist() == [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0]
    assert np.isnan(arrays["poses"]).all(axis=1).sum() == len(drawn.frames) - 1, "frames nobody has heard of"
    assert [(each["name"], each["cells"]) for each in header["objects"]] == [("a", 2), ("b", 1)]
    assert arrays["cells"].tolist() == [[4, 5, 6], [7, 8, 9], [1, 2, 3]]
    assert [(line["layer"], line["count"]) for line in header["lines"]] == [("path", 2), ("driven", 3)]
    assert arrays["points"].sum() == 6.0


def test_a_system_that_says_nothing_is_a_picture_too():
    header, arrays = decode(state_message({}, Scene(), 0, {}, None, []))
    assert (header["grid"], header["objects"], header["lines"]) == ({}, [], [])
    assert all(len(array) == 0 for array in arrays.values())


def test_trails_keep_a_point_every_few_centimetres_and_the_newest_of_them():
    trails = Trails()
    for i in range(3 * POINTS):
        trails.follow("r", i * 0.6 * STEP_M, 0.0)
    (line,) = trails.lines(0.1)
    assert (line.layer, line.name, len(line.points)) == ("driven", "r", POINTS)
    np.testing.assert_allclose(np.diff(line.points[:, 0]), 1.2 * STEP_M)
    assert line.points[-1, 0] > (3 * POINTS - 3) * 0.6 * STEP_M
    assert (line.points[:, 2] == 0.1).all()
    trails.clear()
    assert trails.lines(0.1) == []


def test_who_stands_leaves_no_trail():
    trails = Trails()
    for _ in range(5):
        trails.follow("r", 1.0, 1.0)
    assert trails.lines(0.0) == []
