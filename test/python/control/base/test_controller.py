"""The three-stage controller on the kinematic model."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import List, Optional, Tuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from yarm.control.base.controller import BaseCommand, BaseController, BaseGoal, Outcome, Stage
from yarm.control.base.kinematics import full_turn, half_turn
from yarm.control.base.model import BaseModel, path_deviation
from yarm.control.base.params import BaseParams
from yarm.geometry.poses import Pose2

DT_S = 1.0 / 60.0
START = Pose2(0.4, -0.3, 0.7)
PARAMS = BaseParams()


@dataclass
class Run:
    """What happened on the way to a goal."""

    model: BaseModel
    end: Optional[BaseCommand] = None
    track: List[Tuple[Stage, Pose2]] = field(default_factory=list)
    fastest_mps: float = 0.0
    driven_on_turning_casters: float = 0.0


def drive(goal: BaseGoal, model: Optional[BaseModel] = None, limit_s: float = 120.0) -> Run:
    """Pursue a goal to its end."""
    run = Run(model or BaseModel(START))
    controller = BaseController(PARAMS)
    controller.step(run.model.pose, run.model.casters, run.model.stamp_s)
    controller.start(goal)
    while run.model.stamp_s < limit_s:
        command = controller.step(run.model.pose, run.model.casters, run.model.stamp_s)
        if command.outcome is not Outcome.ACTIVE:
            run.end = command
            return run
        run.track.append((command.stage, run.model.pose))
        note_casters(run, command)
        run.model.step(command, DT_S)
        run.fastest_mps = max(run.fastest_mps, fastest_point(run.model))
    return run


def note_casters(run: Run, command: BaseCommand) -> None:
    """Largest caster error at which the base is told to drive, rad."""
    if command.casters is None or (command.drive_mps == 0.0 and command.yaw_rate_radps == 0.0):
        return
    wrap = full_turn if command.stage is Stage.TRANSLATION else half_turn
    worst = max(abs(wrap(a - b)) for a, b in zip(command.casters, run.model.casters))
    run.driven_on_turning_casters = max(run.driven_on_turning_casters, worst)


def fastest_point(model: BaseModel) -> float:
    """Speed of the fastest of rear edge and end effector, m/s."""
    vx, vy, yaw_rate = model.velocity()
    return max(math.hypot(vx, vy + yaw_rate * x) for x in (-0.35, 0.0, 1.30))


GOALS = st.builds(
    BaseGoal,
    st.builds(Pose2, st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-math.pi, math.pi)),
    st.booleans(),
)


@settings(max_examples=40, deadline=None)
@given(GOALS, st.integers(0, 6), st.floats(0.0, 0.15))
def test_every_goal_is_reached_within_tolerance_and_cap(goal, delay_steps, slip):
    run = drive(goal, BaseModel(START, delay_steps=delay_steps, slip=slip))
    assert run.end is not None and run.end.outcome is Outcome.SUCCEEDED, run.end
    assert run.model.pose.distance(goal.target) <= 0.03
    assert abs(math.degrees(full_turn(run.model.pose.yaw_rad - goal.target.yaw_rad))) <= 1.0
    assert run.fastest_mps <= 1.02 * PARAMS.cap_mps
    assert run.driven_on_turning_casters <= math.radians(PARAMS.caster_tolerance_deg) + 1e-9


@settings(max_examples=30, deadline=None)
@given(st.floats(-math.pi, math.pi), st.floats(0.1, 3.5), st.integers(0, 6))
def test_translation_stays_on_the_line_and_does_not_overshoot(direction, length, delay_steps):
    target = Pose2(START.x + length * math.cos(direction), START.y + length * math.sin(direction), START.yaw_rad)
    run = drive(BaseGoal(target), BaseModel(START, delay_steps=delay_steps))
    assert max(path_deviation(START, target, pose) for _, pose in run.track) < 0.01
    assert max(START.distance(pose) for _, pose in run.track) - length < 0.05


@settings(max_examples=30, deadline=None)
@given(st.one_of(st.floats(-3.1, -0.05), st.floats(0.05, 3.1)), st.integers(0, 6))
def test_turning_keeps_the_end_effector_and_does_not_overshoot(turn, delay_steps):
    target = Pose2(START.x, START.y, full_turn(START.yaw_rad + turn))
    run = drive(BaseGoal(target), BaseModel(START, delay_steps=delay_steps))
    assert max(START.distance(pose) for _, pose in run.track) < 0.03
    beyond = [math.copysign(1.0, turn) * full_turn(pose.yaw_rad - target.yaw_rad) for _, pose in run.track[-120:]]
    assert math.degrees(max(beyond)) < 1.0


def test_a_sideways_push_on_the_way_is_steered_out():
    model = BaseModel(START)
    controller = BaseController(PARAMS)
    target = Pose2(START.x + 3.0, START.y, START.yaw_rad)
    controller.start(BaseGoal(target))
    pushed = worst_after = 0.0
    while True:
        command = controller.step(model.pose, model.casters, model.stamp_s)
        if command.outcome is not Outcome.ACTIVE:
            break
        model.step(command, DT_S)
        if pushed == 0.0 and model.pose.x > START.x + 0.5:
            pushed = 0.025
            model.pose = Pose2(model.pose.x, model.pose.y + pushed, model.pose.yaw_rad)
        if model.pose.x > START.x + 2.5:
            worst_after = max(worst_after, path_deviation(START, target, model.pose))
    assert command.outcome is Outcome.SUCCEEDED
    assert worst_after < 0.01


def test_stop_is_at_once_and_the_base_stands_within_half_a_second():
    model, controller = BaseModel(START), BaseController(PARAMS)
    controller.start(BaseGoal(Pose2(START.x + 3.0, START.y, START.yaw_rad)))
    while math.hypot(*model.velocity()[:2]) < 0.95:
        model.step(controller.step(model.pose, model.casters, model.stamp_s), DT_S)
    command = controller.stop("cancelled")
    assert (command.drive_mps, command.yaw_rate_radps, command.outcome) == (0.0, 0.0, Outcome.PREEMPTED)
    stopped_s = model.stamp_s
    while math.hypot(*model.velocity()[:2]) > 0.01:
        model.step(controller.step(model.pose, model.casters, model.stamp_s), DT_S)
    assert model.stamp_s - stopped_s < 0.5
    assert not controller.active


def test_a_robot_that_does_not_move_is_given_up_with_a_reason():
    model, controller = BaseModel(START), BaseController(PARAMS)
    controller.start(BaseGoal(Pose2(START.x + 1.0, START.y, START.yaw_rad)))
    for tick in range(1000):
        command = controller.step(START, model.casters, tick * DT_S)
        if command.outcome is not Outcome.ACTIVE:
            break
    assert command.outcome is Outcome.ABORTED
    assert tick * DT_S == pytest.approx(10.0, abs=0.1)
    assert "has not moved for 10 s in the translation: 1.00 m" in command.reason


def test_wheels_that_slip_for_good_are_given_up_after_the_attempts():
    model, controller = BaseModel(START), BaseController(PARAMS)
    target = Pose2(START.x + 1.0, START.y, START.yaw_rad)
    controller.start(BaseGoal(target))
    driving = False
    for _ in range(6000):
        command = controller.step(model.pose, model.casters, model.stamp_s)
        if command.outcome is not Outcome.ACTIVE:
            break
        model.step(command, DT_S)
        if driving and command.drive_mps == 0.0:
            model.pose = Pose2(model.pose.x - 0.1, model.pose.y, model.pose.yaw_rad)
        driving = command.drive_mps != 0.0
    assert command.outcome is Outcome.ABORTED
    assert "not reached in 5 attempts" in command.reason


def test_pause_stands_still_and_goes_on():
    model, controller = BaseModel(START), BaseController(PARAMS)
    target = Pose2(START.x + 1.0, START.y, START.yaw_rad)
    controller.start(BaseGoal(target))
    for _ in range(60):
        model.step(controller.step(model.pose, model.casters, model.stamp_s), DT_S)
    assert controller.pause().drive_mps == 0.0
    for _ in range(60):
        model.step(controller.pause(), DT_S)
    while True:
        command = controller.step(model.pose, model.casters, model.stamp_s)
        if command.outcome is not Outcome.ACTIVE:
            break
        model.step(command, DT_S)
    assert command.outcome is Outcome.SUCCEEDED


def test_without_a_goal_nothing_is_commanded():
    command = BaseController(PARAMS).step(START, (0.0,) * 4, 0.0)
    assert (command.casters, command.drive_mps, command.yaw_rate_radps) == (None, 0.0, 0.0)


def test_a_new_goal_under_way_is_pursued_from_there():
    model, controller = BaseModel(START), BaseController(PARAMS)
    controller.start(BaseGoal(Pose2(START.x + 3.0, START.y, START.yaw_rad)))
    for _ in range(120):
        model.step(controller.step(model.pose, model.casters, model.stamp_s), DT_S)
    target = Pose2(START.x, START.y + 1.0, START.yaw_rad + 1.0)
    controller.start(BaseGoal(target))
    while True:
        command = controller.step(model.pose, model.casters, model.stamp_s)
        if command.outcome is not Outcome.ACTIVE:
            break
        model.step(command, DT_S)
    assert command.outcome is Outcome.SUCCEEDED
    assert model.pose.distance(target) <= 0.03
