"""A manipulator's station on its way from the scene to a node."""

from __future__ import annotations

import math

import pytest

from yarm.params import ParamError
from yarm.robots.hc10 import AT_ORIGIN
from yarm.ros.common import names
from yarm.ros.common.stations import station_of, station_values
from yarm.sim.scenes.scene import load_scene


@pytest.mark.parametrize("scene", ["1m1ma", "2m2ma"])
def test_the_parameter_says_what_the_scene_says(scene: str) -> None:
    for arm in load_scene(scene).arms:
        assert station_of(station_values(arm.name, scene), "") == arm.station


def test_without_scene_or_arm_it_stands_at_the_origin() -> None:
    for values in ({}, station_values("hc10_barc"), station_values("hc10_barc", "single")):
        assert station_of(values, "") == AT_ORIGIN


@pytest.mark.parametrize(
    ("raw", "words"),
    [
        ([1, 2], "must be a mapping"),
        ({"yaw_deg": 1.0}, "yaw_deg: unknown key; known: x, y, yaw_rad, storage"),
        ({"x": "left"}, "x = 'left': must be a number"),
        ({"y": math.inf}, "y = inf"),
        ({"storage": 3}, "storage = 3"),
        ({"storage": [1.0, 2.0]}, "6 angles"),
    ],
)
def test_what_is_wrong_is_named(raw: object, words: str) -> None:
    with pytest.raises(ParamError) as raised:
        station_of(raw, "hc10_barc/station")
    assert str(raised.value).startswith("hc10_barc/station")
    assert words in str(raised.value)


def test_each_sander_is_a_node_of_its_own() -> None:
    assert names.sander_node("hc10_barc") == "hc10_state_machine"
    assert names.sander_node("hc10_barc_2") == "hc10_state_machine_2"
