"""The controls server's parameters that are more than a range."""

from __future__ import annotations

import pytest

from yarm.params import ParamError, build
from yarm.robots.hc10 import PRIVATE_AREA, parse_area
from yarm.ros.controls.params import ControlsServerParams


def test_the_area_by_default_is_that_of_the_station_at_the_origin() -> None:
    assert parse_area(ControlsServerParams().manipulator_area) == PRIVATE_AREA


@pytest.mark.parametrize("area", ["11,29,17", "all", "29,11,17,32,0,10"])
def test_an_area_that_is_none_is_refused_at_the_start(area: str) -> None:
    with pytest.raises(ParamError, match=f"manipulator_area: area '{area}'"):
        build(ControlsServerParams, {"manipulator_area": area})
