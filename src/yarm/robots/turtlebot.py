"""TurtleBot 2: a Kobuki base with a Kinect. Sources: the platform's public description; docs/exploration.md."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Optional

from yarm.geometry import Pose2
from yarm.geometry.pinhole import Pinhole

TYPE = "turtlebot"
RADIUS_M = 0.176
"""Of the body, a cylinder."""
BODY_BOTTOM_M, BODY_TOP_M = 0.015, 0.124
HEIGHT_M = 0.42
"""Of the plates above the body."""
MASS_KG = 6.3
WHEEL_RADIUS_M = 0.035
WHEEL_BASE_M = 0.230
"""Between the two driven wheels."""
WHEEL_JOINTS = ("wheel_left_joint", "wheel_right_joint")
WHEEL_TICK_RAD = 0.00243691687
"""Turn of a wheel that its encoder tells from none."""
WHEEL_TORQUE_NM = 1.5
"""Greatest torque of a wheel's motor: more than the floor holds, so that the wheels of a robot that is stuck spin."""
BASE_LINK_Z_M = 0.0102
"""Of base_link above base_footprint."""
SPEED_LIMIT_MPS = 0.7
TURN_LIMIT_RADPS = math.pi
ACCELERATION_MPS2 = 1.0
"""Of each wheel's rim."""
COMMAND_TIMEOUT_S = 0.6
"""The base stops by itself this long after the last command."""

DEPTH_CAMERA = Pose2(-0.087, 0.0135)
"""camera_depth_frame on base_footprint, in the plane; it looks along +x."""
CAMERA_Z_M = 0.297
"""Of the cameras above the floor."""
CAMERA_WIDTH_PX, CAMERA_HEIGHT_PX = 640, 480
CAMERA_FOCAL_PX = 554.3
RGB_CAMERA = Pinhole(CAMERA_WIDTH_PX, CAMERA_HEIGHT_PX, CAMERA_FOCAL_PX, 0.5 * CAMERA_WIDTH_PX, 0.5 * CAMERA_HEIGHT_PX)
RGB_MOUNT = Pose2(-0.087, 0.0)
"""The RGB camera on base_footprint, in the plane; it looks along +x."""
HIDDEN_ROWS_FROM = 408
"""This row of the images and those below show the robot's own plate."""

DEPTH_MIN_M, DEPTH_MAX_M = 0.45, 10.0
"""Depths that the depth camera measures."""

SCAN_BEAMS = 640
SCAN_ROWS = 10
"""Rows about the middle of the depth image whose nearest is taken."""
SCAN_FOV_RAD = math.radians(60.0)
SCAN_RANGE_MIN_M, SCAN_RANGE_MAX_M = 0.45, 10.0
SCAN_VALID_M = 5.0
"""What is farther is not trusted."""
SCAN_RATE_HZ = 20.0
SCAN_LOST = 0.005
"""Share of the beams that are lost, one here and one there."""
SCAN_BIAS_PER_M = 0.0024
"""The scan, the nearest of noisy rows, reads ranges r short by this times r squared (docs/slam.md)."""
ODOMETRY_RATE_HZ = 50.0

BUMPER_LOW_M, BUMPER_HIGH_M = 0.01, 0.13
"""Heights between which a contact presses the bumper."""


class Bumper(IntEnum):
    """A sector of the bumper, 60 degrees each: LEFT is +90 to +30 degrees from ahead; values of kobuki_msgs."""

    LEFT = 0
    CENTER = 1
    RIGHT = 2


@dataclass(frozen=True)
class BumperEvent:
    """A change of one sector.

    Attributes:
        bumper: which.
        pressed: it was pressed, or let go.
    """

    bumper: Bumper
    pressed: bool


def bumper_at(bearing_rad: float) -> Optional[Bumper]:
    """The sector that a contact at a bearing from ahead (+ = left), rad, presses; None behind."""
    if abs(bearing_rad) <= math.radians(30.0):
        return Bumper.CENTER
    if abs(bearing_rad) <= math.radians(90.0):
        return Bumper.LEFT if bearing_rad > 0.0 else Bumper.RIGHT
    return None
