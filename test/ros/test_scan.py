"""The scan of the part: which clouds are placed, by which joints, and what is left out."""

from __future__ import annotations

import numpy as np
import pytest
import rospy
from sensor_msgs.msg import PointCloud2, PointField

from yarm.geometry import transform_points
from yarm.ros.sander.params import SanderNodeParams
from yarm.ros.sander.scan import CLOUD_PERIOD_S, ScanCollector

PARAMS = SanderNodeParams(scan_stride=1, scan_every=1)
Q = np.zeros(6)
NOW_S = 50.0


class Looking:
    """In place of kinematics: a camera over the part's centre that looks down from a height given by joint 1."""

    def camera(self, q):
        pose = np.diag([1.0, -1.0, -1.0, 1.0])
        pose[:3, 3] = [*PARAMS.part_centre_m, 1.2 + q[0]]
        return pose


def cloud(stamp_s: float, xyz) -> PointCloud2:
    """A cloud of one row, metres, camera frame."""
    points = np.zeros((1, len(xyz), 4), dtype=np.float32)
    points[0, :, :3] = xyz
    message = PointCloud2(height=1, width=len(xyz), point_step=16, row_step=16 * len(xyz), data=points.tobytes())
    message.fields = [PointField(axis, 4 * i, PointField.FLOAT32, 1) for i, axis in enumerate("xyz")]
    message.header.stamp = rospy.Time.from_sec(stamp_s)
    return message


@pytest.fixture(name="scan")
def scan_fixture() -> ScanCollector:
    return ScanCollector(PARAMS, Looking(), lambda: None, lambda: NOW_S)


def take(scan: ScanCollector, stamp_s: float, xyz, q=Q, gather: bool = True, begin: bool = False) -> None:
    scan._on_cloud(cloud(stamp_s, xyz))
    scan.step(stamp_s, q, gather, begin)


def test_points_are_placed_by_the_joints_of_their_moment(scan):
    scan.step(0.9, np.full(6, 0.3), True, False)
    take(scan, 1.0, [[0.05, 0.02, 0.45]], np.full(6, 0.05))
    found = scan.points()
    pose = Looking().camera(np.full(6, 0.05))
    assert found == pytest.approx(transform_points(pose, np.array([[0.05, 0.02, 0.45]])), abs=1e-6)


def test_what_is_no_depth_or_not_near_the_part_is_left_out(scan):
    far = PARAMS.scan_volume_m + 0.05
    good = [0.0, 0.0, 0.47]
    bad = [
        [np.nan] * 3,
        [0.0, 0.0, 0.1],
        [0.0, 0.0, 2.5],
        [far, 0.0, 0.47],
        [0.0, 0.0, 1.2 - PARAMS.scan_lowest_m + 0.01],
    ]
    take(scan, 1.0, [good, *bad])
    assert len(scan.points()) == 1


def test_clouds_are_not_kept_while_none_are_wanted(scan):
    take(scan, 1.0, [[0.0, 0.0, 0.47]], gather=False)
    scan.step(1.1, Q, True, False)
    assert len(scan.points()) == 0


def test_a_new_scan_forgets_the_one_before(scan):
    take(scan, 1.0, [[0.0, 0.0, 0.47]])
    scan.step(1.1, Q, True, True)
    assert len(scan.points()) == 0
    take(scan, 1.2, [[0.0, 0.0, 0.47], [0.01, 0.0, 0.47]])
    assert len(scan.points()) == 2
    scan.reset()
    assert len(scan.points()) == 0


def test_only_every_nth_cloud_is_placed():
    scan = ScanCollector(SanderNodeParams(scan_stride=1, scan_every=3), Looking(), lambda: None, lambda: NOW_S)
    for k in range(7):
        take(scan, 1.0 + 0.1 * k, [[0.0, 0.0, 0.47]])
    assert len(scan.points()) == 3


def test_a_cloud_without_joints_of_its_moment_is_left_out(scan):
    scan._on_cloud(cloud(1.0, [[0.0, 0.0, 0.47]]))
    scan.step(1.2, Q, True, False)
    assert len(scan.points()) == 0


def test_in_lock_step_a_tick_is_complete_when_no_cloud_can_still_come(scan):
    assert scan.complete(5.0)  # nobody has seen a cloud: none is waited for
    scan._on_cloud(cloud(1.0, [[0.0, 0.0, 0.47]]))
    assert scan.complete(1.0) and scan.complete(1.0 + 0.8 * CLOUD_PERIOD_S)
    assert not scan.complete(1.0 + 1.5 * CLOUD_PERIOD_S)


def test_a_cloud_from_the_future_is_left_out(scan):
    take(scan, NOW_S + 1.0, [[0.0, 0.0, 0.47]])
    assert len(scan.points()) == 0
