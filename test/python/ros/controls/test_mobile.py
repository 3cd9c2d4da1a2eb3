"""A robot that nobody drew answers its calibration with the extent of its type."""

from __future__ import annotations

import pytest
from yarm.msg import RegisteredObject

from yarm.control.base.footprint import extent_in_cells
from yarm.geometry.grid import GridSpec
from yarm.ros.common.bodies import registry_entry
from yarm.ros.controls.mobile import boxes_in_base, hand_fault, type_boxes
from yarm.sim.scenes.bodies import mobile_body
from yarm.sim.scenes.specs import RobotSpec


def test_the_type_has_the_extent_of_its_drawing():
    drawn = registry_entry(mobile_body(RobotSpec("ankurbot_1", "ankurbot", 0.0, 0.0, 0.0)))
    assert extent_in_cells(boxes_in_base(drawn, "ankurbot_1"), GridSpec()) == (17, 7, 15)
    assert extent_in_cells(type_boxes(), GridSpec()) == (17, 7, 15)


def test_without_shapes_the_registry_tells_frames_alone():
    undrawn = registry_entry(mobile_body(RobotSpec("ankurbot_1", "ankurbot", 0.0, 0.0, 0.0, drawn=False)))
    assert undrawn.shapes == undrawn.shape_frames == undrawn.shape_poses == []
    assert undrawn.link_frames == ["ankurbot_1/base_link", "ankurbot_1/ee"]


@pytest.mark.parametrize(
    ("action", "words"),
    [
        ("PICK debris_1", ""),
        ("PICK debris_auto_4", ""),
        ("DROP bin_1", ""),
        ("True", ""),
        ("PICKING chair", ""),
        ("PICK ", "'PICK ' needs the name of a piece of debris, as in 'PICK debris_1'"),
        ("DROP", "'DROP' needs the name of a bin, as in 'DROP bin_1'"),
        ("PICK chair", "PICK chair: nobody in object_registry is called chair"),
        ("PICK bin_1", "PICK bin_1: bin_1 is no piece of debris"),
        ("DROP debris_1", "DROP debris_1: debris_1 is no bin"),
        ("DROP debris_auto_4", "DROP debris_auto_4: nobody in object_registry is called debris_auto_4"),
    ],
)
def test_hands_work_on_what_there_is(action, words):
    there = {
        "debris_1": RegisteredObject(name="debris_1", object="Debris"),
        "bin_1": RegisteredObject(name="bin_1", object="Obstacle"),
    }
    assert hand_fault(action, there.get) == words
