"""Every topic and service of a room that is explored, as yarm.ros.common.api has those of the cell."""

from __future__ import annotations

from typing import Tuple

from yarm.ros.common import names
from yarm.ros.common.api import Service, Topic

ROOM = "room_simulation"
MUX = "cmd_vel_mux"
SLAM = "slam_gmapping"
STATES = "robot_state_publisher"

TOPICS: Tuple[Topic, ...] = (
    Topic("/clock", "rosgraph_msgs/Clock", ROOM, "all", "60 Hz; lock-step 20 Hz", queue=10, meaning="simulated time"),
    Topic(
        "/tf",
        "tf2_msgs/TFMessage",
        f"{ROOM}, {SLAM}, {STATES}",
        "all",
        "50 Hz; map -> odom 20 Hz",
        queue=100,
        meaning="map -> odom -> base_footprint, and the wheels",
    ),
    Topic(
        "/tf_static",
        "tf2_msgs/TFMessage",
        f"{ROOM}, {STATES}",
        "all",
        "at start",
        latched=True,
        meaning="base_footprint -> base_link -> cameras; world -> map, where the truth is drawn beside the map",
    ),
    Topic(
        names.ODOM,
        "nav_msgs/Odometry",
        ROOM,
        "explorer",
        "50 Hz",
        names.ODOM_FRAME,
        queue=10,
        meaning="wheels and gyro; it slips where the robot does",
    ),
    Topic(
        names.SCAN,
        "sensor_msgs/LaserScan",
        ROOM,
        f"{SLAM}, explorer",
        "20 Hz",
        names.SCAN_FRAME,
        queue=10,
        meaning="640 beams over 60 deg, right to left: the nearest of 10 rows of the depth image; NaN: nothing valid",
    ),
    Topic(
        names.DEPTH_IMAGE,
        "sensor_msgs/Image",
        ROOM,
        "explorer",
        "20 Hz when somebody listens",
        names.DEPTH_FRAME,
        queue=2,
        meaning="640 x 480, 32FC1, metres; NaN where nothing is measured and behind the robot's own plate",
    ),
    Topic(
        names.DEPTH_INFO,
        "sensor_msgs/CameraInfo",
        ROOM,
        "explorer, RViz",
        "20 Hz when somebody listens",
        names.DEPTH_FRAME,
        queue=2,
        meaning="the depth camera's pinhole; images of another one than the TurtleBot's are left out",
    ),
    Topic(
        names.BUMPER,
        "yarm/BumperEvent",
        ROOM,
        "explorer",
        "on change",
        queue=10,
        meaning="a sector of the bumper was pressed or let go; the md5 sum of kobuki_msgs/BumperEvent",
    ),
    Topic(
        names.BUMPER_CLOUD,
        "sensor_msgs/PointCloud2",
        ROOM,
        "RViz, explorer in lock-step",
        "50 Hz while pressed, and once after; in lock-step 10 Hz at least",
        names.BASE_LINK,
        queue=10,
        meaning="a point for each sector: 0.24 m away where it is pressed, 100 m where it is not",
    ),
    Topic(
        names.BASE_JOINTS,
        "sensor_msgs/JointState",
        ROOM,
        STATES,
        "50 Hz when somebody listens",
        queue=10,
        meaning="the two wheels",
    ),
    Topic(
        names.mux_input("{source}"),
        "geometry_msgs/Twist",
        "people, explorer",
        MUX,
        "10 Hz while driving",
        queue=10,
        meaning="linear.x m/s, angular.z rad/s; priorities and timeouts: config/exploration/cmd_vel_mux.yaml",
    ),
    Topic(
        names.MUX_ACTIVE,
        "std_msgs/String",
        MUX,
        "people",
        "on change",
        latched=True,
        queue=10,
        meaning="the source that drives, or idle",
    ),
    Topic(
        names.BASE_VELOCITY,
        "geometry_msgs/Twist",
        MUX,
        ROOM,
        "as commanded",
        queue=10,
        meaning="what was let through; without any for 0.6 s the base stops by itself",
    ),
    Topic(names.MAP, "nav_msgs/OccupancyGrid", SLAM, "explorer", "every 5 s", names.MAP_FRAME, True, 1, "docs/slam.md"),
    Topic(names.MAP_METADATA, "nav_msgs/MapMetaData", SLAM, "people", "every 5 s", latched=True, meaning="its size"),
    Topic(names.SLAM_ENTROPY, "std_msgs/Float64", SLAM, "people", "each match", queue=1, meaning="of the pose, nats"),
    Topic(
        names.SLAM_STATE,
        "diagnostic_msgs/DiagnosticArray",
        SLAM,
        "explorer",
        "each scan",
        names.MAP_FRAME,
        True,
        10,
        "what became of the scan of this stamp: OK when matched or not due, else why not; stamp of the newest map",
    ),
    Topic(
        names.DIAGNOSTICS, "diagnostic_msgs/DiagnosticArray", SLAM, "people", "1 Hz", queue=10, meaning="sick inputs"
    ),
    Topic(
        names.SIM_POSE,
        "nav_msgs/Odometry",
        ROOM,
        "experiments",
        "50 Hz",
        names.WORLD_FRAME,
        queue=100,
        meaning="ground truth: where the robot is, and how fast",
    ),
    Topic(
        names.SIM_CONTACTS, "yarm/Contacts", ROOM, "experiments", "50 Hz", names.WORLD_FRAME, queue=100, meaning="truth"
    ),
    Topic(
        names.SIM_ARENA,
        "visualization_msgs/MarkerArray",
        ROOM,
        "RViz",
        "at start",
        names.WORLD_FRAME,
        True,
        meaning="walls and blocks as they are",
    ),
    Topic(names.SIM_STATUS, "yarm/SimStatus", ROOM, "experiments", "1 Hz", queue=10, meaning="real-time factor, load"),
    Topic(
        names.STEP_ACK,
        "yarm/StepAck",
        "explorer",
        ROOM,
        "each pass, in lock-step only",
        queue=100,
        meaning="a participant is done with a pass",
    ),
)

SERVICES: Tuple[Service, ...] = (Service(names.DYNAMIC_MAP, "nav_msgs/GetMap", SLAM, "the newest map"),)
