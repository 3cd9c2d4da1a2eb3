"""What the recognition of tags has told, as a round takes it; and how much a viewpoint promises."""

from __future__ import annotations

import math
from typing import Callable, Optional, Sequence

import numpy as np

from yarm.geometry import Pose2, wrap_angle
from yarm.geometry.pinhole import level_camera
from yarm.geometry.scans import Scan
from yarm.inspection.boxes import Box
from yarm.inspection.model import UNSEEN, Reading
from yarm.inspection.viewpoints import Viewpoint
from yarm.robots.turtlebot import CAMERA_Z_M, RGB_MOUNT
from yarm.tags.chance import LookChance
from yarm.tags.evidence import TagVerdict
from yarm.tags.face_view import FaceView
from yarm.tags.recogniser import Finding
from yarm.tags.report import predicted_angle_deg

FACE_RAYS = 21
"""Points across the middle of a face that the scan is asked about."""
MIDDLE = 0.8
"""Share of the face's width that they are spread over: the pose is not exact."""
LEAST_RAYS = 6
"""Fewer beams tell nothing."""
SAME_M = 0.15
"""A beam that ends so near to the face has met the box."""
MOST_SEEN, LEAST_THROUGH = 0.5, 0.9
"""Shares of the beams from which on a box stands there, or none does."""


def reading_of(verdict: TagVerdict, box: Box) -> Reading:
    """A verdict as a reading of its box; UNSEEN when there is no answer."""
    moved = verdict.finding is Finding.MOVED and verdict.measured is not None
    moved_m = verdict.measured.distance(box.pose) if moved and verdict.measured is not None else 0.0
    said = verdict.finding in (Finding.MISSING, Finding.UPSIDE_DOWN)
    tag = UNSEEN if verdict.answer is None else verdict.answer
    return Reading(tag, verdict.probability, moved_m, verdict.finding.value if said else "")


def stands(scan: Scan, robot: Pose2, box: Box) -> Optional[bool]:
    """Whether a scan from a pose in the map sees a body where a box's face must be; None when it cannot tell.

    Beams that end before the face, or nowhere, say nothing.
    """
    sensor, face = robot.compose(scan.sensor), box.face
    if box.size.height < CAMERA_Z_M or face.inverse().compose(sensor).x <= 0.0:
        return None
    across = MIDDLE * box.size.width * np.linspace(-0.5, 0.5, FACE_RAYS)
    points = sensor.inverse().compose(face).moved(np.stack([np.zeros(FACE_RAYS), across], axis=1))
    expected, bearings = np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0])
    beams = np.round((bearings - scan.angle_min_rad) / scan.angle_increment_rad).astype(int)
    inside = (beams >= 0) & (beams < len(scan.ranges))
    beams, expected = beams[inside], expected[inside]
    beyond = (scan.ranges[beams] - expected)[scan.valid()[beams]]
    met, through = int(np.count_nonzero(abs(beyond) <= SAME_M)), int(np.count_nonzero(beyond > SAME_M))
    if met + through < LEAST_RAYS:
        return None
    if met >= MOST_SEEN * (met + through):
        return True
    return False if through >= LEAST_THROUGH * (met + through) else None


def face_view(robot: Pose2, box: Box, boxes: Sequence[Box], there: Optional[bool] = None) -> FaceView:
    """What is known before a robot at a pose in the map looks at one of some boxes.

    Args:
        robot: its base.
        box: that is looked at.
        boxes: all that are known.
        there: what ``stands`` says of the box.
    """
    others = tuple((other.pose, other.size) for other in boxes if other.number != box.number)
    return FaceView(level_camera(robot, RGB_MOUNT, CAMERA_Z_M), box.pose, box.size, others=others, stands=there)


def predicted_deg(goal: Pose2, box: Box) -> float:
    """The angle that the report expects at a tag's bottom left corner from a goal at a box, degrees."""
    bearing = math.atan2(goal.y - box.pose.y, goal.x - box.pose.x)
    aside = wrap_angle(bearing - box.pose.yaw_rad)
    return predicted_angle_deg(math.degrees(aside), math.degrees(wrap_angle(goal.yaw_rad - bearing - math.pi)))


def chances(boxes: Sequence[Box], model: LookChance) -> Callable[[Box, Viewpoint], float]:
    """How probable it is that a look from a viewpoint decides what is on a box that stands among these."""

    def chance(box: Box, viewpoint: Viewpoint) -> float:
        return model.of_view(face_view(viewpoint.pose, box, boxes))

    return chance
