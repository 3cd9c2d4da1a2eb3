"""``what_if`` refuses what cannot be asked before it makes anything for it."""

from __future__ import annotations

from typing import List

import pytest
import rospy
from std_msgs.msg import Float32

from yarm.ros.commander.what_if import share_done
from yarm.ros.common import names
from yarm.ros.experiment import what_if


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (["--planner", "nonsense"], "planner = 'nonsense'"),
        (["--set", "speed=3"], "speed: unknown parameter"),
        (["--set", "speed"], "must be KEY=VALUE"),
        (["--robots", "many"], "or FIRST..LAST"),
        (["--runs", "0"], "must be within 1 to 200"),
        (["--case", "1m1ma", "--robots", "9"], "robots = 9: must be within 1 to 4"),
        (["--case", "nowhere"], "no such scene"),
        (["--run", "nowhere", "--at", "1"], "no results of a mission"),
    ],
)
def test_a_wrong_question_is_refused_before_there_are_copies(
    call: List[str], words: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(what_if, "in_own_session", lambda nice, work: work())
    monkeypatch.setattr(what_if, "copies", lambda count: pytest.fail("copies were made"))
    monkeypatch.setattr(what_if, "_cell_of_ros", lambda: pytest.fail("a live cell was asked for"))
    assert what_if.main([*call, "--workers", "2"]) == what_if.WRONG
    assert words in capsys.readouterr().err


def test_the_share_of_the_raster_is_the_first_arms_own_word(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def told(topic: str, kind: type, timeout: float) -> Float32:
        asked.append(topic)
        return Float32(0.4 if len(asked) == 1 else 1.0)

    monkeypatch.setattr(rospy, "wait_for_message", told)
    assert share_done(["hc10_barc_2", "hc10_barc"]) == pytest.approx(0.4)
    assert share_done(["hc10_barc"]) == 0.99, "one that is through is at its end, not beyond it"
    assert asked == 2 * [names.sander_progress("hc10_barc")] and share_done([]) == -1.0

    def silent(*_: object, **__: object) -> Float32:
        raise rospy.ROSException("nobody says it")

    monkeypatch.setattr(rospy, "wait_for_message", silent)
    assert share_done(["hc10_barc"]) == -1.0
