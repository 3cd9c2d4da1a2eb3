"""Names of topics, services, actions, frames and nodes: the one Python source (C++: yarm/ros/names.hpp).

All names are relative, so that they can be remapped and pushed into a namespace; only ``/clock``, ``/tf`` and
``/tf_static`` are global (docs/ros_api.md).
"""

from __future__ import annotations

from yarm.robots import ankurbot, hc10
from yarm.robots import youbot as youbot_robot

WORLD_FRAME = "world"

# The simulated cell.
OBJECT_REGISTRY = "object_registry"
SPAWN_OBSTACLES = "spawn_obstacles"
DELETE_OBSTACLES = "delete_obstacles"
SIM_CONTACTS = "sim/contacts"
SIM_CLEARANCE = "sim/clearance"
SIM_STATUS = "sim/status"
STEP_ACK = "sim/step_ack"

# Perception.
VOXELIZED_CLOUD = "voxelized_cloud"
MERGED_POINTS = "merged_points"
CLOUD_CLUSTERS = "cloud_clusters"
SEED_TRANSFORMS = "seed_transforms"
STATIC_ASSOCIATION_SWITCH = "static_association_switch"
ASSOCIATED_CLUSTERS = "associated_clusters"
PLANNING_METADATA = "planning_metadata"
COLLISIONS = "collisions"
OCCUPANCY = "occupancy"
HIDDEN_CELLS = "hidden_cells"
SEEN_CELLS = "seen_cells"
TRACKED_OBJECTS = "tracked_objects"
TRACKS = "tracks"
COVERAGE = "coverage"
PREDICT_NEW_STATE = "predict_new_state"
DIAGNOSTICS = "/diagnostics"

# The map of a room.
SCAN = "scan"
MAP = "map"
MAP_METADATA = "map_metadata"
DYNAMIC_MAP = "dynamic_map"
STATIC_MAP = "static_map"
SET_MAP = "set_map"
AMCL_POSE = "amcl_pose"
INITIAL_POSE = "initialpose"
PARTICLE_CLOUD = "particlecloud"
GLOBAL_LOCALIZATION = "global_localization"
REQUEST_NOMOTION_UPDATE = "request_nomotion_update"
SLAM_ENTROPY = "slam_gmapping/entropy"
SLAM_STATE = "slam_gmapping/state"

# A TurtleBot in a room.
ODOM = "odom"
BUMPER = "mobile_base/events/bumper"
DEPTH_IMAGE = "camera/depth/image_raw"
BASE_VELOCITY = "mobile_base/commands/velocity"
MAP_FRAME, ODOM_FRAME, BASE_FOOTPRINT = "map", "odom", "base_footprint"
BUMPER_CLOUD = "mobile_base/sensors/bumper_pointcloud"
DEPTH_INFO = "camera/depth/camera_info"
BASE_JOINTS = "joint_states"
SCAN_FRAME, DEPTH_FRAME, BASE_LINK = "camera_depth_frame", "camera_depth_optical_frame", "base_link"
SIM_POSE = "sim/pose"
SIM_ARENA = "sim/arena"
MUX_ACTIVE = "cmd_vel_mux/active"


def mux_input(source: str) -> str:
    """Velocity commands of one source ("safety_controller", "teleop", "navi"); the multiplexer chooses."""
    return f"cmd_vel_mux/input/{source}"


# One robot that explores a room.
TELEOP = mux_input("teleop")
EXPLORER_NODE = "explorer"
GATE_NODE = "velocity_gate"
GATE_INPUT = f"{GATE_NODE}/input"
EXPLORE_RESUME = "explore/resume"


def explorer(name: str) -> str:
    """A private topic or service of the explorer: status, events, frontiers, plan, bumps, map, start, stop ..."""
    return f"{EXPLORER_NODE}/{name}"


# Boxes with tags, and the way to them.
RGB_IMAGE = "camera/rgb/image_raw"
RGB_INFO = "camera/rgb/camera_info"
RGB_FRAME = "camera_rgb_optical_frame"
MOVE_BASE = "move_base"
SIMPLE_GOAL = f"{MOVE_BASE}_simple/goal"
NAVI = mux_input("navi")
AMCL_STATE = "amcl/state"
OBJECTS = "objects"
RECOGNISER_NODE = "tag_recogniser"
INSPECTOR_NODE = "inspector"


def move_base(name: str) -> str:
    """A private topic or service of move_base: make_plan, clear_costmaps, local_plan, global_costmap/costmap ..."""
    return f"{MOVE_BASE}/{name}"


def recogniser(name: str) -> str:
    """A private topic or service of the recogniser: verdict, image, add_tag, remove_tag, load_tags."""
    return f"{RECOGNISER_NODE}/{name}"


def inspector(name: str) -> str:
    """A private topic or service of the inspector: status, verdict, markers, start, stop, return_home ..."""
    return f"{INSPECTOR_NODE}/{name}"


# Commander and safety.
COMMANDER_STATE = "commander_state"
COMMANDER_WHY = "commander/why"
COMMANDER_WHAT_IF = "commander/what_if"
COMMANDER_STATUS = "commander/status"
PERMISSION = "commander/permission"
PLAN_REPORT = "commander/plan"
DECISIONS = "commander/decisions"
PARTICLES_AND_WAYPOINTS = "particles_and_waypoints"
MAPS_AND_MASKS = "maps_and_masks"
SAFETY_STATUS = "safety/status"
SAFETY_PEOPLE = "safety/people"
SAFETY_STOP = "safety/stop"
SAFETY_STOPPED_BY = "safety/stopped_by"
"""Parameter that keeps a stop over the death of the node that serves it: who stopped everything, empty for nobody."""

# The youBot's arm, in bags and of its driver.
TARGET_POSITION = "target_position"
ARM_COMMAND = "EffortJointInterface_trajectory_controller/command"
ARM_JOINT_STATES = "joint_states"
YOUBOT_NODE = "youbot_simulation"
YOUBOT_VELOCITY = "cmd_vel"


def youbot(name: str) -> str:
    """A topic of the youBot on its floor: status, hand_path."""
    return f"{youbot_robot.NAME}/{name}"


# Nodes whose heartbeats others wait for.
COMMANDER_NODE = "commander"
SAFETY_NODE = "safety_monitor"

# The operator's page, and who keeps what becomes of missions; nobody waits for them.
CONSOLE_NODE = "console"
KEEPER_NODE = "mission_keeper"

CASTERS = ankurbot.CASTERS


def camera_points(camera: int) -> str:
    """Depth cloud of overhead camera 1, 2, ..."""
    return f"mapping_camera_{camera}_mapping_kinect/depth/points"


def camera_optical_frame(camera: int) -> str:
    """Optical frame (x right, y down, z forward) of overhead camera 1, 2, ..."""
    return f"mapping_camera_{camera}_depth_optical_frame"


def joint_states(robot: str) -> str:
    """Measured joints of a robot."""
    return f"{robot}/joint_states"


def cmd_vel(robot: str) -> str:
    """Drive command of a mobile robot."""
    return f"{robot}/cmd_vel"


def caster_command(robot: str, caster: str) -> str:
    """Commanded angle of a mobile robot's caster ("fl", "fr", "rl", "rr")."""
    return f"{robot}/{caster}_position_controller/command"


def caster_state(robot: str, caster: str) -> str:
    """State of a mobile robot's caster controller ("fl", "fr", "rl", "rr")."""
    return f"{robot}/{caster}_position_controller/state"


def gripper(robot: str, name: str) -> str:
    """Of a mobile robot's hand: services on and off, topics grasping and state."""
    return f"{robot}/gripper/{name}"


def lift_command(robot: str) -> str:
    """Commanded way of a mobile robot's hand down from drawn up, metres."""
    return f"{robot}/lift_command"


def move_robot(robot: str) -> str:
    """Action of one robot."""
    return f"{robot}/move_robot"


def joint_path_command(arm: str) -> str:
    """Joint trajectory streamed to an arm."""
    return f"{arm}/joint_path_command"


def sander_node(arm: str) -> str:
    """Node of an arm's sander: ``hc10_state_machine`` of ``hc10_barc``, ``hc10_state_machine_2`` of ``hc10_barc_2``."""
    return arm.replace(hc10.NAME, "hc10_state_machine", 1)


def station(arm: str) -> str:
    """Parameter that says where an arm's station is (``yarm.ros.common.stations``)."""
    return f"{arm}/station"


def wrist_points(arm: str) -> str:
    """Cloud of an arm's wrist camera."""
    return f"{arm}/wrist_camera/depth/points"


def wrist_optical_frame(arm: str) -> str:
    """Optical frame of an arm's wrist camera."""
    return f"{arm}/wrist_camera_optical_frame"


def sander_state(arm: str) -> str:
    """State of an arm's sander, Int8."""
    return f"{arm}/state"


def sander_joy(arm: str) -> str:
    """Joystick of an arm's sander."""
    return f"{arm}/joy"


def sander_keep_off(arm: str) -> str:
    """What an arm's tip keeps off."""
    return f"{arm}/keep_off"


def motion_start_stop(arm: str) -> str:
    """Int8 1 or 0: an arm's sander may move, or must pause."""
    return f"{arm}/motion_start_stop"


def sander_raster(arm: str) -> str:
    """Marker of the raster an arm's sander follows."""
    return f"{arm}/raster"


def sander_progress(arm: str) -> str:
    """Float32, share of the raster done, 0 to 1."""
    return f"{arm}/raster_progress"


def sander_status(arm: str) -> str:
    """SanderStatus of an arm's sander: state, whether it is paused, why it waits."""
    return f"{arm}/sander_status"


def sander_command_ack(arm: str) -> str:
    """Lock-step only: StepAck of the controls server with the commands it has sent to an arm's sander so far."""
    return f"{arm}/command_ack"


def base_frame(robot: str) -> str:
    """Frame of a robot's base."""
    return f"{robot}/base_link"


def ee_frame(robot: str) -> str:
    """Frame of a mobile robot's end effector."""
    return f"{robot}/ee"


def link_frame(robot: str, link: str) -> str:
    """Frame of a robot's link."""
    return f"{robot}/{link}"
