"""Headings at which robots fit on goals side by side."""

from __future__ import annotations

import math

import numpy as np

from python.planning.fleet_samples import fleet_of, goals
from python.planning.samples import arm, robot
from yarm.planning.cspace.robot_space import poses_touch
from yarm.planning.fleet.goal_headings import target_choices
from yarm.planning.fleet.joint_plan import valid
from yarm.planning.fleet.joint_search import JointSearch
from yarm.planning.model.types import Goal, GoalKind

ROBOTS = [robot("a", (10, 4), arm(6)), robot("b", (10, 18), arm(6))]


def test_every_choice_with_headings_keeps_the_robots_apart() -> None:
    fleet = fleet_of(ROBOTS, goals((15, 11), (15, 13)))
    choices = target_choices(fleet, (0, 1))
    closed = [targets for targets in choices if all(target.heading is not None for target in targets.values())]
    assert len(closed) >= 2
    for targets in closed:
        poses = [(*targets[i].column, targets[i].heading or 0) for i in (0, 1)]
        assert not poses_touch(fleet.spaces[0], poses[0], fleet.spaces[1], poses[1])
    moves = JointSearch(fleet, (0, 1), 100).run(np.random.default_rng(0))
    assert moves is not None and valid(fleet, moves, (0, 1))


def test_goals_far_apart_leave_the_headings_open() -> None:
    fleet = fleet_of(ROBOTS, goals((8, 4), (25, 18)))
    choices = target_choices(fleet, (0, 1))
    assert len(choices) == 1 and [target.heading for target in choices[0].values()] == [None, None]


def test_a_robot_that_concerns_nobody_keeps_its_heading_open_in_every_choice() -> None:
    fleet = fleet_of([*ROBOTS, robot("c", (28, 3), arm(2))], goals((15, 11), (15, 13), (27, 20)))
    choices = target_choices(fleet, (0, 1, 2))
    assert len(choices) > 1 and all(targets[2].heading is None for targets in choices)


def test_a_heading_that_is_wanted_is_the_only_one_tried() -> None:
    wanted = [Goal("g0", GoalKind.TARGET, (15, 11), yaw_rad=0.0), Goal("g1", GoalKind.TARGET, (15, 13))]
    fleet = fleet_of(ROBOTS, wanted)
    headings = {targets[0].heading for targets in target_choices(fleet, (0, 1))}
    assert headings == {0} and fleet.spaces[0].headings[0] == 0.0


def test_what_turns_little_is_tried_before_what_turns_much() -> None:
    fleet = fleet_of(ROBOTS, goals((15, 11), (15, 13)))
    turns = []
    for targets in target_choices(fleet, (0, 1)):
        if all(target.heading is not None for target in targets.values()):
            angles = [abs(fleet.spaces[i].headings[targets[i].heading or 0]) for i in (0, 1)]
            turns.append(sum(angles))
    assert turns and turns[-1] == max(turns) and turns[-1] > math.pi / 2
