"""The chance of a look falls with what is hidden, the angle and the distance."""

from __future__ import annotations

import pytest

from python.tags.tag_views import BOX, camera_at, robot_at
from yarm.geometry import Pose2
from yarm.geometry.pinhole import BoxSize
from yarm.tags.chance import LookChance
from yarm.tags.face_view import FaceView

CHANCE = LookChance()


def test_it_falls_with_what_makes_a_look_worse() -> None:
    best = CHANCE.of(1.0, 0.0, 0.6)
    assert best > 0.95
    assert CHANCE.of(1.0, 45.0, 0.6) == CHANCE.of(1.0, -45.0, 0.6) == best
    assert best > CHANCE.of(0.5, 0.0, 0.6) > CHANCE.of(0.2, 0.0, 0.6)
    assert best > CHANCE.of(1.0, 55.0, 0.6) > CHANCE.of(1.0, -65.0, 0.6)
    assert best > CHANCE.of(1.0, 0.0, 1.2)
    assert CHANCE.of(0.0, 0.0, 0.6) == 0.0


def test_a_planned_view_counts_what_hides_the_face() -> None:
    def at(angle: float, *others: Pose2) -> float:
        view = FaceView(camera_at(robot_at(0.8, angle)), BOX, others=tuple((pose, BoxSize()) for pose in others))
        return CHANCE.of_view(view)

    assert at(0.0) > 0.9
    assert at(0.0) > at(0.0, BOX.compose(Pose2(0.3, 0.25, 0.0))) + 0.03
    assert at(0.0) == pytest.approx(at(0.0, BOX.compose(Pose2(-0.5, 0.0, 0.0))))
    assert at(60.0) < at(30.0)
    assert at(180.0) == 0.0
