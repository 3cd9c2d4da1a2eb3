"""Rendered views of boxes, each drawn from its number, and what the recognisers make of them."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from functools import lru_cache
from time import process_time
from typing import Any, Dict, List, Mapping, Optional, Tuple

import numpy as np

from yarm.geometry import FloatArray, Pose2
from yarm.geometry.pinhole import BoxSize, face_corners, level_camera
from yarm.robots.turtlebot import CAMERA_Z_M, RGB_CAMERA, RGB_MOUNT
from yarm.sim.sensors.rgb_camera import Imaging, RgbCamera, RgbFrame, Room, TaggedBox, visible_share
from yarm.tags.calibration import BLANK, UNKNOWN, Measures
from yarm.tags.face_view import FaceView
from yarm.tags.motifs import GreyImage
from yarm.tags.pictures import BLANKS, STRANGERS, blank, shipped_pictures, stranger
from yarm.tags.printed import PrintedRecogniser
from yarm.tags.recogniser import Look, Recogniser
from yarm.tags.report import ReportRecogniser

POSE_SIGMA_M, POSE_SIGMA_RAD = 0.012, 0.013
"""Of the robot's pose, each way: 95 % within 0.03 m and 1.5 degrees."""
FRAMES = 21
"""Images that the report takes of a box: of a robot that stands they are copies of one."""
OTHER_WORLD = Room((-3.0, -3.0), (3.0, 3.0))


@dataclass(frozen=True)
class TagView:
    """One view.

    Attributes:
        number: seeds everything else.
        truth: number of the tag, BLANK or UNKNOWN.
        picture: kind of blank or number of the stranger, where it is one; else empty.
        distance_m: from the robot to the box's middle.
        angle_deg: from the face's normal.
        depth_m: of the box.
        imaging: light and camera.
        hidden: share of the face behind a post that nobody knows of.
        neighbours: known boxes with tags beside it.
    """

    number: int
    truth: int
    picture: str
    distance_m: float
    angle_deg: float
    depth_m: float
    imaging: Imaging
    hidden: float
    neighbours: int


@dataclass(frozen=True)
class ViewResult:
    """What came of a view; the view's own values are those of ``drawn(number)``.

    Attributes:
        number: of the view.
        truth: number of the tag, BLANK or UNKNOWN.
        visible: share of the face that the image shows.
        answer: ours; None when there is none.
        probability: of the answer.
        status: whether the image could be used, and how the box stands.
        tags: likeness and inliers of each tag.
        texture: of the face.
        seconds: processor time of the look.
        report: the verdict of ``report``, had all its images been this one; None when it was not asked.
        printed: the same of ``report_printed``; -9 for a box without a line.
    """

    number: int
    truth: int
    visible: float
    answer: Optional[int]
    probability: float
    status: str
    tags: Tuple[Tuple[int, float, int], ...]
    texture: float
    seconds: float
    report: Optional[int] = None
    printed: Optional[int] = None

    @property
    def measures(self) -> Optional[Measures]:
        """What the probabilities were made of; None when the image could not be judged."""
        if self.answer is None:
            return None
        return Measures({tag: (likeness, inliers) for tag, likeness, inliers in self.tags}, self.texture)

    def to_json(self) -> Dict[str, Any]:
        """Plain values."""
        return asdict(self)

    @staticmethod
    def from_json(values: Mapping[str, Any]) -> ViewResult:
        """The same again."""
        return ViewResult(**{**values, "tags": tuple((int(t), float(x), int(n)) for t, x, n in values["tags"])})


def drawn(number: int) -> TagView:
    """The view of a number: over distance, angle, blur, light, what hides it, neighbours, and what is on the box."""
    rng = np.random.default_rng([7, number])
    kind = rng.random()
    truth, picture = int(rng.integers(1, 16)), ""
    if kind > 0.85:
        truth, picture = UNKNOWN, str(int(rng.integers(STRANGERS)))
    elif kind > 0.7:
        truth, picture = BLANK, str(rng.choice([*BLANKS, "none"]))
    imaging = Imaging(
        light=(float(rng.normal()), float(rng.normal()), 1.0),
        ambient=float(rng.uniform(0.4, 0.9)),
        gain=float(np.exp(rng.uniform(math.log(0.3), math.log(1.6)))),
        blur_px=float(rng.uniform(0.0, 4.0)),
        vignetting=float(rng.uniform(0.0, 0.3)),
        noise=float(rng.uniform(1.0, 5.0)),
    )
    hidden = float(rng.uniform(0.0, 0.5)) if rng.random() < 0.5 else 0.0
    distance, angle = float(rng.uniform(0.3, 1.2)), float(rng.uniform(-65.0, 65.0))
    depth = float(rng.choice([0.16, 0.32]))
    return TagView(number, truth, picture, distance, angle, depth, imaging, hidden, int(rng.integers(0, 3)))


@lru_cache(maxsize=1)
def _tags() -> Mapping[int, GreyImage]:
    return shipped_pictures()


@lru_cache(maxsize=32)
def picture_of(truth: int, picture: str) -> Optional[GreyImage]:
    """What a face shows: a tag, a stranger, a kind of blank, or nothing but the box's own grey."""
    if truth == UNKNOWN:
        return stranger(int(picture))
    if truth == BLANK:
        return None if picture == "none" else blank(picture)
    return _tags()[truth]


@lru_cache(maxsize=1)
def _camera() -> RgbCamera:
    return RgbCamera()


@lru_cache(maxsize=1)
def recogniser() -> Recogniser:
    """Ours, with the tags of the task."""
    return Recogniser(_tags())


@lru_cache(maxsize=2)
def report_recogniser(crop: bool = True) -> ReportRecogniser:
    """``report`` with the tags of the task."""
    return ReportRecogniser(_tags(), crop=crop)


@lru_cache(maxsize=1)
def _printed_recogniser() -> PrintedRecogniser:
    return PrintedRecogniser(_tags())


def staged(view: TagView) -> Tuple[RgbFrame, FaceView, FloatArray]:
    """The picture of a view, what the recogniser is told, and the face's corners (4, 2) in the image."""
    rng = np.random.default_rng([8, view.number])
    size = BoxSize(depth=view.depth_m)
    box = Pose2(0.0, 0.0, float(rng.uniform(-math.pi, math.pi)))
    angle = math.radians(view.angle_deg)
    way = Pose2(view.distance_m * math.cos(angle), view.distance_m * math.sin(angle), angle + math.pi)
    robot = box.compose(way)
    others = _neighbours(view, box, size, rng)
    boxes = [TaggedBox(box, size, picture_of(view.truth, view.picture)), *others]
    T_world_optical = level_camera(robot, RGB_MOUNT, CAMERA_Z_M)
    if view.hidden > 0.0:
        boxes.append(_post(view.hidden, box, size, T_world_optical, bool(rng.random() < 0.5)))
    room = Room(OTHER_WORLD.lower, OTHER_WORLD.upper, OTHER_WORLD.wall_m, tuple(boxes))
    frame = _camera().render(room, T_world_optical, view.imaging, view.number)
    x, y, yaw = (float(error) for error in rng.normal(0.0, (POSE_SIGMA_M, POSE_SIGMA_M, POSE_SIGMA_RAD)))
    told = level_camera(Pose2(robot.x + x, robot.y + y, robot.yaw_rad + yaw), RGB_MOUNT, CAMERA_Z_M)
    true = FaceView(T_world_optical, box, size)
    pose = true.face_pose
    corners = RGB_CAMERA.project(face_corners(size.width, size.height) @ pose[:3, :3].T + pose[:3, 3])
    return frame, FaceView(told, box, size, others=tuple((o.pose, o.size) for o in others)), corners


def looked(view: TagView, with_report: bool) -> ViewResult:
    """What the recognisers make of a view; the report's two only when they are asked for."""
    frame, told, corners = staged(view)
    began = process_time()
    look = recogniser().look(frame.grey, told)
    seconds = process_time() - began
    visible = visible_share(frame, 0, corners.tolist()) if np.isfinite(corners).all() else 0.0
    report: Optional[int] = None
    printed: Optional[int] = None
    if with_report:
        report = report_recogniser().verdict(report_recogniser().look(frame.grey) * FRAMES).tag
        tag = _printed_recogniser().verdict(_printed_recogniser().look(frame.grey) * FRAMES).tag
        printed = -9 if tag is None else tag + 1
    return _result(view, look, visible, seconds, report, printed)


def _result(
    view: TagView, look: Look, visible: float, seconds: float, report: Optional[int], printed: Optional[int]
) -> ViewResult:
    answer = look.answer
    tags = tuple((fit.tag, round(fit.likeness, 4), fit.inliers) for fit in look.fits)
    return ViewResult(
        view.number,
        view.truth,
        round(visible, 4),
        answer,
        look.probabilities[answer] if answer is not None else 0.0,
        f"{look.status.value}, {look.finding.value}",
        tags,
        round(look.texture, 5),
        round(seconds, 5),
        report,
        printed,
    )


def _neighbours(view: TagView, box: Pose2, size: BoxSize, rng: np.random.Generator) -> List[TaggedBox]:
    """Boxes with other tags on its left, its right, or both."""
    found = []
    for side in (1.0, -1.0)[: view.neighbours]:
        across = side * (size.width + float(rng.uniform(0.05, 0.4)))
        tag = (view.truth + int(rng.integers(1, 15)) - 1) % 15 + 1 if view.truth > 0 else int(rng.integers(1, 16))
        pose = box.compose(Pose2(float(rng.uniform(-0.3, 0.02)), across, float(rng.uniform(-0.3, 0.3))))
        found.append(TaggedBox(pose, size, picture_of(tag, "")))
    return found


def _post(hidden: float, box: Pose2, size: BoxSize, T_world_optical: FloatArray, left: bool) -> TaggedBox:
    """A thin screen half-way to the camera that hides a share of the face from one side."""
    eye = Pose2(float(T_world_optical[0, 3]), float(T_world_optical[1, 3]))
    wide = 0.15
    edge = 0.5 * size.width * (1.0 if left else -1.0)
    middle = edge - (1.0 if left else -1.0) * (0.5 * hidden * size.width - 0.5 * wide)
    on_face = box.compose(Pose2(0.5 * size.depth, middle))
    half_way = Pose2(0.5 * (eye.x + on_face.x), 0.5 * (eye.y + on_face.y), box.yaw_rad)
    return TaggedBox(half_way, BoxSize(0.5 * (hidden * size.width + wide), 0.01, 0.6))
