"""Every topic, service and action of the cell as data: docs/ros_api.md is drawn from it, and a test compares it live.

Those of a room that is explored are in yarm.ros.common.api_rooms, of driving over a known map in api_navigation.

``{robot}`` stands for each mobile robot, ``{arm}`` for each manipulator, ``{n}`` for the overhead cameras 1 to 4,
``{caster}`` for fl, fr, rl, rr.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Sequence, Tuple

from yarm.ros.common import names

SIM = "simulation"
MERGE = "merge_clouds"
ASSOC = "cluster_assoc"
MAP = "database"
SEEDS = "seed_tf_publisher"
COMMANDER = names.COMMANDER_NODE
CONTROLS = "multi_robot_controls_server"
SANDER = "hc10_state_machine"
SAFETY = names.SAFETY_NODE


@dataclass(frozen=True)
class Topic:
    """One topic: who sends what to whom, how often, and how it is kept."""

    name: str
    type: str
    sender: str
    receivers: str
    rate: str
    frame: str = ""
    latched: bool = False
    queue: int = 1
    meaning: str = ""


@dataclass(frozen=True)
class Service:
    """One service or action."""

    name: str
    type: str
    server: str
    meaning: str


TOPICS: Tuple[Topic, ...] = (
    Topic("/clock", "rosgraph_msgs/Clock", SIM, "all", "60 Hz or more", meaning="simulated time"),
    Topic("/tf", "tf2_msgs/TFMessage", SIM, "all", "60 Hz", "world", meaning="every moving frame, a child of world"),
    Topic(
        "/tf_static", "tf2_msgs/TFMessage", SIM, "all", "at start", "world", True, meaning="cameras and fixed bodies"
    ),
    Topic(
        names.camera_points(0).replace("0", "{n}"),
        "sensor_msgs/PointCloud2",
        SIM,
        MERGE,
        "30 Hz",
        "mapping_camera_{n}_depth_optical_frame",
        queue=2,
        meaning="organised 320 x 320 depth cloud, NaN out of range, stamp = capture time",
    ),
    Topic(
        names.OBJECT_REGISTRY, "yarm/ObjectRegistry", SIM, "all", "on change", "world", True, 1, "who is in the cell"
    ),
    Topic(
        names.joint_states("{robot}"), "sensor_msgs/JointState", SIM, CONTROLS, "60 Hz", meaning="casters and wheels"
    ),
    Topic(names.joint_states("{arm}"), "sensor_msgs/JointState", SIM, SANDER, "60 Hz", meaning="the arm's joints"),
    Topic(
        names.cmd_vel("{robot}"),
        "geometry_msgs/Twist",
        f"{CONTROLS}, {SAFETY}",
        SIM,
        "60 Hz while moving",
        queue=10,
        meaning="linear.x: drive speed along the wheels' heading, m/s; angular.z: yaw rate about the casters' centre",
    ),
    Topic(
        names.caster_command("{robot}", "{caster}"),
        "std_msgs/Float64",
        CONTROLS,
        SIM,
        "60 Hz while moving",
        queue=10,
        meaning="caster angle, rad",
    ),
    Topic(
        names.caster_state("{robot}", "{caster}"),
        "yarm/JointControllerState",
        SIM,
        CONTROLS,
        "60 Hz",
        meaning="set point, measured angle, error and torque of a caster",
    ),
    Topic(
        names.joint_path_command("{arm}"),
        "trajectory_msgs/JointTrajectory",
        SANDER,
        SIM,
        "on change",
        queue=10,
        meaning="joint trajectory to follow from now on",
    ),
    Topic(
        names.wrist_points("{arm}"),
        "sensor_msgs/PointCloud2",
        SIM,
        SANDER,
        "15 Hz when somebody listens",
        names.wrist_optical_frame("{arm}"),
        queue=2,
        meaning="the part scanner",
    ),
    Topic(names.SIM_CONTACTS, "yarm/Contacts", SIM, "experiments", "60 Hz", "world", queue=100, meaning="ground truth"),
    Topic(
        names.SIM_CLEARANCE, "yarm/Clearance", SIM, "experiments", "10 Hz", "world", queue=10, meaning="ground truth"
    ),
    Topic(names.SIM_STATUS, "yarm/SimStatus", SIM, "experiments", "1 Hz", queue=10, meaning="real-time factor, load"),
    Topic(
        names.STEP_ACK,
        "yarm/StepAck",
        f"{COMMANDER}, {CONTROLS}, {SANDER}, {SAFETY}, run_experiment",
        f"{SIM}, {COMMANDER}",
        "each tick, in lock-step only",
        queue=100,
        meaning="a participant is done with a tick",
    ),
    Topic(
        names.SEED_TRANSFORMS,
        "yarm/TransformStampedVector",
        SEEDS,
        f"{ASSOC}, {CONTROLS}, {SAFETY}",
        "60 Hz",
        "world",
        queue=10,
        meaning="where each registered object is",
    ),
    Topic(
        names.STATIC_ASSOCIATION_SWITCH,
        "std_msgs/Int8",
        COMMANDER,
        ASSOC,
        "on change",
        latched=True,
        meaning="0 calibrating, 1 running",
    ),
    Topic(
        names.MERGED_POINTS,
        "sensor_msgs/PointCloud2",
        MERGE,
        ASSOC,
        "30 Hz",
        "world",
        queue=10,
        meaning="every point of a set inside the box: x y z, sigma (m), viewing direction ux uy uz, camera; a point "
        "without coordinates (NaN) says that its camera had no view; handed over by pointer between nodelets",
    ),
    Topic(
        names.VOXELIZED_CLOUD,
        "sensor_msgs/PointCloud2",
        MERGE,
        "RViz",
        "30 Hz",
        "world",
        meaning="centroid of each occupied voxel; stamp = oldest capture time of the set",
    ),
    Topic(names.CLOUD_CLUSTERS, "yarm/CloudVector", ASSOC, "RViz", "30 Hz", "world", meaning="Euclidean clusters"),
    Topic(
        names.ASSOCIATED_CLUSTERS,
        "yarm/AssociatedClusterVector",
        ASSOC,
        MAP,
        "30 Hz",
        "world",
        meaning="each object and its points",
    ),
    Topic(
        names.TRACKED_OBJECTS,
        "yarm/TrackedObjects",
        ASSOC,
        f"{COMMANDER}, {SAFETY}",
        "30 Hz",
        "world",
        queue=10,
        meaning="what nobody registered, over time: one identity, place, velocity and their covariance each",
    ),
    Topic(
        names.TRACKS,
        "visualization_msgs/MarkerArray",
        ASSOC,
        "RViz",
        "30 Hz",
        "world",
        queue=2,
        meaning="the same: boxes, arrows to where each will be in a second, identities; pale what is hidden",
    ),
    Topic(
        names.PLANNING_METADATA,
        "yarm/MapMetaData",
        MAP,
        f"{COMMANDER}, {SAFETY}, {SIM} in lock-step",
        "30 Hz",
        "world",
        meaning="the live occupancy grid and who occupies which cell",
    ),
    Topic(
        names.COLLISIONS, "visualization_msgs/Marker", MAP, "RViz", "30 Hz", "world", meaning="cells of value 2, red"
    ),
    Topic(
        names.OCCUPANCY,
        "visualization_msgs/MarkerArray",
        MAP,
        "RViz",
        "5 Hz",
        "world",
        meaning="occupied cells, one colour an object",
    ),
    Topic(
        names.SEEN_CELLS,
        "yarm/SeenCells",
        MERGE,
        MAP,
        "30 Hz with `visibility`",
        "world",
        queue=32,
        meaning="what the cameras see of each cell, and from which of them something nearer hides it",
    ),
    Topic(
        names.HIDDEN_CELLS,
        "visualization_msgs/Marker",
        MERGE,
        "RViz",
        "5 Hz with `visibility`",
        "world",
        queue=2,
        meaning="cells that no camera sees now, translucent: hidden, or never seen",
    ),
    Topic(
        names.COVERAGE,
        "visualization_msgs/Marker",
        MERGE,
        "RViz",
        "on change with `visibility`",
        "world",
        True,
        meaning="cells that no camera would see if nothing were in the cell",
    ),
    Topic(
        names.DIAGNOSTICS,
        "diagnostic_msgs/DiagnosticArray",
        "perception, safety",
        "people",
        "1 Hz",
        queue=10,
        meaning="which input is sick, and since when",
    ),
    Topic(
        names.COMMANDER_STATUS,
        "yarm/CommanderStatus",
        COMMANDER,
        f"people, {SIM}, experiments",
        "on change, and 1 Hz",
        latched=True,
        queue=10,
        meaning="state, tasks, outcome and reason",
    ),
    Topic(
        names.PLAN_REPORT,
        "yarm/PlanReport",
        COMMANDER,
        "experiments",
        "each planning step",
        "world",
        queue=100,
        meaning="what each planning step decided, and how long it took",
    ),
    Topic(
        names.DECISIONS,
        "yarm/Decision",
        COMMANDER,
        "experiments",
        "each decision of a mission",
        "world",
        queue=1000,
        meaning="the ledger of the mission: what was seen and decided, in order, with every number that was decided",
    ),
    Topic(
        names.PARTICLES_AND_WAYPOINTS,
        "visualization_msgs/MarkerArray",
        COMMANDER,
        "RViz",
        "each planning step",
        "world",
        meaning="particles, waypoints, paths driven",
    ),
    Topic(
        names.MAPS_AND_MASKS,
        "visualization_msgs/MarkerArray",
        COMMANDER,
        "RViz",
        "each planning step",
        "world",
        meaning="masks, private area, state as text",
    ),
    Topic(
        names.PERMISSION,
        "yarm/Permission",
        COMMANDER,
        f"{CONTROLS}, {SANDER}",
        "each map",
        "world",
        queue=10,
        meaning="dead-man's switch: robots and manipulators may move",
    ),
    Topic(
        names.SAFETY_STATUS,
        "yarm/SafetyStatus",
        SAFETY,
        f"{COMMANDER}, {CONTROLS}, {SANDER}, people",
        "30 Hz",
        "world",
        queue=10,
        meaning="clearance ahead of each robot, who is held, and how far people are and must be",
    ),
    Topic(
        names.SAFETY_PEOPLE,
        "visualization_msgs/MarkerArray",
        SAFETY,
        "RViz, console",
        "30 Hz",
        "world",
        queue=2,
        meaning="where each of whom nobody registered may be by the time a robot that drives at 1 m/s stands",
    ),
    Topic(names.sander_state("{arm}"), "std_msgs/Int8", SANDER, CONTROLS, "on change", latched=True, meaning="0 to 5"),
    Topic(
        names.sander_status("{arm}"),
        "yarm/SanderStatus",
        SANDER,
        f"{CONTROLS}, {SIM}",
        "on change, and 10 Hz",
        queue=20,
        meaning="what the sander does, and why it waits",
    ),
    Topic(names.sander_joy("{arm}"), "sensor_msgs/Joy", "people, " + CONTROLS, SANDER, "on press", queue=10),
    Topic(
        names.motion_start_stop("{arm}"),
        "std_msgs/Int8",
        CONTROLS,
        SANDER,
        "on change",
        queue=10,
        meaning="1 sand, 0 pause and lift",
    ),
    Topic(
        names.sander_keep_off("{arm}"),
        "yarm/KeepOff",
        CONTROLS,
        SANDER,
        "on change",
        "world",
        queue=10,
        meaning="what the tip keeps off while it sands",
    ),
    Topic(
        names.sander_raster("{arm}"),
        "visualization_msgs/Marker",
        SANDER,
        "RViz",
        "on change",
        "world",
        True,
        meaning="the passes over the part",
    ),
    Topic(
        names.sander_progress("{arm}"),
        "std_msgs/Float32",
        SANDER,
        f"{SIM}, experiments",
        "10 Hz while sanding",
        meaning="share of the raster done",
    ),
)

SERVICES: Tuple[Service, ...] = (
    Service(names.COMMANDER_STATE, "yarm/StateChange", COMMANDER, "ask for a change of state (docs/commander.md)"),
    Service(
        names.COMMANDER_WHY, "yarm/Why", COMMANDER, "why a goal is not served, or a robot stands (docs/commander.md)"
    ),
    Service(
        names.COMMANDER_WHAT_IF,
        "yarm/WhatIf",
        COMMANDER,
        "what would come of the cell as it is now, under alternatives (docs/experiments.md)",
    ),
    Service(
        names.SAFETY_STOP,
        "std_srvs/SetBool",
        SAFETY,
        "true: every robot and manipulator stands, until false is asked for (docs/safety.md)",
    ),
    Service(names.SPAWN_OBSTACLES, "yarm/SpawnObstacles", SIM, "add debris, a target or an obstacle"),
    Service(names.DELETE_OBSTACLES, "yarm/SpawnObstacles", SIM, "remove one; only the name counts"),
    Service(names.PREDICT_NEW_STATE, "yarm/PredictNewState", MAP, "would these objects touch if they were there?"),
)

ACTIONS: Tuple[Service, ...] = (
    Service(names.move_robot("{robot}"), "yarm/MoveRobot", CONTROLS, "move a mobile robot, or calibrate it"),
    Service(names.move_robot("{arm}"), "yarm/MoveRobot", CONTROLS, "CALIBRATION, ON, OFF, CLEANUP of an arm"),
)

HAND_TOPICS: Tuple[Topic, ...] = (
    Topic(
        names.lift_command("{robot}"),
        "std_msgs/Float64",
        f"{CONTROLS}, people",
        SIM,
        "on change",
        queue=10,
        meaning="how far the hand goes down from drawn up, m; joint lift_joint of joint_states is how far it is",
    ),
    Topic(
        names.gripper("{robot}", "grasping"),
        "std_msgs/Bool",
        SIM,
        f"cluster_assoc, {CONTROLS}, {COMMANDER} with removal: bin",
        "on change",
        latched=True,
        queue=10,
        meaning="something hangs on the cup",
    ),
    Topic(
        names.gripper("{robot}", "state"),
        "yarm/GripperState",
        SIM,
        f"cluster_assoc, {CONTROLS}, {COMMANDER} with removal: bin; all in lock-step only",
        "each tick, to whoever listens",
        queue=10,
        meaning="the same with its time: what counts for a camera set or a tick does not depend on what arrives first",
    ),
)
"""Of mobile robots with a hand, besides the cell's."""

HAND_SERVICES: Tuple[Service, ...] = (
    Service(names.gripper("{robot}", "on"), "std_srvs/Empty", SIM, "suction on: the cup takes what it presses on"),
    Service(names.gripper("{robot}", "off"), "std_srvs/Empty", SIM, "suction off: the cup lets go"),
)


def markdown(topics: Sequence[Topic], services: Sequence[Service], actions: Sequence[Service] = ()) -> List[str]:
    """The tables of docs/ros_api.md for one system, line by line."""
    lines = ["### Topics", "", "| topic | type | from | to | rate | frame | latched | queue | meaning |"]
    lines.append("|---|---|---|---|---|---|---|---|---|")
    for topic in topics:
        cells = [f"`{topic.name}`", topic.type, topic.sender, topic.receivers, topic.rate, topic.frame]
        cells += ["yes" if topic.latched else "", str(topic.queue), topic.meaning]
        lines.append("| " + " | ".join(cells) + " |")
    for title, rows in (("Services", services), ("Actions", actions)):
        if rows:
            lines += ["", f"### {title}", "", "| name | type | server | meaning |", "|---|---|---|---|"]
            lines += [f"| `{row.name}` | {row.type} | {row.server} | {row.meaning} |" for row in rows]
    return lines
