"""Rendered views of tagged boxes for the tests of recognition."""

from __future__ import annotations

import math
from typing import Dict, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import Pose2
from yarm.geometry.pinhole import BoxSize, level_camera
from yarm.robots.turtlebot import CAMERA_Z_M, RGB_MOUNT
from yarm.sim.sensors.rgb_camera import Imaging, RgbCamera, RgbFrame, Room, TaggedBox
from yarm.tags.pictures import shipped_pictures

BOX = Pose2(0.0, 0.0, 0.4)
TAGS: Dict[int, np.ndarray] = shipped_pictures()


def robot_at(distance: float = 0.5, angle_deg: float = 0.0, turn_deg: float = 0.0, box: Pose2 = BOX) -> Pose2:
    """A robot before a box: distance from its middle, angle from its normal, and turned away from facing it."""
    a = math.radians(angle_deg)
    place = Pose2(distance * math.cos(a), distance * math.sin(a), a + math.pi + math.radians(turn_deg))
    return box.compose(place)


def camera_at(robot: Pose2) -> np.ndarray:
    """T_world_optical of its camera."""
    return level_camera(robot, RGB_MOUNT, CAMERA_Z_M)


def room_of(boxes: Sequence[TaggedBox]) -> Room:
    """A room with boxes."""
    return Room((-3.0, -3.0), (3.0, 3.0), 1.0, tuple(boxes))


def tagged(picture: Optional[np.ndarray], pose: Pose2 = BOX, size: Optional[BoxSize] = None) -> TaggedBox:
    """A box that shows a picture."""
    return TaggedBox(pose, size or BoxSize(), picture)


def view(
    picture: Optional[np.ndarray],
    robot: Optional[Pose2] = None,
    imaging: Optional[Imaging] = None,
    others: Sequence[TaggedBox] = (),
    frame: int = 0,
) -> Tuple[RgbFrame, np.ndarray]:
    """What the robot sees of a box, with other boxes about, and T_world_optical."""
    T_world_optical = camera_at(robot or robot_at())
    room = room_of([tagged(picture), *others])
    return RgbCamera().render(room, T_world_optical, imaging or Imaging(), frame), T_world_optical


def view_across_the_room(number: int) -> Tuple[RgbFrame, Pose2]:
    """A robot looks at a tag 4.5 m away; nothing stands between them, though a box may be said to.

    Returns:
        what it sees, and the robot's pose.
    """
    robot = Pose2(-2.25, 0.0, 0.0)
    far = tagged(TAGS[number], robot.compose(Pose2(4.5, 0.0, math.pi)))
    return RgbCamera().render(room_of([far]), camera_at(robot), Imaging(), 0), robot
