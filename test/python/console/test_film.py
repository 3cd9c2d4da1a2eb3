"""Films: what was put in comes out, block by block; what is too old goes; a broken file is refused with its name."""

from __future__ import annotations

import numpy as np
import pytest

from support.films import events, scene, shown, state, taken
from yarm.console.film import BLOCK_S, MAGIC, MOST_EVENTS, Film, FilmError, pack, unpack
from yarm.console.wire import pieces_of


def test_a_message_in_pieces_is_the_message():
    message = state(1.5)
    pieces = pieces_of(message)
    assert len(pieces) == 3
    assert b"".join(pieces) == message


def test_what_was_put_in_comes_out_in_its_order():
    blocks = shown(taken(45))
    states = [time_s for block in blocks for time_s, header in block if header["kind"] == "state"]
    assert states == [0.5 * i for i in range(45)]
    assert all(header["time_s"] == time_s for block in blocks for time_s, header in block if "time_s" in header)


def test_each_block_can_be_shown_without_the_ones_before():
    blocks = shown(taken(45))
    assert len(blocks) > 3
    for block in blocks:
        assert block[0][1]["kind"] == "scene"
        assert block[0][1]["version"] == int(block[0][0] // 15.0)
        assert block[-1][0] - block[0][0] <= BLOCK_S


def test_the_index_says_what_there_is():
    index = taken(45).index()
    assert [entry["pictures"] for entry in index["blocks"]] == [10, 10, 10, 10, 5]
    assert (index["blocks"][0]["first_s"], index["blocks"][-1]["last_s"]) == (0.0, 22.0)


def test_what_is_the_same_is_kept_once():
    rng = np.random.default_rng(3)
    noise = rng.integers(0, 255, (4000, 3))
    entries = [(float(i), pieces_of(state(0.0, noise))) for i in range(25)]
    assert len(pack(entries)) < 1.2 * len(pack(entries[:1]))


def test_what_is_older_than_is_kept_goes_and_numbers_stay():
    film = taken(200, keep_s=20.0)
    index = film.index()
    assert film.block(0) is None
    assert index["first"] > 0
    assert 20.0 - BLOCK_S <= index["blocks"][-1]["last_s"] - index["blocks"][0]["first_s"] <= 20.0 + 2 * BLOCK_S
    times = [time_s for time_s, _ in unpack(film.block(index["first"]))]
    assert times[0] == index["blocks"][0]["first_s"]
    assert film.block(index["first"] + len(index["blocks"])) is None


def test_a_block_that_is_being_filled_can_be_shown():
    film = taken(3)
    assert [time_s for time_s, header in shown(film)[0] if header["kind"] == "state"] == [0.0, 0.5, 1.0]
    film.add(1.5, {"scene": scene(0)}, state(1.5))
    assert shown(film)[0][-1][0] == 1.5


def test_time_that_begins_anew_begins_a_new_film():
    film = taken(45)
    numbers = film.index()["first"] + len(film.index()["blocks"])
    film.add(1.0, {"scene": scene(7)}, state(1.0))
    index = film.index()
    assert [entry["first_s"] for entry in index["blocks"]] == [1.0]
    assert index["first"] >= numbers, "a number means one block for ever"


def test_events_of_the_whole_film_are_in_its_index():
    film = Film()
    film.add(0.0, {"events": events(1, "a", "b")}, state(0.0))
    film.add(9.0, {"events": events(2, "b", "c")}, state(9.0))
    assert {event["text"] for event in film.index()["events"]} == {"a", "b", "c"}
    for i in range(3 * MOST_EVENTS // 100):
        film.add(10.0 + i, {"events": events(3 + i, *(f"{i}/{j}" for j in range(100)))}, state(10.0 + i))
    assert len(film.index()["events"]) == MOST_EVENTS
    assert film.index()["events"][-1]["text"].endswith("/99")


def test_a_file_gives_back_the_film(tmp_path):
    film = taken(45)
    film.note("something is left out")
    film.note("something is left out")
    film.write(tmp_path / "run.film")
    again = Film.read(tmp_path / "run.film")
    assert again.index() == film.index()
    assert shown(again) == shown(film)
    assert again.notes == ["something is left out"]


def test_a_film_that_lost_its_beginning_is_written_from_number_0(tmp_path):
    taken(200, keep_s=20.0).write(tmp_path / "run.film")
    again = Film.read(tmp_path / "run.film")
    assert again.index()["first"] == 0
    assert again.block(0) is not None


@pytest.mark.parametrize("harm", ["gone", "empty", "foreign", "cut", "words"])
def test_a_file_that_is_no_film_is_refused_by_its_name(tmp_path, harm):
    path = tmp_path / "run.film"
    taken(45).write(path)
    data = path.read_bytes()
    harmed = {"empty": b"", "foreign": b"#ROSBAG V2.0\n", "cut": data[:-40], "words": MAGIC + b"\x04\0\0\0{]}x"}
    path.unlink() if harm == "gone" else path.write_bytes(harmed[harm])
    with pytest.raises(FilmError, match=r"run\.film is no film"):
        Film.read(path)
