"""What a controller is given: the pose in the map; and who may decide."""

from __future__ import annotations

import math
from typing import List

import pytest

from support.rooms import room
from yarm.experiments.explore.runner import run_kinematic
from yarm.exploration.model import Observation, Step
from yarm.exploration.params import ExploreParams
from yarm.exploration.registry import CONTROLLERS, make_controller
from yarm.geometry import Pose2
from yarm.geometry.scans import Odometry


def test_the_pose_in_the_map_turns_the_odometry() -> None:
    seen = Observation(0.0, Odometry(0.0, Pose2(1.0, 0.0, 0.0)), Pose2(2.0, 3.0, math.pi / 2))
    assert seen.pose is not None
    assert seen.pose.distance(Pose2(2.0, 4.0)) < 1e-9 and seen.pose.yaw_rad == pytest.approx(math.pi / 2)


def test_without_a_map_frame_there_is_no_pose() -> None:
    assert Observation(0.0, Odometry(0.0, Pose2(1.0, 0.0))).pose is None


def test_an_unknown_controller_is_named() -> None:
    with pytest.raises(ValueError, match="'dice' is not known"):
        make_controller(ExploreParams(controller="dice"), 1)


def test_near_speed_is_not_above_the_greatest() -> None:
    assert "near_speed = 0.4" in ExploreParams(near_speed=0.4).faults and not ExploreParams().faults


@pytest.mark.parametrize("name", sorted(CONTROLLERS))
def test_every_controller_notes_what_it_changes_over_to(name: str) -> None:
    params = ExploreParams(controller=name, time_limit_s=12.0)
    seen: List[str] = []

    class Watched:
        def __init__(self) -> None:
            self._controller = make_controller(params, 1)

        def step(self, observation: Observation) -> Step:
            step = self._controller.step(observation)
            seen.append(step.behaviour)
            return step

    record = run_kinematic(room(half_m=1.0), Watched(), 1, params)
    changes = [b for a, b in zip(["", *seen], seen) if a != b]
    noted = [dict(event.details)["name"] for event in record.events if event.kind == "behaviour"]
    assert changes and noted == changes
