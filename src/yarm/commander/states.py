"""The Commander's states and every transition between them, as data (docs/commander.md is written from it)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Dict, List, Optional, Sequence, Tuple


class State(IntEnum):
    """States of the Commander; the numbers are those of CommanderStatus.msg."""

    IDLE = 0
    STARTED = 1
    CALIBRATION = 2
    MENU = 3
    BOUNDED = 4
    BOUNDLESS = 5
    CLEANUP = 6


MISSION_STATES = (State.BOUNDED, State.BOUNDLESS)
"""States in which robots are sent to tasks."""


class Trigger(Enum):
    """What a request asks for; the values are the names of the fields of StateChange.srv, but for EMPTY."""

    NEXT = "next_state"
    CURRENT = "current_state"
    PREVIOUS = "previous_state"
    JUMP = "jump_state"
    EMPTY = "no field"
    """A request in which nothing is set: "anything", where a state accepts anything."""


@dataclass(frozen=True)
class Transition:
    """One row of the table.

    Attributes:
        source: state it leaves.
        trigger: request that fires it.
        target: state it enters; may be the source.
        jump: number a JUMP must carry; None for any number. Unused by the other triggers.
        needs_success: refused until the source's work has succeeded.
        does: what happens, for the docs.
    """

    source: State
    trigger: Trigger
    target: State
    jump: Optional[int] = None
    needs_success: bool = False
    does: str = ""

    @property
    def label(self) -> str:
        """The trigger as a user writes it, for instance ``jump_state: 5``."""
        if self.trigger is Trigger.JUMP:
            return f"jump_state: {'any' if self.jump is None else self.jump}"
        return str(self.trigger.value)


STATE_DOCS: Dict[State, str] = {
    State.IDLE: "system just started",
    State.STARTED: "switched on; association off, so that perception learns every object's own cloud",
    State.CALIBRATION: "association on; CALIBRATION goal to every robot; done when all have succeeded",
    State.MENU: "a mode may be chosen",
    State.BOUNDED: "tasks done without entering any manipulator's private area",
    State.BOUNDLESS: "tasks done in and around the manipulators' areas",
    State.CLEANUP: "mobile robots go back to where they started, manipulators to storage",
}
"""What each state means, for the docs."""


def _anything(source: State, target: State, does: str) -> Tuple[Transition, ...]:
    """The published "anything -> target": whatever is set, and nothing set, too."""
    return tuple(Transition(source, trigger, target, does=does) for trigger in Trigger)


def _mode(source: State) -> Tuple[Transition, ...]:
    return (
        Transition(source, Trigger.CURRENT, source, does="look for more tasks"),
        Transition(source, Trigger.NEXT, State.CLEANUP, does="send everybody home"),
        Transition(source, Trigger.PREVIOUS, State.MENU, does="leave the mode; while busy: stop every robot"),
    )


TABLE: Tuple[Transition, ...] = (
    *_anything(State.IDLE, State.STARTED, "switch on"),
    Transition(State.STARTED, Trigger.CURRENT, State.STARTED, does="association off once more"),
    Transition(State.STARTED, Trigger.NEXT, State.CALIBRATION, does="calibrate every robot"),
    Transition(State.CALIBRATION, Trigger.CURRENT, State.CALIBRATION, does="redo: association off, settle, on"),
    Transition(State.CALIBRATION, Trigger.PREVIOUS, State.STARTED, does="association off"),
    Transition(State.CALIBRATION, Trigger.NEXT, State.MENU, needs_success=True, does="choose a mode"),
    Transition(State.CALIBRATION, Trigger.JUMP, State.BOUNDED, 4, True, "start tasks outside private areas"),
    Transition(State.CALIBRATION, Trigger.JUMP, State.BOUNDLESS, 5, True, "start tasks everywhere"),
    Transition(State.MENU, Trigger.CURRENT, State.MENU, does="stay"),
    Transition(State.MENU, Trigger.PREVIOUS, State.CALIBRATION, does="redo: association off, settle, on"),
    Transition(State.MENU, Trigger.JUMP, State.BOUNDED, 4, does="start tasks outside private areas"),
    Transition(State.MENU, Trigger.JUMP, State.BOUNDLESS, 5, does="start tasks everywhere"),
    *_mode(State.BOUNDED),
    *_mode(State.BOUNDLESS),
    *_anything(State.CLEANUP, State.IDLE, "switch off; while busy: stop every robot"),
)
"""Every transition there is; what is not in the table is refused."""


class TableError(ValueError):
    """The transition table contradicts itself; the message lists every fault."""


def check_table(table: Sequence[Transition]) -> None:
    """Refuse a table with ambiguous, dangling or missing rows.

    Raises:
        TableError: every fault found.
    """
    faults: List[str] = []
    seen = set()
    for row in table:
        key = (row.source, row.trigger, row.jump)
        if key in seen:
            faults.append(f"{row.source.name} has two rows for {row.label}")
        seen.add(key)
        if row.trigger is not Trigger.JUMP and row.jump is not None:
            faults.append(f"{row.source.name}: {row.trigger.value} must not carry the number {row.jump}")
        if row.jump is not None and row.jump != int(row.target):
            faults.append(f"{row.source.name}: jump_state {row.jump} must lead to state {row.jump}, not {row.target}")
    faults += [f"{state.name} cannot be left" for state in State if not _leaves(table, state)]
    faults += [f"{state.name} cannot be reached from IDLE" for state in State if state not in _reachable(table)]
    if faults:
        raise TableError("; ".join(faults))


def accepted(table: Sequence[Transition], state: State) -> str:
    """What a state accepts, for messages: ``current_state (-> STARTED), ...``."""
    return ", ".join(f"{row.label} (-> {row.target.name})" for row in table if row.source is state)


def find(table: Sequence[Transition], state: State, trigger: Trigger, jump: int = 0) -> Optional[Transition]:
    """The row a request fires in a state; None when there is none."""
    for row in table:
        if row.source is state and row.trigger is trigger and (row.jump is None or row.jump == jump):
            return row
    return None


def _leaves(table: Sequence[Transition], state: State) -> bool:
    return any(row.source is state and row.target is not state for row in table)


def _reachable(table: Sequence[Transition]) -> List[State]:
    found = [State.IDLE]
    for state in found:
        found += [row.target for row in table if row.source is state and row.target not in found]
    return list(dict.fromkeys(found))
