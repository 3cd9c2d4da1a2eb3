"""A robot's solids about its tip: of a hand that is down as of one that is drawn up."""

from __future__ import annotations

import numpy as np
import pytest

from yarm.robots.ankurbot import LIFT_LINKS
from yarm.ros.common.bodies import registry_entry
from yarm.ros.common.solids import solids_at_tip
from yarm.ros.controls.mobile import boxes_in_base
from yarm.sim.engine.world import SimWorld
from yarm.sim.scenes.bodies import mobile_body
from yarm.sim.scenes.scene import load_scene

ROBOT = "ankurbot_1"
DOWN_M = 0.12


@pytest.fixture(scope="module")
def told():
    """The robot's entry of the registry, and its frames with the hand drawn up and down."""
    scene = load_scene("1m1ma_bin")
    with SimWorld(scene, hands=True) as world:
        up = dict(world.transforms())
        world.hands[ROBOT].lift_to(DOWN_M)
        world.run(1.5)
        yield registry_entry(mobile_body(scene.robots[0], True)), up, dict(world.transforms())


def test_the_frames_go_down_with_the_hand(told):
    entry, up, down = told
    for link, share in zip(LIFT_LINKS, (1.0, 0.5)):
        frame = f"{ROBOT}/{link}"
        assert frame in entry.shape_frames
        assert up[frame][2, 3] - down[frame][2, 3] == pytest.approx(share * DOWN_M, abs=2e-3)


def test_the_shape_for_planning_is_that_of_a_hand_drawn_up(told):
    entry, up, down = told
    ours = solids_at_tip(entry, down)
    wanted = solids_at_tip(entry, up)
    assert len(ours) == len(entry.shapes)
    for one, other in zip(ours, wanted):
        np.testing.assert_allclose(one.pose, other.pose, atol=2e-3)
    lowest = min(float(solid.pose[2, 3] - solid.half_extent[2]) for solid in ours if solid.pose[0, 3] > -0.1)
    assert lowest == pytest.approx(-0.075, abs=2e-3)
    assert len(boxes_in_base(entry, ROBOT)) == len(entry.shapes)


def test_without_its_frames_nothing_is_known_of_it(told):
    entry, up, _ = told
    assert solids_at_tip(entry, {}) is None
    assert solids_at_tip(entry, {entry.seed_frame: up[entry.seed_frame]}) is None
