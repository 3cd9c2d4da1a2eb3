"""Looking for a tag anywhere in an image: for a box that was moved, or stands on its head."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Mapping, Optional, Tuple

import cv2
import numpy as np

from yarm.geometry import FloatArray, Pose2
from yarm.tags.alignment import Fit, Reference, flattened, likeness_of, texture_within
from yarm.tags.face_view import UPRIGHT_PX, FaceView
from yarm.tags.features import Detector, Features
from yarm.tags.motifs import GreyImage
from yarm.tags.quads import is_tangled, mapped_corners

RATIO = 0.8
SEARCHED_PX, LEAST_SCALE = 150, 0.24
"""The image is made smaller, at most to this scale, until a face at the box's distance is so wide: at 250 px no more
moved boxes are found, in twice the time."""
RANSAC_PX = 3.0
LEAST_INLIERS = 12
LEAST_LIKENESS = 0.5
FRAME_PX = 22
"""So much along the face's edge may be printed on a blank face, upright pixels."""
STEEPEST_TILT_DEG = 25.0
"""A face that leans farther than this from upright is no box on the floor."""


@dataclass(frozen=True, eq=False)
class Found:
    """A tag somewhere in the image.

    Attributes:
        fit: the tag, and how well it lies there.
        box: where its box stands.
        upside_down: whether it stands on its head.
        texture: of its face there: what is seen where the box should be is not the face.
    """

    fit: Fit
    box: Pose2
    upside_down: bool
    texture: float


def find_anywhere(
    grey: GreyImage, view: FaceView, references: Mapping[int, Reference], detector: Detector
) -> Optional[Found]:
    """The tag with the most matches that agree, outside the other known boxes; None when none is sure."""
    mask = view.other_tags_mask()[: view.robot_row]
    grey = grey[: view.robot_row]
    scale = min(1.0, max(LEAST_SCALE, SEARCHED_PX * _distance(view) / (view.camera.focal_px * view.size.width)))
    size = (round(grey.shape[1] * scale), round(grey.shape[0] * scale))
    small = [cv2.resize(image, size, interpolation=cv2.INTER_AREA) for image in (grey, mask)]
    scene = detector.find(small[0], small[1])
    if len(scene) < LEAST_INLIERS:
        return None
    best: Optional[Tuple[int, int, FloatArray]] = None
    for number, reference in references.items():
        inliers, homography = _homography(reference.features, scene, detector)
        if homography is not None and (best is None or inliers > best[0]):
            best = (inliers, number, homography)
    if best is None:
        return None
    inliers, number, homography = best
    homography = np.diag([grey.shape[1] / size[0], grey.shape[0] / size[1], 1.0]) @ homography
    back = cv2.warpPerspective(grey, homography, UPRIGHT_PX, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
    seen = cv2.warpPerspective(mask, homography, UPRIGHT_PX, flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP)
    flat = flattened(back, seen)
    likeness = likeness_of(flat, seen, references[number], np.eye(3))
    box, upside_down, tilt_deg = pose_from_homography(homography, view)
    if likeness < LEAST_LIKENESS or tilt_deg > STEEPEST_TILT_DEG:
        return None
    return Found(Fit(number, likeness, inliers), box, upside_down, texture_within(back, seen, flat, FRAME_PX))


def pose_from_homography(homography: FloatArray, view: FaceView) -> Tuple[Pose2, bool, float]:
    """Where a box stands whose tag an image shows, whether on its head, and how far it leans, degrees.

    Args:
        homography: (3, 3) from the tag's upright picture to the image.
        view: camera and measures of the box.
    """
    from_edge = np.array([[1.0, 0.0, -0.5], [0.0, 1.0, -0.5], [0.0, 0.0, 1.0]])
    corners = mapped_corners(homography @ from_edge, *UPRIGHT_PX)
    width, height = view.size.width, view.size.height
    solid = np.array([[0, 0, 0], [width, 0, 0], [width, height, 0], [0, height, 0]], dtype=float)
    _, turn, place = cv2.solvePnP(solid, corners, view.camera.matrix, None)
    rotation = view.T_world_optical[:3, :3] @ cv2.Rodrigues(turn)[0]
    middle = rotation @ np.array([0.5 * width, 0.5 * height, 0.0]) + (
        view.T_world_optical[:3, :3] @ place[:, 0] + view.T_world_optical[:3, 3]
    )
    normal = -rotation[:, 2]
    yaw = math.atan2(normal[1], normal[0])
    half = 0.5 * view.size.depth
    box = Pose2(middle[0] - half * math.cos(yaw), middle[1] - half * math.sin(yaw), yaw)
    tilt = math.degrees(math.acos(min(1.0, abs(float(rotation[2, 1])))))
    return box, bool(rotation[2, 1] > 0.0), tilt


def _distance(view: FaceView) -> float:
    """From the camera to where the box must be, metres."""
    return math.hypot(view.box.x - view.T_world_optical[0, 3], view.box.y - view.T_world_optical[1, 3])


def _homography(tag: Features, scene: Features, detector: Detector) -> Tuple[int, Optional[FloatArray]]:
    """Inliers and homography of a tag; none when too few agree, or they agree on no outline of a face.

    Matches that fall on the same few keypoints of the scene are chance: nothing is fitted to them.
    """
    matches = detector.good_matches(tag, scene, RATIO)
    if len(np.unique(matches[:, 1])) < LEAST_INLIERS:
        return 0, None
    homography, kept = cv2.findHomography(tag.points[matches[:, 0]], scene.points[matches[:, 1]], cv2.RANSAC, RANSAC_PX)
    inliers = 0 if homography is None else int(kept.sum())
    if inliers < LEAST_INLIERS or is_tangled(mapped_corners(homography, *UPRIGHT_PX)):
        return 0, None
    return inliers, homography
