"""cell_check passes every shipped scene, and says what is wrong with scenes that cannot be done."""

from __future__ import annotations

from typing import Any, Dict, List

import numpy as np
import pytest

from yarm.geometry import GridSpec
from yarm.sim.cell_check import check_scene, goal_points
from yarm.sim.reachability import ConfigurationSpace, RobotShape, nearest_heading
from yarm.sim.scene import load_scene, scene_from, shipped_scenes


def robot(name: str, x: float, y: float, heading_deg: float) -> Dict[str, Any]:
    return {"name": name, "type": "ankurbot", "x": x, "y": y, "heading_deg": heading_deg}


def failures(**scene: Any) -> List[str]:
    return [finding.text for finding in check_scene(scene_from({"name": "test", **scene}, "test")) if not finding.holds]


@pytest.mark.parametrize("name", shipped_scenes())
def test_every_shipped_scene_can_be_done(name: str) -> None:
    findings = check_scene(load_scene(name))
    assert [finding.text for finding in findings if not finding.holds] == []
    assert len(findings) >= 3


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
    shape = RobotShape.from_points(np.array([[0.0, 0.0, 0.5]]), spec)
    wall = np.array([[x, y, 0.5] for x in (0.0, 0.05) for y in np.arange(-2.49, 2.5, 0.05)])
    space = ConfigurationSpace(shape, wall, spec)
    reached = space.reachable((40, 25), nearest_heading(0.0))
    assert reached[:, 30:].all()
    assert not reached[:, :24].any()
    open_space = ConfigurationSpace(shape, np.zeros((0, 3)), spec)
    assert open_space.reachable((40, 25), 0).all()
