"""A recorded mission repeated up to one of its decisions: what was recorded, the comparison on the way, and the end."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Sequence

import rospy
import yaml

from yarm.commander.events import DecisionKind
from yarm.experiments.run.ledger import LedgerError, difference, ledger_hash, read_ledger, words
from yarm.experiments.run.repeat import RESULT, decision_at
from yarm.ros.experiment.console import say
from yarm.ros.experiment.inputs import ExperimentInputs
from yarm.ros.experiment.lock_step import TICK_HZ
from yarm.ros.experiment.mission import MissionError
from yarm.ros.experiment.params import ExperimentParams

HEARD_S = 20.0
"""Wall time in which what was decided at the last tick must have been heard of, s."""
POLL_S = 0.05


class Replay:
    """Compares what is decided now with what was decided then."""

    def __init__(self, params: ExperimentParams, inputs: ExperimentInputs) -> None:
        """A run to be repeated.

        Raises:
            LedgerError: it cannot be.
        """
        folder = Path(params.replay)
        self._number = decision_at(folder, params.replay_decision)
        if not params.sync:
            raise LedgerError("a mission is repeated in lock-step only: sync:=true")
        self._then = read_ledger(folder / "decisions.csv")
        self._hold = params.replay_hold
        self._inputs = inputs

    @property
    def stop_after_s(self) -> float:
        """When time is to stand still, s since the mission began.

        An entry into a state is asked for a tick after the map it is stamped with: time stands still one tick later.
        """
        row = self._then[self._number - 1]
        return row.time_ms / 1e3 + (2.0 / TICK_HZ if row.kind == DecisionKind.STATE else 0.0)

    def look(self) -> None:
        """Compare as far as it has come.

        Raises:
            MissionError: this is another mission.
        """
        changed = self._difference()
        if changed:
            raise MissionError(f"this is not the same mission: {changed}")

    def end(self, faults: Sequence[str], folder: Path) -> int:
        """Say what came of it, write it to a folder, and stay while a person wants to look; the exit code.

        Args:
            faults: why time does not stand still; empty when it does.
            folder: of the results.
        """
        deadline = time.monotonic() + HEARD_S
        while not faults and self._heard() < self._number and time.monotonic() < deadline:
            time.sleep(POLL_S)
        changed = self._difference()
        with self._inputs.lock:
            now, now_s = self._inputs.recorder.decisions[: self._number], self._inputs.state.now_s
        same = not faults and not changed and len(now) == self._number
        reason = changed or "; ".join(faults) or f"only {len(now)} decisions were heard of"
        result = {
            "reached": same,
            "decision": len(now),
            "time_s": now_s,
            "hash": ledger_hash(now),
            "reason": "" if same else reason,
        }
        folder.mkdir(parents=True, exist_ok=True)
        (folder / RESULT).write_text(yaml.safe_dump(result, sort_keys=False))
        if not same:
            say(f"decision {self._number} was not reached: {reason}")
            return 1
        say(f"stopped at {now_s:.3f} s: decision {self._number}, {words(now[-1])}; all up to it as recorded")
        if self._hold:
            say("the cell stands still; look at it with any tool of ROS; Ctrl-C ends it")
            rospy.spin()
        return 0

    def _heard(self) -> int:
        with self._inputs.lock:
            return len(self._inputs.recorder.decisions)

    def _difference(self) -> str:
        with self._inputs.lock:
            return difference(self._then[: self._number], self._inputs.recorder.decisions[: self._number])
