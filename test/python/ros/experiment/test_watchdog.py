"""A mission that does not end says who waits for whom."""

from __future__ import annotations

from typing import List

import pytest
from yarm.msg import CommanderStatus, TaskStatus

from yarm.ros.experiment import watchdog
from yarm.ros.experiment.watchdog import ask_commander, who_waits

NAN = float("nan")


def test_robots_with_work_and_goals_without_anybody_are_asked_about() -> None:
    asked: List[str] = []

    def ask(subject: str) -> str:
        asked.append(subject)
        return f"why of {subject}"

    tasks = [
        TaskStatus("ankurbot_1", "debris_1", "Debris", "assigned", "TIMEOUT: no plan", 0.5),
        TaskStatus("ankurbot_2", "debris_2", "Debris", "reached", "", 0.0),
        TaskStatus("", "debris_3", "Debris", "waiting", "", NAN),
        TaskStatus("", "target_1", "Target", "unreachable", "wall within its margin", NAN),
    ]
    said = who_waits(CommanderStatus(state_name="BOUNDLESS", busy=True, reason="no way", tasks=tasks), ask)
    assert said == (
        "BOUNDLESS busy no way; "
        "ankurbot_1 -> debris_1 assigned 0.50 m (TIMEOUT: no plan): why of ankurbot_1; "
        "nobody -> debris_3 waiting: why of debris_3; "
        "nobody -> target_1 unreachable (wall within its margin)"
    )
    assert asked == ["ankurbot_1", "debris_3"]


def test_who_has_said_nothing_is_named() -> None:
    assert who_waits(None, ask_commander) == "commander has said nothing"


def test_a_commander_that_does_not_answer_is_no_hindrance(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", "http://localhost:1")
    monkeypatch.setattr(watchdog, "ANSWER_S", 10.0)
    assert "does not answer" in ask_commander("debris_1") or "no answer" in ask_commander("debris_1")
