"""Made arenas: the same for the same name, and all hundred keep the rules."""

from __future__ import annotations

import numpy as np
import pytest

from yarm.robots.turtlebot import RADIUS_M
from yarm.sim.checks.arena_check import arena_cells, check_arena, is_sound
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.kinematic.world import KinematicWorld
from yarm.sim.scenes.arena_maker import KINDS, benchmark_names, find_arena, make_arena, outline_of
from yarm.yaml_fields import SceneError


def test_a_name_always_means_the_same_arena() -> None:
    assert make_arena("bricks", 3) == find_arena("bricks_3") != make_arena("bricks", 4)


def test_other_names_are_looked_for_in_files() -> None:
    assert find_arena("practice").kind == "practice"
    with pytest.raises(SceneError, match="no such arena"):
        find_arena("halls_3")
    with pytest.raises(ValueError, match="kind 'halls' is not known"):
        make_arena("halls", 3)


def test_all_hundred_are_sound_and_can_be_started() -> None:
    names = benchmark_names()
    assert len(set(names)) == 100 and names[:4] == tuple(f"{kind}_0" for kind in KINDS)
    touching = 0
    for name in names:
        arena = find_arena(name)
        assert is_sound(arena_cells(arena)), name
        gap = FlatBoxes(arena.blocks).distances(arena.start.x, arena.start.y).min()
        touching += gap < RADIUS_M + 0.001
        KinematicWorld(arena, 0)
        low = [block for block in arena.blocks if block.kind == "low"]
        assert len(low) <= 6 and all(0.05 <= block.size[2] <= 0.20 for block in low), name
        assert arena.kind != "bricks" or len(low) >= 3, name
        assert all(block.size[2] == 0.6 for block in arena.blocks if block.kind != "low")
    assert touching == 10, "one in ten starts against a wall"


@pytest.mark.parametrize("kind", KINDS)
def test_one_of_each_kind_passes_every_check(kind: str) -> None:
    arena = make_arena(kind, 11)
    assert [finding.text for finding in check_arena(arena) if not finding.holds] == []


def test_an_outline_goes_round() -> None:
    block = make_arena("clutter", 0).blocks[0]
    outline = outline_of(block, 0.05)
    steps = np.hypot(*(np.roll(outline, -1, axis=0) - outline).T)
    assert steps.max() <= 0.05 + 1e-9 and steps.sum() == pytest.approx(2 * (block.size[0] + block.size[1]))
    assert np.abs(FlatBoxes([block]).signed(outline)).max() < 1e-9
