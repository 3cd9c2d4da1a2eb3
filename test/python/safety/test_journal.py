"""Journals: what is read is what was written, however the file was cut off, mixed up or meant for somebody else."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from yarm.safety.journal import Journal

settings.register_profile("journal", deadline=None, derandomize=True)
settings.load_profile("journal")

RECORDS = [{"step": i, "words": "ä" * i} for i in range(4)]
VALUES = st.none() | st.booleans() | st.integers(-(2**40), 2**40) | st.floats(allow_nan=False) | st.text(max_size=20)
RECORD = st.dictionaries(st.text(max_size=6), VALUES | st.lists(VALUES, max_size=3), max_size=4)


@pytest.fixture(name="path")
def fixture_path(tmp_path):
    return tmp_path / "run" / "node.journal"


def written(path, records=RECORDS, of="node", life="7-1"):
    journal, _ = Journal.open(path, of, life)
    journal.begin(records[:1])
    for record in records[1:]:
        journal.append(record, sync=True)
    journal.close()
    return path.read_bytes()


def found(path, of="node", life="7-1"):
    return Journal.open(path, of, life)[1]


def test_what_was_written_is_read_in_order(path):
    written(path)
    assert list(found(path).records) == RECORDS
    assert found(path).complaint == ""


def test_without_a_file_there_is_nothing_and_nothing_wrong(path):
    assert found(path).records == ()
    assert found(path).complaint == ""


def test_opening_alone_changes_nothing(path):
    before = written(path)
    Journal.open(path, "node", "another life")
    assert path.read_bytes() == before


def test_beginning_again_forgets_what_was(path):
    written(path)
    journal, _ = Journal.open(path, "node", "7-1")
    journal.begin([{"fresh": 1}])
    assert list(found(path).records) == [{"fresh": 1}]
    assert [file.name for file in path.parent.iterdir()] == [path.name]


def test_a_torn_last_line_is_left_out_and_said(path):
    text = written(path)
    path.write_bytes(text[:-5])
    assert list(found(path).records) == RECORDS[:-1]
    assert "its last line is cut off" in found(path).complaint


@pytest.mark.parametrize(
    ("of", "life", "words"),
    [("other", "7-1", "journal 'node', not 'other'"), ("node", "8-1", "life '7-1', not '8-1'")],
)
def test_another_ones_journal_is_not_taken_up(path, of, life, words):
    written(path)
    assert found(path, of, life).records == ()
    assert f"is another one's: {words}" in found(path, of, life).complaint


def test_a_damaged_line_in_the_middle_spoils_all_and_is_named(path):
    lines = written(path).split(b"\n")
    lines[2] = lines[2].replace(b"1", b"2")
    path.write_bytes(b"\n".join(lines))
    assert found(path).records == ()
    assert "is damaged in line 3 of 5" in found(path).complaint


@pytest.mark.parametrize("text", [b"", b"no journal", b"\x00\xff" * 50, b"00000000 {}\n", b"[" * 100000 + b"\n"])
def test_whatever_is_no_journal_is_said_to_be_none(path, text):
    path.parent.mkdir()
    path.write_bytes(text)
    assert found(path).records == ()
    assert "does not begin as a journal does" in found(path).complaint


def test_a_folder_in_its_place_is_a_complaint_and_an_error_to_the_writer(path):
    path.mkdir(parents=True)
    assert "cannot be read" in found(path).complaint
    with pytest.raises(OSError, match=r"directory|Is a"):
        Journal.open(path, "node", "7-1")[0].begin([])


def test_nothing_is_appended_before_it_is_begun(path):
    with pytest.raises(ValueError, match="begin the journal first"):
        Journal.open(path, "node", "7-1")[0].append({})


def test_what_is_discarded_is_not_taken_up(path):
    written(path)
    Journal.open(path, "node", "7-1")[0].discard()
    assert found(path).records == ()


@given(records=st.lists(RECORD, min_size=1, max_size=5), cut=st.floats(0.0, 1.0), noise=st.binary(max_size=30))
def test_cut_off_anywhere_and_with_anything_behind_only_whole_records_are_read(records, cut, noise):
    with TemporaryDirectory() as folder:
        path = Path(folder) / "node.journal"
        text = written(path, records)
        path.write_bytes(text[: round(cut * len(text))] + noise)
        kept = list(found(path).records)
        assert kept == records[: len(kept)]


@given(text=st.binary(max_size=300))
def test_any_bytes_are_read_without_a_crash(text):
    with TemporaryDirectory() as folder:
        path = Path(folder) / "node.journal"
        path.write_bytes(text)
        assert found(path).records == ()
