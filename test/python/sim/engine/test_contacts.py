"""Who may touch whom."""

from __future__ import annotations

import pytest

from yarm.geometry.kinds import ContactKind
from yarm.sim.engine.contacts import Side, contact_kind

WHEEL, BODY = Side("ankurbot_1", "Mobile", "fl_wheel"), Side("ankurbot_1", "Mobile", "base_link")
EE, ARM = Side("ankurbot_1", "Mobile", "ee"), Side("ankurbot_1", "Mobile", "arm")
OTHER = Side("ankurbot_2", "Mobile", "arm")
FLOOR, PART, TABLE = (
    Side("floor", "Floor", "floor"),
    Side("table", "Obstacle", "part"),
    Side("table", "Obstacle", "table"),
)
STAND = Side("stand", "Obstacle", "stand")
SANDER, LINK, BASE = (Side("hc10_barc", "Manipulator", link) for link in ("sander", "link_4_r", "base_link"))
SECOND = "hc10_barc_2"
SANDER_2, BASE_2 = (Side(SECOND, "Manipulator", link) for link in ("sander", "base_link"))
PART_2, STAND_2 = Side(f"{SECOND}_table", "Obstacle", "part"), Side(f"{SECOND}_stand", "Obstacle", "stand")
STATIONS = {
    "hc10_barc": {"table": "table", "stand": "stand"},
    SECOND: {"table": f"{SECOND}_table", "stand": f"{SECOND}_stand"},
}
BIN = Side("bin_1", "Obstacle", "bin")
DEBRIS, DEBRIS_2 = Side("debris_1", "Debris", "base_link"), Side("debris_2", "Debris", "base_link")
OK, BAD, SANDED = ContactKind.ALLOWED, ContactKind.FAILURE, ContactKind.SANDER_DEBRIS


@pytest.mark.parametrize(
    ("a", "b", "kind"),
    [
        (WHEEL, FLOOR, OK),
        (BODY, FLOOR, BAD),
        (WHEEL, TABLE, BAD),
        (BASE, STAND, OK),
        (LINK, STAND, BAD),
        (DEBRIS, PART, OK),
        (DEBRIS, TABLE, OK),
        (DEBRIS, FLOOR, OK),
        (DEBRIS, STAND, BAD),
        (DEBRIS, BIN, OK),
        (EE, BIN, BAD),
        (BODY, BIN, BAD),
        (BIN, FLOOR, OK),
        (SANDER, PART, OK),
        (SANDER, TABLE, BAD),
        (LINK, PART, BAD),
        (SANDER, DEBRIS, SANDED),
        (LINK, DEBRIS, BAD),
        (EE, DEBRIS, OK),
        (EE, DEBRIS_2, BAD),
        (ARM, DEBRIS, BAD),
        (EE, PART, BAD),
        (EE, OTHER, BAD),
        (ARM, LINK, BAD),
        (EE, SANDER, BAD),
        (STAND, FLOOR, OK),
        (BASE_2, STAND_2, OK),
        (BASE_2, STAND, BAD),
        (SANDER_2, PART_2, OK),
        (SANDER_2, PART, BAD),
        (SANDER, PART_2, BAD),
        (DEBRIS, PART_2, OK),
        (SANDER_2, DEBRIS, SANDED),
        (SANDER_2, SANDER, BAD),
    ],
)
def test_pairs_in_either_order(a: Side, b: Side, kind: ContactKind) -> None:
    goals = {"ankurbot_1": "debris_1"}
    assert contact_kind(a, b, goals, STATIONS) is kind
    assert contact_kind(b, a, goals, STATIONS) is kind


def test_what_hangs_on_a_hand_may_touch_it_wherever_the_robot_is_sent() -> None:
    goals, held = {"ankurbot_1": "debris_2"}, {"ankurbot_1": "debris_1"}
    hand = Side("ankurbot_1", "Mobile", "hand")
    assert contact_kind(hand, DEBRIS, goals, STATIONS) is BAD
    assert contact_kind(hand, DEBRIS, goals, STATIONS, held) is OK is contact_kind(DEBRIS, hand, goals, STATIONS, held)
    assert contact_kind(ARM, DEBRIS, goals, STATIONS, held) is BAD
    assert contact_kind(Side("ankurbot_2", "Mobile", "hand"), DEBRIS, goals, STATIONS, held) is BAD


def test_without_goals_known_any_debris_is_an_end_effectors_goal() -> None:
    assert contact_kind(EE, DEBRIS_2, {}, STATIONS) is OK
    assert contact_kind(EE, DEBRIS_2, {"ankurbot_2": "debris_2"}, STATIONS) is BAD
