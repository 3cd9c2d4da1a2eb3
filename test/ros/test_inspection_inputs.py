"""What the inspector hears beside what every robot hears: a map that holds its boxes, a place that is known."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid

from yarm.geometry import Pose2
from yarm.inspection.boxes import Box
from yarm.inspection.model import Outcome
from yarm.ros.common import names
from yarm.ros.inspection.inputs import InspectorInputs
from yarm.ros.inspection.params import InspectorParams


def map_of(rows, columns):
    message = OccupancyGrid(data=[0] * (rows * columns))
    message.header.frame_id = "map"
    message.info.resolution, message.info.height, message.info.width = 0.1, rows, columns
    message.info.origin.orientation.w = 1.0
    return message


@pytest.fixture
def heard(monkeypatch):
    monkeypatch.setattr(rospy, "Subscriber", lambda *_, **__: None)
    monkeypatch.setattr(rospy, "get_time", lambda: 10.0)
    navigation = SimpleNamespace(outcome=lambda now_s: (Outcome.BUSY, ""), gone=lambda now_s: "")
    return InspectorInputs(InspectorParams(), navigation, [Box(3, Pose2(1.0, 0.5)), Box(7, Pose2(2.5, 0.5, math.pi))])


def test_a_map_in_which_a_box_does_not_lie_is_refused_by_number_place_and_size(heard):
    assert heard.observe(10.0).map_fault == "none has come"
    heard._on_map(map_of(20, 20))
    assert heard.observe(10.0).map_fault == "box 7 at (2.5, 0.5) outside of it, 2 x 2 m from (0, 0) on"
    heard._on_map(map_of(20, 30))
    assert heard.observe(10.0).map_fault == ""


def pose_of(variance, frame="map", length=1.0):
    message = PoseWithCovarianceStamped()
    message.header.frame_id = frame
    message.pose.pose.orientation.w = length
    message.pose.covariance = [0.0] * 36
    message.pose.covariance[0] = message.pose.covariance[7] = variance
    return message


def state_of(level, text=""):
    message = DiagnosticArray(status=[DiagnosticStatus(level=level, message=text)])
    message.header.stamp, message.header.frame_id = rospy.Time(10.0), "map"
    return message


def place(heard):
    seen = heard.observe(11.0)
    return seen.localised, seen.place_fault


def test_the_platforms_amcl_localises_by_its_pose_alone(heard):
    assert place(heard) == (False, "")
    assert heard._on_pose(pose_of(0.25)) == "" and "deviation of 0.50 m" in place(heard)[1]
    assert heard._on_pose(pose_of(0.001)) == "" and place(heard) == (True, "")
    assert "expected 'map'" in heard._on_pose(pose_of(1.0, frame="odom"))
    assert "length 1" in heard._on_pose(pose_of(1.0, length=2.0))
    assert place(heard) == (True, ""), "what is no pose in the map says nothing of it"
    assert "not all are finite" in heard._on_pose(pose_of(math.nan)) and not place(heard)[0]


def test_our_amcls_word_counts_alone_once_it_is_heard(heard):
    heard._on_pose(pose_of(0.001))
    assert heard._on_state(state_of(DiagnosticStatus.WARN, "scan and map disagree")) == ""
    heard._on_pose(pose_of(0.001))
    assert place(heard) == (False, "scan and map disagree")
    heard._on_state(state_of(DiagnosticStatus.OK))
    heard._on_pose(pose_of(9.0))
    assert place(heard) == (True, "")


@pytest.mark.parametrize("sync", [False, True])
def test_the_lock_step_hears_no_poses(sync, monkeypatch):
    topics = []
    monkeypatch.setattr(rospy, "Subscriber", lambda topic, *_, **__: topics.append(topic))
    InspectorInputs(InspectorParams(sync=sync), SimpleNamespace(), [])
    assert names.AMCL_STATE in topics and (names.AMCL_POSE in topics) is not sync
