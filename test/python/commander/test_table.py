"""Every row of the transition table, and every refusal."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from yarm.commander.drawing import table_markdown, table_mermaid
from yarm.commander.requests import Request, Situation, decide
from yarm.commander.states import TABLE, State, TableError, Transition, Trigger, check_table, find

JUMPS = (-1, 1, 2, 3, 4, 5, 6, 7)


def request_of(trigger, jump=4):
    if trigger is Trigger.JUMP:
        return Request(jump_state=jump)
    if trigger is Trigger.EMPTY:
        return Request()
    return Request(**{trigger.value: True})


@pytest.mark.parametrize("row", TABLE, ids=lambda row: f"{row.source.name}-{row.label}")
def test_every_row_fires(row):
    jump = row.jump if row.jump is not None else 3
    verdict = decide(request_of(row.trigger, jump), Situation(row.source, succeeded=True))
    assert verdict.transition == row
    assert verdict.message == ""


SPEC_TABLE = {
    State.IDLE: {"empty": 1, "next": 1, "current": 1, "previous": 1, 4: 1, 5: 1, 2: 1},
    State.STARTED: {"next": 2, "current": 1},
    State.CALIBRATION: {"current": 2, "previous": 1, "next": 3, 4: 4, 5: 5},
    State.MENU: {"current": 3, "previous": 2, 4: 4, 5: 5},
    State.BOUNDED: {"current": 4, "next": 6, "previous": 3},
    State.BOUNDLESS: {"current": 5, "next": 6, "previous": 3},
    State.CLEANUP: {"empty": 0, "next": 0, "current": 0, "previous": 0, 4: 0, 5: 0, 2: 0},
}


@pytest.mark.parametrize("state", State)
@pytest.mark.parametrize("asked", ["empty", "next", "current", "previous", 2, 4, 5])
def test_the_table_is_the_specified_one(state, asked):
    if asked == "empty":
        request = Request()
    else:
        request = Request(jump_state=asked) if isinstance(asked, int) else Request(**{f"{asked}_state": True})
    verdict = decide(request, Situation(state, succeeded=True))
    expected = SPEC_TABLE[state].get(asked)
    assert (None if verdict.transition is None else int(verdict.transition.target)) == expected


@pytest.mark.parametrize("state", State)
@pytest.mark.parametrize("trigger", Trigger)
@pytest.mark.parametrize("jump", JUMPS)
def test_what_is_not_in_the_table_is_refused_with_state_and_choices(state, trigger, jump):
    if find(TABLE, state, trigger, jump) is not None:
        return
    verdict = decide(request_of(trigger, jump), Situation(state, succeeded=True))
    assert verdict.transition is None, verdict
    assert f"state {int(state)} {state.name} accepts:" in verdict.message
    for row in TABLE:
        if row.source is state:
            assert f"{row.label} (-> {row.target.name})" in verdict.message


@pytest.mark.parametrize("state", State)
@pytest.mark.parametrize(
    "request_",
    [
        Request(next_state=True, current_state=True),
        Request(next_state=True, jump_state=4),
        Request(True, True, True, 5),
    ],
)
def test_exactly_one_field(state, request_):
    verdict = decide(request_, Situation(state, succeeded=True))
    assert verdict.transition is None
    assert "exactly one field must be set" in verdict.message
    assert state.name in verdict.message


@pytest.mark.parametrize("state", [s for s in State if s not in (State.IDLE, State.CLEANUP)])
@pytest.mark.parametrize("busy", [False, True])
def test_an_empty_request_is_refused_where_not_anything_is_accepted(state, busy):
    verdict = decide(Request(), Situation(state, busy=busy, succeeded=True))
    assert verdict.transition is None
    assert verdict.message.startswith("refused: exactly one field must be set, but set were: none; state ")
    assert f"{state.name} accepts:" in verdict.message


@pytest.mark.parametrize("state", [s for s in State if s not in (State.IDLE, State.STARTED)])
@pytest.mark.parametrize("trigger", [t for t in Trigger if t is not Trigger.EMPTY])
def test_busy_accepts_only_previous(state, trigger):
    verdict = decide(request_of(trigger), Situation(state, busy=True, succeeded=True))
    if trigger is Trigger.PREVIOUS:
        assert verdict.transition is not None
    else:
        assert verdict.transition is None
        assert "busy" in verdict.message
        assert "previous_state" in verdict.message


@pytest.mark.parametrize("request_", [Request(next_state=True), Request(jump_state=4), Request(jump_state=5)])
def test_calibration_must_have_succeeded(request_):
    verdict = decide(request_, Situation(State.CALIBRATION, reason="ankurbot_1 did not calibrate"))
    assert verdict.transition is None
    assert "CALIBRATION has not succeeded yet (ankurbot_1 did not calibrate)" in verdict.message


def test_the_shipped_table_is_consistent():
    check_table(TABLE)


def test_faults_of_a_table_are_all_named_at_once():
    broken = [row for row in TABLE if row.source is not State.MENU]
    broken.append(Transition(State.IDLE, Trigger.NEXT, State.STARTED))
    broken.append(Transition(State.BOUNDED, Trigger.JUMP, State.MENU, 5))
    broken.append(replace(TABLE[0], trigger=Trigger.CURRENT, jump=2, source=State.STARTED))
    with pytest.raises(TableError) as error:
        check_table(broken)
    for part in ("IDLE has two rows", "jump_state 5 must lead", "must not carry the number 2", "MENU cannot be left"):
        assert part in str(error.value)


def test_a_state_nobody_reaches_is_named():
    with pytest.raises(TableError, match="CLEANUP cannot be reached"):
        check_table([row for row in TABLE if row.target is not State.CLEANUP])


def test_drawings_hold_every_row():
    markdown, mermaid = table_markdown(), table_mermaid()
    assert markdown.count("\n") == len(TABLE) + 2
    for row in TABLE:
        assert f"`{row.label}`" in markdown
        assert f"{row.source.name} --> {row.target.name}:" in mermaid


def test_the_page_shows_the_table_of_the_code():
    page = (Path(__file__).resolve().parents[3] / "docs" / "commander.md").read_text()
    assert table_markdown() in page
    assert table_mermaid() in page
