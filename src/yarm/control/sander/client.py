"""How the controls server brings the sander where a goal wants it: which buttons to press, and when it is done."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Tuple

from yarm.control.actions import ArmAction
from yarm.control.base.controller import Outcome
from yarm.control.sander.states import Button, SanderReport, SanderState

SWITCHES = {ArmAction.ON: True, ArmAction.OFF: False}
"""Actions that throw the sander's switch, and how."""
REPEAT_S = 1.0


@dataclass(frozen=True)
class Request:
    """What to do this tick.

    Attributes:
        press: button to press; None for none.
        switch: value for ``motion_start_stop``; None for none.
        outcome: how the goal stands.
        reason: sentence on the outcome.
    """

    press: Optional[Button] = None
    switch: Optional[bool] = None
    outcome: Outcome = Outcome.ACTIVE
    reason: str = ""


class SanderClient:
    """Pursues one goal at a time; ``step`` is called with each report or tick."""

    def __init__(self, timeout_s: float) -> None:
        """Client without a goal.

        Args:
            timeout_s: simulated time after which a goal is given up.
        """
        self._timeout_s = timeout_s
        self._action: Optional[ArmAction] = None
        self._started_s: Optional[float] = None
        self._asked: Tuple[object, float] = (None, 0.0)

    @staticmethod
    def refusal(action: str, report: Optional[SanderReport]) -> str:
        """Why a goal cannot be taken; empty when it can."""
        known = [wanted.value for wanted in ArmAction]
        if action not in known:
            return f"action {action!r} is unknown to a manipulator: expected one of {', '.join(known)}"
        if ArmAction(action) in SWITCHES:
            if report is None:
                return f"action {action!r}: the sander has not reported its state; is hc10_state_machine running?"
            if report.state is not SanderState.SCAN_TO_PATH:
                return (
                    f"action {action!r} is accepted only in state {SanderState.SCAN_TO_PATH.value} "
                    f"({SanderState.SCAN_TO_PATH.words}); the sander is in state {report.state.value} "
                    f"({report.state.words})"
                )
        return ""

    def start(self, action: ArmAction) -> None:
        """Take a goal."""
        self._action = action
        self._started_s = None
        self._asked = (None, 0.0)

    def step(self, report: Optional[SanderReport], now_s: float) -> Request:
        """What to send now.

        Args:
            report: newest report of the sander; None before the first.
            now_s: simulated time.
        """
        action = self._action
        if action is None:
            return Request()
        if self._started_s is None:
            self._started_s = now_s
        if now_s - self._started_s > self._timeout_s:
            where = "unheard of" if report is None else f"in state {report.state.value} ({report.state.words})"
            said = f"; it says: {report.reason}" if report is not None and report.reason else ""
            return Request(
                outcome=Outcome.ABORTED,
                reason=f"{action.value} not done in {self._timeout_s:g} s: the sander is {where}{said}",
            )
        if report is None:
            return Request()
        if action in SWITCHES:
            return self._switch(action, report, now_s)
        return self._store(report, now_s) if action is ArmAction.CLEANUP else self._calibrate(report, now_s)

    def _calibrate(self, report: SanderReport, now_s: float) -> Request:
        """To teleoperation by itself, pause, start: standing above the part in SCAN_TO_PATH, not sanding."""
        if report.enabled:
            return self._ask(None, False, now_s)
        if report.state is SanderState.SCAN_TO_PATH:
            return Request(
                outcome=Outcome.SUCCEEDED, reason=f"in state {report.state.value} ({report.state.words}), stopped"
            )
        if report.state is SanderState.TELEOPERATION:
            return self._ask(Button.START, None, now_s)
        if report.state is SanderState.STORAGE or not report.moving:
            return self._ask(Button.ADVANCE, None, now_s)
        return Request()

    def _store(self, report: SanderReport, now_s: float) -> Request:
        if report.state is SanderState.STORAGE:
            return Request(outcome=Outcome.SUCCEEDED, reason="in storage")
        if report.state in (SanderState.TELEOPERATION, SanderState.SCAN_TO_PATH) or not report.moving:
            return self._ask(Button.STORE, None, now_s)
        return Request()

    def _switch(self, action: ArmAction, report: SanderReport, now_s: float) -> Request:
        if report.state is not SanderState.SCAN_TO_PATH:
            reason = f"{action.value} not applied: the sander has left for state {report.state.value}"
            return Request(outcome=Outcome.ABORTED, reason=reason)
        wanted = SWITCHES[action]
        if report.enabled == wanted:
            return Request(outcome=Outcome.SUCCEEDED, reason=f"{action.value} applied")
        return self._ask(None, wanted, now_s)

    def _ask(self, press: Optional[Button], switch: Optional[bool], now_s: float) -> Request:
        """Ask once, and again when nothing came of it."""
        asked = (press, switch)
        if self._asked[0] == asked and now_s - self._asked[1] < REPEAT_S:
            return Request()
        self._asked = (asked, now_s)
        return Request(press=press, switch=switch)
