"""What is different in a real cell: who tells what there, as data for docs/ros_api.md."""

from __future__ import annotations

from typing import Tuple

from yarm.ros.common import names
from yarm.ros.common.api import Service, Topic

REGISTRY = "cell_registry"

TOPICS: Tuple[Topic, ...] = (
    Topic(
        "/tf",
        "tf2_msgs/TFMessage",
        "drivers",
        "all",
        "30 Hz or more",
        "world",
        meaning="every frame of robots and arms, a child of world",
    ),
    Topic(
        "/tf_static",
        "tf2_msgs/TFMessage",
        f"drivers, {REGISTRY}",
        "all",
        "on change",
        "world",
        True,
        10,
        "cameras from drivers; what the scene fixes or a person has named from the registry, unless a driver tells it",
    ),
    Topic(
        names.OBJECT_REGISTRY,
        "yarm/ObjectRegistry",
        REGISTRY,
        "all",
        "on change",
        "world",
        True,
        10,
        "who is in the cell: the scene's bodies, robots and arms while their frames are fresh, what a person has named",
    ),
)

SERVICES: Tuple[Service, ...] = (
    Service(
        names.SPAWN_OBSTACLES,
        "yarm/SpawnObstacles",
        REGISTRY,
        "a person says what is there: debris, a target or an obstacle",
    ),
    Service(names.DELETE_OBSTACLES, "yarm/SpawnObstacles", REGISTRY, "and what is there no more; only the name counts"),
)
