"""Ways over the known map, and driving them in the kinematic world."""

from __future__ import annotations

import math

import numpy as np

from yarm.experiments.inspect.pilot import RADIUS_M, Pilot, Ways, known_map
from yarm.geometry import Pose2
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.kinematic.world import KinematicWorld
from yarm.sim.scenes.layout_maker import make_layout

LAYOUT = make_layout("open", 1)
WAYS = Ways(known_map(LAYOUT.arena))


def test_the_known_map_holds_walls_and_boxes_and_nothing_else() -> None:
    grid = known_map(LAYOUT.arena)
    rows, columns = np.nonzero(grid.occupied)
    centres = grid.centres_of(np.stack([rows, columns], axis=1))
    gaps = FlatBoxes(LAYOUT.arena.blocks).signed(centres).min(axis=1)
    assert gaps.max() <= 0.03
    for box in LAYOUT.boxes:
        assert grid.cells[grid.cell_of(box.pose.x, box.pose.y)] == 100
    assert grid.cells[grid.cell_of(LAYOUT.start.x, LAYOUT.start.y)] == 0


def test_lengths_are_never_shorter_than_straight_and_infinite_into_a_box() -> None:
    start = LAYOUT.start
    goals = [Pose2(2.5, 2.5), Pose2(-2.5, 0.0), LAYOUT.boxes[0].pose]
    lengths = WAYS.lengths(start, goals)
    free = FlatBoxes(LAYOUT.arena.blocks)
    for goal, length in zip(goals[:2], lengths):
        if free.distances(goal.x, goal.y).min() > RADIUS_M + 0.05:
            assert start.distance(goal) - 0.1 <= length < 4.0 * start.distance(goal) + 1.0
    assert math.isinf(lengths[2])


def test_a_goal_in_a_box_is_refused_with_a_reason() -> None:
    assert "no way" in Pilot(WAYS, 0.1).go(LAYOUT.start, LAYOUT.boxes[0].pose)


def test_it_drives_there_without_a_touch() -> None:
    world = KinematicWorld(LAYOUT.arena, 1)
    free = FlatBoxes(LAYOUT.arena.blocks)
    far = max(
        (Pose2(x, y, 1.0) for x in (-2.5, 0.0, 2.5) for y in (-2.5, 0.0, 2.5) if free.distances(x, y).min() > 0.3),
        key=lambda goal: goal.distance(LAYOUT.start),
    )
    pilot = Pilot(WAYS, 0.1)
    assert pilot.go(world.truth, far) == ""
    for _ in range(1200):
        v, w, arrived = pilot.step(world.truth, world)
        world.step(v, w, 0.1)
        if arrived:
            break
    assert world.truth.distance(far) < 0.06 and abs(world.truth.yaw_rad - 1.0) < 0.07 and not world.touches
