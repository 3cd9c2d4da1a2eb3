"""Whole rounds without ROS: a layout of four boxes by ours and by the report's, and ours over ten."""

from __future__ import annotations

import dataclasses
from typing import Any, Callable, Tuple

import numpy as np
import pytest

from python.experiments.inspect_samples import SMALL, ours, printed, report
from yarm.experiments.inspect.measures import faults_of, measure
from yarm.experiments.inspect.record import RoundRecord
from yarm.experiments.inspect.runner import LIMIT_S, run_round
from yarm.inspection.model import Stage
from yarm.sim.scenes.layout_maker import make_layout


def test_ours_reads_four_of_four_and_is_home() -> None:
    found = measure(ours())
    assert ours().stage == Stage.DONE and found.kept and found.right == 4 and found.named_wrong == 0
    assert found.bumps == 0 and found.end_s < 0.5 * LIMIT_S and found.looking_s < 5.0
    assert faults_of(ours(), found) == ()


def test_the_report_looks_long_and_drives_more() -> None:
    found = measure(report())
    assert report().stage == Stage.DONE and len(report().verdicts) == 4
    assert found.looking_s >= 4 * 21 * 0.1 - 0.2 and found.end_s > measure(ours()).end_s
    assert found.images == 84


def comparable(record: RoundRecord) -> Tuple[Any, ...]:
    images = tuple((look.t_s, look.box, look.robot, int(look.image.sum())) for look in record.looks)
    rest = dataclasses.replace(record, computing_s=0.0, looks=())
    return images, tuple(repr(getattr(rest, field.name)) for field in dataclasses.fields(rest))


@pytest.mark.parametrize(("controller", "first"), [("yarm", ours), ("report", report), ("report_printed", printed)])
def test_the_same_seed_gives_the_same_round(controller: str, first: Callable[[], RoundRecord]) -> None:
    assert comparable(run_round(SMALL, controller, 1)) == comparable(first())


def test_another_seed_gives_another_round() -> None:
    assert comparable(run_round(SMALL, "yarm", 2)) != comparable(ours())


def test_every_order_is_on_record_with_its_end() -> None:
    orders = ours().orders
    assert [order.doing for order in orders] == ["drive", "look"] * 4 + ["drive"]
    assert all(a.end_s == b.start_s for a, b in zip(orders, orders[1:])) and orders[-1].end_s == ours().end_s
    assert {order.outcome for order in orders} == {"done"} and orders[-1].stage == "home"
    assert [order.box for order in orders[1::2]] == [verdict.box for verdict in ours().verdicts]


def test_the_spins_of_the_report_are_turning_and_its_way_is_driving() -> None:
    found = measure(report())
    assert found.turning_s > 2 * 2.0 * np.pi / 0.2 - 1.0
    parts = found.driving_s + found.turning_s + found.looking_s + found.standing_s
    assert parts == pytest.approx(found.end_s) and found.driving_s > 10.0


def test_why_a_view_was_chosen_is_told() -> None:
    told = [dict(event.details) for event in ours().events if event.kind == "viewpoint"]
    assert [int(details["box"]) for details in told] == [verdict.box for verdict in ours().verdicts]
    assert "cheapest round over the 4 left" in str(told[0]["why"])
    drives = [order for order in ours().orders if order.doing == "drive"]
    assert [float(details["x"]) for details in told] == pytest.approx([drive.x for drive in drives[:-1]], abs=1e-3)
    assert "first that can be reached" in str(next(e for e in report().events if e.kind == "viewpoint").details)


@pytest.mark.parametrize("kind", ["open", "wall", "cluster", "corridor"])
def test_ours_reads_ten_of_ten(kind: str) -> None:
    found = measure(run_round(make_layout(kind, 3), "yarm", 1))
    assert found.kept and found.right == 10 and found.named_wrong == 0 and found.bumps == 0


def test_an_unknown_controller_is_named() -> None:
    with pytest.raises(ValueError, match="'dice' is not known"):
        run_round(SMALL, "dice", 1)
