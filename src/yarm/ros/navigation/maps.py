"""Occupancy grids as messages and back."""

from __future__ import annotations

import numpy as np
import rospy
from nav_msgs.msg import OccupancyGrid

from yarm.navigation.grid_map import GridMap
from yarm.ros.common.checks import pose_fault
from yarm.ros.common.conversions import pose2_of_pose, pose_message


def grid_message(grid: GridMap, frame: str, stamp: rospy.Time) -> OccupancyGrid:
    """The message of a grid whose origin is given in ``frame``."""
    message = OccupancyGrid()
    message.header.frame_id, message.header.stamp = frame, stamp
    message.info.map_load_time = stamp
    message.info.resolution = grid.resolution_m
    message.info.height, message.info.width = grid.cells.shape
    message.info.origin = pose_message(grid.origin.x, grid.origin.y, 0.0, grid.origin.yaw_rad)
    message.data = grid.cells.ravel().tolist()
    return message


def grid_fault(message: OccupancyGrid, frame: str = "") -> str:
    """What is wrong with a grid; empty when it can be used.

    Args:
        message: as it came.
        frame: it must be given in; empty: in any.
    """
    info, given = message.info, message.header.frame_id.lstrip("/")
    if frame and given != frame:
        return f"its frame is {given!r}, expected {frame}"
    if len(message.data) != info.width * info.height or not message.data:
        return f"{len(message.data)} cells for {info.width} x {info.height}, expected as many, and at least one"
    if not 1e-3 <= info.resolution <= 100.0:
        return f"cells of {info.resolution:g} m, expected 0.001 to 100 m"
    if min(message.data) < -1 or max(message.data) > 100:
        return f"values {min(message.data)} to {max(message.data)}, expected -1 to 100"
    return pose_fault(info.origin)


def grid_of(message: OccupancyGrid) -> GridMap:
    """The grid of a message without fault; its origin in the message's frame."""
    info = message.info
    values = np.array(message.data, np.int8).reshape(info.height, info.width)
    return GridMap(values, float(info.resolution), pose2_of_pose(info.origin))
