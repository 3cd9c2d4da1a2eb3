"""What becomes of passes when a navigation drives: goals once each, taken back, and what is driven past it."""

from __future__ import annotations

from typing import Optional

from yarm.exploration.goal_relay import GoalRelay, Order
from yarm.exploration.model import Command, Intent
from yarm.exploration.session import SessionStep, State
from yarm.geometry import Pose2

AHEAD = Command(0.2, 0.1)
THERE = Pose2(1.0, 2.0, 3.14)


def passed(
    goal: Optional[Pose2], command: Command = AHEAD, state: State = State.EXPLORING, behaviour: str = "drive"
) -> SessionStep:
    return SessionStep(command, state, behaviour, "", 1.0, 2.0, 3.0, 0, 0.0, (), (), Intent(goal), ())


def test_a_goal_is_sent_once_and_again_when_it_has_changed() -> None:
    relay = GoalRelay()
    assert relay.step(passed(THERE)) == Order(goal=THERE)
    assert relay.step(passed(Pose2(1.005, 2.0, -3.14))) == Order(), "the same, the short way round"
    turned = Pose2(1.0, 2.0, 3.0)
    assert relay.step(passed(turned)) == Order(goal=turned)
    farther = Pose2(1.1, 2.0, 3.0)
    assert relay.step(passed(farther)) == Order(goal=farther)


def test_it_is_taken_back_once_when_the_robot_is_to_stand() -> None:
    for stands in (
        passed(THERE, Command(), State.PAUSED),
        passed(THERE, Command(), State.DONE),
        passed(THERE, Command(), behaviour="hold"),
        passed(None, Command()),
    ):
        relay = GoalRelay()
        assert relay.step(stands) == Order(), "nothing to take back"
        relay.step(passed(THERE))
        assert relay.step(stands) == Order(cancel=True)
        assert relay.step(stands) == Order()
        assert relay.step(passed(THERE)) == Order(goal=THERE), "and sent anew"


def test_backing_off_and_turns_without_a_goal_are_driven_past_it() -> None:
    relay = GoalRelay()
    relay.step(passed(THERE))
    back, turn = Command(-0.08, 0.0), Command(0.0, 1.0)
    assert relay.step(passed(THERE, back)) == Order(cancel=True, command=back)
    assert relay.step(passed(None, turn)) == Order(command=turn)
    assert relay.step(passed(THERE, turn)) == Order(goal=THERE), "a turn on the way is the navigation's"


def test_who_may_not_move_commands_nothing() -> None:
    assert GoalRelay().step(passed(None, AHEAD, State.PAUSED)) == Order()


def test_the_way_back_to_the_start_is_a_goal_too() -> None:
    home = Pose2(0.0, 0.0)
    assert GoalRelay().step(passed(home, state=State.RETURNING)) == Order(goal=home)
