"""What a robot's RGB camera sees of a flat room with boxes: every plane drawn by its homography, the nearest last.

A test holds the picture against PyBullet's renderer.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Dict, List, Optional, Sequence, Tuple

import cv2
import numpy as np
import numpy.typing as npt

from yarm.geometry import FloatArray, Pose2
from yarm.geometry.pinhole import NEAR_M, BoxSize, Pinhole, face_corners, plane_homography, tag_face
from yarm.robots.turtlebot import HIDDEN_ROWS_FROM, RGB_CAMERA
from yarm.sim.sensors.draw_order import far_to_near
from yarm.sim.sensors.noise import NormalPool

GreyImage = npt.NDArray[np.uint8]
SUBPIXEL = 4
"""Bits of a pixel's fraction in drawn polygons."""
SKY, FLOOR, WALL, BODY, TAG, ROBOT = range(6)
"""What a pixel can show."""
TINTS = np.array([(0.97, 0.98, 1.0), (1.0, 0.96, 0.88), (0.98, 1.0, 0.96), (1.0, 0.93, 0.82), (1, 1, 1), (1, 1, 1)])
"""Red, green and blue of each kind for a grey of 1."""
TINTED: GreyImage = np.round(np.arange(256.0)[None, :, None] * TINTS[:, None, :]).astype(np.uint8)
"""Red, green and blue of each kind and grey."""
PACKED: npt.NDArray[np.uint32] = np.pad(TINTED, ((0, 0), (0, 0), (0, 1))).reshape(-1, 4).view(np.uint32)[:, 0]
"""The same in one number each, which is looked up faster."""
SKY_GREY = 175
PLAIN_WALL: GreyImage = np.full((64, 64), 205, np.uint8)
PLAIN_BODY: GreyImage = np.full((16, 16), 235, np.uint8)
CAMERA_NUMBER = 99
"""Tells this camera's noise from other cameras' of the same seed."""


@dataclass(frozen=True, eq=False)
class TaggedBox:
    """An upright box on the floor.

    Attributes:
        pose: its middle; the tag's face is on the side the yaw points to.
        size: its measures.
        picture: what its face shows, (h, w) grey; None for nothing but the body's own grey.
    """

    pose: Pose2
    size: BoxSize = field(default_factory=BoxSize)
    picture: Optional[GreyImage] = None


@dataclass(frozen=True, eq=False)
class Room:
    """A rectangular room.

    Attributes:
        lower: least x and y of the floor, metres.
        upper: greatest x and y, metres.
        wall_m: height of the walls, metres.
        boxes: what stands in it; anywhere, but not in each other, or the picture shows one through the other.
    """

    lower: Tuple[float, float]
    upper: Tuple[float, float]
    wall_m: float = 1.0
    boxes: Tuple[TaggedBox, ...] = ()


@dataclass(frozen=True)
class Imaging:
    """Light and camera.

    Attributes:
        light: direction to the light, world; any length but 0.
        ambient: share of the light that comes from everywhere, 0 to 1.
        gain: brightness, 1 being well exposed.
        blur_px: standard deviation of the blur, pixels.
        vignetting: share of the light that is lost in the image's corners, 0 to 1.
        noise: standard deviation of each pixel's noise, grey values.
        robot_row: first row that shows the robot itself.
    """

    light: Tuple[float, float, float] = (0.3, 0.2, 1.0)
    ambient: float = 0.7
    gain: float = 1.0
    blur_px: float = 0.7
    vignetting: float = 0.15
    noise: float = 2.5
    robot_row: int = HIDDEN_ROWS_FROM


@dataclass(frozen=True, eq=False)
class RgbFrame:
    """One picture.

    Attributes:
        grey: (height, width).
        kinds: (height, width) what each pixel shows.
        owners: (height, width) number of the box it belongs to, 255 for none.
    """

    grey: GreyImage
    kinds: GreyImage
    owners: GreyImage

    def rgb(self) -> GreyImage:
        """(height, width, 3) red, green, blue."""
        numbers = np.left_shift(self.kinds, 8, dtype=np.uint16) | self.grey
        packed = PACKED[numbers].view(np.uint8).reshape(*numbers.shape, 4)
        coloured: GreyImage = cv2.cvtColor(packed, cv2.COLOR_RGBA2RGB)
        return coloured


@dataclass(frozen=True, eq=False)
class _Plane:
    """A rectangle with a picture: T_world_plane as of a face, width and height, metres."""

    pose: FloatArray
    width: float
    height: float
    texture: GreyImage
    kind: int
    owner: int = 255


@dataclass(eq=False)
class RgbCamera:
    """Draws frames; not thread-safe.

    Attributes:
        camera: optics.
        seed: of the noise.
    """

    camera: Pinhole = RGB_CAMERA
    seed: int = 0

    def __post_init__(self) -> None:
        """Make what all frames share."""
        self._pool = NormalPool(self.seed)
        self._floor = _floor_texture(self.seed)
        self._pyramids: Dict[int, List[GreyImage]] = {}
        self._drawn: Optional[Tuple[Room, List[_Plane], List[List[_Plane]]]] = None
        x = (np.arange(self.camera.width) - self.camera.centre_x) / self.camera.width
        y = (np.arange(self.camera.height) - self.camera.centre_y) / self.camera.height
        self._edge = (2.0 * (x[None, :] ** 2 + y[:, None] ** 2)).astype(np.float32)
        self._robot = _robot_picture(self.camera)

    def render(self, room: Room, T_world_optical: FloatArray, imaging: Imaging, frame: int = 0) -> RgbFrame:
        """One picture of a room; ``frame`` numbers the pictures, so that each has noise of its own.

        Args:
            room: what is there.
            T_world_optical: (4, 4) pose of the camera, which stands inside the room.
            imaging: light and camera.
            frame: number of the picture.
        """
        shape = (self.camera.height, self.camera.width)
        picture = RgbFrame(*(np.full(shape, value, np.uint8) for value in (SKY_GREY, SKY, 255)))
        view = np.linalg.inv(T_world_optical)
        eye = T_world_optical[:3, 3]
        light = np.asarray(imaging.light, dtype=float)
        light = light / np.linalg.norm(light)
        for plane in self._planes(room, eye):
            facing = -plane.pose[:3, 2]
            if float((eye - plane.pose[:3, 3]) @ facing) > 0.0:
                shade = imaging.ambient + (1.0 - imaging.ambient) * max(0.0, float(facing @ light))
                self._draw(picture, plane, view @ plane.pose, shade)
        return RgbFrame(self._exposed(picture, imaging, frame), picture.kinds, picture.owners)

    def _planes(self, room: Room, eye: FloatArray) -> List[_Plane]:
        """Floor, walls and the faces of the boxes, in the order in which they are drawn."""
        if self._drawn is None or self._drawn[0] is not room:
            of_boxes = [_box_planes(box, number) for number, box in enumerate(room.boxes)]
            self._drawn = room, _room_planes(room, self._floor), of_boxes
        _, planes, of_boxes = self._drawn
        order = far_to_near([(box.pose, box.size) for box in room.boxes], (float(eye[0]), float(eye[1])))
        return [*planes, *(plane for number in order for plane in of_boxes[number])]

    def _draw(self, picture: RgbFrame, plane: _Plane, T_optical_plane: FloatArray, shade: float) -> None:
        """Draw a plane where it is in view."""
        corners = face_corners(plane.width, plane.height) @ T_optical_plane[:3, :3].T + T_optical_plane[:3, 3]
        outline = self.camera.project(_clipped(corners))
        if len(outline) < 3:
            return
        limit = (self.camera.width, self.camera.height)
        low = np.clip(np.floor(outline.min(0)), 0, limit).astype(int)
        high = np.clip(np.ceil(outline.max(0)) + 1, 0, limit).astype(int)
        if (high <= low).any():
            return
        width, height = (int(v) for v in high - low)
        mask = np.zeros((height, width), np.uint8)
        drawn = np.round(np.clip(outline - low, -8000, 8000) * (1 << SUBPIXEL)).astype(np.int32)
        rows, columns = slice(low[1], high[1]), slice(low[0], high[0])
        painted = (mask, 255), (picture.kinds[rows, columns], plane.kind), (picture.owners[rows, columns], plane.owner)
        for image, value in painted:
            cv2.fillConvexPoly(image, drawn, value, cv2.LINE_8, SUBPIXEL)
        texture = self._texture(plane.texture, outline)
        step_x, step_y = plane.width / texture.shape[1], plane.height / texture.shape[0]
        to_metres = np.array([[step_x, 0.0, 0.5 * step_x], [0.0, step_y, 0.5 * step_y], [0.0, 0.0, 1.0]])
        to_part = np.array([[1.0, 0.0, -low[0]], [0.0, 1.0, -low[1]], [0.0, 0.0, 1.0]])
        homography = to_part @ plane_homography(self.camera, T_optical_plane) @ to_metres
        seen = cv2.warpPerspective(texture, homography, (width, height), borderMode=cv2.BORDER_REPLICATE)
        cv2.copyTo(cv2.convertScaleAbs(seen, alpha=shade), mask, picture.grey[rows, columns])

    def _texture(self, texture: GreyImage, outline: FloatArray) -> GreyImage:
        """The texture, halved until it has about as many pixels as its outline in the image."""
        pyramid = self._pyramids.get(id(texture))
        if pyramid is None or pyramid[0] is not texture:
            pyramid = [texture]
            while min(pyramid[-1].shape) > 8:
                pyramid.append(cv2.resize(pyramid[-1], None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA))
            self._pyramids[id(texture)] = pyramid
        pixels = max(1.0, abs(cv2.contourArea(np.clip(outline, -8000, 8000).astype(np.float32))))
        level = round(0.5 * np.log2(max(1.0, texture.size / pixels)))
        chosen: GreyImage = pyramid[min(level, len(pyramid) - 1)]
        return chosen

    def _exposed(self, picture: RgbFrame, imaging: Imaging, frame: int) -> GreyImage:
        """Blur, the robot in the foreground, vignetting, gain and noise."""
        grey = picture.grey
        if imaging.blur_px > 0.0:
            grey = cv2.GaussianBlur(grey, (0, 0), imaging.blur_px)
        row = min(imaging.robot_row, self.camera.height)
        grey[row:] = self._robot[row:]
        picture.kinds[row:], picture.owners[row:] = ROBOT, 255
        light = grey * (imaging.gain * (1.0 - imaging.vignetting * self._edge))
        if imaging.noise > 0.0:
            light += imaging.noise * self._pool.take(light.size, CAMERA_NUMBER, frame).reshape(light.shape)
        exposed: GreyImage = cv2.convertScaleAbs(np.maximum(light, 0.0))
        return exposed


def _clipped(corners: FloatArray) -> FloatArray:
    """The part of a polygon (n, 3) in front of the camera (Sutherland and Hodgman's clipping)."""
    kept: List[FloatArray] = []
    near = 2.0 * NEAR_M
    for a, b in zip(corners, np.roll(corners, -1, axis=0)):
        if a[2] >= near:
            kept.append(a)
        if (a[2] >= near) != (b[2] >= near):
            kept.append(a + (near - a[2]) / (b[2] - a[2]) * (b - a))
    return np.array(kept).reshape(-1, 3)


def _room_planes(room: Room, floor: GreyImage) -> List[_Plane]:
    (x0, y0), (x1, y1) = room.lower, room.upper
    ground = np.eye(4)
    ground[:3, 1], ground[:3, 2], ground[:3, 3] = (0, -1, 0), (0, 0, -1), (x0, y1, 0.0)
    planes = [_Plane(ground, x1 - x0, y1 - y0, floor, FLOOR)]
    middle_x, middle_y = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
    for x, y, yaw, width in (
        (x0, middle_y, 0.0, y1 - y0),
        (x1, middle_y, np.pi, y1 - y0),
        (middle_x, y0, 0.5 * np.pi, x1 - x0),
        (middle_x, y1, -0.5 * np.pi, x1 - x0),
    ):
        pose = tag_face(Pose2(x, y, yaw), BoxSize(width, 0.0, room.wall_m))
        planes.append(_Plane(pose, width, room.wall_m, PLAIN_WALL, WALL))
    return planes


def _box_planes(box: TaggedBox, number: int) -> List[_Plane]:
    """Top and sides; of a convex body those that are seen do not cover each other."""
    size = box.size
    planes = []
    for quarter in range(4):
        across, along = (size.width, size.depth) if quarter % 2 == 0 else (size.depth, size.width)
        pose = tag_face(box.pose.compose(Pose2(0.0, 0.0, 0.5 * np.pi * quarter)), BoxSize(across, along, size.height))
        texture = box.picture if quarter == 0 and box.picture is not None else PLAIN_BODY
        planes.append(_Plane(pose, across, size.height, texture, TAG if quarter == 0 else BODY, number))
    face = planes[0].pose
    top = np.eye(4)
    top[:3, 0], top[:3, 1], top[:3, 2] = face[:3, 0], -face[:3, 2], (0.0, 0.0, -1.0)
    top[:3, 3] = face[:3, 3] + size.depth * face[:3, 2]
    return [_Plane(top, size.width, size.depth, PLAIN_BODY, BODY, number), *planes]


def _floor_texture(seed: int) -> GreyImage:
    """A speckled grey floor."""
    rng = np.random.default_rng(seed)
    speckles = cv2.GaussianBlur(rng.standard_normal((1024, 1024)).astype(np.float32), (0, 0), 1.5)
    floor: GreyImage = np.clip(125.0 + 6.0 * speckles / speckles.std(), 0, 255).astype(np.uint8)
    return floor


def _robot_picture(camera: Pinhole) -> GreyImage:
    """The robot's own top plate, dark, with the poles' ends."""
    picture = np.full((camera.height, camera.width), 38, np.uint8)
    for column in (70, 570):
        cv2.circle(picture, (column * camera.width // 640, camera.height - 25), 14, 95, -1, cv2.LINE_AA)
    return picture


def visible_share(frame: RgbFrame, number: int, outline: Sequence[Tuple[float, float]]) -> float:
    """Share of a box's face, as its outline (n, 2) in pixels, that a frame shows: not outside, hidden or behind."""
    whole = abs(cv2.contourArea(np.asarray(outline, dtype=np.float32)))
    shown = int(np.count_nonzero((frame.kinds == TAG) & (frame.owners == number)))
    return min(1.0, shown / whole) if whole > 0.0 else 0.0
