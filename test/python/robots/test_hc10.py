"""Stations: where an arm, its part and its private area come to lie when its station is moved and turned."""

from __future__ import annotations

import math

import numpy as np
import pytest

from yarm.control.sander.params import SanderParams
from yarm.geometry import GridSpec, transform_points
from yarm.robots.hc10 import (
    AT_ORIGIN,
    PRIVATE_AREA,
    Station,
    area_text,
    arm_mount,
    parse_area,
    station_boxes,
    station_faults,
)

SPEC = GridSpec()


def test_the_station_at_the_origin_changes_nothing() -> None:
    assert np.array_equal(AT_ORIGIN.pose, np.eye(4))
    assert AT_ORIGIN.base_xyz == arm_mount().base_xyz
    assert AT_ORIGIN.folded == arm_mount().storage
    assert AT_ORIGIN.moved_area(SPEC, PRIVATE_AREA) == PRIVATE_AREA


@pytest.mark.parametrize(
    ("station", "area"),
    [
        (Station(-1.0, 1.1), (1, 19, 28, 43, 0, 10)),
        (Station(1.0, -1.1, math.pi), (30, 48, 6, 21, 0, 10)),
        (Station(0.0, 0.0, math.pi / 2), (17, 32, 11, 29, 0, 10)),
        (Station(0.04, 0.0), (11, 30, 17, 32, 0, 10)),
        (Station(-2.0, 0.0), (0, 9, 17, 32, 0, 10)),
    ],
)
def test_the_area_moves_with_the_station(station: Station, area: tuple) -> None:
    assert station.moved_area(SPEC, PRIVATE_AREA) == area


def test_the_area_holds_the_part_wherever_it_is_turned() -> None:
    part = np.array([(x, y, 0.0) for x in (-0.44, -0.06) for y in (-0.29, 0.29)])
    for degrees in range(0, 360, 15):
        station = Station(0.3, -0.2, math.radians(degrees))
        x0, x1, y0, y1, _, _ = station.moved_area(SPEC, PRIVATE_AREA)
        for point in transform_points(station.pose, part):
            gx, gy = SPEC.column_of(point)
            assert x0 <= gx <= x1, degrees
            assert y0 <= gy <= y1, degrees


def test_the_arm_stands_on_its_turned_stand() -> None:
    x, y, z = arm_mount().base_xyz
    assert Station(1.0, -1.1, math.pi).base_xyz == pytest.approx((1.0 - x, -1.1 - y, z))
    folded = tuple(0.1 * i for i in range(6))
    assert Station(storage=folded).folded == folded


@pytest.mark.parametrize("text", ["1,2,3", "1,2,3,4,5,x", "", "5,1,0,1,0,1", "0,1,0,1,2,1"])
def test_an_area_that_is_none_is_quoted(text: str) -> None:
    with pytest.raises(ValueError, match="area"):
        parse_area(text)


def test_an_area_reads_as_it_is_written() -> None:
    assert parse_area(area_text(PRIVATE_AREA)) == PRIVATE_AREA


def test_faults_of_a_station_are_named() -> None:
    assert station_faults(AT_ORIGIN) == ""
    assert "finite" in station_faults(Station(math.nan))
    assert "6 angles" in station_faults(Station(storage=(0.0, 1.0)))


def test_the_arm_is_bolted_onto_the_middle_of_its_stand() -> None:
    stand = next(box for box in station_boxes() if box.name == "stand")
    x, y, z = arm_mount().base_xyz
    assert (x, y) == stand.centre[:2]
    assert z == pytest.approx(stand.centre[2] + stand.size[2] / 2.0)


def test_the_sander_looks_for_the_part_where_it_is() -> None:
    part = next(box for box in station_boxes() if box.name == "part")
    assert SanderParams().part_centre_m == part.centre[:2]


def test_the_private_area_holds_stand_and_part() -> None:
    lower, size = np.array(SPEC.lower[:2]), SPEC.resolution[:2]
    low = lower + np.array(PRIVATE_AREA[0:4:2]) * size
    high = lower + (np.array(PRIVATE_AREA[1:4:2]) + 1) * size
    for box in station_boxes():
        if box.name != "table":
            half = np.array(box.size[:2]) / 2.0
            assert np.all(np.array(box.centre[:2]) - half >= low - 1e-9), box.name
            assert np.all(np.array(box.centre[:2]) + half <= high + 1e-9), box.name
