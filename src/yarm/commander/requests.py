"""Requests for a change of state: which row of the table they fire, or why they are refused."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional, Sequence

from yarm.commander.states import TABLE, State, Transition, Trigger, accepted, find


@dataclass(frozen=True)
class Request:
    """A StateChange request without ROS; at most one field is to be set, and none only where a state accepts that.

    Attributes:
        next_state: go on.
        current_state: do again, or start.
        previous_state: go back.
        jump_state: number of the state to jump to; 0 for no jump.
    """

    next_state: bool = False
    current_state: bool = False
    previous_state: bool = False
    jump_state: int = 0

    @property
    def triggers(self) -> List[Trigger]:
        """The fields that are set, or EMPTY alone."""
        fields = (trigger for trigger in Trigger if trigger is not Trigger.EMPTY)
        return [trigger for trigger in fields if getattr(self, trigger.value)] or [Trigger.EMPTY]


@dataclass(frozen=True)
class Situation:
    """What decides on a request.

    Attributes:
        state: present state.
        busy: its work goes on.
        succeeded: its work has ended well.
        reason: why it has not, for the refusal.
    """

    state: State
    busy: bool = False
    succeeded: bool = False
    reason: str = ""


@dataclass(frozen=True)
class Verdict:
    """Answer to a request.

    Attributes:
        transition: the row that fires; None when the request is refused.
        message: why it is refused and what is accepted; empty when a row fires.
    """

    transition: Optional[Transition]
    message: str = ""


def decide(request: Request, now: Situation, table: Sequence[Transition] = TABLE) -> Verdict:
    """The row a request fires in a situation, or a refusal that names the state and what it accepts."""
    hint = f"state {int(now.state)} {now.state.name} accepts: {accepted(table, now.state)}"
    triggers = request.triggers
    trigger = triggers[0]
    row = find(table, now.state, trigger, request.jump_state)
    if len(triggers) != 1 or (trigger is Trigger.EMPTY and row is None):
        fields = "none" if trigger is Trigger.EMPTY else ", ".join(asked.value for asked in triggers)
        return Verdict(None, f"refused: exactly one field must be set, but set were: {fields}; {hint}")
    if now.busy and trigger is not Trigger.PREVIOUS:
        return Verdict(None, f"refused: busy; {_busy_hint(now.state, table)}")
    if row is None:
        return Verdict(None, f"refused: {_asked(request, trigger)} is not accepted; {hint}")
    if row.needs_success and not now.succeeded:
        why = f" ({now.reason})" if now.reason else ""
        return Verdict(None, f"refused: {now.state.name} has not succeeded yet{why}; do it again with current_state")
    return Verdict(row)


def _asked(request: Request, trigger: Trigger) -> str:
    return f"jump_state: {request.jump_state}" if trigger is Trigger.JUMP else trigger.value


def _busy_hint(state: State, table: Sequence[Transition]) -> str:
    row = find(table, state, Trigger.PREVIOUS)
    if row is None:
        return f"state {int(state)} {state.name} accepts nothing until its work has ended"
    return (
        f"state {int(state)} {state.name} accepts only previous_state (-> {row.target.name}), which stops every robot"
    )
