"""Seeds from transforms: ticks, chains of frames, objects that come and go, time that starts again."""

from __future__ import annotations

import math

import pytest

from yarm.ros.seeds.tracker import STATIC_STAMP, Link, RegisteredSeed, SeedTracker

UNIT = (0.0, 0.0, 0.0, 1.0)
ROBOT = RegisteredSeed("ankurbot_1", "Mobile", "dynamic", "ankurbot_1/ee")
TABLE = RegisteredSeed("table", "Obstacle", "static", "table")


def moved(x: float, stamp_ns: int, parent: str = "world") -> Link:
    return Link(parent, (x, 0.0, 0.0), UNIT, stamp_ns)


def tracker() -> SeedTracker:
    made = SeedTracker("world")
    made.set_registry([ROBOT, TABLE])
    made.add_fixed("table", moved(5.0, STATIC_STAMP))
    return made


def test_each_new_stamp_is_one_tick() -> None:
    made = tracker()
    assert made.add_moving([("ankurbot_1/ee", moved(1.0, 100))]) == 100
    assert made.add_moving([("ankurbot_1/ee", moved(1.0, 100))]) is None
    assert made.add_moving([("ankurbot_1/ee", moved(1.5, 200))]) == 200
    assert made.add_moving([]) is None


def test_seeds_carry_their_true_stamps() -> None:
    made = tracker()
    made.add_moving([("ankurbot_1/ee", moved(1.0, 100))])
    made.add_moving([("other", moved(1.0, 200))])
    placed, missing = made.seeds()
    assert [(s.registered.name, s.translation[0], s.stamp_ns) for s in placed] == [
        ("ankurbot_1", 1.0, 100),
        ("table", 5.0, STATIC_STAMP),
    ]
    assert missing == []


def test_an_object_without_a_transform_is_named() -> None:
    placed, missing = tracker().seeds()
    assert [s.registered for s in placed] == [TABLE]
    assert missing == [ROBOT]


def test_objects_come_and_go_with_the_registry() -> None:
    made = tracker()
    made.set_registry([TABLE])
    made.add_moving([("ankurbot_1/ee", moved(1.0, 100))])
    assert [s.registered.name for s in made.seeds()[0]] == ["table"]
    made.set_registry([ROBOT])
    assert [s.registered.name for s in made.seeds()[0]] == ["ankurbot_1"]


def test_a_chain_of_frames_is_joined_and_as_old_as_its_oldest_part() -> None:
    made = tracker()
    quarter = (0.0, 0.0, math.sin(math.pi / 4), math.cos(math.pi / 4))
    made.add_moving([("ankurbot_1/base_link", Link("world", (1.0, 2.0, 0.0), quarter, 300))])
    made.add_moving([("ankurbot_1/ee", moved(1.3, 290, "ankurbot_1/base_link"))])
    seed = next(s for s in made.seeds()[0] if s.registered is ROBOT)
    assert seed.translation == pytest.approx((1.0, 3.3, 0.0), abs=1e-12)
    assert seed.rotation == pytest.approx(quarter, abs=1e-12)
    assert seed.stamp_ns == 290


def test_a_loop_of_frames_is_no_seed() -> None:
    made = tracker()
    made.add_moving([("ankurbot_1/ee", moved(1.0, 1, "a")), ("a", moved(1.0, 1, "ankurbot_1/ee"))])
    assert made.seeds()[1] == [ROBOT]


def test_time_that_starts_again_forgets_the_future() -> None:
    made = tracker()
    made.add_moving([("ankurbot_1/ee", moved(9.0, 5_000))])
    assert made.went_back(1_000, 100)
    assert not made.went_back(4_950, 100)
    made.forget_after(1_000)
    assert made.seeds()[1] == [ROBOT]
    assert made.add_moving([("ankurbot_1/ee", moved(1.0, 1_000))]) == 1_000
    assert made.seeds()[0][0].translation[0] == 1.0
