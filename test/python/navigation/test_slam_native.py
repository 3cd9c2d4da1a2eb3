"""The C++ map maker and localisation from Python: a room mapped, a place found in it, what is wrong refused."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Iterator, List, Sequence

import numpy as np
import pytest

from support.rooms import block, room
from yarm.geometry import Pose2, wrap_angle
from yarm.geometry.scans import Odometry, Scan
from yarm.navigation import slam_native
from yarm.navigation.grid_map import GridMap
from yarm.navigation.slam_native import Localiser, LocaliserState, Mapper, ScanStatus, SlamError
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.kinematic.world import KinematicWorld
from yarm.sim.scenes.arena import Arena

ARENA = room(
    block("pillar", 1.0, 0.9, (0.3, 0.5, 0.6)),
    block("post", -1.2, -0.4, (0.4, 0.3, 0.6)),
    block("nook", -1.5, 1.4, (1.0, 1.2, 0.6)),
    start=Pose2(0.1, -0.2, 0.4),
)
"""Alike from no two sides."""


@dataclass(frozen=True)
class Moment:
    odometry: Odometry
    scan: Scan
    truth: Pose2


def turning(arena: Arena, seconds: float, seed: int = 3) -> Iterator[Moment]:
    """What a robot sees that turns on the spot at 0.5 rad/s, driving a little now and then."""
    world = KinematicWorld(arena, seed)
    for i in range(round(10.0 * seconds)):
        yield Moment(world.odometry(), world.scan(), world.truth)
        world.step(0.1 if i % 40 < 5 else 0.0, 0.5, 0.1)


CORNER = Pose2(-2.4, -2.3)


def true_map(arena: Arena, origin: Pose2 = CORNER) -> GridMap:
    """The room's blocks as cells of 0.05 m, the map frame the world's; the grid's corner as given."""
    empty = GridMap(np.zeros((96, 96), dtype=np.int8), 0.05, origin)
    cells = np.stack(np.meshgrid(np.arange(96), np.arange(96), indexing="ij"), axis=-1).reshape(-1, 2)
    inside = FlatBoxes(arena.blocks).signed(empty.centres_of(cells)).min(axis=1) < 0.0
    filled = np.where(inside.reshape(96, 96), 100, 0).astype(np.int8)
    return GridMap(filled, 0.05, origin)


def apart_rad(a: Pose2, b: Pose2) -> float:
    return abs(wrap_angle(a.yaw_rad - b.yaw_rad))


def mapped(moments: Sequence[Moment]) -> Mapper:
    mapper = Mapper()
    for moment in moments:
        assert mapper.add(moment.odometry, moment.scan).status is not ScanStatus.DROPPED
    return mapper


def test_walls_are_mapped_where_they_stand_and_the_pose_follows() -> None:
    mapper, errors = Mapper(ARENA.start), []
    for moment in turning(ARENA, 30.0):
        answer = mapper.add(moment.odometry, moment.scan)
        assert answer.reason == "" and answer.status in (
            ScanStatus.PREDICTED,
            ScanStatus.MATCHED,
            ScanStatus.KEYFRAME,
        )
        assert answer.map_from_odom.compose(moment.odometry.pose).distance(answer.pose) < 1e-9
        errors.append(answer.pose.distance(moment.truth))
    assert max(errors) < 0.06
    grid = mapper.map()
    centres = grid.centres_of(np.argwhere(grid.occupied))
    off = np.abs(FlatBoxes(ARENA.blocks).signed(centres)).min(axis=1)
    assert len(centres) > 100 and off.mean() < 0.03 and np.percentile(off, 95) < 0.07
    assert grid.free[grid.cell_of(ARENA.start.x + 0.3, ARENA.start.y)] and grid.known_m2 > 10.0
    assert mapper.counts.keyframes > 20 and mapper.counts.matched > 20 and mapper.counts.unmatched == 0


def test_the_map_begins_where_the_robot_does_unless_told_otherwise() -> None:
    first = next(turning(ARENA, 0.1))
    assert Mapper().add(first.odometry, first.scan).pose == Pose2(0.0, 0.0, 0.0)
    given = Mapper(Pose2(1.0, 2.0, 0.5)).add(first.odometry, first.scan).pose
    assert given.distance(Pose2(1.0, 2.0)) < 1e-9 and given.yaw_rad == pytest.approx(0.5)


def test_a_first_scan_of_which_nothing_is_sure_yet_gives_a_small_map_of_nothing() -> None:
    grid = mapped(list(turning(ARENA, 0.1))).map()
    assert grid.cells.shape == (40, 40) and grid.origin == Pose2(-1.0, -1.0) and grid.known_m2 == 0.0


def test_the_same_scans_give_the_same_map_to_the_last_cell() -> None:
    moments = list(turning(ARENA, 20.0))
    first, second = mapped(moments).map(), mapped(moments).map()
    assert np.array_equal(first.cells, second.cells) and first.origin == second.origin
    assert not np.array_equal(first.cells, mapped(list(turning(ARENA, 20.0, seed=4))).map().cells)


def test_a_map_that_was_given_out_does_not_change_with_later_scans() -> None:
    moments = list(turning(ARENA, 20.0))
    mapper = mapped(moments[:50])
    early = mapper.map()
    kept = early.cells.copy()
    for moment in moments[50:]:
        mapper.add(moment.odometry, moment.scan)
    assert mapper.map().known_m2 > early.known_m2 and np.array_equal(early.cells, kept)


def test_scans_that_cannot_be_used_are_dropped_with_the_reason_and_change_nothing() -> None:
    moments = list(turning(ARENA, 5.0))
    mapper, last = mapped(moments), moments[-1]
    before = mapper.map().cells
    again = mapper.add(last.odometry, last.scan)
    assert again.status is ScanStatus.DROPPED and "stamp" in again.reason
    later = replace(last.scan, stamp_s=last.scan.stamp_s + 0.1)
    bare = mapper.add(last.odometry, replace(later, ranges=np.zeros(0, dtype=np.float32)))
    assert bare.status is ScanStatus.DROPPED and "no beams" in bare.reason
    lost = mapper.add(Odometry(later.stamp_s, Pose2(math.nan, 0.0)), later)
    assert lost.status is ScanStatus.DROPPED and lost.reason
    assert np.array_equal(mapper.map().cells, before)
    assert mapper.add(last.odometry, later).status is not ScanStatus.DROPPED


def test_there_is_no_map_before_the_first_scan() -> None:
    mapper = Mapper()
    with pytest.raises(SlamError, match="first scan"):
        mapper.map()
    moment = next(turning(ARENA, 0.1))
    mapper.add(moment.odometry, replace(moment.scan, ranges=np.zeros(0, dtype=np.float32)))
    with pytest.raises(SlamError, match="first scan"):
        mapper.map()


def test_a_robot_that_turns_round_is_found_in_a_known_map_and_followed() -> None:
    localiser = Localiser(true_map(ARENA))
    states: List[LocaliserState] = []
    for moment in turning(ARENA, 40.0):
        answer = localiser.add(moment.odometry, moment.scan)
        states.append(answer.state)
        assert not answer.dropped and answer.localised == (answer.reason == "")
        if answer.pose is None:
            assert answer.state is LocaliserState.SEARCHING and answer.map_from_odom is None
        else:
            assert answer.pose.distance(moment.truth) < 0.06 and apart_rad(answer.pose, moment.truth) < 0.06
            assert answer.map_from_odom is not None
            assert answer.map_from_odom.compose(moment.odometry.pose).distance(answer.pose) < 1e-9
    assert states[0] is LocaliserState.SEARCHING and set(states[150:]) == {LocaliserState.TRACKING}
    assert answer.agreement > 0.8 and answer.spread_m < 0.05 and answer.spread_rad < 0.05
    assert np.allclose(answer.covariance, answer.covariance.T) and np.linalg.eigvalsh(answer.covariance)[0] > 0.0


def test_a_square_that_is_alike_from_four_sides_stays_in_doubt() -> None:
    localiser = Localiser(true_map(room()))
    answers = [localiser.add(moment.odometry, moment.scan) for moment in turning(room(), 30.0)]
    assert not any(answer.localised for answer in answers)
    assert answers[-1].state is LocaliserState.SEARCHING and "two places fit" in answers[-1].reason


def test_a_rough_pose_is_enough_when_the_next_scan_is_to_be_fitted() -> None:
    localiser, moments = Localiser(true_map(ARENA)), list(turning(ARENA, 12.0))
    localiser.believe(Pose2(ARENA.start.x + 0.2, ARENA.start.y - 0.1, ARENA.start.yaw_rad + 0.1))
    first = localiser.add(moments[0].odometry, moments[0].scan)
    assert first.state is LocaliserState.CHECKING and first.pose is not None and first.spread_m > 0.4
    answers = [localiser.add(moment.odometry, moment.scan) for moment in moments[1:]]
    found = next(i for i, answer in enumerate(answers) if answer.localised)
    assert moments[found].scan.stamp_s < 8.0, "sooner than by a search of the whole map"
    last = answers[-1].pose
    assert last is not None and last.distance(moments[-1].truth) < 0.06
    localiser.forget()
    later = replace(moments[-1].scan, stamp_s=moments[-1].scan.stamp_s + 0.1)
    assert localiser.add(moments[-1].odometry, later).state is LocaliserState.SEARCHING


def test_a_scan_is_fitted_on_the_spot_when_asked_for() -> None:
    localiser, moments = Localiser(true_map(ARENA)), list(turning(ARENA, 20.0))
    for moment in moments:
        answer = localiser.add(moment.odometry, moment.scan)
    assert answer.localised
    spreads = []
    for i, asked in enumerate((False, True)):
        if asked:
            localiser.fit_next()
        later = replace(moments[-1].scan, stamp_s=moments[-1].scan.stamp_s + 0.1 * (i + 1))
        spreads.append(localiser.add(moments[-1].odometry, later).covariance)
    assert not np.array_equal(*spreads), "only the second was fitted"


def test_the_corner_of_the_grid_may_stand_turned() -> None:
    turned = Pose2(2.4, 2.3, math.pi)
    localiser = Localiser(true_map(ARENA, turned))
    for moment in turning(ARENA, 25.0):
        answer = localiser.add(moment.odometry, moment.scan)
    assert answer.pose is not None and answer.pose.distance(moment.truth) < 0.06


def test_faulty_maps_and_poses_are_refused_with_the_reason() -> None:
    empty = GridMap(np.zeros((20, 20), dtype=np.int8), 0.05, Pose2(0.0, 0.0))
    with pytest.raises(SlamError, match="0 cells of surfaces"):
        Localiser(empty)
    with pytest.raises(SlamError, match="not finite"):
        Localiser(replace(true_map(ARENA), origin=Pose2(math.nan, 0.0)))
    localiser = Localiser(true_map(ARENA))
    with pytest.raises(SlamError, match="not finite"):
        localiser.believe(Pose2(math.inf, 0.0))
    moment = next(turning(ARENA, 0.1))
    localiser.add(moment.odometry, moment.scan)
    again = localiser.add(moment.odometry, moment.scan)
    assert again.dropped and "stamp" in again.reason


def test_a_package_that_is_not_built_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(slam_native, "library_path", lambda: None)
    slam_native._library.cache_clear()
    with pytest.raises(SlamError, match="make build"):
        Mapper()
    monkeypatch.undo()
    slam_native._library.cache_clear()
    assert isinstance(slam_native.library_path(), Path) and Mapper()
