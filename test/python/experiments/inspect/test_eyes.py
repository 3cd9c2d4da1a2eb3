"""Looking at boxes in drawn pictures: both recognitions from a good place, and from one that shows nothing."""

from __future__ import annotations

import dataclasses
import math
from typing import List

import pytest

from yarm.experiments.inspect.eyes import Camera, Moment, boxes_of, make_eyes
from yarm.experiments.inspect.record import LookRecord
from yarm.geometry import Pose2
from yarm.geometry.pinhole import BoxSize
from yarm.inspection.boxes import Box
from yarm.inspection.model import OURS, REPORT, UNSEEN, Look
from yarm.inspection.reading import predicted_deg
from yarm.inspection.viewpoints import viewpoint
from yarm.sim.checks.layout_check import sights
from yarm.sim.kinematic.world import KinematicWorld
from yarm.sim.scenes.layout_maker import make_layout

LAYOUT = make_layout("open", 0)
TAGGED = next(i + 1 for i, tag in enumerate(LAYOUT.tags) if tag > 0)
PLACES = {sight.box: sight.pose for sight in sights(LAYOUT)}


def place() -> Pose2:
    pose = PLACES[TAGGED]
    assert pose is not None
    return pose


def test_boxes_are_told_as_they_stand() -> None:
    for box, block in zip(boxes_of(LAYOUT), LAYOUT.boxes):
        assert box.pose == block.pose and box.size == BoxSize(block.size[1], block.size[0], block.size[2])


def moment(robot: Pose2) -> Moment:
    world = KinematicWorld(dataclasses.replace(LAYOUT.arena, start=robot), 1)
    return Moment(3.0, robot, robot, world.scan(), robot)


def test_ours_is_sure_after_one_good_look_and_keeps_it() -> None:
    kept: List[LookRecord] = []
    eyes = make_eyes(OURS, LAYOUT, Camera(LAYOUT, 1), kept.append)
    reading = eyes.look(Look(TAGGED, 5, 2.0), moment(place()))
    assert len(kept) == 1 and kept[0].box == TAGGED and kept[0].t_s == 3.0 and kept[0].robot == place()
    assert kept[0].look is not None and kept[0].look.answer == LAYOUT.tags[TAGGED - 1]
    assert kept[0].image.shape == (480, 640) and eyes.computing_s > 0.0
    assert reading is not None and reading.tag == LAYOUT.tags[TAGGED - 1] and reading.probability >= 0.999


def test_ours_names_nothing_when_it_looks_away() -> None:
    away = place().compose(Pose2(0.0, 0.0, 3.0))
    eyes = make_eyes(OURS, LAYOUT, Camera(LAYOUT, 1), lambda look: None)
    assert eyes.look(Look(TAGGED, 5, 2.0), moment(away)) is None
    assert eyes.reading(TAGGED).tag == UNSEEN


def test_the_report_votes_after_all_its_images() -> None:
    kept: List[LookRecord] = []
    eyes = make_eyes(REPORT, LAYOUT, Camera(LAYOUT, 1), kept.append)
    order = Look(TAGGED, 7, 5.0)
    assert eyes.reading(TAGGED).tag == UNSEEN
    for _ in range(12):
        assert eyes.look(order, moment(place())) is None
    assert len(kept) == 12 and len(kept[0].sightings) == 15 and kept[0].look is None
    assert eyes.reading(TAGGED).tag == LAYOUT.tags[TAGGED - 1]


@pytest.mark.parametrize("angle_deg, turn_deg, predicted", [(0, 0, 90), (30, 0, 120), (-60, 0, 30), (30, 5.6, 125.6)])
def test_the_report_predicts_the_angle_from_its_goal(angle_deg: float, turn_deg: float, predicted: float) -> None:
    box = Box(1, Pose2(1.0, -2.0, 2.9))
    goal = viewpoint(box, 0.5, angle_deg).pose.compose(Pose2(0.0, 0.0, math.radians(turn_deg)))
    assert predicted_deg(goal, box) == pytest.approx(predicted)
