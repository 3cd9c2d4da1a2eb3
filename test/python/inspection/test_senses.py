"""What is sick, since when: ages, what never came, a place that jumps."""

from __future__ import annotations

from dataclasses import replace
from typing import Dict

import numpy as np
import pytest

from yarm.geometry import Pose2
from yarm.geometry.scans import Odometry, Scan
from yarm.inspection.senses import PATIENCE_S, Senses, SensesWatch


def scan_at(stamp_s: float) -> Scan:
    return Scan(stamp_s, np.ones(3, np.float32), -0.1, 0.1, 0.4, 10.0, Pose2(0.0, 0.0))


WELL = Senses(
    10.0,
    scan=scan_at(10.0),
    odometry=Odometry(10.0, Pose2(1.0, 0.0), 0.0, 0.0),
    map_from_odom=Pose2(0.0, 2.0),
    place_s=10.0,
    localised=True,
)


def at(now_s: float, **changes: object) -> Senses:
    """All well at a time, but for these."""
    moved = replace(
        WELL, now_s=now_s, scan=scan_at(now_s), odometry=Odometry(now_s, Pose2(1.0, 0.0), 0.0, 0.0), place_s=now_s
    )
    return replace(moved, **changes)  # type: ignore[arg-type]


def test_where_the_base_is_in_the_map() -> None:
    assert WELL.pose == Pose2(1.0, 2.0)
    assert replace(WELL, odometry=None).pose is None and replace(WELL, map_from_odom=None).pose is None


def test_all_well_is_no_complaint() -> None:
    assert SensesWatch().step(WELL) == ()


@pytest.mark.parametrize(
    ("changes", "sensor", "words"),
    [
        ({"scan": scan_at(18.0)}, "scan", "none newer than 2.0 s"),
        ({"odometry": Odometry(19.0, Pose2(0.0, 0.0), 0.0, 0.0)}, "odometry", "none newer than 1.0 s"),
        ({"place_s": 17.0}, "place", "none newer than 3.0 s"),
        ({"camera": "dark: very"}, "camera", "dark: very"),
        ({"navigation": "silent for 9.0 s"}, "navigation", "silent for 9.0 s"),
        ({"map_fault": "none has come"}, "map", "none has come"),
        ({"map_fault": "box 3 at (9, 1) outside of it"}, "map", "box 3 at (9, 1) outside of it"),
    ],
)
def test_each_fault_is_named_since_it_began_and_goes_away(changes: Dict[str, object], sensor: str, words: str) -> None:
    watch = SensesWatch()
    watch.step(at(10.0))
    for _ in range(2):
        (complaint,) = watch.step(at(20.0, **changes))
        assert complaint.sensor == sensor and complaint.since_s == 20.0
        assert words in complaint.text and "since 20.0 s" in complaint.text
    assert watch.step(at(21.0)) == ()


def test_what_never_came_is_missing_only_after_a_while() -> None:
    watch = SensesWatch()
    nothing = Senses(1.0, map_fault="none has come", camera="no picture has come yet", navigation="nothing heard")
    assert watch.step(nothing) == ()
    found = watch.step(replace(nothing, now_s=1.0 + PATIENCE_S))
    assert {c.sensor for c in found} == {"scan", "odometry", "map", "camera", "navigation"}


def test_a_jump_is_told_at_its_pass_and_only_of_a_place_that_was_sure() -> None:
    watch = SensesWatch()
    watch.step(at(10.0))
    watch.step(at(10.1, map_from_odom=Pose2(0.05, 2.0)))
    assert watch.jump == ""
    watch.step(at(10.2, map_from_odom=Pose2(0.05, 3.0)))
    assert watch.jump == "the place has jumped by 1.00 m and 0.00 rad"
    watch.step(at(10.3, map_from_odom=Pose2(0.05, 3.0)))
    assert watch.jump == ""
    watch.step(at(10.4, localised=False))
    watch.step(at(10.5))
    assert watch.jump == ""
