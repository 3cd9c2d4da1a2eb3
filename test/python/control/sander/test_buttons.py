"""Which button counts in which state, and what it begins."""

from __future__ import annotations

import numpy as np
import pytest

from python.control.arm_samples import arm, planner
from yarm.control.sander.buttons import BUSY_STATES, ButtonTable
from yarm.control.sander.scripts import SanderScripts, Situation
from yarm.control.sander.states import Button, SanderState

SCRIPTS = SanderScripts(Situation(arm().storage), planner(), lambda: np.zeros((0, 3)), lambda: None)
TABLE = ButtonTable(SCRIPTS)
MEANT = {
    (SanderState.STORAGE, Button.ADVANCE): SCRIPTS.scan,
    (SanderState.SCANNING, Button.ADVANCE): SCRIPTS.scan,
    (SanderState.MOVE_TO_PART, Button.ADVANCE): SCRIPTS.to_part,
    (SanderState.TELEOPERATION, Button.START): SCRIPTS.sand,
    (SanderState.SCAN_TO_PATH, Button.START): SCRIPTS.sand,
    **{(state, Button.STORE): SCRIPTS.store for state in SanderState if state is not SanderState.STORAGE},
}
"""What docs/control.md says of a sander that stands still."""


@pytest.mark.parametrize("button", [Button.STORE, Button.ADVANCE, Button.START])
@pytest.mark.parametrize("state", SanderState)
def test_a_sander_that_stands_takes_the_buttons_of_its_state(state: SanderState, button: Button) -> None:
    assert TABLE.script(button, state, idle=True) == MEANT.get((state, button))


@pytest.mark.parametrize("state", SanderState)
def test_at_work_it_can_be_stored_from_the_part_and_sand_anew_but_not_leave_a_sweep(state: SanderState) -> None:
    stores = state in (SanderState.TELEOPERATION, SanderState.SCAN_TO_PATH)
    assert TABLE.script(Button.STORE, state, idle=False) == (SCRIPTS.store if stores else None)
    for button in (Button.ADVANCE, Button.START):
        wanted = None if state in BUSY_STATES else MEANT.get((state, button))
        assert TABLE.script(button, state, idle=False) == wanted


def test_hold_begins_nothing() -> None:
    assert all(TABLE.script(Button.HOLD, state, idle) is None for state in SanderState for idle in (True, False))
