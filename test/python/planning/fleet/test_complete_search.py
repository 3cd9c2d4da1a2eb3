"""The complete search: held against a brute-force search over all places, never wrong, near the optimum, repeatable."""

from __future__ import annotations

from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np
import pytest

from python.planning.fleet_samples import FLEETS, SPEC, fleet_of, goals
from python.planning.samples import block, robot, walls
from yarm.planning.cspace.robot_space import ShapeCache
from yarm.planning.fleet.complete_search import CompleteSearch, make_complete_search
from yarm.planning.fleet.fleet import Fleet
from yarm.planning.fleet.joint_native import Outcome, library_path
from yarm.planning.fleet.joint_plan import valid
from yarm.planning.fleet.problem import PlanningProblem, turns_of
from yarm.planning.roadmap.roadmap import Roadmap
from yarm.planning.scenes.coordination import (
    COORDINATED,
    IMPOSSIBLE,
    drawn,
    free_slots,
    make_coordinated,
    random_scene,
    slot_scene,
)
from yarm.planning.scenes.crowded import CROWDS, HARD, HOPELESS, make_crowded
from yarm.planning.scenes.joint_oracle import TooLargeError, least_cost
from yarm.planning.scenes.scene import PlanScene

pytestmark = pytest.mark.skipif(library_path() is None, reason="the package is not built")
TURNS = (0.0, 90.0, -90.0)


def fleet_in(scene: PlanScene, turns_deg: Sequence[float] = TURNS) -> Fleet:
    problem = PlanningProblem.of(scene.request(), turns_of(turns_deg), ShapeCache())
    assert problem is not None
    return Fleet(problem.spaces, problem.targets, Roadmap.of(np.zeros((0, 2), dtype=np.int64)))


def searched(fleet: Fleet) -> Tuple[CompleteSearch, Optional[List]]:
    wanted = [i for i, target in enumerate(fleet.targets) if target is not None]
    search = CompleteSearch(fleet, wanted)
    moves = search.run(fleet)
    assert moves is None or valid(fleet, moves, wanted)
    return search, moves


def held_against_brute_force(scene: PlanScene, turns_deg: Sequence[float], what: str) -> float:
    """Both agree; cost over the least, 1 where there is no way at all or none is needed."""
    least = least_cost(scene, turns_deg)
    fleet = fleet_in(scene, turns_deg)
    search, moves = searched(fleet)
    if least is None:
        assert search.proved and moves is None, f"{what}: {search.outcome}, brute force found no way"
        return 1.0
    assert moves is not None, f"{what}: {search.outcome}, brute force found a way of {least}"
    return fleet.cost(moves) / least if least else 1.0


def test_what_was_found_is_given_again() -> None:
    """A planner may ask once more for the same: when its memory was of other goals meanwhile."""
    fleet = fleet_in(SMALL["swap at a bay"])
    search, moves = searched(fleet)
    assert moves and search.run(fleet) == moves


@pytest.mark.parametrize("turns_deg", [TURNS, (0.0,)])
def test_random_fleets_as_brute_force_says(turns_deg: Sequence[float]) -> None:
    """Robots of different shapes and heights among boxes, goals wherever they fit."""
    ratios, impossible = [], 0
    for seed in range(70):
        scene = random_scene(np.random.default_rng([4000, seed]))
        if scene is not None:
            ratios.append(held_against_brute_force(scene, turns_deg, f"seed {seed}, turns {turns_deg}"))
            impossible += least_cost(scene, turns_deg) is None
    assert impossible >= 8 and len(ratios) >= 40
    assert np.median(ratios) <= 1.1 and np.percentile(ratios, 90) <= 1.4


SMALL: Dict[str, PlanScene] = {
    "swap at a bay": slot_scene(["......", "##.###"], 1, ((0, 0), (5, 0)), ((5, 0), (0, 0))),
    "swap of large ones": slot_scene([".....", "#.###"], 3, ((0, 0), (4, 0)), ((4, 0), (0, 0))),
    "swap without a bay": slot_scene(["......"], 1, ((0, 0), (5, 0)), ((5, 0), (0, 0))),
    "three in a ring": slot_scene(["..", ".."], 2, ((0, 0), (1, 0), (1, 1)), ((1, 0), (1, 1), (0, 1))),
    "ring the wrong way": slot_scene(["..", ".."], 1, ((0, 0), (1, 0), (1, 1)), ((1, 0), (0, 0), (1, 1))),
    "one free place": slot_scene(
        ["...", "..."], 1, ((0, 0), (1, 0), (2, 0), (0, 1), (1, 1)), ((1, 0), (2, 0), (2, 1), (0, 0), (0, 1))
    ),
    "side pocket": slot_scene(["....", "..##"], 1, ((3, 0), (0, 0), (0, 1)), ((0, 1), (3, 0), (0, 0))),
    "tee": slot_scene([".....", "##.##", "##.##"], 1, ((0, 0), (4, 0), (2, 2)), ((4, 0), (0, 0), (2, 2))),
    "somebody idle in the lane": slot_scene([".....", "##.##"], 2, ((0, 0), (2, 0)), ((4, 0), None)),
    "idle without a bay": slot_scene(["....."], 1, ((0, 0), (2, 0)), ((4, 0), None)),
}
"""Scenes that only a joint search decides, small enough for brute force."""


@pytest.mark.parametrize("name", sorted(SMALL))
def test_small_scenes_as_brute_force_says(name: str) -> None:
    assert held_against_brute_force(SMALL[name], (0.0,), name) <= 1.1


def test_brute_force_itself_tells_ways_from_none() -> None:
    """Known by counting: a swap at a bay of one-cell carts, five places two cells apart, and two cells into the bay."""
    assert least_cost(SMALL["swap at a bay"], ()) == 2 * 5 * 2 + 2 * 2
    assert least_cost(SMALL["swap without a bay"], ()) is None
    assert least_cost(SMALL["three in a ring"], ()) == 3 * 3
    assert least_cost(SMALL["ring the wrong way"], ()) is None
    with pytest.raises(TooLargeError):
        least_cost(make_coordinated("puzzle", 0).scene)


@pytest.mark.parametrize("family", sorted(set(COORDINATED) - {"turning"}))
def test_families_are_solved(family: str) -> None:
    for seed in (1, 2):
        search, moves = searched(fleet_in(make_coordinated(family, seed).scene))
        assert moves is not None, f"{family} {seed}: {search.outcome}"


def test_impossible_families_are_proved() -> None:
    for family, seed in (("no_bay", 1), ("no_bay", 2), ("wrong_parity", 9)):
        assert family in IMPOSSIBLE
        search, moves = searched(fleet_in(make_coordinated(family, seed).scene))
        assert moves is None and search.proved, f"{family} {seed}: {search.outcome}"


@pytest.mark.parametrize("family", sorted({*HARD, *CROWDS}))
def test_families_with_hardly_room_are_solved(family: str) -> None:
    for seed in (3, 5):
        search, moves = searched(fleet_in(make_crowded(family, seed).scene))
        assert moves is not None, f"{family} {seed}: {search.outcome}"


@pytest.mark.parametrize("family", sorted(HOPELESS))
def test_hopeless_families_are_proved(family: str) -> None:
    for seed in (1, 2, 3):
        search, moves = searched(fleet_in(make_crowded(family, seed).scene))
        assert moves is None and search.proved, f"{family} {seed}: {search.outcome}"


def test_orders_of_equal_robots_as_brute_force_says() -> None:
    """Random orders, some with an idle robot, in a frame, a ring, a corridor, a tee."""
    rng, ends = np.random.default_rng(77), {"found": 0, "exchange": 0}
    plans = (["...", "..."], ["..", ".."], ["....", ".##.", "...."], ["....."], [".....", "##.##"])
    for _ in range(60):
        rows = plans[int(rng.integers(len(plans)))]
        slots = free_slots(rows)
        count = min(5, int(rng.integers(2, len(slots))))
        starts, ends_at = drawn(rng, slots, count), drawn(rng, slots, count)
        wanted = [*ends_at[:-1], None if rng.random() < 0.3 else ends_at[-1]]
        fleet = fleet_in(slot_scene(rows, 1, starts, wanted), (0.0,))
        least = least_cost(slot_scene(rows, 1, starts, wanted), ())
        search, moves = searched(fleet)
        assert (moves is None) == (least is None) and search.proved == (least is None), f"{rows} {starts} {wanted}"
        ends["found"] += moves is not None
        ends["exchange"] += search.by_exchange
    assert ends["found"] >= 15 and ends["exchange"] >= 5, ends


def test_an_odd_permutation_of_fifteen_pieces_is_proved_without_their_places_being_tried() -> None:
    """16! / 2 places could not be; the same pieces in an even permutation can be reached."""
    search, moves = searched(fleet_in(make_crowded("odd_15", 5).scene))
    assert moves is None and search.proved and search.by_exchange and search.visited < 1_000_000


@pytest.mark.parametrize("name", sorted(FLEETS))
def test_found_again_the_same(name: str) -> None:
    first, again = searched(FLEETS[name]), searched(FLEETS[name])
    assert first[1] is not None and first[1] == again[1]
    assert first[0].visited == again[0].visited


def test_goes_on_where_it_stopped() -> None:
    """In small portions it visits the same places, and in the end says the same."""
    fleet = fleet_in(make_crowded("yard", 4).scene)
    whole, parts = (CompleteSearch(fleet, range(len(fleet.spaces))) for _ in range(2))
    assert whole.outcome_within(10**9) is Outcome.FOUND
    count = 0
    while parts.outcome_within(1) is Outcome.OPEN:
        count += 1
    assert parts.outcome is Outcome.FOUND and count > 3
    assert (parts.visited, parts.work) == (whole.visited, whole.work)


def test_memory_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("yarm.planning.fleet.complete_search.MEMORY_BYTES", 16 << 10)
    fleet = fleet_in(make_coordinated("wrong_parity", 0).scene)
    search = CompleteSearch(fleet, range(len(fleet.spaces)))
    assert search.outcome_within(10**10) is Outcome.FULL
    assert not search.proved and search.visited < 50_000


def test_nothing_is_proved_of_robots_that_start_within_a_margin() -> None:
    corridor = walls(SPEC, [(0, 30, 0, 10), (0, 30, 13, 24)])
    beside = [robot("a", (8, 11), block(1, 1)), robot("b", (9, 11), block(1, 1))]
    search, moves = searched(fleet_of(beside, goals((27, 11), (2, 11)), corridor))
    assert moves is None and search.outcome is Outcome.IMPOSSIBLE and not search.proved
    apart = [robot("a", (8, 11), block(1, 1)), robot("b", (10, 11), block(1, 1))]
    search, moves = searched(fleet_of(apart, goals((27, 11), (2, 11)), corridor))
    assert moves is None and search.proved


def test_goals_on_which_two_cannot_stand_together_are_refused_at_once() -> None:
    fleet = fleet_of([robot("a", (2, 2), block(2, 2)), robot("b", (2, 12), block(2, 2))], goals((26, 12), (26, 13)))
    search, moves = searched(fleet)
    assert moves is None and search.proved and search.visited == 0


def test_without_the_library_there_is_no_complete_search(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("yarm.planning.fleet.complete_search.library_path", lambda: None)
    assert make_complete_search(FLEETS["swap"], (0, 1)) is None
