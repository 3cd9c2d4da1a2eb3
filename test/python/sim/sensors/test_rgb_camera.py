"""The RGB camera's pictures: against PyBullet's renderer, and what light, blur, noise and the robot do to them."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Dict, Tuple

import cv2
import numpy as np
import pybullet
import pytest

from yarm.geometry import Pose2
from yarm.geometry.pinhole import BoxSize, face_corners, level_camera, tag_face
from yarm.resources import resource
from yarm.robots.turtlebot import CAMERA_Z_M, RGB_CAMERA, RGB_MOUNT
from yarm.sim.sensors.rgb_camera import (
    BODY,
    FLOOR,
    ROBOT,
    TAG,
    TINTED,
    WALL,
    Imaging,
    RgbCamera,
    RgbFrame,
    Room,
    TaggedBox,
    visible_share,
)

CLEAN = Imaging(ambient=1.0, blur_px=0.0, vignetting=0.0, noise=0.0, robot_row=480)
PICTURE = cv2.imread(str(resource("tags", "tag_06.png")), cv2.IMREAD_GRAYSCALE)
BOX = TaggedBox(Pose2(1.2, 0.1, 2.7), BoxSize(), PICTURE)
ROOM = Room((-3.0, -3.0), (3.0, 3.0), 1.0, (BOX, TaggedBox(Pose2(2.2, 0.4, 3.0), BoxSize(depth=0.32), PICTURE)))


def pose(x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> np.ndarray:
    return level_camera(Pose2(x, y, yaw), RGB_MOUNT, CAMERA_Z_M)


@pytest.fixture(scope="module")
def camera() -> RgbCamera:
    return RgbCamera()


def bullet_box(client: int, box: TaggedBox, texture: int) -> Tuple[int, int]:
    """A box and a textured face just before it, in PyBullet; their numbers."""
    half = [0.5 * box.size.depth, 0.5 * box.size.width, 0.5 * box.size.height]
    turn = pybullet.getQuaternionFromEuler([0, 0, box.pose.yaw_rad])
    shape = pybullet.createVisualShape(pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client)
    place = [box.pose.x, box.pose.y, half[2]]
    body = pybullet.createMultiBody(0, -1, shape, place, turn, physicsClientId=client)
    face = tag_face(box.pose, box.size)
    corners = face_corners(box.size.width, box.size.height) @ face[:3, :3].T + face[:3, 3] - 0.001 * face[:3, 2]
    shape = pybullet.createVisualShape(
        pybullet.GEOM_MESH,
        vertices=corners.tolist(),
        indices=[0, 2, 1, 0, 3, 2],
        uvs=[[0, 1], [1, 1], [1, 0], [0, 0]],
        normals=[(-face[:3, 2]).tolist()] * 4,
        rgbaColor=[1, 1, 1, 1],
        physicsClientId=client,
    )
    tag = pybullet.createMultiBody(0, -1, shape, physicsClientId=client)
    pybullet.changeVisualShape(tag, -1, textureUniqueId=texture, physicsClientId=client)
    return body, tag


def bullet_picture(
    T_world_optical: np.ndarray, room: Room, texture: Path
) -> Tuple[np.ndarray, np.ndarray, Dict[int, Tuple[int, int]]]:
    """Grey picture, body of each pixel, and body and face of each box, of PyBullet's renderer with the same camera."""
    client = pybullet.connect(pybullet.DIRECT)
    try:
        number = pybullet.loadTexture(str(texture), physicsClientId=client)
        bodies = {i: bullet_box(client, box, number) for i, box in enumerate(room.boxes)}
        eye, forward, down = T_world_optical[:3, 3], T_world_optical[:3, 2], T_world_optical[:3, 1]
        view = pybullet.computeViewMatrix(eye.tolist(), (eye + forward).tolist(), (-down).tolist())
        lens, near = RGB_CAMERA, 0.02
        # PyBullet's image plane reaches from the outer edge of the first pixel to that of the last.
        left, right = (-0.5 - lens.centre_x) / lens.focal_px * near, (639.5 - lens.centre_x) / lens.focal_px * near
        top, bottom = (0.5 + lens.centre_y) / lens.focal_px * near, (lens.centre_y - 479.5) / lens.focal_px * near
        matrix = pybullet.computeProjectionMatrix(left, right, bottom, top, near, 20.0)
        _, _, rgba, _, owners = pybullet.getCameraImage(
            640, 480, view, matrix, shadow=0, lightAmbientCoeff=1.0, lightDiffuseCoeff=0.0, lightSpecularCoeff=0.0,
            renderer=pybullet.ER_TINY_RENDERER, physicsClientId=client,
        )  # fmt: skip
        grey = np.reshape(rgba, (480, 640, 4))[..., :3].mean(2)
        return grey, np.reshape(owners, (480, 640)), bodies
    finally:
        pybullet.disconnect(client)


def best_likeness(ours: np.ndarray, theirs: np.ndarray, where: np.ndarray) -> float:
    """Correlation of two pictures when one is shifted by at most a pixel: PyBullet takes the nearest texture pixel."""
    smooth, other = (cv2.GaussianBlur(picture.astype(np.float32), (0, 0), 1.0) for picture in (ours, theirs))
    shifts = [(x, y) for x in (-1.0, -0.5, 0.0, 0.5, 1.0) for y in (-1.0, -0.5, 0.0, 0.5, 1.0)]
    moved = [cv2.warpAffine(smooth, np.array([[1, 0, x], [0, 1, y]]), smooth.shape[::-1]) for x, y in shifts]
    return max(float(np.corrcoef(picture[where], other[where])[0, 1]) for picture in moved)


@pytest.mark.parametrize("robot", [(0.0, 0.0, 0.05), (0.4, 0.5, -0.4), (1.0, 1.2, -1.2)], ids=["front", "near", "side"])
def test_it_shows_what_pybullet_shows(camera: RgbCamera, robot: Tuple[float, float, float]) -> None:
    T_world_optical = pose(*robot)
    theirs, owners, bodies = bullet_picture(T_world_optical, ROOM, resource("tags", "tag_06.png"))
    ours = camera.render(ROOM, T_world_optical, CLEAN)
    for number, (body, tag) in bodies.items():
        for kind, theirs_shown in ((TAG, owners == tag), (BODY, owners == body)):
            shown = (ours.kinds == kind) & (ours.owners == number)
            if theirs_shown.sum() < 800 and shown.sum() < 800:
                continue
            common = (shown & theirs_shown).sum() / (shown | theirs_shown).sum()
            assert common > 0.93, (number, kind, common, shown.sum(), theirs_shown.sum())
        inner = cv2.erode(((owners == tag) & (ours.kinds == TAG)).astype(np.uint8), np.ones((9, 9))) > 0
        if inner.sum() > 3000:
            likeness = best_likeness(ours.grey, theirs, inner)
            assert likeness > 0.98, (number, likeness)


def test_floor_walls_and_robot_are_where_they_must_be(camera: RgbCamera) -> None:
    kinds = camera.render(replace(ROOM, boxes=()), pose(), Imaging()).kinds
    assert (kinds[408:] == ROBOT).all()
    assert (kinds[400:408] == FLOOR).all()
    # The wall is 3.087 m away: from 0.297 m below the eye to 0.703 m above.
    foot, head = 240 + 554.3 * 0.297 / 3.087, 240 - 554.3 * 0.703 / 3.087
    column = kinds[:408, 320]
    assert np.flatnonzero(column == WALL).tolist() == pytest.approx(list(range(round(head), round(foot) + 1)), abs=1)


def test_the_nearer_box_covers_the_farther(camera: RgbCamera) -> None:
    alone = camera.render(replace(ROOM, boxes=ROOM.boxes[1:]), pose(), CLEAN)
    both = camera.render(ROOM, pose(), CLEAN)
    assert (alone.owners == 0).sum() > 2 * (both.owners == 1).sum()
    assert (both.owners == 0).sum() == (camera.render(replace(ROOM, boxes=(BOX,)), pose(), CLEAN).owners == 0).sum()


def test_only_the_front_of_a_box_bears_the_tag(camera: RgbCamera) -> None:
    behind = camera.render(replace(ROOM, boxes=(BOX,)), pose(2.2, -0.4, 2.7), CLEAN)
    assert not (behind.kinds == TAG).any()
    assert (behind.kinds == BODY).sum() > 10000


def test_a_box_at_the_cameras_side_and_behind_it_is_no_trouble(camera: RgbCamera) -> None:
    room = replace(ROOM, boxes=(TaggedBox(Pose2(0.0, 0.35, -1.57), BoxSize(2.0, 0.1, 0.4), PICTURE),))
    frame = camera.render(room, pose(), CLEAN)
    assert (frame.kinds[240, :100] == TAG).all()
    assert not (frame.kinds[:, 330:] == TAG).any()
    behind = replace(ROOM, boxes=(TaggedBox(Pose2(-1.0, 0.0, 0.0), BoxSize(), PICTURE),))
    assert (camera.render(behind, pose(), CLEAN).owners == 255).all()


def test_frames_repeat_with_the_seed_and_differ_in_their_noise_alone(camera: RgbCamera) -> None:
    imaging = Imaging(noise=3.0, vignetting=0.0, blur_px=0.0)
    first, second = (camera.render(ROOM, pose(), imaging, frame).grey.astype(int) for frame in (1, 2))
    assert np.array_equal(RgbCamera(seed=0).render(ROOM, pose(), imaging, 1).grey, first)
    difference = (first - second)[:400, :]
    assert abs(difference.mean()) < 0.1
    assert difference.std() == pytest.approx(3.0 * math.sqrt(2.0), rel=0.05)


def test_gain_vignetting_blur_and_light_do_what_they_say(camera: RgbCamera) -> None:
    def shot(**changes: object) -> RgbFrame:
        return camera.render(ROOM, pose(0.5, 0.2), replace(CLEAN, **changes))

    plain = shot()
    tag = (plain.kinds == TAG) & (plain.owners == 0)
    assert shot(gain=0.5).grey[tag].mean() == pytest.approx(0.5 * plain.grey[tag].mean(), rel=0.02)
    assert (shot(gain=9.0).grey[plain.kinds == FLOOR] == 255).all()
    dim = shot(vignetting=0.4).grey
    assert dim[5, 5] == pytest.approx(plain.grey[5, 5] * (1 - 0.4 * 0.96), rel=0.05)
    assert dim[240, 320] == plain.grey[240, 320]
    sharp, soft = (cv2.Laplacian(shot(blur_px=blur).grey, cv2.CV_32F)[tag].std() for blur in (0.0, 3.0))
    assert soft < 0.2 * sharp
    lit, shaded = (shot(ambient=0.5, light=(side, 0.0, 0.1)).grey[tag].mean() for side in (-1.0, 1.0))
    assert lit > 1.7 * shaded


def test_the_share_of_a_face_that_is_seen(camera: RgbCamera) -> None:
    room = replace(ROOM, boxes=(TaggedBox(Pose2(0.0, 0.0, 0.0), BoxSize(), PICTURE),))
    T_world_optical = pose(0.5, 0.0, math.pi)
    face = np.linalg.inv(T_world_optical) @ tag_face(Pose2(0, 0, 0), BoxSize())
    outline = RGB_CAMERA.project(face_corners(0.5, 0.4) @ face[:3, :3].T + face[:3, 3])
    frame = camera.render(room, T_world_optical, Imaging())
    assert visible_share(frame, 0, outline.tolist()) == pytest.approx(0.64, abs=0.01)
    assert visible_share(frame, 1, outline.tolist()) == 0.0
    assert visible_share(frame, 0, [(0, 0), (0, 0), (0, 0)]) == 0.0


def test_the_coloured_picture_keeps_tags_grey_and_tints_the_rest(camera: RgbCamera) -> None:
    frame = camera.render(ROOM, pose(), Imaging())
    rgb = frame.rgb()
    assert rgb.shape == (480, 640, 3)
    assert (np.ptp(rgb[frame.kinds == TAG], axis=1) == 0).all()
    floor = rgb[frame.kinds == FLOOR].mean(0)
    assert floor[0] > floor[1] > floor[2]
    assert np.array_equal(rgb, TINTED[frame.kinds, frame.grey])
