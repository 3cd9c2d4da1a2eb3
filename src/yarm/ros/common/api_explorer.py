"""Every topic and service of the explorer, beside those of the room it explores (yarm.ros.common.api_rooms)."""

from __future__ import annotations

from dataclasses import replace
from typing import Tuple

from yarm.ros.common import api_rooms, names
from yarm.ros.common.api import Service, Topic

EXPLORER = names.EXPLORER_NODE
GATE = names.GATE_NODE

TOPICS: Tuple[Topic, ...] = (
    Topic(
        names.explorer("status"),
        "yarm/ExplorerStatus",
        EXPLORER,
        f"{GATE}, experiments, people",
        "10 Hz",
        names.MAP_FRAME,
        True,
        10,
        "state, behaviour, time left, area, bumps, goal, sick sensors, reason; the gate lives on it",
    ),
    Topic(
        names.explorer("events"),
        "yarm/ExplorerEvent",
        EXPLORER,
        "experiments",
        "when something happens",
        names.MAP_FRAME,
        queue=1000,
        meaning="a line of events.csv",
    ),
    Topic(
        names.explorer("map"),
        "nav_msgs/OccupancyGrid",
        EXPLORER,
        "RViz, experiments",
        "on change, 1 Hz at most",
        names.MAP_FRAME,
        True,
        meaning="the map with low obstacles and what was bumped into, as it is saved",
    ),
    Topic(
        names.explorer("frontiers"),
        "visualization_msgs/MarkerArray",
        EXPLORER,
        "RViz",
        "2 Hz",
        names.MAP_FRAME,
        True,
        2,
        "candidates from yellow to green by score; refused ones red, with the reason",
    ),
    Topic(
        names.explorer("plan"), "nav_msgs/Path", EXPLORER, "RViz", "2 Hz", names.MAP_FRAME, True, 2, "way to the goal"
    ),
    Topic(names.explorer("path"), "nav_msgs/Path", EXPLORER, "RViz", "2 Hz", names.MAP_FRAME, True, 2, "way so far"),
    Topic(
        names.explorer("bumps"),
        "visualization_msgs/MarkerArray",
        EXPLORER,
        "RViz",
        "2 Hz",
        names.MAP_FRAME,
        True,
        2,
        "where the robot bumped into something",
    ),
    Topic(
        names.explorer("view"),
        "visualization_msgs/MarkerArray",
        EXPLORER,
        "RViz",
        "2 Hz",
        names.MAP_FRAME,
        True,
        2,
        "footprint, goal with what it would see, state and time left as text",
    ),
    Topic(
        names.EXPLORE_RESUME,
        "std_msgs/Bool",
        "people",
        EXPLORER,
        "on demand",
        queue=10,
        meaning="true resumes, false pauses, as explore_lite's successor has it",
    ),
    Topic(
        names.TELEOP,
        "geometry_msgs/Twist",
        EXPLORER,
        api_rooms.MUX,
        "10 Hz",
        queue=10,
        meaning="what the explorer wants: one command a pass, zeros while it stands; driven by move_base it sends "
        "goals, and the rest through navi",
    ),
    Topic(
        names.GATE_INPUT,
        "geometry_msgs/Twist",
        api_rooms.MUX,
        GATE,
        "as commanded",
        queue=10,
        meaning="what the multiplexer lets through, on its way to the base",
    ),
    Topic(
        names.SAFETY_STATUS,
        "yarm/SafetyStatus",
        GATE,
        f"{names.CONSOLE_NODE}, people",
        "2 Hz, and on change",
        names.MAP_FRAME,
        True,
        10,
        "whether a person has stopped the robot, and who; nothing is measured ahead of it",
    ),
)
REQUESTS = {
    "start": "begin, from idle or after a run",
    "stop": "end the run; the map is saved",
    "pause": "stand; the time runs on",
    "resume": "go on",
    "save_map": "save the map now",
    "return_to_start": "drive back to where the run began, and end",
}
STOP = Service(
    names.SAFETY_STOP, "std_srvs/SetBool", GATE, "true: the robot stands, until false is asked for (docs/safety.md)"
)
SERVICES: Tuple[Service, ...] = (
    *(Service(names.explorer(name), "std_srvs/Trigger", EXPLORER, meaning) for name, meaning in REQUESTS.items()),
    STOP,
)


SENDERS = {names.BASE_VELOCITY: GATE, names.mux_input("{source}"): "people"}
"""With the explorer the gate stands before the base, and of the multiplexer's sources only one is the explorer's."""


EVERY_TOPIC: Tuple[Topic, ...] = (
    *(replace(topic, sender=SENDERS.get(topic.name, topic.sender)) for topic in api_rooms.TOPICS),
    *TOPICS,
)
EVERY_SERVICE: Tuple[Service, ...] = (*api_rooms.SERVICES, *SERVICES)
"""Of exploration.launch."""
