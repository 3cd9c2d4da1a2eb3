"""The ledger of a mission: who saw what, who was sent and why, every step with the checker's word, and how it ended."""

from __future__ import annotations

from python.commander.fake_cell import FakeCell
from yarm.commander.events import Decision, DecisionKind, Outcome
from yarm.commander.states import State

SCENE = {"ankurbot_1": (0.7, 1.9, 3.14), "ankurbot_2": (0.6, -1.9, 1.57)}


class Kept(FakeCell):
    """A cell that keeps the ledger."""

    def __init__(self, **robots):
        super().__init__(**robots)
        self.ledger = []

    def _do(self, actions):
        self.ledger += [action for action in actions if isinstance(action, Decision)]
        super()._do(actions)

    def of(self, *kinds):
        return [entry for entry in self.ledger if entry.kind in kinds]


def cleared(scene=SCENE):
    cell = Kept(**scene)
    cell.debris = {"debris_1": (-0.15, 0.25), "debris_2": (-0.2, -0.2)}
    cell.calibrate()
    assert cell.request(next_state=True).success
    assert not cell.ledger, "outside of missions nothing is kept"
    assert cell.request(jump_state=State.BOUNDLESS).success
    cell.run(cell.idle)
    assert cell.status.outcome == "succeeded"
    return cell


def test_a_mission_is_told_from_its_beginning_to_its_end_in_order():
    cell = cleared()
    assert [entry.number for entry in cell.ledger] == list(range(1, len(cell.ledger) + 1))
    assert cell.ledger[0] == Decision(1, DecisionKind.STATE, text="BOUNDLESS")
    assert cell.ledger[-1].kind is DecisionKind.END and cell.ledger[-1].text == "succeeded"
    for name in ("debris_1", "debris_2"):
        of = [entry.kind for entry in cell.ledger if entry.goal == name]
        order = [DecisionKind.SEEN, DecisionKind.ASSIGN, DecisionKind.SEND, DecisionKind.REACHED, DecisionKind.DELETE]
        assert [kind for kind in dict.fromkeys(of) if kind in order] == order


def test_who_was_sent_is_told_with_the_ways_of_the_others():
    first, second = cleared().of(DecisionKind.ASSIGN)[:2]
    assert {first.robot, second.robot} == set(SCENE)
    other = next(name for name in SCENE if name != first.robot)
    assert "cells of way" in first.text and other in first.text


def test_every_step_is_told_with_its_target_and_the_checkers_word():
    cell = cleared()
    steps = cell.of(DecisionKind.SEND)
    sent = [goal for _, goal in cell.sent if goal.target is not None]
    assert len(steps) == len(sent) >= 2
    for entry, goal in zip(steps, sent):
        assert entry.robot == goal.robot
        assert f"({goal.target.x:.4f}, {goal.target.y:.4f}) m" in entry.text
        assert entry.text.endswith("; safe")
    plans = cell.of(DecisionKind.PLAN)
    assert len(plans) == len(cell.shown)
    assert all("checker: nothing against it" in plan.text for plan in plans)


def test_the_same_mission_gives_the_same_ledger_and_another_one_another():
    first, again = cleared().ledger, cleared().ledger
    assert first == again
    moved = dict(SCENE, ankurbot_2=(0.9, -1.9, 1.57))
    assert cleared(moved).ledger != first


def test_a_goal_that_fails_is_told_with_the_reason_and_a_second_mission_begins_anew():
    cell = Kept(**SCENE)
    cell.targets = {"target_1": (0.2, 1.4)}
    cell.calibrate()
    cell.request(next_state=True)
    cell.fail_next = {"ankurbot_1": (Outcome.ABORTED, "a wheel is stuck")}
    cell.request(jump_state=State.BOUNDLESS)
    cell.run(cell.idle)
    assert any(entry.text.endswith("ABORTED a wheel is stuck") for entry in cell.of(DecisionKind.ENDED))
    cell.request(previous_state=True)
    cell.request(jump_state=State.BOUNDLESS)
    numbers = [entry.number for entry in cell.ledger]
    assert numbers.count(1) == 2, "a mode entered again from elsewhere is another mission"
