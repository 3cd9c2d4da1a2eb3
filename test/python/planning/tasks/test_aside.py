"""Who was moved aside into columns to be kept clear, and how long that counts."""

from __future__ import annotations

from yarm.planning.tasks.aside import StoodAside


def test_one_moved_inside_while_idle_stays_until_those_it_made_way_for_are_done() -> None:
    aside = StoodAside()
    assert aside.update({"a": False}, ["debris_1"]) == set()
    assert aside.update({"a": True}, ["debris_1"]) == {"a"}
    assert aside.update({"a": True}, ["debris_1", "debris_2"]) == {"a"}
    assert aside.update({"a": True}, ["debris_2"]) == set()


def test_one_that_came_inside_with_a_goal_of_its_own_is_sent_out_at_once() -> None:
    aside = StoodAside()
    assert aside.update({}, ["debris_1", "debris_2"]) == set()
    assert aside.update({"a": True}, ["debris_2"]) == set()


def test_inside_for_nobodys_sake_does_not_count() -> None:
    aside = StoodAside()
    aside.update({"a": False}, [])
    assert aside.update({"a": True}, []) == set()
    assert aside.update({"a": True}, ["debris_1"]) == set()


def test_leaving_or_a_goal_of_its_own_ends_it() -> None:
    for after in ({"a": False}, {}):
        aside = StoodAside()
        aside.update({"a": False}, ["debris_1"])
        aside.update({"a": True}, ["debris_1"])
        assert aside.update(after, ["debris_1"]) == set()
        assert aside.update({"a": True}, []) == set()
