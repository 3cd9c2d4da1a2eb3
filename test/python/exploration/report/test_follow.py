"""Following a path as the report does: it comes to the end from any heading, and turns before it drives."""

from __future__ import annotations

import math

import numpy as np
import pytest

from support.report_rig import moved
from yarm.exploration.report.follow import CellFollower
from yarm.exploration.report.params import ReportParams
from yarm.geometry import Pose2

PARAMS = ReportParams()


def driven(points: np.ndarray, pose: Pose2, passes: int = 3000) -> Pose2:
    follower = CellFollower(points, 0.05, PARAMS)
    for _ in range(passes):
        command = follower.step(pose)
        if command is None:
            return pose
        assert abs(command.w_radps) <= PARAMS.angular_max and command.v_mps in (0.0, pytest.approx(0.06))
        pose = moved(pose, command)
    raise AssertionError(f"not at the end after {passes} passes: {pose}")


def test_a_path_of_one_cell_is_done() -> None:
    assert CellFollower(np.array([[1.0, 1.0]]), 0.05, PARAMS).step(Pose2(0.0, 0.0)) is None


@pytest.mark.parametrize("yaw_deg", [0, 90, 180, -135])
@pytest.mark.parametrize("cells", [4, 30])
def test_it_comes_to_the_end(cells: int, yaw_deg: int) -> None:
    along = 0.05 * np.arange(cells)
    end = driven(np.stack([along, np.minimum(along, 0.4)], axis=1), Pose2(0.0, 0.0, math.radians(yaw_deg)))
    assert end.distance(Pose2(along[-1], min(along[-1], 0.4))) <= 0.1 + 1e-9


def test_it_turns_before_it_drives() -> None:
    follower = CellFollower(np.array([[0.05 * i, 0.0] for i in range(20)]), 0.05, PARAMS)
    first = follower.step(Pose2(0.0, 0.0, 0.5))
    assert first is not None and first.v_mps == 0.0 and first.w_radps == pytest.approx(-0.5 * PARAMS.angular_max)
    second = follower.step(Pose2(0.0, 0.0, 0.04))
    assert second is not None and second.v_mps == pytest.approx(0.06) and second.w_radps == pytest.approx(-0.37 * 0.04)
