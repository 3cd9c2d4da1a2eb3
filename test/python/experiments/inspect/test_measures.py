"""What a round comes to, from a record put together by hand."""

from __future__ import annotations

import dataclasses

import pytest

from python.experiments.inspect_samples import SMALL, told
from yarm.experiments.inspect.measures import faults_of, measure
from yarm.geometry import Pose2
from yarm.inspection.model import UNSEEN, Stage

TAGS = dict(enumerate(SMALL.tags, start=1))


def test_the_time_is_what_the_robot_did() -> None:
    found = measure(told(SMALL, "yarm", TAGS))
    assert (found.driving_s, found.turning_s, found.looking_s, found.standing_s) == (2.0, 1.0, 1.0, 0.0)
    assert found.distance_m == pytest.approx(0.6) and found.computing_s == 0.25 and found.bumps == 1
    assert found.place_p50_m == pytest.approx(0.02) and found.place_p95_deg == pytest.approx(0.0)


def test_the_slowest_look_is_told() -> None:
    record = told(SMALL, "yarm", TAGS)
    looks = [order for order in record.orders if order.doing == "look"]
    drives = [order for order in record.orders if order.doing != "look"]
    assert looks and measure(record).slowest_look_s == max(look.end_s - look.start_s for look in looks) > 0.0
    longer = dataclasses.replace(looks[0], end_s=looks[0].start_s + 7.0)
    assert measure(dataclasses.replace(record, orders=(*record.orders, longer))).slowest_look_s == 7.0
    assert measure(dataclasses.replace(record, orders=tuple(drives))).slowest_look_s == 0.0


def test_goals_that_failed_are_counted() -> None:
    record = told(SMALL, "yarm", TAGS)
    assert [order.outcome for order in record.orders] == ["done", "done", "failed", "done"]
    failed = dataclasses.replace(record.orders[0], outcome="failed")
    found = measure(dataclasses.replace(record, orders=(failed, *record.orders[1:])))
    assert (found.goals, found.goals_failed, measure(record).goals_failed) == (2, 1, 0)


def test_wrong_and_missing_verdicts_are_named() -> None:
    wrong = {1: TAGS[1] % 15 + 1, 2: TAGS[2], 3: UNSEEN}
    record = told(SMALL, "yarm", wrong)
    found = measure(record)
    assert (found.right, found.named_wrong, found.boxes) == (1, 1, 4) and found.kept
    faults = faults_of(record, found)
    assert len(faults) == 3 and "box 1 is" in faults[0] and "in doubt" in faults[1]
    assert faults[2] == "box 4 ended without a verdict"


@pytest.mark.parametrize(
    "home, kept", [(Pose2(0.05, 0.0, 0.05), True), (Pose2(0.12, 0.0), False), (Pose2(0, 0, 0.2), False)]
)
def test_home_is_where_it_began_by_the_truth(home: Pose2, kept: bool) -> None:
    record = told(SMALL, "yarm", TAGS, SMALL.start.compose(home))
    found = measure(record)
    assert found.kept is kept and bool(faults_of(record, found)) is not kept


def test_late_or_failed_is_not_home_in_time() -> None:
    record = told(SMALL, "yarm", TAGS)
    late = dataclasses.replace(record, end_s=481.0)
    failed = dataclasses.replace(record, stage=Stage.FAILED, reason="not home: blocked")
    assert not measure(late).kept and not measure(failed).kept
    assert "not home: blocked" in faults_of(failed, measure(failed))[0]


def test_belief_is_compared_in_the_world() -> None:
    record = told(SMALL, "yarm", TAGS)
    moved = dataclasses.replace(record, map_in_world=Pose2(1.0, 0.0))
    assert measure(moved).place_p50_m == pytest.approx(1.0, abs=0.03)


def test_a_round_without_a_way_is_refused() -> None:
    with pytest.raises(ValueError, match="no row of the way"):
        measure(dataclasses.replace(told(SMALL, "yarm", TAGS), path=()))
