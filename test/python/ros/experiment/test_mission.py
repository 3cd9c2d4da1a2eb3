"""A mission's waits: a Commander that has fallen silent is named long before the wait's own limit."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import List

import pytest
import rospy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Int8
from yarm.msg import CommanderStatus, ObjectRegistry, RegisteredObject, SanderStatus
from yarm.srv import StateChangeRequest, StateChangeResponse

from yarm.console.film import Film
from yarm.console.wire import encode
from yarm.control.sander.states import SanderState
from yarm.experiments.run.cases import Case
from yarm.experiments.run.record import RunInfo
from yarm.experiments.run.recorder import Recorder
from yarm.geometry import GridSpec
from yarm.ros.common.status_age import LOST_S
from yarm.ros.experiment.inputs import ExperimentInputs
from yarm.ros.experiment.mission import BegunAgainError, MissionDriver, MissionError
from yarm.ros.experiment.params import ExperimentParams
from yarm.ros.experiment.saved import SavedRun, Saver
from yarm.safety.supervise import LIFE

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


class Anew(Cell):
    """Its simulation is started again after five seconds; the Commander calibrates, and goes on in the mode."""

    def __init__(self, resumes: bool) -> None:
        self.resumes = resumes
        super().__init__(spoken_s=LIMIT_S)
        self.asked: List[str] = []
        self.driver._service = self.answer

    def say(self) -> None:
        now_s, again = self.inputs.state.now_s, self.inputs.begun_again
        calibrates = again and (now_s < 4.0 or not self.resumes)
        state = CommanderStatus.CALIBRATION if calibrates else CommanderStatus.BOUNDLESS
        idle = bool(calibrates and now_s >= 4.0)
        status = CommanderStatus(state=state, busy=not idle, outcome="succeeded" if idle else "")
        status.header.stamp = rospy.Time.from_sec(now_s)
        self.inputs._on_status(status)

    def second(self, what: str) -> None:
        super().second(what)
        if self.inputs.state.now_s == 5.0 and not self.inputs.begun_again:
            self.inputs.forget()

    def answer(self, request: StateChangeRequest) -> StateChangeResponse:
        self.asked.append("next" if request.next_state else "other")
        return StateChangeResponse(success=True)


@pytest.mark.parametrize("resumes", [True, False])
def test_a_cell_that_begins_anew_is_waited_for_and_begun_with(resumes: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    cell = Anew(resumes)
    with pytest.raises(BegunAgainError, match="raster at 50 %: the simulation was started again"):
        cell.driver.await_raster(0.5, LIMIT_S)
    monkeypatch.setattr(cell.driver, "_missing", lambda: "")
    cell.driver.await_start()
    assert cell.driver.switch_on_and_calibrate() is resumes
    assert cell.asked == ([] if resumes else ["next"]), "the menu is opened by who asks; what was interrupted goes on"
    assert 4.0 <= cell.inputs.state.now_s <= 5.0


def test_words_of_the_cell_before_are_not_taken_for_those_of_the_new_one() -> None:
    cell = Anew(True)
    cell.inputs._clock._on_clock(Clock(clock=rospy.Time.from_sec(30.0)))
    cell.inputs._clock._on_clock(Clock(clock=rospy.Time.from_sec(1.0)))
    assert cell.inputs.begun_again == 1
    late = CommanderStatus()
    late.header.stamp = rospy.Time.from_sec(30.0)
    cell.inputs._on_status(late)
    assert cell.inputs.state.status is None
    late.header.stamp = rospy.Time.from_sec(1.2)
    cell.inputs._on_status(late)
    assert cell.inputs.state.now_s == pytest.approx(1.2)


def test_who_is_in_a_cell_may_be_told_before_its_time_is() -> None:
    """The registry is sent once; the new simulation's may come before its clock shows that it is another one's."""
    cell = Anew(True)
    robot = RegisteredObject(name="ankurbot_1", object="Mobile", type="dynamic", seed_frame="ankurbot_1/base_link")
    arm = RegisteredObject(name="hc10_barc", object="Manipulator", type="dynamic", seed_frame="hc10_barc/flange")
    cell.inputs._on_registry(ObjectRegistry(entries=[robot, arm]))
    cell.inputs.forget()
    assert (cell.inputs.state.robots, set(cell.inputs.state.manipulators)) == ({"ankurbot_1"}, {"hc10_barc"})


def test_an_arm_that_works_when_it_is_taken_up_is_known_to(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else its next pause would not be one, as before the first word to it."""
    inputs = ExperimentInputs(Recorder(GridSpec(), [], 0.0))
    arm = RegisteredObject(name="hc10_barc", object="Manipulator", type="dynamic", seed_frame="hc10_barc/flange")
    inputs._on_registry(ObjectRegistry(entries=[arm]))
    inputs._on_sander(Int8(data=SanderState.SCAN_TO_PATH), "hc10_barc")
    inputs._on_switch(Int8(data=0), "hc10_barc")
    assert inputs.recorder.pauses == (), "OFF before the first ON"
    told = SanderStatus(state=SanderState.SCAN_TO_PATH, enabled=True)
    monkeypatch.setattr(rospy, "wait_for_message", lambda *_, **__: told)
    inputs.look_at_arms()
    inputs._on_switch(Int8(data=0), "hc10_barc")
    assert [pause.manipulator for pause in inputs.recorder.pauses] == ["hc10_barc"]


def test_what_was_kept_is_taken_up_by_the_same_life_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    recorder = Recorder(GridSpec(), ["ankurbot_1"], 2.0)
    recorder.pose(3.0, "ankurbot_1", 1.0, 0.0, 0.0)
    run = SavedRun(recorder, {"debris_1": 4.0}, {"debris_1"}, 1, (2.0, 7.0, 12), 5.0, None, "no way")
    monkeypatch.setenv(LIFE, "1-2")
    saver = Saver(tmp_path)
    assert saver.found() is None
    saver.begin(lambda: run, threading.Lock())
    saver.keep()
    found = Saver(tmp_path).found()
    assert found is not None
    assert (found.ended_s, found.began, found.now_s) == (run.ended_s, run.began, run.now_s)
    assert found.failure == "no way"
    found.recorder.pose(4.0, "ankurbot_1", 2.0, 0.0, 0.0)
    path = found.recorder.finish(RunInfo("x", 1, "boundless"), Case("x", "made up"), 0.12).path
    assert [(row.time_s, row.x_m) for row in path] == [(1.0, 1.0), (2.0, 2.0)]
    monkeypatch.setenv(LIFE, "1-3")
    assert Saver(tmp_path).found() is None, "another supervisor's"
    monkeypatch.delenv(LIFE)
    assert Saver(tmp_path).found() is None, "nobody's"
    saver.end()
    assert list(tmp_path.iterdir()) == []


def test_the_film_is_kept_by_whole_blocks_and_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(LIFE, "1-2")
    (tmp_path / "film.saved").write_bytes(b"of another life")
    run = SavedRun(Recorder(GridSpec(), ["ankurbot_1"], 2.0), {}, set(), 0, None, 5.0, None, "")
    film, saver = Film("a run"), Saver(tmp_path)
    film.note("taken up")
    saver.begin(lambda: run, threading.Lock(), film)
    assert Saver(tmp_path).film() is None, "another run's"
    for second in range(8):
        film.add(float(second), {}, encode({"now_s": second}, {}))
    saver.keep()
    before = Saver(tmp_path).film()
    assert before is not None
    after = Film("a run")
    after.begin_with(before)
    after.add(9.0, {}, encode({"now_s": 9}, {}))
    index = after.index()
    assert [(b["first_s"], b["last_s"], b["pictures"]) for b in index["blocks"]] == [
        (0.0, 4.0, 5),
        (5.0, 7.0, 3),
        (9.0, 9.0, 1),
    ]
    assert index["notes"] == ["taken up"]
    (tmp_path / "film.saved").write_bytes(b"torn")
    assert Saver(tmp_path).film() is None
    saver.end()
    assert list(tmp_path.iterdir()) == []
