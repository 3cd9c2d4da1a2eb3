"""The camera and the faces it sees, held against the figures of the robot's data."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from yarm.geometry import Pose2
from yarm.geometry.pinhole import BoxSize, face_corners, level_camera, plane_homography, tag_face
from yarm.robots.turtlebot import CAMERA_Z_M, RGB_CAMERA, RGB_MOUNT

SIZE = BoxSize()


def seen_corners(robot: Pose2, box: Pose2) -> np.ndarray:
    T_optical_face = np.linalg.inv(level_camera(robot, RGB_MOUNT, CAMERA_Z_M)) @ tag_face(box, SIZE)
    corners = face_corners(SIZE.width, SIZE.height)
    return RGB_CAMERA.project(corners @ T_optical_face[:3, :3].T + T_optical_face[:3, 3])


def area(corners: np.ndarray) -> float:
    return float(cv2.contourArea(corners.astype(np.float32)))


def test_half_a_metre_before_a_box_the_tag_spans_columns_47_to_593_and_36_percent_are_hidden() -> None:
    corners = seen_corners(Pose2(0.5, 0.0, math.pi), Pose2(0.0, 0.0, 0.0))
    assert np.round(corners[:, 0]).tolist() == [47, 593, 593, 47]
    hidden = (corners[2, 1] - 408.0) / (corners[2, 1] - corners[1, 1])
    assert hidden == pytest.approx(0.36, abs=0.005)


@pytest.mark.parametrize(("angle_deg", "pixels"), [(0.0, 239000.0), (30.0, 214000.0), (60.0, 113000.0)])
def test_the_tags_area_half_a_metre_away(angle_deg: float, pixels: float) -> None:
    angle = math.radians(angle_deg)
    robot = Pose2(0.5 * math.cos(angle), 0.5 * math.sin(angle), angle + math.pi)
    assert area(seen_corners(robot, Pose2(0.0, 0.0, 0.0))) == pytest.approx(pixels, rel=0.02)


@pytest.mark.parametrize("yaw", [0.0, 1.1, -2.7])
def test_left_on_the_picture_is_left_in_the_image_whichever_way_the_box_looks(yaw: float) -> None:
    box = Pose2(1.0, -2.0, yaw)
    corners = seen_corners(box.compose(Pose2(0.7, 0.1, math.pi)), box)
    assert corners[0, 0] < corners[1, 0]
    assert corners[0, 1] < corners[3, 1]
    assert area(corners) == pytest.approx(area(seen_corners(Pose2(0.7, 0.1, math.pi), Pose2(0, 0, 0))), rel=1e-9)


def test_the_homography_agrees_with_projection() -> None:
    T_optical_face = np.linalg.inv(level_camera(Pose2(1.2, 0.4, 3.0), RGB_MOUNT, CAMERA_Z_M)) @ tag_face(
        Pose2(0, 0, 0), SIZE
    )
    points = np.array([[0.1, 0.2], [0.45, 0.33]])
    through = np.column_stack([points, np.ones(2)]) @ plane_homography(RGB_CAMERA, T_optical_face).T
    solid = np.column_stack([points, np.zeros(2)]) @ T_optical_face[:3, :3].T + T_optical_face[:3, 3]
    assert through[:, :2] / through[:, 2:] == pytest.approx(RGB_CAMERA.project(solid), abs=1e-9)
    assert through[:, 2] == pytest.approx(solid[:, 2])


def test_what_is_behind_the_camera_is_nowhere() -> None:
    assert np.isnan(RGB_CAMERA.project([[0.0, 0.0, -1.0], [0.0, 0.0, 0.0]])).all()
    assert RGB_CAMERA.project([0.0, 0.0, 2.0]).tolist() == [320.0, 240.0]
