"""Verdicts on tags as a round takes them, and what viewpoints promise."""

from __future__ import annotations

from dataclasses import replace
from typing import Optional, Sequence

import pytest

from yarm.geometry import Pose2
from yarm.geometry.pinhole import BoxSize
from yarm.geometry.scans import Scan
from yarm.inspection.boxes import Box
from yarm.inspection.model import BLANK, UNKNOWN, UNSEEN, Reading
from yarm.inspection.reading import chances, face_view, reading_of, stands
from yarm.inspection.viewpoints import viewpoint
from yarm.sim.kinematic.world import KinematicWorld
from yarm.sim.scenes.arena import Arena, Block
from yarm.tags import calibration
from yarm.tags.chance import LookChance
from yarm.tags.evidence import TagVerdict
from yarm.tags.recogniser import Finding

BOX = Box(3, Pose2(1.0, -2.0, 0.7))


def verdict(answer: Optional[int], finding: Finding, measured: Optional[Pose2] = None) -> TagVerdict:
    return TagVerdict(3, answer, 0.9 if answer is not None else 0.0, {}, finding, measured, 4, 1, "")


def test_both_name_blank_and_unknown_alike() -> None:
    assert (BLANK, UNKNOWN) == (calibration.BLANK, calibration.UNKNOWN)


def test_answers_and_how_the_box_stands() -> None:
    assert reading_of(verdict(7, Finding.IN_PLACE, Pose2(1.02, -2.0, 0.7)), BOX) == Reading(7, 0.9)
    assert reading_of(verdict(7, Finding.UPSIDE_DOWN), BOX) == Reading(7, 0.9, 0.0, "upside down")
    assert reading_of(verdict(None, Finding.MISSING), BOX) == Reading(UNSEEN, 0.0, 0.0, "missing")
    assert reading_of(verdict(None, Finding.NOT_SEEN), BOX) == Reading()
    moved = reading_of(verdict(7, Finding.MOVED, Pose2(1.3, -1.6, 0.7)), BOX)
    assert moved.moved_m == pytest.approx(0.5)


def test_a_viewpoint_promises_less_from_the_side_and_behind_another_box() -> None:
    hiding = Box(4, BOX.pose.compose(Pose2(0.3, 0.25, 0.0)))
    free, hidden = chances([BOX], LookChance()), chances([BOX, hiding], LookChance())
    assert free(BOX, viewpoint(BOX, 0.8, 0)) > 0.9
    assert free(BOX, viewpoint(BOX, 0.8, 60)) < free(BOX, viewpoint(BOX, 0.8, 30))
    assert hidden(BOX, viewpoint(BOX, 0.8, 0)) < free(BOX, viewpoint(BOX, 0.8, 0)) - 0.03


def test_a_box_does_not_hide_itself() -> None:
    view = face_view(viewpoint(BOX, 0.8, 0).pose, BOX, [BOX, Box(4, Pose2(9.0, 9.0))])
    assert [pose for pose, _ in view.others] == [Pose2(9.0, 9.0)]
    assert view.size.depth == BOX.size.depth


def scan_of(blocks: Sequence[Block], robot: Pose2) -> Scan:
    arena = Arena("a", "custom", 0, (-9.0, -9.0), (9.0, 9.0), (*WALL, *blocks), robot)
    return KinematicWorld(arena, 1).scan()


WALL = (Block("wall", "wall", BOX.pose.compose(Pose2(-2.0, 0.0)), (0.05, 9.0, 0.6)),)
BODY = Block("box", "box", BOX.pose, (BOX.size.depth, BOX.size.width, BOX.size.height))


@pytest.mark.parametrize("distance_m, angle_deg", [(0.7, 0), (0.95, 40), (0.8, -60)])
def test_a_scan_tells_a_box_from_none(distance_m: float, angle_deg: int) -> None:
    robot = viewpoint(BOX, distance_m, angle_deg).pose
    assert stands(scan_of([BODY], robot), robot, BOX) is True
    assert stands(scan_of([], robot), robot, BOX) is False


def test_a_scan_tells_nothing_of_what_is_hidden_behind_or_beside_it() -> None:
    robot = viewpoint(BOX, 1.5, 0).pose
    screen = Block("screen", "box", BOX.pose.compose(Pose2(0.6, 0.0)), (0.05, 0.6, 0.4))
    assert stands(scan_of([screen], robot), robot, BOX) is None
    away = robot.compose(Pose2(0.0, 0.0, 2.0))
    assert stands(scan_of([BODY], away), away, BOX) is None
    behind = BOX.pose.compose(Pose2(-1.2, 0.0))
    assert stands(scan_of([BODY], behind), behind, BOX) is None


def test_a_scan_passes_over_a_box_that_is_lower_than_it() -> None:
    robot = viewpoint(BOX, 0.8, 0).pose
    low = replace(BOX, size=BoxSize(height=0.2))
    assert stands(scan_of([], robot), robot, low) is None


def test_what_the_scan_says_goes_into_the_view() -> None:
    robot = viewpoint(BOX, 0.8, 0).pose
    assert face_view(robot, BOX, [BOX], False).stands is False and face_view(robot, BOX, [BOX]).stands is None
