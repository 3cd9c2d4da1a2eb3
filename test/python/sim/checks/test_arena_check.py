"""What can be reached and mapped: rooms whose answers are known."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import List

import numpy as np
import pytest

from yarm.geometry import Pose2
from yarm.resources import package_root
from yarm.robots.turtlebot import RADIUS_M
from yarm.sim.checks.arena_check import arena_cells, check_arena, is_sound, mappable, narrow_passages
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.scenes.arena import Arena, Block, load_arena, shipped_arenas

WALLS = [
    Block("south", "wall", Pose2(0.0, -1.525), (4.1, 0.05, 0.6)),
    Block("north", "wall", Pose2(0.0, 1.525), (4.1, 0.05, 0.6)),
    Block("west", "wall", Pose2(-2.025, 0.0), (0.05, 3.1, 0.6)),
    Block("east", "wall", Pose2(2.025, 0.0), (0.05, 3.1, 0.6)),
]


def room(*blocks: Block, start: Pose2 = Pose2(-1.0, 0.0)) -> Arena:  # noqa: B008
    return Arena("t", "custom", 0, (-2.0, -1.5), (2.0, 1.5), (*WALLS, *blocks), start)


def split(door_m: float) -> List[Block]:
    length = 0.5 * (3.0 - door_m)
    y = 1.5 - 0.5 * length
    return [Block(f"half_{s}", "wall", Pose2(0.0, s * y), (0.05, length, 0.6)) for s in (-1, 1)]


def failed(arena: Arena) -> List[str]:
    return [finding.text for finding in check_arena(arena) if not finding.holds]


def test_an_empty_room_is_reached_and_seen_whole() -> None:
    seen = mappable(room())
    assert seen.cells.reachable.sum() * 0.0025 == pytest.approx((4.0 - 0.36) * (3.0 - 0.36), rel=0.06)
    assert seen.free.sum() * 0.0025 == pytest.approx(3.9 * 2.9, rel=0.01), "cells beside a wall count as neither"
    assert 270 < seen.faces.sum() < 290, "14 m of walls"
    assert not np.any(seen.free & seen.faces) and failed(room()) == []


def test_what_lies_behind_a_closed_wall_counts_for_nothing() -> None:
    arena = room(Block("shut", "wall", Pose2(0.0, 0.0), (0.05, 3.0, 0.6)))
    seen = mappable(arena)
    assert seen.free.sum() * 0.0025 == pytest.approx(1.9 * 2.9, rel=0.01)
    assert any("never be seen" in text for text in failed(arena)) and not is_sound(arena_cells(arena))


def test_what_is_seen_through_a_gap_counts_though_it_is_not_reached() -> None:
    seen = mappable(room(*split(0.30)))
    assert not seen.cells.reachable[:, 60:].any() and 6.3 < seen.free.sum() * 0.0025 < 11.5


@pytest.mark.parametrize(("door_m", "narrow"), [(0.50, True), (0.60, True), (0.70, False), (0.90, False)])
def test_narrow_doors_are_found(door_m: float, narrow: bool) -> None:
    found = narrow_passages(arena_cells(room(*split(door_m))))
    assert bool(found) == narrow
    if narrow:
        assert found[0] == pytest.approx((0.0, 0.0), abs=0.1)


def test_a_narrow_way_round_a_block_is_found_and_a_niche_is_not() -> None:
    beside = Block("block", "block", Pose2(0.0, -0.8), (0.4, 0.4, 0.6))
    assert narrow_passages(arena_cells(room(beside))) != [], "0.5 m between block and wall"
    flush = Block("block", "block", Pose2(0.0, -1.3), (0.4, 0.4, 0.6))
    assert narrow_passages(arena_cells(room(flush))) == []


def test_low_things_block_the_way_and_not_the_view() -> None:
    low = Block("low_1", "low", Pose2(0.0, 0.0), (0.2, 3.0, 0.1))
    seen = mappable(room(low))
    assert not seen.cells.reachable[:, 60:].any() and seen.free[:, 60:].sum() * 0.0025 == pytest.approx(
        1.45 * 2.9, rel=0.01
    )
    assert not seen.free[40, 50] and not seen.faces[40, 50], "the low wall itself is neither"


def test_starts_are_judged() -> None:
    touching = room(start=Pose2(-2.0 + RADIUS_M + 0.0005, 0.0))
    assert check_arena(touching)[0].text == "starts in contact" and failed(touching) == []
    assert any("inside something" in text for text in failed(room(start=Pose2(-1.9, 0.0))))
    box = [
        Block(f"b{i}", "block", Pose2(-1 + 0.25 * x, 0.25 * y), (0.1, 0.1, 0.6))
        for i, (x, y) in enumerate([(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)])
    ]
    assert any("enclosed" in text for text in failed(room(*box)))


def test_low_obstacles_have_limits() -> None:
    many = [Block(f"low_{i}", "low", Pose2(1.9, -1.2 + 0.3 * i), (0.1, 0.1, 0.1)) for i in range(7)]
    assert any("7 low obstacles" in text for text in failed(room(*many)))
    assert any("0.25 m tall" in text for text in failed(room(Block("low_1", "low", Pose2(1.9, 0), (0.1, 0.1, 0.25)))))


@pytest.mark.parametrize("name", shipped_arenas())
def test_shipped_arenas_keep_the_rules(name: str) -> None:
    assert failed(load_arena(name)) == []


def test_practice_has_what_it_is_to_have() -> None:
    practice = load_arena("practice")
    kinds = [block.kind for block in practice.blocks]
    assert kinds.count("low") >= 3 and kinds.count("block") >= 8
    assert {b.size[2] for b in practice.blocks if b.kind == "wall"} == {0.6}
    assert FlatBoxes(practice.blocks).distances(practice.start.x, practice.start.y).min() > RADIUS_M


def test_the_script_says_it_and_fails_when_it_is_so(tmp_path: Path) -> None:
    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        environment = {**os.environ, "PYTHONPATH": str(package_root() / "src")}
        command = [sys.executable, str(package_root() / "scripts" / "arena_check"), *arguments]
        return subprocess.run(command, capture_output=True, text=True, timeout=120, env=environment, check=False)

    good = run("practice")
    assert good.returncode == 0 and "can be mapped" in good.stdout and "FAIL" not in good.stdout
    text = (package_root() / "scenes" / "exploration" / "practice.yaml").read_text()
    (tmp_path / "shut.yaml").write_text(
        text.replace("name: brick_2, kind: low, x: -0.98,", "name: brick_2, kind: low, x: -1.2,")
    )
    bad = run(str(tmp_path / "shut.yaml"), "nowhere")
    assert bad.returncode == 1 and "FAIL a passage at (-1." in bad.stdout and "no such arena" in bad.stdout
