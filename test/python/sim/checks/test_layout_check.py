"""How much of a tag a camera sees: the printed shares, what hides it, and where the disc cannot go."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Tuple

import pytest

from yarm.geometry import Pose2
from yarm.resources import package_root
from yarm.robots.turtlebot import RGB_MOUNT
from yarm.sim.checks.layout_check import DISC_M, sights, visible_share
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.scenes.arena import Arena, Block
from yarm.sim.scenes.layout import Layout

SIZE = (0.16, 0.50, 0.40)
FACING_X = Block("box_1", "box", Pose2(0.0, 0.0, 0.0), SIZE)


def layout(*more: Block, start: Tuple[float, float] = (2.0, 0.0)) -> Layout:
    arena = Arena("small", "custom", 0, (-3.0, -3.0), (3.0, 3.0), (FACING_X, *more), Pose2(*start))
    return Layout(arena, (1,) * (1 + sum(block.kind == "box" for block in more)))


def before(distance_m: float, aside_m: float = 0.0) -> Pose2:
    """The robot's base so far before the middle of the box, its camera looking back at it."""
    return Pose2(distance_m, aside_m - RGB_MOUNT.y, 3.14159265)


def test_the_script_says_of_each_tag_from_where_it_is_seen_and_fails_when_one_is_not(tmp_path: Path) -> None:
    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        environment = {**os.environ, "PYTHONPATH": str(package_root() / "src")}
        command = [sys.executable, str(package_root() / "scripts" / "arena_check"), "--layouts", *arguments]
        return subprocess.run(command, capture_output=True, text=True, timeout=120, env=environment, check=False)

    good = run()
    assert good.returncode == 0 and good.stdout.count("  ok   box ") == 10, good.stdout
    scenes = package_root() / "scenes" / "inspection"
    text = (scenes / "practice.yaml").read_text()
    boxes = (scenes / "practice_boxes.yaml").read_text()
    turned = boxes.replace("x: -1.99914, y: -2.13877, phi: 2.34732", "x: -2.20, y: -2.13877, phi: 3.14159")
    assert turned != boxes
    (tmp_path / "turned.yaml").write_text(text)
    (tmp_path / "practice_boxes.yaml").write_text(turned)
    bad = run(str(tmp_path / "turned.yaml"), "nowhere_1")
    assert bad.returncode == 1 and "no such layout" in bad.stdout, bad.stdout
    assert "FAIL box 5: 0 % of its face is seen from nowhere" in bad.stdout, bad.stdout


def test_half_a_metre_away_the_robot_hides_the_lower_third() -> None:
    assert visible_share(layout(), 1, before(0.5)) == pytest.approx(0.64, abs=0.07)


def test_farther_away_more_is_seen() -> None:
    shares = [visible_share(layout(), 1, before(distance)) for distance in (0.4, 0.5, 0.6, 0.8, 1.0)]
    assert shares == sorted(shares) and shares[-1] >= 0.9


def test_from_behind_and_looking_away_nothing_is_seen() -> None:
    assert visible_share(layout(), 1, Pose2(-1.0, 0.0, 0.0)) == 0.0
    assert visible_share(layout(), 1, Pose2(1.0, 0.0, 0.0)) == 0.0


def test_a_box_in_the_way_hides_its_share() -> None:
    half = Block("box_2", "box", Pose2(0.45, 0.25, 0.0), (0.05, 0.50, 0.40))
    alone, hidden = visible_share(layout(), 1, before(1.2)), visible_share(layout(half), 1, before(1.2))
    assert 0.3 * alone < hidden < 0.7 * alone
    assert visible_share(layout(Block("box_2", "box", Pose2(0.4, 0.0), (0.05, 1.5, 0.4))), 1, before(1.2)) == 0.0


def test_what_is_low_hides_nothing() -> None:
    brick = Block("low_1", "low", Pose2(0.4, 0.0), (0.1, 1.0, 0.1))
    assert visible_share(layout(brick), 1, before(1.2)) == visible_share(layout(), 1, before(1.2))


def test_the_best_look_is_from_where_the_disc_fits_and_gets_to() -> None:
    room = layout(Block("wall_1", "wall", Pose2(0.75, 0.0), (0.05, 4.0, 0.6)))
    sight = sights(room)[0]
    assert sight.pose is not None and sight.share > 0.3
    assert FlatBoxes(room.arena.blocks).distances(sight.pose.x, sight.pose.y).min() >= DISC_M
    closed = layout(
        Block("wall_1", "wall", Pose2(1.2, 0.0), (0.05, 3.0, 0.6)),
        Block("wall_2", "wall", Pose2(-1.2, 0.0), (0.05, 3.0, 0.6)),
        Block("wall_3", "wall", Pose2(0.0, 1.5), (2.5, 0.05, 0.6)),
        Block("wall_4", "wall", Pose2(0.0, -1.5), (2.5, 0.05, 0.6)),
    )
    assert sights(closed)[0].pose is None and sights(closed)[0].share == 0.0
