"""Names of topics, services, actions, frames and nodes: the one Python source (C++: yarm/ros/names.hpp).

All names are relative, so that they can be remapped and pushed into a namespace; only ``/clock``, ``/tf`` and
``/tf_static`` are global (docs/ros_api.md).
"""

from __future__ import annotations

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
PREDICT_NEW_STATE = "predict_new_state"
DIAGNOSTICS = "/diagnostics"

# Commander and safety.
COMMANDER_STATE = "commander_state"
COMMANDER_STATUS = "commander/status"
PLAN_REPORT = "commander/plan"
PARTICLES_AND_WAYPOINTS = "particles_and_waypoints"
MAPS_AND_MASKS = "maps_and_masks"
SAFETY_STATUS = "safety/status"

CASTERS = ("fl", "fr", "rl", "rr")


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


def move_robot(robot: str) -> str:
    """Action of one robot."""
    return f"{robot}/move_robot"


def joint_path_command(arm: str) -> str:
    """Joint trajectory streamed to an arm."""
    return f"{arm}/joint_path_command"


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
