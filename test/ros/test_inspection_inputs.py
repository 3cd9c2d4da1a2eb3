"""What the inspector hears beside what every robot hears: whether the map that is served holds its boxes."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest
import rospy
from nav_msgs.msg import OccupancyGrid

from yarm.geometry import Pose2
from yarm.inspection.boxes import Box
from yarm.inspection.model import Outcome
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
