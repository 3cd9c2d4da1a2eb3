"""The instances with hardly room to move: the same for the same seed, and with the answer that their family says."""

from __future__ import annotations

import pytest

from yarm.planning.scenes.crowded import CROWDS, HARD, HOPELESS, make_crowded
from yarm.planning.scenes.joint_oracle import TooLargeError, least_cost


@pytest.mark.parametrize("family", sorted({*HARD, *HOPELESS}))
def test_the_same_for_the_same_seed_and_others_for_others(family: str) -> None:
    one, again = make_crowded(family, 3).scene, make_crowded(family, 3).scene
    stands = [tuple(robot.start for robot in scene.robots) for scene in (one, again)]
    assert stands[0] == stands[1] and one.boxes == again.boxes
    goals = [{name: goal.column for name, goal in scene.goals.items()} for scene in (one, again)]
    assert goals[0] == goals[1]
    others = [make_crowded(family, seed).scene for seed in (4, 5, 6)]
    assert any(other.robots != one.robots or other.boxes != one.boxes for other in others)


@pytest.mark.parametrize("family", sorted({*HARD, *HOPELESS}))
def test_what_is_said_of_small_ones_is_so_by_brute_force(family: str) -> None:
    """Of a dozen seeds those that can be looked through; a family of large ones only may have none."""
    for seed in range(12):
        try:
            least = least_cost(make_crowded(family, seed).scene, (), 200_000)
        except TooLargeError:
            continue
        assert (least is None) == (family in HOPELESS), f"{family} {seed}: least cost {least}"


@pytest.mark.parametrize(("family", "count"), [("crowd_60", 60), ("crowd_40", 40), ("puzzle_15", 15), ("puzzle_7", 7)])
def test_as_many_robots_as_the_name_says(family: str, count: int) -> None:
    scene = make_crowded(family, 1).scene
    assert family in {**HARD, **CROWDS} and len(scene.robots) == count == len(scene.assignments)


def test_unknown_families_are_refused() -> None:
    with pytest.raises(KeyError):
        make_crowded("no such", 0)
