"""Where a box's face must be in an image, and that part of the image drawn upright."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Optional, Tuple

import cv2
import numpy as np

from yarm.geometry import FloatArray, Pose2
from yarm.geometry.pinhole import BoxSize, Pinhole, face_corners, footprint, plane_homography, tag_face
from yarm.robots.turtlebot import HIDDEN_ROWS_FROM, RGB_CAMERA
from yarm.tags.motifs import GreyImage

UPRIGHT_PX = (250, 200)
"""Width and height of an upright face."""
MARGIN_PX = 25
"""What is kept around it: the pose is known to about a tenth of the face."""
LEAST_FACING = 0.17
"""Cosine of the steepest view (80 deg) that is looked at."""


@dataclass(frozen=True, eq=False)
class FaceView:
    """What is known before an image is looked at.

    Attributes:
        T_world_optical: (4, 4) pose of the camera.
        box: where the box must be, on the floor of the world.
        size: its measures.
        camera: optics.
        robot_row: first image row that shows the robot itself.
        others: the other boxes that are known, which can hide this one and whose tags are not this one's.
        stands: whether a range sensor sees a body there; None if nothing is known.
    """

    T_world_optical: FloatArray
    box: Pose2
    size: BoxSize = field(default_factory=BoxSize)
    camera: Pinhole = RGB_CAMERA
    robot_row: int = HIDDEN_ROWS_FROM
    others: Tuple[Tuple[Pose2, BoxSize], ...] = ()
    stands: Optional[bool] = None

    @property
    def face_pose(self) -> FloatArray:
        """T_optical_face (4, 4): the face before the camera."""
        pose: FloatArray = np.linalg.inv(self.T_world_optical) @ tag_face(self.box, self.size)
        return pose

    @property
    def facing(self) -> float:
        """Cosine of the angle between the face's normal and the way to the camera; negative from behind."""
        pose = self.face_pose
        middle = pose[:3, 3] + 0.5 * (self.size.width * pose[:3, 0] + self.size.height * pose[:3, 1])
        return float(middle @ pose[:3, 2] / np.linalg.norm(middle))

    @property
    def angle_deg(self) -> float:
        """Angle of the view from the face's normal in the plane of the floor, degrees, left of it positive."""
        pose = self.face_pose
        middle = pose[:3, 3] + 0.5 * self.size.width * pose[:3, 0]
        return math.degrees(math.atan2(float(-middle @ pose[:3, 0]), float(middle @ pose[:3, 2])))

    def upright_to_image(self) -> FloatArray:
        """(3, 3) from pixels of the upright picture with its margin to pixels of the image."""
        step_x, step_y = self.size.width / UPRIGHT_PX[0], self.size.height / UPRIGHT_PX[1]
        to_face = np.array(
            [
                [step_x, 0.0, (0.5 - MARGIN_PX) * step_x],
                [0.0, step_y, (0.5 - MARGIN_PX) * step_y],
                [0.0, 0.0, 1.0],
            ]
        )
        homography: FloatArray = plane_homography(self.camera, self.face_pose) @ to_face
        return homography

    def hidden_mask(self) -> GreyImage:
        """(height, width) of the image: 255 where this face can be seen, 0 at the robot and behind nearer boxes."""
        mask = np.zeros((self.camera.height, self.camera.width), np.uint8)
        mask[: self.robot_row] = 255
        eye = self.T_world_optical[:2, 3]
        own = math.hypot(self.box.x - eye[0], self.box.y - eye[1])
        for pose, size in self.others:
            if math.hypot(pose.x - eye[0], pose.y - eye[1]) < own:
                self._fill(mask, pose, size, 0)
        return mask

    def other_tags_mask(self) -> GreyImage:
        """(height, width) of the image: 255 where no other known box is, seen above the robot."""
        mask = np.zeros((self.camera.height, self.camera.width), np.uint8)
        mask[: self.robot_row] = 255
        for pose, size in self.others:
            self._fill(mask, pose, size, 0)
        return mask

    def _fill(self, mask: GreyImage, pose: Pose2, size: BoxSize, value: int) -> None:
        """Fill a box's outline; one that is partly behind the camera is no obstacle to the view ahead."""
        corners = np.array([(x, y, z) for x, y in footprint(pose, size) for z in (0.0, size.height)])
        view = np.linalg.inv(self.T_world_optical)
        pixels = self.camera.project(corners @ view[:3, :3].T + view[:3, 3])
        if np.isfinite(pixels).all():
            hull = cv2.convexHull(np.clip(pixels, -4000, 4000).astype(np.float32))
            cv2.fillConvexPoly(mask, np.round(hull).astype(np.int32), value)


@dataclass(frozen=True, eq=False)
class Upright:
    """A face as it would be seen from straight ahead.

    Attributes:
        picture: (h, w) grey, the face within its margin.
        mask: (h, w) 255 where the image shows it.
        share: share of the face that is seen, 0 to 1.
        detail: pixels of the image for each pixel of the upright face, along the side seen worst.
        to_image: (3, 3) upright pixels to image pixels.
    """

    picture: GreyImage
    mask: GreyImage
    share: float
    detail: float
    to_image: FloatArray


def upright(image: GreyImage, view: FaceView) -> Optional[Upright]:
    """The face drawn upright; None when it is seen from behind, too steeply, or is not before the camera."""
    corners = face_corners(view.size.width, view.size.height)
    pose = view.face_pose
    pixels = view.camera.project(corners @ pose[:3, :3].T + pose[:3, 3])
    if view.facing < LEAST_FACING or not np.isfinite(pixels).all():
        return None
    to_image = view.upright_to_image()
    size = (UPRIGHT_PX[0] + 2 * MARGIN_PX, UPRIGHT_PX[1] + 2 * MARGIN_PX)
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    picture = cv2.warpPerspective(image, to_image, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
    mask = cv2.warpPerspective(view.hidden_mask(), to_image, size, flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP)
    inner = mask[MARGIN_PX:-MARGIN_PX, MARGIN_PX:-MARGIN_PX]
    sides = np.linalg.norm(pixels - np.roll(pixels, -1, axis=0), axis=1) / (*UPRIGHT_PX, *UPRIGHT_PX)
    return Upright(picture, mask, float(np.count_nonzero(inner)) / inner.size, float(sides.min()), to_image)


def outline_support(image: GreyImage, view: FaceView, reach_px: int = 18) -> float:
    """Share of the face's outline (both sides and the top, where seen) near which the image has an edge along it.

    For each point the steepest step of grey across the outline within the reach is taken; it counts when it is three
    times the noise and lies within 4 px of the median offset along its side.
    """
    shown = upright(image, view)
    if shown is None:
        return 0.0
    smooth = cv2.GaussianBlur(shown.picture, (0, 0), 2.0).astype(np.float32)
    across = np.abs(cv2.Sobel(smooth, cv2.CV_32F, 1, 0)), np.abs(cv2.Sobel(smooth, cv2.CV_32F, 0, 1))
    left, right, top = MARGIN_PX, MARGIN_PX + UPRIGHT_PX[0], MARGIN_PX
    found, counted = 0, 0
    rows = range(MARGIN_PX + 8, MARGIN_PX + UPRIGHT_PX[1] - 8, 4)
    columns = range(MARGIN_PX + 8, MARGIN_PX + UPRIGHT_PX[0] - 8, 4)
    lines = [[(across[0][r], shown.mask[r], at) for r in rows] for at in (left, right)]
    lines.append([(across[1][:, c], shown.mask[:, c], top) for c in columns])
    for line in lines:
        offsets = []
        for steps, seen, at in line:
            window = slice(at - reach_px, at + reach_px + 1)
            if not seen[window].all():
                continue
            counted += 1
            best = int(np.argmax(steps[window]))
            if steps[window][best] > EDGE_STEP:
                offsets.append(best)
        if offsets:
            found += int(np.count_nonzero(np.abs(np.array(offsets) - np.median(offsets)) <= 4))
    return found / counted if counted else 0.0


EDGE_STEP = 12.0
"""Sobel response of the smoothed face, of an edge of about three times the camera's noise."""
