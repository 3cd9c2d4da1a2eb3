"""Which button begins what, by the sander's state and by what goes on."""

from __future__ import annotations

from typing import Callable, Dict, Optional, Tuple

from yarm.control.sander.scripts import SanderScripts
from yarm.control.sander.states import Button, SanderState
from yarm.control.sander.steps import Script

BUSY_STATES = (SanderState.SCANNING, SanderState.MOVE_TO_PART)
"""While a script goes on in these, only ``hold`` counts."""
WAITING_STATES = (SanderState.TELEOPERATION, SanderState.SCAN_TO_PATH)
"""``store`` counts in these whatever goes on."""


class ButtonTable:
    """The script that each button begins; ``hold``, which ends one, is the machine's own."""

    def __init__(self, scripts: SanderScripts) -> None:
        """Over the scripts that buttons begin."""
        self._store = scripts.store
        self._begins: Dict[Tuple[SanderState, Button], Callable[[], Script]] = {
            (SanderState.STORAGE, Button.ADVANCE): scripts.scan,
            (SanderState.SCANNING, Button.ADVANCE): scripts.scan,
            (SanderState.MOVE_TO_PART, Button.ADVANCE): scripts.to_part,
            (SanderState.TELEOPERATION, Button.START): scripts.sand,
            (SanderState.SCAN_TO_PATH, Button.START): scripts.sand,
        }

    def script(self, button: Button, state: SanderState, idle: bool) -> Optional[Callable[[], Script]]:
        """What a button begins now.

        Args:
            button: the one that was pressed.
            state: of the sander.
            idle: whether no script is under way.

        Returns:
            the script's maker; None for a button that means nothing now.
        """
        if button is Button.STORE:
            counts = state in WAITING_STATES or (idle and state is not SanderState.STORAGE)
            return self._store if counts else None
        return self._begins.get((state, button)) if idle or state not in BUSY_STATES else None
