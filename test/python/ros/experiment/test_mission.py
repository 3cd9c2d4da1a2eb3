"""A mission's waits: a Commander that has fallen silent is named long before the wait's own limit."""

from __future__ import annotations

import pytest
import rospy
from yarm.msg import CommanderStatus

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
    with pytest.raises(MissionError, match="raster at 50 % did not end within 30 s"):
        Cell(spoken_s=100.0).driver.await_raster(0.5, LIMIT_S)
