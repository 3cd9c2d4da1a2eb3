"""What a page shows of a robot in a room: its map, its place, what it sees, boxes with verdicts."""

from __future__ import annotations

import math

import numpy as np
import pytest
from nav_msgs.msg import OccupancyGrid
from visualization_msgs.msg import Marker, MarkerArray
from yarm.msg import ExplorerStatus, SafetyStatus

from support.room_bag import (
    CORNER_M,
    LENGTH_S,
    ODOM_AT_M,
    RESOLUTION_M,
    SCAN_M,
    SHAPE,
    SPEED_MPS,
    WALL_ROW,
    write_room_bag,
)
from yarm.console.film import unpack
from yarm.console.room import UNSEEN, Marks
from yarm.console.wire import decode
from yarm.ros.common import names
from yarm.ros.console.bags import film_of_bag
from yarm.ros.console.room_book import RoomBook, draw
from yarm.ros.console.system_book import SystemBook
from yarm.ros.console.transforms import PoseBook


def newest(film):
    """Of each kind the last message: header and arrays."""
    index = film.index()
    entries = [entry for i in range(len(index["blocks"])) for entry in unpack(film.block(i))]
    return {found[0]["kind"]: found for found in (decode(message) for _, message in entries)}


@pytest.fixture
def shown(tmp_path):
    return newest(film_of_bag(write_room_bag(tmp_path / "run.bag"), 0.2))


def test_the_robot_is_where_its_frames_say(shown):
    header, arrays = shown["state"]
    last_s = LENGTH_S - 0.1
    wanted = (ODOM_AT_M[0] + SPEED_MPS * last_s, ODOM_AT_M[1], 0.0, 0.0, 0.0, 0.0, 1.0)
    np.testing.assert_allclose(arrays["poses"][0], wanted, atol=1e-5)
    assert [body["name"] for body in shown["scene"][0]["bodies"]] == ["turtlebot"]
    assert header["scene"] == shown["scene"][0]["version"]


def test_the_map_is_drawn_with_what_nobody_has_seen(shown):
    header, arrays = shown["map"]
    cells = arrays["cells"].reshape(header["height"], header["width"])
    assert cells.shape == SHAPE
    assert set(cells[WALL_ROW]) == {100}
    assert set(cells[WALL_ROW - 1]) == {UNSEEN}
    assert set(cells[WALL_ROW + 1]) == {0}
    low_y = CORNER_M[1] + WALL_ROW * RESOLUTION_M
    high = (CORNER_M[0] + SHAPE[1] * RESOLUTION_M, CORNER_M[1] + SHAPE[0] * RESOLUTION_M)
    np.testing.assert_allclose(header["seen"], (CORNER_M[0], low_y, *high))


def test_ways_particles_and_every_second_beam_are_on_the_map(shown):
    header, arrays = shown["state"]
    layers = {line["layer"]: line["count"] for line in header["lines"]}
    assert layers == {"driven": pytest.approx(15, abs=2), "path": 2, "particles": 2, "scan": 1}
    first = sum(line["count"] for line in header["lines"]) - layers["scan"]
    x_m = ODOM_AT_M[0] + SPEED_MPS * (LENGTH_S - 0.1) + 0.1
    wanted = [(x_m + SCAN_M, ODOM_AT_M[1], 0.0)]
    np.testing.assert_allclose(arrays["points"][first:], wanted, atol=1e-5)


def test_marks_are_solids_words_and_lines(shown):
    header, arrays = shown["marks"]
    assert [solid["shape"] for solid in header["solids"]] == ["box"]
    assert header["texts"] == [{"text": "7: tag 3", "at": [0.0, 0.0, 0.0]}]
    assert [line["count"] for line in header["lines"]] == [2]
    assert arrays["size"].shape == (1, 3)


def test_an_exploration_says_how_it_stands(shown):
    room = shown["state"][0]["room"]
    assert room["title"] == "Exploration"
    assert ["known", "4.5 m\u00b2"] in room["facts"]
    assert room["verdicts"] == []


def test_an_inspection_has_its_verdicts(tmp_path):
    found = newest(film_of_bag(write_room_bag(tmp_path / "run.bag", inspected=True), 0.2))
    room = found["state"][0]["room"]
    assert room["title"] == "Inspection"
    assert [(each["box"], each["tag"], each["probability"]) for each in room["verdicts"]] == [
        (7, "tag 3", 0.998),
        (8, "unknown", 0.9),
    ]


def test_a_mark_that_is_deleted_is_gone(tmp_path):
    book = RoomBook(PoseBook(print), print)
    take = book.routes()[names.explorer("bumps")].take
    mark = Marker(type=Marker.TEXT_VIEW_FACING, text="here")
    mark.header.frame_id = "map"
    for action, wanted in ((Marker.ADD, ["here"]), (Marker.DELETE, []), (Marker.ADD, ["here"]), (Marker.DELETEALL, [])):
        mark.action = action
        take(MarkerArray([mark]))
        assert [each["text"] for each in decode(book.parts()["marks"].message)[0]["texts"]] == wanted


def test_a_room_with_a_stop_is_a_room_and_says_who_stopped_it():
    book = SystemBook(lambda _: [], print)

    def state(topic, message):
        book.routes()[topic].take(message)
        book.heard(topic, 1.0, 1.0)
        return decode(book.state(1.0, 1.0))[0]

    assert state(names.explorer("status"), ExplorerStatus(state="exploring"))["stop"] is None
    shown = state(names.SAFETY_STATUS, SafetyStatus(latched=True, reason="stopped by somebody"))
    assert shown["room"]["title"] == "Exploration"
    assert shown["stop"] == {"latched": True, "reason": "stopped by somebody"}
    assert decode(book.state(9.0, 9.0))[0]["silent"] == [
        f"nothing heard on {topic} for 8 s: what is shown is old"
        for topic in (names.explorer("status"), names.SAFETY_STATUS)
    ]


@pytest.mark.parametrize(("width", "values"), [(0, 0), (3, 5), (100_000, 0)])
def test_a_map_that_cannot_be_is_left_out_and_told(width, values):
    said = []
    book = RoomBook(PoseBook(print), said.append)
    message = OccupancyGrid(data=[0] * values)
    message.info.width, message.info.height = width, 2
    book.routes()[names.MAP].take(message)
    assert "map" not in book.parts()
    assert f"{width} x 2 cells, {values} values" in said[0]


def test_a_mark_with_numbers_that_are_none_is_not_drawn():
    marks, mark = Marks(), Marker(type=Marker.SPHERE)
    mark.scale.x, mark.scale.y, mark.scale.z = math.nan, 1.0, 1.0
    draw(marks, mark)
    assert marks.solids == []
