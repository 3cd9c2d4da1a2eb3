"""The Commander's buttons: which changes of state can be asked for now, and what each does."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Dict, List, Sequence

from yarm.commander.requests import Request, Situation, decide
from yarm.commander.states import TABLE, State, Transition

REQUESTS: Sequence[Request] = (
    Request(next_state=True),
    Request(current_state=True),
    Request(previous_state=True),
    *(Request(jump_state=int(state)) for state in State if state is not State.IDLE),
)
"""Every request that a person may mean."""


@dataclass(frozen=True)
class Button:
    """One transition of the present state.

    Attributes:
        label: request, as the table names it.
        target: state it leads to.
        does: what happens.
        request: fields of ``commander_state`` that are set.
        refusal: why it would be refused now; empty when it would not.
    """

    label: str
    target: str
    does: str
    request: Dict[str, Any]
    refusal: str


def buttons(now: Situation, table: Sequence[Transition] = TABLE) -> List[Button]:
    """The transitions of a situation's state, each once; of several requests that do the same, the first allowed one.

    Args:
        now: state, whether its work goes on or has succeeded.
        table: of transitions.
    """
    found: Dict[Any, Button] = {}
    for request in REQUESTS:
        free = Situation(now.state, busy=False, succeeded=True)
        row = decide(request, free, table).transition
        if row is None:
            continue
        known, refusal = found.get((row.target, row.does)), decide(request, now, table).message
        if known is not None and (refusal or not known.refusal):
            continue
        fields = {name: value for name, value in asdict(request).items() if value}
        label = f"jump_state: {int(row.target)}" if request.jump_state else row.label
        found[row.target, row.does] = Button(label, row.target.name, row.does, fields, refusal)
    return list(found.values())
