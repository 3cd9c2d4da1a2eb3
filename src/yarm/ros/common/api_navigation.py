"""Every topic, service and action of driving over a known map, beside those of the room (yarm.ros.common.api_rooms)."""

from __future__ import annotations

from dataclasses import replace
from typing import Tuple

from yarm.ros.common import api_rooms, names
from yarm.ros.common.api import Service, Topic
from yarm.ros.common.api_rooms import MUX, ROOM, SLAM

AMCL = "amcl"
MAP_SERVER = "map_server"
FINE_MAP_SERVER = f"localisation/{MAP_SERVER}"
MOVE_BASE = names.MOVE_BASE

CAMERA: Tuple[Topic, ...] = (
    Topic(
        names.RGB_IMAGE,
        "sensor_msgs/Image",
        ROOM,
        "tag_recogniser",
        "30 Hz when somebody listens",
        names.RGB_FRAME,
        meaning="640 x 480, rgb8; only in a layout: boxes with tags, drawn by homography",
    ),
    Topic(
        names.RGB_INFO,
        "sensor_msgs/CameraInfo",
        ROOM,
        "tag_recogniser",
        "30 Hz when somebody listens",
        names.RGB_FRAME,
        meaning="the RGB camera's pinhole",
    ),
)
PLACE: Tuple[Topic, ...] = (
    Topic(
        f"localisation/{names.MAP}",
        "nav_msgs/OccupancyGrid",
        FINE_MAP_SERVER,
        AMCL,
        "once",
        names.MAP_FRAME,
        True,
        1,
        "the same map with cells of 2.5 cm, so that a face stands nearer to its place; fine_map:=false: amcl takes map",
    ),
    Topic(
        f"localisation/{names.MAP_METADATA}",
        "nav_msgs/MapMetaData",
        FINE_MAP_SERVER,
        "people",
        "once",
        latched=True,
        meaning="its size",
    ),
    Topic(
        names.INITIAL_POSE,
        "geometry_msgs/PoseWithCovarianceStamped",
        "people",
        AMCL,
        "on demand",
        names.MAP_FRAME,
        queue=10,
        meaning="about where the robot is; 2D Pose Estimate of RViz",
    ),
    Topic(
        names.AMCL_POSE,
        "geometry_msgs/PoseWithCovarianceStamped",
        AMCL,
        f"{names.INSPECTOR_NODE}, people",
        "each fit",
        names.MAP_FRAME,
        True,
        10,
        f"where the robot is, and how sure that is; the inspector takes it while nobody has said {names.AMCL_STATE}",
    ),
    Topic(
        names.PARTICLE_CLOUD,
        "geometry_msgs/PoseArray",
        AMCL,
        "RViz",
        "2 Hz",
        names.MAP_FRAME,
        True,
        10,
        "samples of the belief",
    ),
    Topic(
        f"{AMCL}/localised",
        "std_msgs/Bool",
        AMCL,
        "people",
        "on change",
        latched=True,
        queue=10,
        meaning="the place is known: small spread, and the scan agrees with the map",
    ),
    Topic(f"{AMCL}/reason", "std_msgs/String", AMCL, "people", "on change", "", True, 10, "why it is not"),
    Topic(
        names.AMCL_STATE,
        "diagnostic_msgs/DiagnosticArray",
        AMCL,
        names.INSPECTOR_NODE,
        "each scan",
        names.MAP_FRAME,
        True,
        10,
        "what became of the scan of this stamp: OK when localised, else why not; without frame when no place was sent",
    ),
)
DRIVING: Tuple[Topic, ...] = (
    Topic(
        names.SIMPLE_GOAL,
        "geometry_msgs/PoseStamped",
        "people",
        MOVE_BASE,
        "on demand",
        "any",
        queue=10,
        meaning="a goal without a client; 2D Nav Goal of RViz",
    ),
    Topic(
        names.mux_input("navi"),
        "geometry_msgs/Twist",
        MOVE_BASE,
        MUX,
        "5 Hz while driving, 10 Hz in a round",
        queue=10,
        meaning="linear.x m/s, angular.z rad/s; a zero when a goal ends",
    ),
    Topic(
        names.move_base("global_costmap/costmap"),
        "nav_msgs/OccupancyGrid",
        MOVE_BASE,
        "RViz",
        "on change, 1 Hz at most, when somebody listens",
        names.MAP_FRAME,
        True,
        meaning="100 taken, 99 the robot's disc touches, then falling, -1 not known",
    ),
    Topic(
        names.move_base("local_costmap/costmap"),
        "nav_msgs/OccupancyGrid",
        MOVE_BASE,
        "RViz",
        "1 Hz when somebody listens",
        names.MAP_FRAME,
        True,
        meaning="the same, 4 x 4 m around the robot",
    ),
    Topic(
        names.move_base("NavfnROS/plan"),
        "nav_msgs/Path",
        MOVE_BASE,
        "RViz",
        "each new way",
        names.MAP_FRAME,
        True,
        meaning="the way as it was planned",
    ),
    Topic(
        names.move_base("local_plan"),
        "nav_msgs/Path",
        MOVE_BASE,
        "RViz",
        "each command, when somebody listens",
        names.MAP_FRAME,
        meaning="what is left of it",
    ),
    Topic(
        names.move_base("current_goal"),
        "geometry_msgs/PoseStamped",
        MOVE_BASE,
        "RViz",
        "each goal",
        names.MAP_FRAME,
        True,
        meaning="what is driven to",
    ),
)
TOPICS: Tuple[Topic, ...] = (*CAMERA, *PLACE, *DRIVING)
SERVICES: Tuple[Service, ...] = (
    Service(names.STATIC_MAP, "nav_msgs/GetMap", MAP_SERVER, "the map, with known boxes in it"),
    Service(f"localisation/{names.STATIC_MAP}", "nav_msgs/GetMap", FINE_MAP_SERVER, "the map that amcl is given"),
    Service(names.GLOBAL_LOCALIZATION, "std_srvs/Empty", AMCL, "forget the place and look for it in the whole map"),
    Service(names.REQUEST_NOMOTION_UPDATE, "std_srvs/Empty", AMCL, "fit the next scan although the robot stands"),
    Service(names.SET_MAP, "nav_msgs/SetMap", AMCL, "another map and a place in it"),
    Service(
        names.move_base("make_plan"),
        "nav_msgs/GetPlan",
        MOVE_BASE,
        "the way from a start, or from the robot when its frame is empty; empty: not reachable; also while driving",
    ),
    Service(names.move_base("NavfnROS/make_plan"), "nav_msgs/GetPlan", MOVE_BASE, "the same"),
    Service(names.move_base("clear_costmaps"), "std_srvs/Empty", MOVE_BASE, "forget what was seen or touched"),
    Service(
        names.move_base("clear_unknown_space"),
        "std_srvs/Empty",
        MOVE_BASE,
        "take unknown cells within 1.5 m of the robot for free",
    ),
)
ACTIONS: Tuple[Service, ...] = (
    Service(
        MOVE_BASE,
        "move_base_msgs/MoveBaseAction",
        MOVE_BASE,
        "drive to a pose; feedback is the robot's; the status text says why a goal was given up or refused",
    ),
)


def _known(topic: Topic) -> Topic:
    """A topic of the room as it is where the map is known."""
    senders = {names.MAP: MAP_SERVER, names.MAP_METADATA: MAP_SERVER, names.DIAGNOSTICS: AMCL}
    return replace(topic, sender=senders.get(topic.name, topic.sender.replace(SLAM, AMCL)))


EVERY_TOPIC: Tuple[Topic, ...] = (
    *(
        _known(topic)
        for topic in api_rooms.TOPICS
        if topic.name not in (names.SLAM_ENTROPY, names.SLAM_STATE, names.mux_input("{source}"))
    ),
    Topic(names.mux_input("{source}"), "geometry_msgs/Twist", "people", MUX, "on demand"),
    *TOPICS,
)
"""Of a layout with map, localisation and driving."""
EVERY_SERVICE: Tuple[Service, ...] = SERVICES
