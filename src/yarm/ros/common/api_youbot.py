"""Topics and services of the youBot on its floor, as data (see ``yarm.ros.common.api``)."""

from __future__ import annotations

from typing import Tuple

from yarm.robots.youbot import NAME
from yarm.ros.common import names
from yarm.ros.common.api import Service, Topic

YOUBOT = names.YOUBOT_NODE
TOPICS: Tuple[Topic, ...] = (
    Topic("/clock", "rosgraph_msgs/Clock", YOUBOT, "all", "60 Hz", queue=10, meaning="simulated time"),
    Topic("/tf", "tf2_msgs/TFMessage", YOUBOT, "all", "20 Hz", "world", queue=10, meaning="links and debris"),
    Topic("/tf_static", "tf2_msgs/TFMessage", YOUBOT, "all", "at start", "world", True, 10, "bin and obstacles"),
    Topic(
        names.OBJECT_REGISTRY, "yarm/ObjectRegistry", YOUBOT, "console", "at start", "world", True, 10, "who is there"
    ),
    Topic(
        names.youbot("status"),
        "yarm/YoubotStatus",
        YOUBOT,
        "console, people",
        "10 Hz",
        "world",
        True,
        10,
        "what it does, what it refused and why, what hangs on the cup, what is in the bin",
    ),
    Topic(
        names.youbot("hand_path"),
        "nav_msgs/Path",
        YOUBOT,
        "console, RViz",
        "when a motion begins",
        "world",
        True,
        10,
        "the hand's way in it; places alone, the turns mean nothing",
    ),
    Topic(
        names.SAFETY_STATUS,
        "yarm/SafetyStatus",
        YOUBOT,
        "console, people",
        "2 Hz, and at a stop and its end",
        "world",
        True,
        10,
        "whether a person has stopped it, who and when",
    ),
    Topic(
        names.YOUBOT_VELOCITY,
        "geometry_msgs/Twist",
        "people",
        YOUBOT,
        "on demand",
        queue=10,
        meaning="velocity of the base, m/s ahead and to the left, rad/s; it counts for 0.5 s",
    ),
    Topic(
        names.gripper(NAME, "grasping"),
        "std_msgs/Bool",
        YOUBOT,
        "people",
        "on change",
        latched=True,
        queue=10,
        meaning="something hangs on the cup",
    ),
    Topic(
        names.ARM_COMMAND,
        "trajectory_msgs/JointTrajectory",
        "people",
        YOUBOT,
        "on demand",
        queue=10,
        meaning="a motion in the angles of the driver, rad (rosbag play tour.bag), or refused with the reason",
    ),
    Topic(
        names.ARM_JOINT_STATES,
        "sensor_msgs/JointState",
        YOUBOT,
        "people",
        "60 Hz",
        queue=10,
        meaning="measured angles and speeds of arm_joint_1 to 5, the driver's",
    ),
)

SERVICES: Tuple[Service, ...] = (
    Service(names.gripper(NAME, "on"), "std_srvs/Empty", YOUBOT, "suction on: the cup takes what it presses on"),
    Service(names.gripper(NAME, "off"), "std_srvs/Empty", YOUBOT, "suction off: the cup lets go"),
    Service(names.SAFETY_STOP, "std_srvs/SetBool", YOUBOT, "true: base and arm stand, until false is asked for"),
)
