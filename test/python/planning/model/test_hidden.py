"""Cells that no camera sees: what they count as, and who is said to hide them. Drawn maps; a cell is 10 cm."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from yarm.geometry import CellMap, CellState, GridSpec, MappedObject, Visibility
from yarm.geometry.cell_map import NO_HIDER, OTHER_HIDERS
from yarm.planning.model.hidden import HiddenParams, HiddenPolicy, HiddenSpace

SPEC = GridSpec((20, 20, 6), (0.0, 0.0, 0.0), (2.0, 2.0, 0.6))
KNOWN = HiddenParams(HiddenPolicy.KNOWN_BODIES, age_s=1.0, speed_m_s=1.5, least_m=0.0, starts_clear=True)
PERIOD_S = 1.0 / 30.0
BEHIND = (slice(8, 12), slice(8, 12), slice(0, 3))
"""What the box in the middle hides."""


def block(x, y, z=(0, 3)):
    return np.stack(np.meshgrid(*(np.arange(*r) for r in (x, y, z)), indexing="ij"), axis=-1).reshape(-1, 3)


def body(name, cells, kind="Obstacle"):
    return MappedObject(name, kind, 1, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), np.asarray(cells))


def in_box(cell, box):
    return all(part.start <= value < part.stop for value, part in zip(cell, box))


ROBOT = body("ankurbot_1", block((4, 8), (8, 12)), "Mobile")


class Maps:
    """Maps one period apart, told to a HiddenSpace."""

    def __init__(self, params=KNOWN):
        self.space = HiddenSpace(params)
        self.now_s = 0.0
        self.ever = np.zeros(SPEC.shape, dtype=bool)

    def see(self, hidden=(), objects=(ROBOT,), bits=1, periods=1, seen=(), robots=()):
        """So many maps in which the cells of ``hidden`` (slices) are hidden by the objects with ``bits``."""
        for _ in range(periods):
            self.now_s += PERIOD_S
            states = np.full(SPEC.shape, CellState.FREE, dtype=np.int8)
            hidden_by = np.zeros(SPEC.shape, dtype=np.uint32)
            for where in (hidden,) if hidden else ():
                states[where] = np.where(self.ever[where], CellState.HIDDEN, CellState.NEVER_SEEN)
                hidden_by[where] = bits
            for thing in objects:
                states[tuple(thing.cells.T)] = CellState.OCCUPIED
            for where in seen:
                states[where] = CellState.OCCUPIED
            sight = Visibility(states, hidden_by[states < CellState.FREE])
            self.ever |= states >= CellState.FREE
            grid = np.zeros(SPEC.shape, dtype=np.int8)
            self.space.see(CellMap(self.now_s, SPEC, grid, {o.name: o for o in objects}, sight), robots)
        return self

    @property
    def count(self):
        return int(np.count_nonzero(self.space.occupied))


def test_what_is_hidden_by_a_registered_body_stays_free_however_long():
    maps = Maps().see()
    assert maps.see(BEHIND, periods=90).count == 0
    assert maps.space.by_hider() == {}


def test_what_is_hidden_when_somebody_takes_over_is_not_known_to_be_free_until_it_is_seen():
    maps = Maps().see().see(BEHIND)
    maps.space.begin_unwatched()
    assert maps.see(BEHIND, periods=90).count == 48
    assert maps.see().see(BEHIND, periods=90).count == 0
    maps.space.begin_unwatched()
    maps.space.forget()
    assert maps.see(BEHIND).count == 0, "the simulator was started again, and begins as the scene says"


def test_what_was_told_before_the_start_is_forgotten():
    maps = Maps().see().see(BEHIND, bits=NO_HIDER, periods=90)
    assert maps.count == 48
    maps.space.start()
    assert maps.space.fault(maps.now_s, 1.0) == ""
    assert maps.see(BEHIND, periods=90).count == 0, "a registered body hides it, and at the start nothing was there"


def test_what_something_else_hides_is_free_for_a_while_only():
    crate = body("unknown_1", block((1, 3), (1, 3)))
    for bits in (NO_HIDER, NO_HIDER | 1, 2):
        maps = Maps().see(objects=(ROBOT, crate))
        assert maps.see(BEHIND, (ROBOT, crate), bits, periods=25).count == 0, bits
        assert maps.see(BEHIND, (ROBOT, crate), bits, periods=10).count == 4 * 4 * 3, bits
        assert maps.see(objects=(ROBOT, crate)).count == 0, "seen again"


def test_a_gap_counts_until_the_cells_are_seen_again():
    maps = Maps().see().see(BEHIND, bits=NO_HIDER).see(BEHIND, periods=25)
    assert maps.count == 0
    assert maps.see(BEHIND, periods=10).count == 48
    assert maps.see().see(BEHIND, periods=60).count == 0


def test_a_thing_that_walks_into_the_shadow_may_be_anywhere_it_could_have_reached():
    maps = Maps().see()
    beside, step = body("unknown_1", block((12, 14), (9, 11))), 0.1 / 1.5
    maps.see(BEHIND, (ROBOT, beside))
    assert 0 < maps.count <= 4 * 4 * 3
    maps.see(BEHIND, periods=math.ceil(4 * step / PERIOD_S))
    assert maps.count == 48, "it may be anywhere behind the robot, and nobody has seen it leave"
    assert maps.see(BEHIND, periods=300).count == 48
    assert maps.see(seen=[BEHIND]).see(BEHIND).count > 0, "it is there, and is hidden again"
    assert maps.see().see(BEHIND, periods=300).count == 0, "it is not there"


@pytest.mark.parametrize(("robots", "count"), [((ROBOT.cells,), 0), ((), 8)], ids=["drawn", "not drawn"])
def test_nothing_else_is_within_a_robot_for_whose_points_nobody_had_a_name(robots, count):
    """Seen without its name for a moment, it is a thing where the robot stands, and no camera sees its inside."""
    inside = np.s_[5:7, 9:11, 0:2]
    shell = body("ankurbot_1", [cell for cell in ROBOT.cells.tolist() if not in_box(cell, inside)], "Mobile")
    maps = Maps().see(inside, (shell,), robots=robots)
    maps.see(inside, (replace(shell, name="unknown_1", kind="Unknown"),), robots=robots)
    assert maps.see(inside, (shell,), periods=30, robots=robots).count == count


def test_what_the_cameras_see_and_nobody_believes_yet_may_walk_into_the_shadow_too():
    assert Maps().see().see(BEHIND, seen=[np.s_[13:14, 9:12, 1:2]]).count == 0, "two cells away"
    assert Maps().see().see(BEHIND, seen=[np.s_[12:13, 9:12, 1:2]]).count == 12
    assert Maps().see().see(BEHIND, seen=[np.s_[12:13, 9:11, 1:2]]).count == 0, "noise"
    at_robot = np.s_[5:8, 12:13, 1:2]
    assert Maps().see().see(BEHIND, seen=[at_robot]).count == 0, "a registered body's edge, for all that noise tells"


def test_nobody_comes_through_what_is_seen():
    far = body("unknown_1", block((15, 17), (9, 11)))
    maps = Maps().see(objects=(ROBOT, far))
    assert maps.see(BEHIND, (ROBOT, far), periods=90).count == 0


def test_nobody_comes_through_a_registered_body():
    wall = body("wall", block((12, 13), (0, 20), (0, 6)))
    beside = body("unknown_1", block((14, 16), (9, 11)))
    beyond = (slice(8, 14), slice(8, 12), slice(0, 3))
    maps = Maps().see(objects=(ROBOT, wall, beside))
    maps.see(beyond, (ROBOT, wall, beside), periods=60)
    assert np.argwhere(maps.space.occupied)[:, 0].min() == 13


def test_from_outside_something_may_come_in_where_nobody_sees_the_border():
    lane = (slice(8, 20), slice(8, 12), slice(0, 3))
    maps = Maps().see().see(lane)
    assert maps.count == 12, "the border"
    assert maps.see(lane, periods=3).count == 4 * 12, "no faster than it moves, in whole cells"
    low = (slice(8, 12), slice(8, 12), slice(0, 1))
    assert Maps().see().see(low, periods=90).count == 0, "nobody comes through the floor"


@pytest.mark.parametrize(("bits", "count"), [(1, 0), (2, 0), (NO_HIDER, 144), (NO_HIDER | 1, 144)])
def test_in_a_fenced_cell_nothing_comes_in_behind_what_registered_bodies_alone_hide(bits, count):
    lane = (slice(8, 20), slice(8, 12), slice(0, 3))
    table = body("table", block((2, 4), (2, 4)))
    maps = Maps(replace(KNOWN, fenced=True)).see(objects=(ROBOT, table))
    assert maps.see(lane, (ROBOT, table), bits, periods=25).count == count
    assert maps.see(lane, (ROBOT, table), periods=90).count == count, "what came in may be there still"
    assert maps.see(objects=(ROBOT, table)).see(lane, (ROBOT, table), periods=90).count == 0, "seen again"


def test_points_without_a_name_for_a_moment_are_no_gap_for_what_takes_longer_to_come_in():
    lane = (slice(8, 20), slice(8, 12), slice(0, 3))
    params = replace(KNOWN, fenced=True, least_m=0.3)
    for periods, count in ((5, 0), (8, 144)):
        maps = Maps(params).see().see(lane, bits=NO_HIDER | 1, periods=periods)
        assert maps.see(lane, periods=90).count == count, f"0.2 s are enough for 0.3 m at 1.5 m/s, not {periods} maps"
    maps = Maps(params).see()
    for _ in range(20):
        maps.see(lane, bits=NO_HIDER | 1, periods=4).see(lane)
    assert maps.count == 0, "never long enough at a time"


def test_nothing_comes_in_where_there_is_no_room_for_it():
    lane, slit = (slice(8, 20), slice(8, 12), slice(0, 3)), (slice(15, 20), slice(8, 9), slice(0, 3))
    maps = Maps(replace(KNOWN, fenced=True, least_m=0.3)).see()
    assert maps.see(lane).see(slit, bits=NO_HIDER, periods=9).see(lane, periods=90).count == 0


def test_in_a_fenced_cell_who_was_seen_may_still_go_behind_a_robot():
    beside = body("unknown_1", block((12, 14), (9, 11)))
    maps = Maps(replace(KNOWN, fenced=True)).see().see(BEHIND, (ROBOT, beside))
    assert maps.see(BEHIND, periods=30).count == 48


@pytest.mark.parametrize(("fenced", "count"), [(False, 144), (True, 0)])
def test_a_pause_between_maps_counts_as_time_to_move(fenced, count):
    lane = (slice(8, 20), slice(8, 12), slice(0, 3))
    maps = Maps(replace(KNOWN, fenced=fenced)).see()
    maps.now_s += 1.0
    assert maps.see(lane).count == count


@pytest.mark.parametrize(
    ("where", "least_m", "counts"),
    [
        (np.s_[8:12, 8:12, 0:3], 0.25, 48),
        (np.s_[8:10, 8:12, 0:3], 0.35, 0),
        (np.s_[8:10, 8:12, 0:3], 0.25, 24),  # and a cell of the robot's skin, which both may share
        (np.s_[8:9, 8:12, 0:3], 0.25, 0),
        (np.s_[12:14, 8:12, 0:3], 0.25, 0),
        (np.s_[12:15, 8:12, 0:2], 0.25, 0),
        (np.s_[12:14, 8:12, 0:3], 0.2, 24),
        (np.s_[19:20, 8:12, 3:6], 0.25, 12),  # it may reach out of the volume
        (np.s_[12:15, 8:12, 5:6], 0.25, 12),
    ],
)
def test_only_where_there_is_room_for_it_may_something_be(where, least_m, counts):
    params = replace(KNOWN, least_m=least_m)
    assert Maps(params).see().see(where, bits=NO_HIDER, periods=40).count == counts


@pytest.mark.parametrize(("starts_clear", "occupied"), [(True, 0), (False, 48)])
def test_what_was_never_seen_is_free_only_where_the_scene_says_so(starts_clear, occupied):
    params = HiddenParams(HiddenPolicy.KNOWN_BODIES, least_m=0.0, starts_clear=starts_clear)
    maps = Maps(params).see(BEHIND, periods=60)
    assert maps.count == occupied
    assert maps.see().see(BEHIND, periods=60).count == 0


def test_what_was_never_seen_is_free_where_there_is_no_room_for_what_is_looked_for():
    thin = np.s_[8:9, 8:12, 0:3]
    params = HiddenParams(HiddenPolicy.KNOWN_BODIES, least_m=0.25)
    assert Maps(params).see(thin, periods=60).count == 0
    assert Maps(replace(params, least_m=0.2)).see(thin, periods=60).count == 12, "with a cell of the robot's skin"


@pytest.mark.parametrize(("starts_clear", "occupied"), [(True, 0), (False, 12)])
def test_where_no_camera_looks_the_scenes_word_holds(starts_clear, occupied):
    corner = (slice(18, 20), slice(18, 20), slice(3, 6))
    for policy in (HiddenPolicy.KNOWN_BODIES, HiddenPolicy.OCCUPIED):
        maps = Maps(HiddenParams(policy, starts_clear=starts_clear)).see(corner, bits=0, periods=60)
        assert maps.count == occupied, policy


def test_the_other_policies():
    assert Maps(HiddenParams()).see().see(BEHIND).space.occupied is None
    maps = Maps(HiddenParams(HiddenPolicy.OCCUPIED)).see().see(BEHIND)
    assert maps.count == 48
    assert maps.see((slice(4, 12), slice(8, 12), slice(0, 3))).count == 48, "the robot's own cells are the robot's"


def test_hidden_cells_are_told_with_who_hides_them_and_who_would_have_to_move():
    table = body("table", block((0, 2), (0, 2)))
    maps = Maps(HiddenParams(HiddenPolicy.OCCUPIED))
    for bits, words in (
        (1, "behind ankurbot_1, which would have to move"),
        (3, "behind ankurbot_1, which would have to move"),
        (2, "behind table"),
        (NO_HIDER, "no camera sees it"),
        (0, "no camera sees it"),
    ):
        groups = maps.see(BEHIND, (ROBOT, table), bits).space.by_hider()
        assert list(groups) == [f"a hidden space of 48 cells from (8, 8, 0) on ({words})"]
        assert next(iter(groups.values())).shape == (48, 3)


def test_objects_from_the_thirty_first_on_share_a_bit():
    many = tuple(body(f"box_{k}", block((0, 1), (k % 20, k % 20 + 1))) for k in range(31))
    stranger = body("unknown_1", block((2, 3), (0, 1)))
    for objects, count in ((many, 0), ((*many, stranger), 48)):
        maps = Maps().see(objects=objects).see(BEHIND, objects, OTHER_HIDERS, periods=60)
        assert maps.count == count


def test_without_visibility_there_is_a_fault_that_says_what_to_do():
    space = HiddenSpace(KNOWN)
    assert "set visibility of merge_clouds to true" in space.fault(1.0, 1.0)
    space.see(CellMap(1.0, SPEC, np.zeros(SPEC.shape, dtype=np.int8)))
    assert "planning_metadata tells no visibility" in space.fault(1.0, 1.0)
    maps = Maps().see()
    assert maps.space.fault(maps.now_s + 0.9, 1.0) == ""
    assert maps.space.fault(maps.now_s + 1.1, 1.0)
    maps.space.forget()
    assert maps.space.fault(maps.now_s, 1.0) and maps.space.occupied is None
    assert HiddenSpace(HiddenParams()).fault(99.0, 1.0) == ""
