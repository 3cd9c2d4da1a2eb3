"""Picks and drops on a lift that moves as it is told, meets things, and loses what it holds."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import List, Tuple

import pytest

from yarm.control.actions import MobileAction
from yarm.control.base.controller import Outcome
from yarm.control.hand import CARRYING_M, HandCommand, HandParams, HandReading, HandWork
from yarm.robots.ankurbot import HAND_STROKE_M

DT_S, SPEED_MPS = 1.0 / 60.0, 0.15
PARAMS = HandParams()


@dataclass
class Lift:
    """A lift over something.

    Attributes:
        floor_m: how far down it meets something.
        holds: what it meets can be held.
        lost_at_m: on its way up it loses what it holds above this; -1 for never.
        heavy: it does not come up with what it holds.
    """

    floor_m: float = 0.125
    holds: bool = True
    lost_at_m: float = -1.0
    heavy: bool = False
    at_m: float = 0.0
    grasping: bool = False
    suction: bool = False
    wanted_m: float = 0.0
    speed_mps: float = 0.0
    log: List[Tuple[float, bool]] = field(default_factory=list)

    def take(self, command: HandCommand) -> None:
        """Obey."""
        self.wanted_m = self.wanted_m if command.lift_m is None else command.lift_m
        self.suction = self.suction if command.suction is None else command.suction
        self.grasping &= self.suction

    def move(self) -> None:
        """One tick."""
        before, step = self.at_m, 0.0 if self.heavy and self.grasping else SPEED_MPS * DT_S
        self.at_m = min(self.at_m + min(max(self.wanted_m - self.at_m, -step), step), self.floor_m)
        self.speed_mps = (self.at_m - before) / DT_S
        touches = self.at_m >= self.floor_m
        self.grasping |= self.suction and self.holds and touches
        if self.wanted_m < self.at_m < self.lost_at_m:
            self.grasping = False
        self.log.append((self.at_m, self.grasping))

    @property
    def reading(self) -> HandReading:
        """What is measured."""
        return HandReading(self.at_m, self.speed_mps, self.grasping)


def play(lift: Lift, action: MobileAction, limit_s: float = 40.0) -> HandCommand:
    """Work to its end."""
    work, now_s = HandWork(PARAMS), 3.0
    command = work.start(action, lift.reading, now_s)
    lift.take(command)
    while command.outcome is Outcome.ACTIVE:
        assert now_s < limit_s, "it never ends"
        assert work.active
        lift.move()
        now_s += DT_S
        command = work.step(lift.reading, now_s)
        lift.take(command)
    assert not work.active
    return command


def test_a_piece_is_picked_up() -> None:
    lift = Lift()
    end = play(lift, MobileAction.PICK)
    assert end == HandCommand(0.0, None, Outcome.SUCCEEDED, "picked up 0.125 m down")
    assert lift.grasping and lift.at_m <= 0.003


def test_what_is_held_is_let_go_at_its_depth_and_not_before() -> None:
    lift = Lift(floor_m=1.0, grasping=True, suction=True)
    end = play(lift, MobileAction.DROP)
    assert end.outcome is Outcome.SUCCEEDED
    assert not lift.grasping and lift.at_m <= 0.003
    assert max(at_m for at_m, grasping in lift.log if grasping) == pytest.approx(PARAMS.hand_drop_m, abs=0.004)


@pytest.mark.parametrize(
    ("lift", "action", "words"),
    [
        (Lift(floor_m=1.0), MobileAction.PICK, "nothing met down to"),
        (Lift(holds=False), MobileAction.PICK, "what was met 0.125 m down is not held"),
        (Lift(lost_at_m=0.08), MobileAction.PICK, "lost on the way up, 0.0"),
        (
            Lift(heavy=True),
            MobileAction.PICK,
            "holds it 0.125 m down and is let go: the lift raises 1.8 kg at most",
        ),
        (Lift(grasping=True, suction=True), MobileAction.PICK, "hangs on the cup already"),
        (Lift(), MobileAction.DROP, "nothing hangs on the cup"),
    ],
)
def test_what_cannot_be_done_ends_with_its_reason_and_the_hand_up(lift: Lift, action: MobileAction, words: str) -> None:
    held = lift.grasping
    end = play(lift, action)
    assert (end.outcome, end.lift_m) == (Outcome.ABORTED, 0.0)
    assert words in end.reason
    assert lift.at_m <= 0.003
    assert lift.grasping is held
    assert lift.suction is held, "suction stays on only for what hung there before"


def test_a_full_bin_is_told_and_the_piece_kept() -> None:
    lift = Lift(floor_m=0.1, grasping=True, suction=True)
    end = play(lift, MobileAction.DROP)
    assert end.outcome is Outcome.ABORTED
    assert "met something 0.100 m down; is the bin full?" in end.reason
    assert lift.grasping and lift.at_m <= 0.003


def test_a_piece_lost_on_the_way_into_the_bin_is_told() -> None:
    lift, work = Lift(floor_m=1.0, grasping=True, suction=True), HandWork(PARAMS)
    lift.take(work.start(MobileAction.DROP, lift.reading, 0.0))
    lift.grasping = False
    lift.take(work.step(lift.reading, 0.1))
    assert work.step(HandReading(0.0, 0.0, False), 0.2).reason == "the piece was lost 0.000 m down"


def test_a_lift_that_does_not_come_up_is_given_up() -> None:
    work = HandWork(PARAMS)
    work.start(MobileAction.PICK, HandReading(0.0, 0.0, False), 0.0)
    work.step(HandReading(0.125, 0.1, False), 1.0)
    work.step(HandReading(0.2, 0.0, False), 2.0)
    assert work.step(HandReading(0.1, 0.0, False), PARAMS.hand_limit_s - 0.1).outcome is Outcome.ACTIVE
    end = work.step(HandReading(0.1, 0.0, False), PARAMS.hand_limit_s + 0.1)
    assert (end.outcome, end.reason) == (Outcome.ABORTED, "not done within 15 s: up, 0.100 m down")


def test_stopped_it_is_drawn_up_with_what_it_holds() -> None:
    work = HandWork(PARAMS)
    assert work.start(MobileAction.PICK, HandReading(0.0, 0.0, False), 0.0) == HandCommand(HAND_STROKE_M, True)
    assert work.stop() == HandCommand(lift_m=0.0)
    assert not work.active
    with pytest.raises(RuntimeError, match="no pick or drop"):
        work.step(HandReading(0.0, 0.0, False), 1.0)


@pytest.mark.parametrize(
    ("text", "action"),
    [
        ("PICK debris_1", MobileAction.PICK),
        ("PICK", MobileAction.PICK),
        ("DROP bin_1", MobileAction.DROP),
        ("PICKING", MobileAction.ABOUT_TIP),
        ("", MobileAction.ABOUT_TIP),
        ("True", MobileAction.ABOUT_BODY),
        ("CALIBRATION", MobileAction.CALIBRATE),
    ],
)
def test_the_words_of_actions(text: str, action: MobileAction) -> None:
    assert MobileAction.of(text) is action


def before_driving(lift: Lift, work: HandWork, limit_s: float = 40.0) -> Tuple[HandCommand, float]:
    """Ask until the base may drive or the goal is ended; the last command (at rest when it may) and its time, s."""
    now_s = 3.0
    command = work.before_driving(lift.reading, now_s)
    while command is not None and command.outcome is Outcome.ACTIVE:
        assert now_s < limit_s, "it never ends"
        assert lift.at_m > CARRYING_M, "the base may drive"
        lift.take(command)
        lift.move()
        now_s += DT_S
        command = work.before_driving(lift.reading, now_s)
    if command is not None:
        lift.take(command)
    return command or HandCommand(), now_s - 3.0


def test_after_a_cancelled_drop_the_base_waits_until_the_hand_is_up() -> None:
    lift, work = Lift(floor_m=1.0, grasping=True, suction=True), HandWork(PARAMS)
    lift.take(work.start(MobileAction.DROP, lift.reading, 0.0))
    while lift.at_m < 0.12:
        lift.move()
    lift.take(work.stop())
    command, took_s = before_driving(lift, work)
    assert command == HandCommand()
    assert lift.at_m <= CARRYING_M and lift.grasping
    assert took_s == pytest.approx((0.12 - CARRYING_M) / SPEED_MPS, abs=0.05)


def test_a_hand_that_is_up_lets_the_base_drive_at_once() -> None:
    assert HandWork(PARAMS).before_driving(HandReading(0.003, 0.0, True), 1.0) is None


def test_a_piece_that_holds_the_hand_down_before_driving_is_let_go() -> None:
    lift, work = Lift(heavy=True, at_m=0.125, grasping=True, suction=True, wanted_m=0.125), HandWork(PARAMS)
    command, took_s = before_driving(lift, work)
    assert command.outcome is Outcome.ABORTED and not lift.grasping
    assert "does not drive with its hand 0.125 m down, 0.005 m allowed" in command.reason
    assert "is let go: the lift raises 1.8 kg at most" in command.reason
    assert took_s == pytest.approx(2.0 * PARAMS.hand_stall_s, abs=0.05)
    command, _ = before_driving(lift, work)
    assert command == HandCommand(), "the next goal drives"


def test_a_hand_that_stays_down_ends_the_goal_and_the_next_has_its_time_again() -> None:
    work, stuck = HandWork(PARAMS), HandReading(0.1, 0.0, False)
    for begin_s in (1.0, 31.0):
        assert work.before_driving(stuck, begin_s) == HandCommand(lift_m=0.0)
        assert work.before_driving(stuck, begin_s + PARAMS.hand_limit_s - 0.1) == HandCommand(lift_m=0.0)
        end = work.before_driving(stuck, begin_s + PARAMS.hand_limit_s + 0.1)
        assert end is not None and end.outcome is Outcome.ABORTED
        assert end.reason.endswith("0.100 m down, 0.005 m allowed: not drawn up within 15 s")
