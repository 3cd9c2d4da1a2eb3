"""Every topic and service of the inspector and the recogniser, beside those of the known room they are in."""

from __future__ import annotations

from dataclasses import replace
from typing import Tuple

from yarm.ros.common import api_explorer, api_navigation, names
from yarm.ros.common.api import Service, Topic
from yarm.ros.common.api_rooms import MUX

INSPECTOR = names.INSPECTOR_NODE
RECOGNISER = names.RECOGNISER_NODE

TOPICS: Tuple[Topic, ...] = (
    Topic(
        names.inspector("status"),
        "yarm/InspectionStatus",
        INSPECTOR,
        f"{names.GATE_NODE}, {RECOGNISER}, experiments, people",
        "10 Hz",
        names.MAP_FRAME,
        True,
        10,
        "the gate lives on it: stage, box, time left, time home, verdicts so far, sick inputs, reason",
    ),
    Topic(
        names.inspector("verdict"),
        "yarm/TagVerdict",
        INSPECTOR,
        "people",
        "once a box",
        names.MAP_FRAME,
        queue=100,
        meaning="what is on a box, when the visit to it has ended",
    ),
    Topic(
        names.inspector("markers"),
        "visualization_msgs/MarkerArray",
        INSPECTOR,
        "RViz",
        "2 Hz",
        names.MAP_FRAME,
        True,
        2,
        "boxes by verdict, viewpoints and tour, home, time left",
    ),
    Topic(
        names.NAVI,
        "geometry_msgs/Twist",
        f"{INSPECTOR}, {names.MOVE_BASE}",
        MUX,
        "10 Hz",
        queue=10,
        meaning="turns in place of the inspector, only while move_base has no goal of its",
    ),
    Topic(
        names.recogniser("verdict"),
        "yarm/TagVerdict",
        RECOGNISER,
        "people",
        "5 Hz while somebody listens",
        names.RGB_FRAME,
        meaning="what a picture shows of which nothing else is known but the box that a round is looking at",
    ),
    Topic(
        names.OBJECTS,
        "std_msgs/Float32MultiArray",
        RECOGNISER,
        "people",
        "5 Hz while somebody listens",
        meaning="of each tag number, width, height, nine of the homography in Qt's order, as find_object_2d does",
    ),
    Topic(
        names.recogniser("image"),
        "sensor_msgs/Image",
        RECOGNISER,
        "RViz",
        "5 Hz while somebody listens",
        names.RGB_FRAME,
        queue=2,
        meaning="the picture with the outlines of the tags, bgr8",
    ),
)
REQUESTS = {
    "start": "begin a round, from idle or after one",
    "stop": "stand; the result so far is written",
    "return_home": "drive home; boxes that are left have no verdict",
    "relocalise": "turn once in place, then go on",
    "save": "write the result so far",
}
SERVICES: Tuple[Service, ...] = (
    *(Service(names.inspector(name), "std_srvs/Trigger", INSPECTOR, meaning) for name, meaning in REQUESTS.items()),
    Service(names.recogniser("add_tag"), "yarm/AddTag", RECOGNISER, "look for one more tag"),
    Service(names.recogniser("remove_tag"), "yarm/RemoveTag", RECOGNISER, "look for a tag no longer"),
    Service(names.recogniser("load_tags"), "yarm/LoadTags", RECOGNISER, "replace all tags by those of a file"),
)

OWN = {topic.name for topic in TOPICS}
EVERY_TOPIC: Tuple[Topic, ...] = (
    *(
        replace(topic, sender=api_explorer.SENDERS[names.BASE_VELOCITY]) if topic.name == names.BASE_VELOCITY else topic
        for topic in api_navigation.EVERY_TOPIC
        if topic.name not in OWN
    ),
    *(topic for topic in api_explorer.TOPICS if topic.sender == api_explorer.GATE or topic.name == names.GATE_INPUT),
    *TOPICS,
)
EVERY_SERVICE: Tuple[Service, ...] = (*api_navigation.EVERY_SERVICE, *SERVICES, api_explorer.STOP)
"""Of inspection.launch."""
