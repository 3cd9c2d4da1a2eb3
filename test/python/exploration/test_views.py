"""What a look would show: areas against geometry, walls, and turns."""

from __future__ import annotations

import math
from typing import List

import numpy as np
import pytest

from yarm.exploration.views import FINE, MOST_DECAY_M, Look, Views, ViewSettings, sweeps
from yarm.geometry import Pose2
from yarm.navigation.costs import clearance
from yarm.navigation.grid_map import GridMap

PLAIN = ViewSettings(directions=120, tight_factor=1.0, through_m=100.0, decay_m=MOST_DECAY_M, near_m=0.0)


def unknown_room(cells: int = 201, yaw_rad: float = 0.0) -> GridMap:
    return GridMap(np.full((cells, cells), -1, np.int8), 0.05, Pose2(0.0, 0.0, yaw_rad))


def views(room: GridMap, worth: np.ndarray, settings: ViewSettings) -> Views:
    return Views(room, worth, clearance(room), settings)


def all_unknown(room: GridMap) -> np.ndarray:
    return room.unknown.astype(float)


def test_a_look_all_round_shows_the_area_of_a_disc() -> None:
    room = unknown_room()
    gains = views(room, all_unknown(room), PLAIN).gains(np.array([[100, 100]]))
    assert gains.sum() * 0.05**2 == pytest.approx(math.pi * 4.5**2, rel=0.03)


def test_what_is_near_or_known_counts_nothing() -> None:
    room = unknown_room()
    ring = views(
        room, all_unknown(room), ViewSettings(directions=120, through_m=100.0, decay_m=MOST_DECAY_M, near_m=1.0)
    )
    assert ring.gains(np.array([[100, 100]])).sum() * 0.05**2 == pytest.approx(math.pi * (4.5**2 - 1.0), rel=0.03)
    assert views(room, np.zeros(room.cells.shape), PLAIN).gains(np.array([[100, 100]])).sum() == 0.0


def test_walls_end_rays_and_so_does_the_edge_of_the_map() -> None:
    room = unknown_room()
    room.cells[:, 120] = 100
    gains = views(room, all_unknown(room), PLAIN).gains(np.array([[100, 100], [100, 2]]))
    assert gains[0, 0] * 0.05**2 == pytest.approx(0.5 * 0.95**2 * 2 * math.pi / 120, rel=0.1)
    assert gains[0, 60] > 10 * gains[0, 0]
    assert gains[1, 60] < gains[1, 0] / 100


def test_a_ray_ends_in_unknown_ground_and_fades_on_the_way() -> None:
    room = unknown_room()
    short = views(
        room, all_unknown(room), ViewSettings(directions=120, through_m=1.0, decay_m=MOST_DECAY_M, near_m=0.0)
    )
    area = short.gains(np.array([[100, 100]])).sum() * 0.05**2
    assert math.pi * 1.0**2 * 0.9 <= area <= math.pi * 1.5**2
    faded = views(room, all_unknown(room), ViewSettings(directions=120, through_m=1.0, decay_m=0.5, near_m=0.0))
    assert faded.gains(np.array([[100, 100]])).sum() * 0.05**2 < 0.6 * area


def test_a_slit_in_a_wall_promises_little_and_a_door_much() -> None:
    def behind(gap: int) -> float:
        room = unknown_room()
        room.cells[:, 80:110] = 0
        room.cells[:, 110] = 100
        room.cells[100 - gap // 2 : 100 + gap - gap // 2, 110] = -1
        made = views(room, all_unknown(room), ViewSettings())
        return float(made.gains(np.array([[100, 95]]))[0, :10].sum())

    assert behind(14) > 6.0 * behind(5)


def test_direction_0_is_along_x_of_the_frame_also_on_a_turned_map() -> None:
    room = unknown_room(yaw_rad=math.pi / 2)
    room.cells[:, :100] = 0
    gains = views(room, all_unknown(room), PLAIN).gains(np.array([[100, 100]]))[0]
    assert gains[10:51].min() > 0.0 and gains[70:111].max() < 0.1, "the map's columns run along y of the frame"


def test_sweeps_are_sums_over_what_the_turn_passes() -> None:
    gains = np.arange(120, dtype=float)[None, :]
    turns = np.array([0.0, math.pi / 2, -math.pi / 2, 2.0 * math.pi])
    seen = sweeps(gains, np.array([math.pi]), turns, math.pi / 3)[0]
    assert seen[0] == gains[0, 50:70].sum()
    assert seen[1] == gains[0, 50:100].sum() and seen[2] == gains[0, 20:70].sum()
    assert seen[3] == gains.sum()
    wrapped = sweeps(gains, np.array([0.0]), np.array([0.0]), math.pi / 3)[0, 0]
    assert wrapped == gains[0, 110:].sum() + gains[0, :10].sum()


def test_what_a_view_shows_is_what_it_counts() -> None:
    room = unknown_room()
    room.cells[90:110, 90:130] = 0
    room.cells[:, 140] = 100
    worth = all_unknown(room)
    shown = views(room, worth, PLAIN).shown((100, 100), 0.0, 0.0)
    assert len(shown) > 0 and np.all(shown[:, 1] < 140) and np.all(shown[:, 1] > 129 - 20)
    angle = np.degrees(np.arctan2(shown[:, 0] - 100, shown[:, 1] - 100))
    assert np.abs(angle).max() <= 33.0
    turned = views(room, worth, PLAIN).shown((100, 100), 0.0, math.pi / 2)
    angle = np.degrees(np.arctan2(turned[:, 0] - 100, turned[:, 1] - 100))
    assert angle.max() == pytest.approx(120.0, abs=4.0) and angle.min() > -33.0


NEARER = ViewSettings(tight_factor=1.0, through_m=100.0, decay_m=MOST_DECAY_M, near_m=0.0, range_m=2.0)


def shown(made: Views, looks: List[Look]) -> float:
    return float(made.together([looks])[0])


def test_looks_together_count_every_cell_once() -> None:
    room = unknown_room()
    made = views(room, all_unknown(room), NEARER)
    one = shown(made, [((100, 100), 0.0, 0.0)])
    assert one * 0.05**2 == pytest.approx(math.pi * 2.0**2 / 6.0, rel=0.1)
    assert shown(made, [((100, 100), 0.0, 0.0), ((100, 100), 0.0, 0.0)]) == one
    apart = shown(made, [((100, 100), 0.0, 0.0), ((100, 100), math.pi, 0.0)])
    assert apart == pytest.approx(2.0 * one, rel=0.02)
    ahead = [((100, 100), 0.0, 0.0), ((100, 110), 0.0, 0.0)]
    assert one < shown(made, ahead) < 2.0 * one
    assert shown(made, ahead) == shown(made, ahead[::-1])


def test_a_look_with_a_turn_shows_what_the_turn_passes() -> None:
    room = unknown_room()
    made = views(room, all_unknown(room), NEARER)
    turned = shown(made, [((100, 100), 0.2, math.pi / 3.0)])
    assert turned == pytest.approx(2.0 * shown(made, [((100, 100), 0.2, 0.0)]), rel=0.03)
    assert turned == pytest.approx(shown(made, [((100, 100), 0.2 + math.pi / 3.0, -math.pi / 3.0)]), rel=0.02)


def test_what_is_behind_a_wall_near_or_known_is_not_counted_together_either() -> None:
    room = unknown_room()
    walled = room.cells.copy()
    walled[:, 120] = 100
    shut = GridMap(walled, room.resolution_m, room.origin)
    seen = shown(views(shut, all_unknown(shut), NEARER), [((100, 100), 0.0, 0.0)])
    assert 0.0 < seen * 0.05**2 < 0.6 * 1.0
    assert shown(views(room, np.zeros(room.cells.shape), NEARER), [((100, 100), 0.0, 0.0)]) == 0.0


def test_tours_that_share_looks_count_for_themselves() -> None:
    room = unknown_room()
    made = views(room, all_unknown(room), NEARER)
    here, on, back = ((100, 100), 0.0, 0.0), ((100, 110), 0.0, 0.0), ((100, 100), math.pi, 1.0)
    tours = [[here], [on, here], [back], [here, back], [here]]
    assert made.together(tours).tolist() == [shown(made, tour) for tour in tours]


def test_of_what_several_looks_show_the_clearest_counts() -> None:
    room = unknown_room()
    made = views(room, all_unknown(room), ViewSettings(through_m=100.0, near_m=0.0, range_m=2.0, decay_m=0.5))
    best = np.zeros(room.cells.shape)
    for row, column in ((100, 100), (100, 108), (95, 104)):
        for angle in 2.0 * np.pi * (np.arange(-15, 16) % FINE) / FINE:
            steps = np.rint(np.arange(1, 41)[:, None] * [math.sin(angle), math.cos(angle)]).astype(int)
            at = steps + np.array([row, column])
            left = np.cumprod(np.full(40, math.exp(-0.05 / 0.5)))
            np.maximum.at(best, (at[:, 0], at[:, 1]), left)
    looks: List[Look] = [((100, 100), 0.0, 0.0), ((100, 108), 0.0, 0.0), ((95, 104), 0.0, 0.0)]
    assert shown(made, looks) == pytest.approx(best.sum(), rel=1e-5)
