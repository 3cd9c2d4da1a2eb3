"""Following a path as the report does: it comes to the end from any heading, and turns before it drives."""

from __future__ import annotations

import math

import numpy as np
import pytest

from support.report_rig import moved
from yarm.exploration.report.follow import CellFollower
from yarm.exploration.report.params import ReportParams
from yarm.geometry import FloatArray, Pose2

PARAMS = ReportParams()
CELL_M = 0.05


def driven(points: np.ndarray, pose: Pose2, passes: int = 3000) -> Pose2:
    follower = CellFollower(points, CELL_M, PARAMS)
    for _ in range(passes):
        command = follower.step(pose)
        if command is None:
            return pose
        assert abs(command.w_radps) <= PARAMS.angular_max and command.v_mps in (0.0, pytest.approx(0.06))
        pose = moved(pose, command)
    raise AssertionError(f"not at the end after {passes} passes: {pose}")


def straight(cells: int) -> FloatArray:
    """Along x from the origin, a cell every 5 cm."""
    return np.stack([CELL_M * np.arange(cells), np.zeros(cells)], axis=1)


def turn_at(follower: CellFollower, pose: Pose2) -> float:
    """What it turns here while it drives, rad/s."""
    command = follower.step(pose)
    assert command is not None and command.v_mps == pytest.approx(0.06), "0.3 of 0.2 m/s"
    return command.w_radps


def driving(cells: int, start_x: float = -0.5) -> CellFollower:
    """On a straight path; it looks along it from the left of its first cell, so that it has nothing to turn."""
    follower = CellFollower(straight(cells), CELL_M, PARAMS)
    turn_at(follower, Pose2(start_x, 0.0))
    return follower


def aimed_at(follower: CellFollower, x: float, y: float = 0.05) -> int:
    """Index of the cell of a straight path that it drives to from here, read from how it turns."""
    error = turn_at(follower, Pose2(x, y)) / 0.37
    return round((x - y / math.tan(error)) / CELL_M)


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


@pytest.mark.parametrize("error, rate", [(0.051, 0.051 * math.pi / 6), (-0.9, -0.9 * math.pi / 6), (2.0, math.pi / 6)])
def test_on_the_spot_it_turns_by_the_greatest_rate_times_the_error(error: float, rate: float) -> None:
    command = CellFollower(straight(20), CELL_M, PARAMS).step(Pose2(0.0, 0.0, -error))
    assert command is not None and command.v_mps == 0.0 and command.w_radps == pytest.approx(rate)


def test_aligned_to_a_twentieth_it_drives_and_turns_on_the_spot_no_more() -> None:
    follower = CellFollower(straight(20), CELL_M, PARAMS)
    assert turn_at(follower, Pose2(0.0, 0.0, 0.049)) == pytest.approx(-0.37 * 0.049)
    assert turn_at(follower, Pose2(0.0, 0.0, 1.0)) == pytest.approx(-0.37)


@pytest.mark.parametrize("error, rate", [(1.4, 0.37 * 1.4), (1.5, math.pi / 6), (-3.0, -math.pi / 6)])
def test_steering_is_a_share_of_the_error_clamped(error: float, rate: float) -> None:
    assert turn_at(driving(20), Pose2(0.0, 0.0, -error)) == pytest.approx(rate)


def test_from_afar_it_aims_at_the_fourth_cell_after_its_own() -> None:
    assert aimed_at(driving(20), -0.4) == 4


def test_within_four_cells_of_the_tolerance_cell_both_go_on_by_two() -> None:
    """The tolerance cell is first the one at 0.10 m, then that at 0.20 m."""
    follower, y = driving(20), 0.05
    along = math.sqrt((4 * CELL_M) ** 2 - y**2)
    aims = [aimed_at(follower, x, y) for x in (0.099 - along, 0.101 - along, 0.199 - along, 0.201 - along)]
    assert aims == [4, 6, 6, 8]


def test_the_last_cell_is_as_far_as_it_looks() -> None:
    follower = driving(10)
    assert [aimed_at(follower, x) for x in (0.0, 0.1, 0.2, 0.3)] == [6, 8, 9, 9]


@pytest.mark.parametrize("cells, aim", [(7, 6), (8, 4)])
def test_fewer_than_eight_cells_are_driven_straight_to_the_last(cells: int, aim: int) -> None:
    assert aimed_at(driving(cells), -0.4) == aim


@pytest.mark.parametrize("cells", [5, 20])
def test_it_has_arrived_at_a_tenth_of_a_metre(cells: int) -> None:
    follower, end = driving(cells), CELL_M * (cells - 1)
    assert follower.step(Pose2(end - 0.101, 0.0)) is not None
    assert follower.step(Pose2(end - 0.099, 0.0)) is None
