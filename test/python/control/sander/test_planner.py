"""The sander's motions: where they begin and end, how fast and along which line the tip goes."""

from __future__ import annotations

import numpy as np
import pytest

from python.control.arm_samples import PART_LOWER, PART_TOP_M, PART_UPPER, arm, planner, scan
from yarm.control.arm.errors import ArmError
from yarm.control.arm.motion import ArmMotion
from yarm.control.sander.params import SanderParams
from yarm.control.sander.planner import CAMERA_AHEAD_M, RasterPlan, SanderPlanner
from yarm.geometry import FloatArray

PARAMS = SanderParams(spacing_m=0.12)


@pytest.fixture(name="raster", scope="module")
def raster_fixture() -> RasterPlan:
    """A raster of few passes over the part."""
    return planner(PARAMS.spacing_m).raster(scan())


@pytest.fixture(name="hovering", scope="module")
def hovering_fixture() -> FloatArray:
    """Joints (6,) over the part's centre."""
    made = planner(PARAMS.spacing_m)
    return made.to_hover(arm().storage).positions[-1]


def tips(motion: ArmMotion) -> FloatArray:
    """Tip positions (n, 3) every 20 ms of a motion, metres, world."""
    times = np.arange(0.0, motion.duration_s + 0.02, 0.02)
    return np.array([planner(PARAMS.spacing_m).kinematics.tip(motion.at(t))[:3, 3] for t in times])


def speeds(motion: ArmMotion) -> FloatArray:
    """Speed of the tip (n,), m/s."""
    return np.linalg.norm(np.diff(tips(motion), axis=0), axis=1) / 0.02


def test_the_hover_is_over_the_parts_centre(hovering: FloatArray) -> None:
    pose = planner(PARAMS.spacing_m).kinematics.tip(hovering)
    assert pose[:3, 3] == pytest.approx([*PARAMS.part_centre_m, PARAMS.hover_height_m], abs=2e-3)
    assert pose[:3, 2] == pytest.approx([0.0, 0.0, -1.0], abs=1e-3)


def test_storage_is_reached_exactly(hovering: FloatArray) -> None:
    home = planner(PARAMS.spacing_m).to_storage(hovering)
    assert home.positions[0] == pytest.approx(hovering)
    assert home.positions[-1] == pytest.approx(arm().storage, abs=1e-6)


def test_the_sweep_takes_the_camera_straight_over_the_part() -> None:
    made = planner(PARAMS.spacing_m)
    start = made.to_scan(arm().storage).positions[-1]
    motion = made.sweep(start)
    way = tips(motion)
    x = PARAMS.part_centre_m[0] - CAMERA_AHEAD_M
    assert way[0] == pytest.approx(
        [x, PARAMS.part_centre_m[1] - PARAMS.scan_reach_m / 2, PARAMS.scan_height_m], abs=3e-3
    )
    assert way[-1] == pytest.approx(
        [x, PARAMS.part_centre_m[1] + PARAMS.scan_reach_m / 2, PARAMS.scan_height_m], abs=3e-3
    )
    assert np.abs(way[:, [0, 2]] - [x, PARAMS.scan_height_m]).max() < 3e-3
    assert speeds(motion).max() <= 1.05 * PARAMS.scan_speed_mps


def test_the_raster_lies_on_the_part(raster: RasterPlan) -> None:
    points = raster.raster.polyline
    assert np.all(points[:, :2] >= np.array(PART_LOWER) - 0.01) and np.all(points[:, :2] <= np.array(PART_UPPER) + 0.01)
    assert np.abs(points[:, 2] - PART_TOP_M - PARAMS.standoff_m).max() < 4e-3


def test_the_joints_of_the_raster_put_the_tip_on_its_points(raster: RasterPlan) -> None:
    made = planner(PARAMS.spacing_m)
    for stroke, joints in zip(raster.raster.strokes, raster.joints):
        at = np.array([made.kinematics.tip(q)[:3, 3] for q in joints[::5]])
        assert np.abs(at - stroke.points[::5]).max() < 1e-3


@pytest.mark.parametrize("share", [0.0, 0.37, 1.0])
def test_a_point_along_the_raster_is_between_its_points(raster: RasterPlan, share: float) -> None:
    point, normal = raster.point_at(share * raster.raster.length_m)
    assert np.linalg.norm(raster.raster.polyline - point, axis=1).min() < 0.01
    assert np.linalg.norm(normal) == pytest.approx(1.0)
    assert normal[2] > 0.99


def test_a_stroke_goes_on_from_where_sanding_stopped(raster: RasterPlan) -> None:
    made = planner(PARAMS.spacing_m)
    stroke = raster.raster.strokes[0]
    arc = stroke.arc_m[0] + 0.4 * (stroke.arc_m[-1] - stroke.arc_m[0])
    motion = made.stroke_from(raster, float(arc))
    assert motion.arc_m[0] == pytest.approx(arc) and motion.arc_m[-1] == pytest.approx(stroke.arc_m[-1])
    assert np.all(np.diff(motion.arc_m) >= -1e-9)
    assert tips(motion)[0] == pytest.approx(raster.point_at(float(arc))[0], abs=2e-3)
    assert speeds(motion).max() <= 1.05 * PARAMS.sanding_speed_mps


def test_beyond_the_end_of_the_raster_there_is_nothing_to_sand(raster: RasterPlan) -> None:
    with pytest.raises(ArmError, match=r"the raster ends at \d"):
        planner(PARAMS.spacing_m).stroke_from(raster, raster.raster.length_m + 0.1)


def test_coming_down_goes_over_the_point_first_and_lifting_goes_back_up(
    raster: RasterPlan, hovering: FloatArray
) -> None:
    made = planner(PARAMS.spacing_m)
    arc = 0.5 * raster.raster.length_m
    point, _ = raster.point_at(arc)
    down = made.come_down(hovering, raster, arc)
    way = tips(down)
    assert way[-1] == pytest.approx(point, abs=2e-3)
    low = way[way[:, 2] < point[2] + 0.1]
    assert np.linalg.norm(low[:, :2] - point[:2], axis=1).max() < 5e-3  # the last 10 cm are straight down
    up = made.lift(down.positions[-1])
    assert tips(up)[-1] == pytest.approx([point[0], point[1], PARAMS.hover_height_m], abs=5e-3)
    assert made.lift(up.positions[-1]).duration_s == 0.0


def test_a_place_out_of_reach_is_named() -> None:
    far = SanderPlanner(arm(), SanderParams(part_centre_m=(4.0, 0.0)))
    with pytest.raises(ArmError, match=r"the tip cannot reach \(4\.000, 0\.000, \d\.\d+\) m"):
        far.to_hover(arm().storage)


def test_a_part_under_the_arm_itself_is_refused_with_what_is_too_near() -> None:
    """Points of a surface as high as the arm's own elbow can be reached by the tip alone, not by the arm."""
    high = scan(debris=False)
    high[:, 2] += 0.75
    with pytest.raises(ArmError, match=r"apart|cannot reach|turn over"):
        planner(PARAMS.spacing_m).raster(high)
