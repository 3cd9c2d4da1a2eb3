"""The RViz configuration shows topics that exist, each with the display that its type needs."""

from __future__ import annotations

import re
from pathlib import Path

import yaml

from yarm.ros import api, names

CONFIG = Path(__file__).resolve().parents[2] / "config" / "rviz" / "yarm.rviz"
DISPLAY_OF = {
    "visualization_msgs/Marker": "rviz/Marker",
    "visualization_msgs/MarkerArray": "rviz/MarkerArray",
    "sensor_msgs/PointCloud2": "rviz/PointCloud2",
}
WITHOUT_TOPIC = {"rviz/Grid", "rviz/TF"}


def type_of(topic: str) -> str:
    """Type of a topic in the documented interface; fields such as {arm} stand for any name."""
    for entry in api.TOPICS:
        if re.fullmatch(re.sub(r"\\\{\w+\\\}", r"\\w+", re.escape(entry.name)), topic):
            return entry.type
    raise AssertionError(f"nobody publishes {topic}")


def test_each_display_fits_its_topic():
    displays = yaml.safe_load(CONFIG.read_text())["Visualization Manager"]["Displays"]
    shown = {}
    for display in displays:
        topic = display.get("Marker Topic") or display.get("Topic")
        if topic is None:
            assert display["Class"] in WITHOUT_TOPIC, display
            continue
        assert display["Class"] == DISPLAY_OF[type_of(topic)], f"{display['Name']}: {topic} is a {type_of(topic)}"
        shown[topic] = display["Enabled"]
    for topic in (names.OCCUPANCY, names.COLLISIONS, names.MAPS_AND_MASKS, names.PARTICLES_AND_WAYPOINTS):
        assert shown[topic], f"{topic} is not shown"
