"""The last piece by odometry: where the robot is, with and without odometry's frame held."""

from __future__ import annotations

import pytest

from yarm.geometry import Pose2
from yarm.navigation.approach import MOST, Approach

BELIEVED, ODOMETRY = Pose2(1.0, 2.0, 0.5), Pose2(-0.3, 0.1, 0.2)


def test_the_believed_place_is_followed_until_the_frame_is_held() -> None:
    assert Approach().place(BELIEVED, ODOMETRY) is BELIEVED


def test_while_it_is_held_odometry_alone_moves_the_place() -> None:
    approach = Approach()
    assert approach.begin(BELIEVED, ODOMETRY)
    here = approach.place(Pose2(9.0, 9.0, 9.0), ODOMETRY.compose(Pose2(0.06, 0.0, -1.0)))
    wanted = BELIEVED.compose(Pose2(0.06, 0.0, -1.0))
    assert (here.x, here.y, here.yaw_rad) == pytest.approx((wanted.x, wanted.y, wanted.yaw_rad))
    approach.end()
    assert approach.place(BELIEVED, ODOMETRY) is BELIEVED


def test_it_is_begun_so_often_at_most_and_never_without_odometry() -> None:
    approach = Approach()
    assert not approach.begin(BELIEVED, None)
    assert [approach.begin(BELIEVED, ODOMETRY) for _ in range(MOST + 1)] == [True] * MOST + [False]
    assert approach.place(BELIEVED, None) is BELIEVED
