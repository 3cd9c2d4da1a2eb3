"""State CALIBRATION: perception learns the objects' clouds, then every robot says what it can do."""

from __future__ import annotations

from typing import Dict, List, Optional

from yarm.commander.activity import Activity, Ending, cancel_all
from yarm.commander.answers import Answer, AnswerError, parse_answer
from yarm.commander.cell_state import CellState
from yarm.commander.events import Action, GoalDone, Outcome, SetAssociation, Target
from yarm.commander.goals import ActiveGoal, Purpose
from yarm.control.actions import MobileAction


class Calibration(Activity):
    """Association off for a while, on, then a CALIBRATION goal to every robot; done when all have succeeded."""

    def __init__(self, cell: CellState, off_since_s: Optional[float]) -> None:
        """Calibrate.

        Args:
            cell: the cell as it is known.
            off_since_s: since when association has been off; None to switch it off first (a redo).
        """
        super().__init__(cell)
        self._off_since_s = off_since_s
        self._started_s = 0.0
        self._on_s: Optional[float] = None
        self._answers: Dict[str, Answer] = {}

    def start(self, now_s: float) -> List[Action]:
        """Switch association off when it is not."""
        self._started_s = now_s
        if self._off_since_s is not None:
            return []
        self._off_since_s = now_s
        return [SetAssociation(False)]

    def advance(self, now_s: float) -> List[Action]:
        """Settle, switch on, ask every robot, wait."""
        if self._on_s is None:
            return self._settle(now_s)
        actions: List[Action] = []
        for robot in self._robots():
            if robot not in self._answers and robot not in self.cell.goals.active:
                actions += self._ask(robot, now_s)
        late = [g for g in self.cell.goals.of(Purpose.CALIBRATION) if self._late(g, now_s)]
        if late:
            limit = self.cell.params.calibration_timeout_s
            return actions + self._fail(f"{late[0].robot} has not calibrated within {limit:g} s", now_s)
        waiting = [robot for robot in self._robots() if robot not in self._answers]
        self.reason = f"waiting for {', '.join(waiting)}" if waiting else ""
        if not waiting and self._robots():
            self._succeed()
        return actions

    def goal_done(self, goal: ActiveGoal, event: GoalDone, now_s: float) -> List[Action]:
        """Take a robot's answer."""
        if goal.purpose is not Purpose.CALIBRATION or self.result is not None:
            return []
        if event.outcome is not Outcome.SUCCEEDED:
            return self._fail(f"{goal.robot} did not calibrate: {event.outcome.value} {event.message}".rstrip(), now_s)
        try:
            self._answers[goal.robot] = parse_answer(event.message)
        except AnswerError as error:
            return self._fail(f"{goal.robot}: {error}", now_s)
        return []

    def _robots(self) -> List[str]:
        return self.cell.mobiles + self.cell.manipulators

    def _late(self, goal: ActiveGoal, now_s: float) -> bool:
        return now_s - goal.sent_s > self.cell.params.calibration_timeout_s

    def _settle(self, now_s: float) -> List[Action]:
        off_since = self._off_since_s if self._off_since_s is not None else now_s
        if self.cell.map is None or not self._robots():
            missing = "map on planning_metadata" if self.cell.map is None else "robot in object_registry"
            self.reason = f"waiting for the first {missing}"
            return []
        if now_s - off_since < self.cell.params.settle_s:
            self.reason = "association is off while perception learns the clouds"
            return []
        self._on_s = now_s
        return [SetAssociation(True), *self.advance(now_s)]

    def _ask(self, robot: str, now_s: float) -> List[Action]:
        if robot in self.cell.connected:
            return [self.cell.goals.send(robot, Purpose.CALIBRATION, MobileAction.CALIBRATE.value, now_s)]
        waited = now_s - (self._on_s if self._on_s is not None else now_s)
        if waited > self.cell.params.server_timeout_s:
            limit = self.cell.params.server_timeout_s
            return self._fail(f"no action server {robot}/move_robot within {limit:g} s", now_s)
        return []

    def _fail(self, reason: str, now_s: float) -> List[Action]:
        self.finish(Ending.FAILED, reason)
        return cancel_all(self.cell, now_s, reason)

    def _succeed(self) -> None:
        self.cell.answers = dict(self._answers)
        for name, robot in self.cell.robots.items():
            self.cell.homes.setdefault(name, Target(robot.x, robot.y, robot.yaw_rad))
        if self.cell.params.starts_clear:
            self.cell.hidden.start()
        self.finish(Ending.SUCCEEDED)
