"""Each RViz configuration shows topics that exist, each with the display that its type needs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Sequence

import pytest
import yaml

from yarm.ros.common import api, api_explorer, api_inspection, names

CONFIGS = Path(__file__).resolve().parents[2] / "config"
DISPLAY_OF = {
    "geometry_msgs/PoseArray": "rviz/PoseArray",
    "geometry_msgs/PoseStamped": "rviz/Pose",
    "nav_msgs/OccupancyGrid": "rviz/Map",
    "nav_msgs/Odometry": "rviz/Odometry",
    "nav_msgs/Path": "rviz/Path",
    "sensor_msgs/Image": "rviz/Image",
    "sensor_msgs/LaserScan": "rviz/LaserScan",
    "visualization_msgs/Marker": "rviz/Marker",
    "visualization_msgs/MarkerArray": "rviz/MarkerArray",
    "sensor_msgs/PointCloud2": "rviz/PointCloud2",
}
WITHOUT_TOPIC = {"rviz/Grid", "rviz/RobotModel", "rviz/TF"}
CELL = (
    names.OCCUPANCY,
    names.COLLISIONS,
    names.HIDDEN_CELLS,
    names.TRACKS,
    names.MAPS_AND_MASKS,
    names.PARTICLES_AND_WAYPOINTS,
)
EXPLORATION = (
    names.SCAN,
    names.SIM_POSE,
    *(names.explorer(n) for n in ("map", "frontiers", "plan", "path", "bumps", "view")),
)
INSPECTION = (
    names.inspector("markers"),
    names.MAP,
    names.SCAN,
    names.PARTICLE_CLOUD,
    names.RGB_IMAGE,
    names.move_base("global_costmap/costmap"),
    names.move_base("NavfnROS/plan"),
)

TOOLS = {
    "rviz/SetInitialPose": (names.INITIAL_POSE, "geometry_msgs/PoseWithCovarianceStamped"),
    "rviz/SetGoal": (names.SIMPLE_GOAL, "geometry_msgs/PoseStamped"),
}


def type_of(topic: str, topics: Sequence[api.Topic]) -> str:
    """Type of a topic in the documented interface; fields such as {arm} stand for any name."""
    for entry in topics:
        if re.fullmatch(re.sub(r"\\\{\w+\\\}", r"\\w+", re.escape(entry.name)), topic):
            return entry.type
    raise AssertionError(f"nobody publishes {topic}")


@pytest.mark.parametrize(
    ("config", "topics", "wanted"),
    [
        ("cell/rviz/yarm.rviz", api.TOPICS, CELL),
        ("exploration/rviz/exploration.rviz", api_explorer.EVERY_TOPIC, EXPLORATION),
        ("inspection/rviz/inspection.rviz", api_inspection.EVERY_TOPIC, INSPECTION),
    ],
)
def test_each_display_fits_its_topic(config, topics, wanted):
    displays = yaml.safe_load((CONFIGS / config).read_text())["Visualization Manager"]["Displays"]
    shown = {}
    for display in displays:
        topic = display.get("Marker Topic") or display.get("Topic") or display.get("Image Topic")
        if topic is None:
            assert display["Class"] in WITHOUT_TOPIC, display
            continue
        kind = type_of(topic, topics)
        assert display["Class"] == DISPLAY_OF[kind], f"{display['Name']}: {topic} is a {kind}"
        shown[topic] = display["Enabled"]
    for topic in wanted:
        assert shown[topic], f"{topic} is not shown"


def test_the_round_has_the_tools_for_pose_and_goal_on_the_topics_that_are_heard():
    shown = yaml.safe_load((CONFIGS / "inspection/rviz/inspection.rviz").read_text())["Visualization Manager"]
    assert shown["Global Options"]["Fixed Frame"] == names.MAP_FRAME, "poses are sent in it, and taken only there"
    topics = {tool["Class"]: tool["Topic"] for tool in shown["Tools"] if "Topic" in tool}
    assert topics == {tool: topic for tool, (topic, _) in TOOLS.items()}
    for topic, kind in TOOLS.values():
        assert type_of(topic, api_inspection.EVERY_TOPIC) == kind
