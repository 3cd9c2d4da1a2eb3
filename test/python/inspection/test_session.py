"""Rounds begin when everything is there, and end: done, stopped, out of time, time gone backwards."""

from __future__ import annotations

from dataclasses import replace
from typing import List, Optional, Tuple

import numpy as np

from yarm.geometry import FloatArray, Pose2
from yarm.geometry.scans import Odometry, Scan
from yarm.inspection.boxes import Box
from yarm.inspection.flow import RoundFlow
from yarm.inspection.model import Outcome, Reading, Stage
from yarm.inspection.readers import PictureRead, Reader, Shot
from yarm.inspection.round import Round, RoundParams
from yarm.inspection.senses import Picture, Senses
from yarm.inspection.session import IDLE, OVERTIME_S, STOPPED, InspectionSession, Request, SessionParams, SessionStep

BOXES = [Box(1, Pose2(2.0, 0.0, 3.1)), Box(2, Pose2(0.0, 2.0, -1.5))]
PICTURE = np.zeros((4, 4), np.uint8)


def scan_at(stamp_s: float) -> Scan:
    return Scan(stamp_s, np.ones(3, np.float32), -0.1, 0.1, 0.4, 10.0, Pose2(0.0, 0.0))


class SureReader:
    """Reads its own number on every box."""

    def read(self, box: int, shot: Shot) -> PictureRead:
        return PictureRead(box, shot, final=True)

    def reading(self, box: int) -> Reading:
        return Reading(box, 0.9999)

    def evidence(self, box: int) -> None:
        return None


def lengths(start: Pose2, goals: object) -> FloatArray:
    return np.array([start.distance(goal) for goal in goals])  # type: ignore[attr-defined]


class World:
    """A robot that is at its goal two seconds after it was given it, and turns as it is told."""

    def __init__(self, time_limit_s: float = 200.0, autostart: bool = True) -> None:
        self.now_s, self.pose = 50.0, Pose2(0.0, 0.0)
        self.goal: Optional[Pose2] = None
        self.due_s, self.turn = 0.0, 0.0
        self.steps: List[SessionStep] = []
        self.goals: List[Pose2] = []
        self.rounds = 0
        self.limit_s = time_limit_s
        self.session = InspectionSession(SessionParams(time_limit_s, 0.6, autostart), self._make)

    def _make(self) -> Tuple[RoundFlow, Reader]:
        self.rounds += 1
        params = RoundParams(time_limit_s=self.limit_s)
        return Round(BOXES, lengths, lambda box, view: 0.9, params), SureReader()

    def senses(self, **changes: object) -> Senses:
        there = self.goal is not None and self.now_s >= self.due_s
        if there:
            self.pose = self.goal or self.pose
        seen = Senses(
            self.now_s,
            scan_at(self.now_s),
            Odometry(self.now_s, self.pose, 0.0, 0.0),
            Pose2(0.0, 0.0),
            self.now_s,
            True,
            picture=Picture(self.now_s, PICTURE),
            goal=(Outcome.DONE if there else Outcome.BUSY, ""),
        )
        return replace(seen, **changes)  # type: ignore[arg-type]

    def run(self, seconds: float, **changes: object) -> SessionStep:
        for _ in range(round(seconds * 10)):
            step = self.session.step(self.senses(**changes))
            self.steps.append(step)
            action = step.action
            if action.cancel:
                self.goal = None
            if action.goal is not None:
                self.goal, self.due_s = action.goal, self.now_s + 2.0
                self.goals.append(action.goal)
            self.turn = self.turn if action.turn_radps is None else action.turn_radps
            self.pose = replace(self.pose, yaw_rad=self.pose.yaw_rad + 0.1 * self.turn)
            self.now_s = round(self.now_s + 0.1, 3)
        return self.steps[-1]


def test_a_place_that_is_known_and_not_there_yet_is_waited_for() -> None:
    """What the localisation says of itself may come before its transform: such a round had failed at its first pass."""
    world = World()
    step = world.run(0.3, map_from_odom=None)
    assert (step.stage, step.reason) == (IDLE, "waits for transform of the place") and world.rounds == 0
    assert world.run(30.0).stage == Stage.DONE and "localise" not in {step.stage for step in world.steps}


def test_a_place_that_never_comes_is_complained_about() -> None:
    step = World().run(6.0, map_from_odom=None)
    assert step.stage == IDLE and step.reason.startswith("waits: place: nothing has come yet")


def test_a_whole_round_with_its_verdicts_and_the_way_home() -> None:
    world = World()
    step = world.run(30.0)
    assert step.stage == Stage.DONE and step.reason == ""
    assert {v.box: v.reading.tag for v in world.session.verdicts} == {1: 1, 2: 2}
    assert world.goals[-1] == world.session.home == Pose2(0.0, 0.0)
    assert {s.stage for s in world.steps} >= {"drive", "look", "home", "done"}
    assert max(s.time_home_s for s in world.steps) > 1.0
    assert step.elapsed_s == world.run(5.0).elapsed_s and not world.session.running


def test_home_is_where_it_began_and_not_where_it_knew_its_place() -> None:
    world = World()
    begun = world.pose
    world.run(1.0, localised=False)
    assert world.turn == 0.6
    while world.turn:
        world.run(0.1, localised=False)
    turned = world.pose
    step = world.run(40.0)
    assert step.stage == Stage.DONE and turned.yaw_rad - begun.yaw_rad > 6.28
    assert world.session.home == begun and world.goals[-1] == begun


def test_it_waits_for_every_input_and_says_for_which() -> None:
    world = World()
    step = world.run(1.0, map_fault="none has come", navigation="nothing heard of it yet")
    assert (step.stage, step.reason) == (IDLE, "waits for map, navigation") and world.rounds == 0
    assert world.run(0.1).stage != IDLE


def test_boxes_outside_the_map_keep_a_round_from_beginning_and_are_named() -> None:
    world = World()
    step = world.run(6.0, map_fault="box 3 at (9, 1) outside of it, 6 x 6 m from (-3, -3) on")
    assert step.stage == IDLE and world.rounds == 0
    assert "waits: map: box 3 at (9, 1) outside of it" in step.reason and "the boxes' file" in step.reason


def test_without_autostart_it_waits_for_start() -> None:
    world = World(autostart=False)
    assert world.run(1.0).reason == "waits for ~start"
    assert not world.session.ask(Request.STOP).success and not world.session.ask(Request.RELOCALISE).success
    assert world.session.ask(Request.START).success and not world.session.ask(Request.START).success
    assert world.session.ask(Request.STOP).success
    assert world.run(1.0).stage == IDLE
    world.session.ask(Request.START)
    assert world.run(30.0).stage == Stage.DONE
    assert world.session.ask(Request.START).success
    assert world.run(30.0).stage == Stage.DONE and world.rounds == 2


def test_stopping_takes_the_goal_back_and_keeps_the_verdicts() -> None:
    world = World()
    while not world.session.verdicts:
        world.run(0.1)
    while world.steps[-1].stage != "drive":
        world.run(0.1)
    assert world.session.ask(Request.STOP).success
    step = world.run(0.1)
    assert step.stage == STOPPED and step.action.cancel and len(world.session.verdicts) == 1
    assert world.run(5.0).action.goal is None


def test_sent_home_the_boxes_that_are_left_get_the_reason() -> None:
    world = World()
    world.run(0.5)
    assert world.session.ask(Request.RETURN_HOME).success
    step = world.run(10.0)
    assert step.stage == Stage.DONE
    assert {v.reason for v in world.session.verdicts} == {"sent home on request"}


def test_asked_to_it_turns_once_and_then_goes_on_to_the_same_goal() -> None:
    world = World()
    world.run(0.5)
    goal = world.goals[-1]
    assert world.session.ask(Request.RELOCALISE).success
    world.run(1.0)
    assert world.turn == 0.6 and world.goal is None
    while world.turn:
        world.run(0.1)
    world.run(2.0)
    assert world.goals[-1] == goal
    assert world.run(30.0).stage == Stage.DONE


def test_without_a_scan_nothing_is_driven_and_it_goes_on_afterwards() -> None:
    world = World()
    world.run(0.5)
    step = world.run(3.0, scan=scan_at(50.0))
    assert world.goal is None and "scan: none newer than" in step.reason
    said = [event for s in world.steps for event in s.events if event.kind == "trouble"]
    assert len(said) == 1 and "scan: none newer than 0.6 s" in dict(said[0].details)["what"]
    assert world.run(30.0).stage == Stage.DONE


def test_a_scan_that_never_comes_back_ends_in_a_failure_after_the_time() -> None:
    world = World(time_limit_s=20.0)
    world.run(0.5)
    step = world.run(20.0 + OVERTIME_S + 2.0, scan=scan_at(50.0))
    assert step.stage == Stage.FAILED and "scan" in step.reason and world.goal is None
    assert all(v.reason for v in world.session.verdicts) and len(world.session.verdicts) == 2


def test_time_that_goes_backwards_forgets_the_round() -> None:
    world = World(autostart=False)
    world.session.ask(Request.START)
    world.run(3.0)
    world.now_s = 5.0
    world.session.restart("time went backwards; waits for ~start")
    step = world.run(1.0)
    assert (step.stage, step.reason) == (IDLE, "time went backwards; waits for ~start")
    world.session.ask(Request.START)
    assert world.run(30.0).stage == Stage.DONE
