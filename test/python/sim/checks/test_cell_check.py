"""cell_check passes every shipped scene, and says what is wrong with scenes that cannot be done."""

from __future__ import annotations

import math
from functools import partial
from typing import Any, Dict, List, Sequence

import numpy as np
import pytest

from yarm.geometry import GridSpec
from yarm.robots.ankurbot import Disc, ankurbot_mask
from yarm.robots.shapes import TAKEN_OFF_M, RobotShape
from yarm.robots.turns import QUARTER_TURNS_DEG
from yarm.sim.checks.cell_check import TURNS_DEG, check_scene, debris_shape, goal_points, shape_of, unreachable_goals
from yarm.sim.checks.reachability import ConfigurationSpace
from yarm.sim.engine.world import SimWorld
from yarm.sim.scenes.random_cell import random_cell
from yarm.sim.scenes.scene import load_scene, scene_from, shipped_scenes


def robot(name: str, x: float, y: float, heading_deg: float) -> Dict[str, Any]:
    return {"name": name, "type": "ankurbot", "x": x, "y": y, "heading_deg": heading_deg}


def failures(turns_deg: Sequence[float] = TURNS_DEG, **scene: Any) -> List[str]:
    findings = check_scene(scene_from({"name": "test", **scene}, "test"), turns_deg=turns_deg)
    return [finding.text for finding in findings if not finding.holds]


@pytest.mark.parametrize("name", shipped_scenes())
def test_every_shipped_scene_can_be_done(name: str) -> None:
    findings = check_scene(load_scene(name))
    assert [finding.text for finding in findings if not finding.holds] == []
    assert len(findings) >= 3


@pytest.mark.parametrize("name", ["1m1ma", "1m1ma_bin", "2m1ma", "2m1ma_bin", "3m6_bin"])
def test_the_cells_of_debris_can_be_done_with_hands_too(name: str) -> None:
    scene = load_scene(name)
    findings = check_scene(scene, hands=True)
    assert [finding.text for finding in findings if not finding.holds] == []
    assert any("clear of the hovering" in finding.text for finding in findings) is bool(scene.working_arms)


def test_a_hand_must_get_to_every_bin() -> None:
    """Nothing can be let go into a bin under a roof; without a hand nobody asks for that."""
    bins = [{"name": "bin_1", "x": -0.55, "y": -1.45}, {"name": "bin_2", "x": 0.45, "y": -1.45}]
    roof = {"name": "roof", "x": -0.55, "y": -1.45, "z": 1.0, "size": [0.3, 0.3, 0.1]}
    robots = [robot("ankurbot_1", 1.95, 1.6, 180.0)]
    scene = scene_from({"name": "test", "robots": robots, "bins": bins, "obstacles": [roof]}, "test")
    said = {finding.goal: finding.holds for finding in check_scene(scene, hands=True) if finding.goal}
    assert said == {"bin_1": False, "bin_2": True}
    assert not any(finding.goal for finding in check_scene(scene))


def test_a_robot_fills_the_cells_at_each_heading_that_the_planner_is_told_of() -> None:
    spec = GridSpec()
    with SimWorld(load_scene("1m1ma")) as world:
        shape = shape_of(world, next(iter(world.robots.values())))
    for yaw_deg in range(0, 360, 10):
        yaw = math.radians(yaw_deg)
        assert np.array_equal(shape.mask(spec, yaw).cells, ankurbot_mask(spec, yaw).cells), yaw_deg


def test_a_carried_piece_hangs_under_the_cup_and_is_as_wide_as_it_is_long() -> None:
    piece = debris_shape()
    assert (piece.radius_m, piece.height_m) == pytest.approx((math.hypot(0.075, 0.03), 0.0405), abs=1e-3)
    with SimWorld(load_scene("1m1ma_bin"), hands=True) as world:
        load = shape_of(world, next(iter(world.robots.values()))).discs[-1]
    assert load.z == pytest.approx((0.895 - piece.height_m, 0.895), abs=1e-3)
    assert load.radius == pytest.approx(piece.radius_m + TAKEN_OFF_M)


def test_a_start_outside_the_volume() -> None:
    told = failures(robots=[robot("ankurbot_1", 2.0, 2.0, 0.0)])
    assert any("ankurbot_1 starts outside the volume" in text for text in told)


def test_overlapping_starts() -> None:
    told = failures(robots=[robot("ankurbot_1", 1.5, 1.5, 180.0), robot("ankurbot_2", 1.0, 1.5, 180.0)])
    assert any("ankurbot_1 overlaps ankurbot_2" in text for text in told)


def test_a_goal_nobody_can_reach() -> None:
    told = failures(
        robots=[robot("ankurbot_1", 2.0, 2.0, 180.0)],
        targets=[{"name": "target_1", "x": -1.1, "y": 0.0}],
        manipulators=[{"name": "hc10_barc", "type": "hc10"}],
    )
    assert any("target_1: no robot can get to column" in text for text in told)


def test_private_areas_that_overlap() -> None:
    stations = [{"x": -1.0, "y": 1.1}, {"x": -0.5, "y": -0.35, "yaw_deg": 180}]
    arms = [{"name": f"hc10_barc_{i}", "type": "hc10", "station": station} for i, station in enumerate(stations)]
    told = failures(manipulators=arms)
    assert told == [
        "private areas of hc10_barc_0 (columns x 1..19, y 28..43) and hc10_barc_1 (columns x 15..33, y 13..29) overlap"
    ]


@pytest.mark.parametrize(
    ("heading_deg", "turns_deg", "possible"),
    [(180.0, QUARTER_TURNS_DEG, False), (140.0, QUARTER_TURNS_DEG, True), (180.0, TURNS_DEG, True)],
)
def test_a_goal_in_the_corner_needs_finer_turns_or_a_robot_that_stands_askew(
    heading_deg: float, turns_deg: Sequence[float], possible: bool
) -> None:
    scene = {
        "robots": [robot("ankurbot_1", 1.0, 1.0, heading_deg)],
        "targets": [{"name": "target_1", "x": 2.35, "y": -2.35}],
    }
    words = (
        "target_1: turns of 0, 90, -90 deg (the Commander's turns_deg and finer_turns_deg) lead no robot to column "
        "(48, 1); with any turns ankurbot_1 can at headings ["
    )
    told = failures(turns_deg, **scene)
    assert [text[: len(words)] for text in told] == ([] if possible else [words])


def test_a_robot_is_not_believed_to_drive_at_headings_that_its_turns_do_not_lead_to() -> None:
    """The robots of this cell start at -74 and -173 deg: quarter turns leave hardly a way."""
    cell = random_cell("mixed", 26)
    assert set(unreachable_goals(cell)) == {"target_inside"}
    assert set(unreachable_goals(cell, QUARTER_TURNS_DEG)) > {"target_inside"}


def test_goals_that_cannot_be_held_together() -> None:
    told = failures(
        robots=[robot("ankurbot_1", 2.0, 2.0, 180.0), robot("ankurbot_2", 2.0, -2.0, 180.0)],
        targets=[{"name": "target_1", "x": -1.9, "y": 0.0}, {"name": "target_2", "x": -1.9, "y": 0.05}],
    )
    assert "target_1 and target_2 cannot be held together at any headings with the margin" in told


def test_goals_of_events_and_pushes_are_checked_too() -> None:
    names = [goal.name for goal in goal_points(load_scene("2m1ma"))]
    assert names[:2] == ["debris_1", "debris_2"]
    assert any("after: first debris slips" in name for name in names)


def test_headings_join_in_a_circle_and_walls_part_the_space() -> None:
    spec = GridSpec()
    mask_at = partial(RobotShape((Disc(0.0, 0.0, 0.02, (0.48, 0.52)),), ()).mask, spec)
    wall = np.array([[x, y, 0.5] for x in (0.0, 0.05) for y in np.arange(-2.49, 2.5, 0.05)])
    reached = ConfigurationSpace(mask_at, wall, spec).reachable((40, 25), 0.0, TURNS_DEG).columns
    assert reached[:, 30:].all()
    assert not reached[:, :24].any()
    assert ConfigurationSpace(mask_at, np.zeros((0, 3)), spec).reachable((40, 25), 0.0, TURNS_DEG).columns.all()
