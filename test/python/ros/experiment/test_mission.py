"""A mission's waits: a Commander that has fallen silent is named long before the wait's own limit."""

from __future__ import annotations

import pytest
import rospy
from yarm.msg import CommanderStatus
from yarm.srv import StateChangeResponse

from yarm.experiments.run.recorder import Recorder
from yarm.geometry import GridSpec
from yarm.ros.common.status_age import LOST_S
from yarm.ros.experiment.inputs import ExperimentInputs
from yarm.ros.experiment.mission import MissionDriver, MissionError
from yarm.ros.experiment.params import ExperimentParams

LIMIT_S = 30.0


class Cell:
    """A second of simulated time passes with each look; the Commander speaks in each of its first seconds."""

    def __init__(self, spoken_s: float) -> None:
        self.inputs = ExperimentInputs(Recorder(GridSpec(), [], 0.0))
        self.driver = MissionDriver(self.inputs, ExperimentParams(), self.second)
        self.spoken_s = spoken_s
        self.say()

    def say(self) -> None:
        status = CommanderStatus(state_name="BOUNDLESS", busy=True)
        status.header.stamp = rospy.Time.from_sec(self.inputs.state.now_s)
        self.inputs._on_status(status)

    def second(self, _: str) -> None:
        self.inputs.state.now_s += 1.0
        if self.inputs.state.now_s <= self.spoken_s:
            self.say()


def test_a_silent_commander_ends_the_wait() -> None:
    cell = Cell(spoken_s=5.0)
    with pytest.raises(MissionError, match=r"raster at 50 %: nothing heard from commander for 1\d.0 s"):
        cell.driver.await_raster(0.5, LIMIT_S)
    assert cell.inputs.state.now_s == pytest.approx(5.0 + LOST_S + 1.0)


def test_one_that_speaks_is_waited_for_to_the_end() -> None:
    words = "raster at 50 % did not end within 30 s of simulated time: BOUNDLESS busy"
    with pytest.raises(MissionError, match=words):
        Cell(spoken_s=100.0).driver.await_raster(0.5, LIMIT_S)


DEATH_S, BACK_S = 5.0, 8.0


class Mortal(Cell):
    """Its Commander is dead for three seconds, before it has carried out what it is asked for or just after that."""

    def __init__(self, carried_out: bool, back_s: float = BACK_S) -> None:
        self.state, self.entered_s, self.asked = CommanderStatus.CALIBRATION, 2.0, 0
        self.carried_out, self.back_s = carried_out, back_s
        super().__init__(spoken_s=0.0)
        self.inputs.state.now_s = DEATH_S
        self.say()
        self.driver._service = self.answer

    def say(self) -> None:
        now_s = self.inputs.state.now_s
        status = CommanderStatus(state=self.state, outcome="succeeded", elapsed_s=now_s - self.entered_s)
        status.header.stamp = rospy.Time.from_sec(now_s)
        self.inputs._on_status(status)

    def second(self, what: str) -> None:
        super().second(what)
        if self.inputs.state.now_s >= self.back_s:
            self.say()

    def answer(self, _: object) -> StateChangeResponse:
        now_s, self.asked = self.inputs.state.now_s, self.asked + 1
        if now_s >= self.back_s or self.carried_out:
            self.state, self.entered_s = CommanderStatus.MENU, now_s
        if now_s < self.back_s:
            raise rospy.ServiceException("transport error completing service call")
        return StateChangeResponse(success=True)


@pytest.mark.parametrize(("carried_out", "asked"), [(False, 2), (True, 1)])
def test_a_commander_that_dies_when_asked_is_asked_again_unless_it_has_done_it(carried_out: bool, asked: int) -> None:
    cell = Mortal(carried_out)
    cell.driver._request("open the menu", next_state=True)
    assert cell.state == CommanderStatus.MENU
    assert cell.asked == asked
    assert cell.inputs.state.now_s == pytest.approx(BACK_S)
    cell.second("")
    assert cell.driver._idle_in(CommanderStatus.MENU)


def test_one_that_does_not_come_back_is_named() -> None:
    with pytest.raises(MissionError, match=r"menu: the Commander did not answer \(transport error.*nothing heard from"):
        Mortal(False, back_s=100.0).driver._request("open the menu", next_state=True)
