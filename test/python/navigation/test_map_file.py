"""Map files: the format to the byte, both ways; whole or not at all; every fault of a file by name."""

from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from yarm.geometry.poses import Pose2
from yarm.navigation import map_file
from yarm.navigation.grid_map import GridMap
from yarm.navigation.map_file import MapFileError, parse_pgm, pgm_bytes, read_map, write_map, writing_fault

GOOD = {
    "image": "room.pgm",
    "resolution": 0.05,
    "origin": [-1.0, 2.0, 0.5],
    "negate": 0,
    "occupied_thresh": 0.65,
    "free_thresh": 0.196,
}
SHADES = np.array([[0, 254, 205], [100, 80, 200]], np.uint8)


def sample() -> GridMap:
    """Three columns, two rows, every kind of value; row 0 is the lower one."""
    return GridMap(np.array([[0, 100, -1], [25, 65, 50]], np.int8), 0.05, Pose2(-1.0, 2.0, 0.0))


def room(folder: Path, **changes: object) -> Path:
    """A map with some keys changed; None leaves a key out."""
    (folder / "room.pgm").write_bytes(b"P5\n3 2\n255\n" + SHADES.tobytes())
    keys = {key: value for key, value in {**GOOD, **changes}.items() if value is not None}
    path = folder / "room.yaml"
    path.write_text(yaml.safe_dump(keys))
    return path


def test_image_to_the_byte() -> None:
    head, pixels = pgm_bytes(sample())[:-6], pgm_bytes(sample())[-6:]
    assert list(pixels) == [254, 0, 205, 254, 0, 205]  # the upper row first
    lines = head.decode().splitlines()
    assert lines[0] == "P5" and lines[1].startswith("# CREATOR: ") and lines[1].endswith(" 0.050 m/pix")
    assert lines[2:] == ["3 2", "255"]


def test_yaml_to_the_byte(tmp_path: Path) -> None:
    files = write_map(sample(), tmp_path / "first.floor")
    assert files.description == tmp_path / "first.floor.yaml"
    assert files.description.read_text() == (
        "image: first.floor.pgm\nresolution: 0.050000\norigin: [-1.000000, 2.000000, 0.000000]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n\n"
    )


def test_thresholds_of_the_command_line() -> None:
    assert list(pgm_bytes(sample(), occupied=70, free=24)[-6:]) == [205, 205, 205, 254, 0, 205]
    assert list(pgm_bytes(sample(), occupied=50, free=0)[-6:]) == [205, 0, 0, 254, 0, 205]


@pytest.mark.parametrize("occupied, free", [(0, 0), (101, 25), (65, -1), (65, 65), (20, 25)])
def test_thresholds_that_cannot_be(tmp_path: Path, occupied: int, free: int) -> None:
    with pytest.raises(MapFileError, match=r"threshold is .* expected"):
        write_map(sample(), tmp_path / "map", occupied, free)
    assert list(tmp_path.iterdir()) == []


@given(
    st.integers(1, 30),
    st.integers(1, 30),
    st.integers(0, 2**32 - 1),
    st.floats(0.01, 1.0),
    st.tuples(*[st.floats(-50.0, 50.0)] * 2, st.floats(-3.1, 3.1)),
)
def test_what_is_written_is_read(
    tmp_path_factory: pytest.TempPathFactory, rows: int, columns: int, seed: int, resolution_m: float, origin: tuple
) -> None:
    values = np.random.default_rng(seed).choice(np.array([-1, 0, 100], np.int8), (rows, columns))
    files = write_map(GridMap(values, resolution_m, Pose2(*origin)), tmp_path_factory.mktemp("maps") / "map")
    found = read_map(files.description)
    np.testing.assert_array_equal(found.cells, values)
    assert found.resolution_m == pytest.approx(resolution_m, abs=1e-6)
    assert (found.origin.x, found.origin.y, found.origin.yaw_rad) == pytest.approx(origin, abs=1e-6)


def test_older_files_give_way_and_nothing_is_left_over(tmp_path: Path) -> None:
    write_map(sample(), tmp_path / "map")
    write_map(GridMap(np.zeros((4, 4), np.int8), 0.1, Pose2(0.0, 0.0)), tmp_path / "map")
    assert read_map(tmp_path / "map.yaml").cells.shape == (4, 4)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["map.pgm", "map.yaml"]


@pytest.mark.parametrize("failing", [1, 2])
def test_a_full_disk_leaves_the_older_map_as_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failing: int
) -> None:
    write_map(sample(), tmp_path / "map")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    calls = []

    def fsync(handle: int) -> None:
        calls.append(handle)
        if len(calls) == failing:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", fsync)
    with pytest.raises(MapFileError, match=r"map.pgm cannot be written: No space left on device"):
        write_map(GridMap(np.zeros((9, 9), np.int8), 0.1, Pose2(0.0, 0.0)), tmp_path / "map")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_folder_that_is_not_there_is_said_before(tmp_path: Path) -> None:
    assert writing_fault(tmp_path / "map") == ""
    assert list(tmp_path.iterdir()) == []
    assert "No such file or directory" in writing_fault(tmp_path / "nowhere" / "map")
    with pytest.raises(MapFileError, match=r"is .*nowhere a folder with room"):
        write_map(sample(), tmp_path / "nowhere" / "map")


def test_a_file_in_place_of_the_folder(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert "Not a directory" in writing_fault(tmp_path / "file" / "map")
    with pytest.raises(MapFileError, match="Not a directory"):
        write_map(sample(), tmp_path / "file" / "map")


def test_trinary_and_its_borders(tmp_path: Path) -> None:
    values = read_map(room(tmp_path)).cells
    assert values.tolist() == [[-1, 100, -1], [100, 0, -1]]  # 100: 0.608, 80: 0.686, 200: 0.216; lower row first


def test_negate_turns_the_shades_round(tmp_path: Path) -> None:
    assert read_map(room(tmp_path, negate=1)).cells.tolist() == [[-1, -1, 100], [0, 100, 100]]


def test_scale_gives_what_lies_between(tmp_path: Path) -> None:
    values = read_map(room(tmp_path, mode="scale")).cells
    expected = [1 + 98 * ((255 - shade) / 255 - 0.196) / (0.65 - 0.196) for shade in (100, 200, 205)]
    assert values[0].tolist() == [int(expected[0]), 100, int(expected[1])]
    assert values[1].tolist() == [100, 0, int(expected[2])]


def test_raw_takes_the_shades_themselves(tmp_path: Path) -> None:
    assert read_map(room(tmp_path, mode="raw")).cells.tolist() == [[100, 80, -1], [0, -1, -1]]
    assert read_map(room(tmp_path, mode="raw", negate=1)).cells.tolist() == [[-1, -1, 55], [-1, 1, 50]]


def test_other_resolution_and_rotated_origin(tmp_path: Path) -> None:
    found = read_map(room(tmp_path, resolution=0.02, origin=[3.0, -4.0, -math.pi / 3]))
    assert found.resolution_m == 0.02
    assert found.origin == Pose2(3.0, -4.0, -math.pi / 3)


def test_image_by_absolute_path(tmp_path: Path) -> None:
    room(tmp_path)
    (tmp_path / "elsewhere").mkdir()
    moved = tmp_path / "elsewhere" / "map.yaml"
    moved.write_text(yaml.safe_dump({**GOOD, "image": str(tmp_path / "room.pgm")}))
    assert read_map(moved).cells.shape == (2, 3)


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"image": None}, "room.yaml: image is missing: expected a text"),
        ({"image": "no.pgm"}, "image = .*no.pgm'.*: expected a PGM file that can be read: .*No such file"),
        ({"resolution": 0.0}, "resolution = 0.0: expected a number within 0.001 to 100 m"),
        ({"resolution": "fine"}, "resolution = 'fine'"),
        ({"resolution": None}, "resolution is missing"),
        ({"origin": [0.0, 0.0]}, "origin = .*expected a list of 3 numbers"),
        ({"origin": [0.0, 0.0, 90.0]}, "yaw within -2 pi to 2 pi rad; is it in degrees?"),
        ({"origin": [0.0, float("nan"), 0.0]}, "origin = "),
        ({"negate": None}, "negate is missing: expected 0 or 1"),
        ({"negate": 2}, "negate = 2: expected 0 or 1"),
        ({"occupied_thresh": 1.5}, "occupied_thresh = 1.5: expected a number within 0 to 1"),
        ({"free_thresh": 0.7}, "free_thresh = 0.7: expected less than occupied_thresh, 0.65"),
        ({"mode": "fancy"}, "mode = 'fancy': expected one of trinary, scale, raw"),
    ],
)
def test_a_wrong_key_is_named(tmp_path: Path, changes: dict, words: str) -> None:
    with pytest.raises(MapFileError, match=words):
        read_map(room(tmp_path, **changes))


def test_all_faults_at_once(tmp_path: Path) -> None:
    with pytest.raises(MapFileError) as error:
        read_map(room(tmp_path, resolution=-1.0, negate=None, mode="x"))
    assert len(str(error.value).splitlines()) == 3


def test_a_yaml_that_is_not_there_or_none(tmp_path: Path) -> None:
    with pytest.raises(MapFileError, match="no such file"):
        read_map(tmp_path / "map.yaml")
    (tmp_path / "map.yaml").write_text("image: [")
    with pytest.raises(MapFileError, match="not readable as YAML"):
        read_map(tmp_path / "map.yaml")


def test_keys_of_other_programs_are_left_alone(tmp_path: Path) -> None:
    assert read_map(room(tmp_path, author="somebody")).cells.shape == (2, 3)


@pytest.mark.parametrize(
    "data, words",
    [
        (b"", "begins with b''"),
        (b"\x89PNG\r\n\x1a\n", "expected a PGM"),
        (b"P6\n1 1\n255\nxxx", "expected a PGM"),
        (b"P5\n2 2\n255\nabc", r"holds 3 shades: expected 2 x 2 = 4; cut off\?"),
        (b"P5\n0 2\n255\n", "size = 0 x 2"),
        (b"P5\n99999 99999\n255\n", "size = 99999 x 99999"),
        (b"P5\n1 1\n65535\nab", "largest shade = 65535: expected 1 to 255"),
        (b"P5\n1 1\n100\nz", "a shade of 122: expected at most 100"),
        (b"P2\n1 1\n255\n300\n", "whole numbers 0 to 255"),
        (b"P2\n1 1\n255\nzero\n", "whole numbers 0 to 255"),
    ],
)
def test_an_image_that_is_none(data: bytes, words: str) -> None:
    with pytest.raises(MapFileError, match=words):
        parse_pgm(data, "x.pgm")


def test_other_images_that_are_good() -> None:
    plain = b"P2 # plain\n# a comment\n2 1\n15\n0 15 # the end\n"
    assert parse_pgm(plain, "x").tolist() == [[0, 255]]
    assert parse_pgm(b"P5\n2 1\n#c\n255\n\x01\x02more", "x").tolist() == [[1, 2]]


def test_a_map_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(map_file, "MOST_CELLS", 3)
    with pytest.raises(MapFileError, match="2 x 2: expected 1 to 3 cells"):
        parse_pgm(b"P5\n2 2\n255\nabcd", "x")
