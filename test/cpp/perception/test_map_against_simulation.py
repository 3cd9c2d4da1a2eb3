"""The map of the C++ perception against the simulation's own bodies, Kinect noise on, in every shipped scene."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Dict, List, Set, Tuple

import numpy as np
import pytest

from support.perception_chain import GRID, ChainMap, SceneFactory
from support.simulated_cell import CAMERAS, SimulatedCell
from yarm.geometry import FloatArray, GridSpec
from yarm.sim.engine.world import SimWorld
from yarm.sim.scenes.scene import shipped_scenes
from yarm.sim.sensors.camera_model import KINECT
from yarm.sim.sensors.cameras import Eyes

Cell = Tuple[int, int, int]
CALIBRATION_SETS, RUNNING_SETS = 5, 12
BIRTH_SETS = 2
"""A thing that nobody registered is on the map from the set after these on."""
LEAST_RAYS = 3
SPEC = GridSpec()


def visible_cells(eyes: Eyes, poses: Dict[str, FloatArray]) -> Set[Cell]:
    """Cells that three or more noise-free rays of the set end in; the floor is below the grid."""
    hits: Dict[Cell, int] = {}
    for camera in CAMERAS:
        depth = eyes.overhead_image(camera, poses).depth
        T = eyes.overhead_poses[camera - 1]
        points = (KINECT.directions() * depth[..., None]).reshape(-1, 3)
        seen = (depth.reshape(-1) >= KINECT.near_m) & (depth.reshape(-1) <= KINECT.far_m)
        world = points[seen].astype(float) @ T[:3, :3].T + T[:3, 3]
        inside = np.all((world >= SPEC.lower) & (world < SPEC.upper), axis=1) & (world[:, 2] > 0.012)
        cells = np.floor((world[inside] - SPEC.lower) / SPEC.resolution).astype(int)
        unique, counts = np.unique(cells, axis=0, return_counts=True)
        for cell, count in zip(unique, counts):
            key = (int(cell[0]), int(cell[1]), int(cell[2]))
            hits[key] = hits.get(key, 0) + int(count)
    return {cell for cell, count in hits.items() if count >= LEAST_RAYS}


def filled_cells(world: SimWorld, poses: Dict[str, FloatArray]) -> np.ndarray:
    """Boolean grid of cells that some body reaches into, by dense sampling of its solids (1.5 cm)."""
    filled = np.zeros(GRID, dtype=bool)
    for body in world.bodies.values():
        for item in body.solids:
            half = np.asarray(item.solid.half_extent)
            axes = [np.linspace(-h, h, max(2, int(np.ceil(2 * h / 0.015)) + 1)) for h in half]
            local = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
            if item.solid.shape == "sphere":
                local = local[np.linalg.norm(local, axis=1) <= half[0]]
            elif item.solid.shape == "cylinder":
                local = local[np.linalg.norm(local[:, :2], axis=1) <= half[0]]
            T = poses[item.frame] @ item.T_frame_solid
            points = local @ T[:3, :3].T + T[:3, 3]
            points = points[np.all((points >= SPEC.lower) & (points < SPEC.upper), axis=1)]
            cells = np.floor((points - SPEC.lower) / SPEC.resolution).astype(int)
            filled[cells[:, 0], cells[:, 1], cells[:, 2]] = True
    return filled


def inflated(grid: np.ndarray, corners: bool) -> np.ndarray:
    """A boolean grid inflated by one cell over faces, or over corners too."""
    padded = np.pad(grid, 1)
    result = np.zeros_like(grid)
    for dx, dy, dz in np.ndindex(3, 3, 3):
        if corners or abs(dx - 1) + abs(dy - 1) + abs(dz - 1) <= 1:
            result |= padded[dx : dx + grid.shape[0], dy : dy + grid.shape[1], dz : dz + grid.shape[2]]
    return result


@dataclass
class Tally:
    """Counts over the sets of a scene."""

    visible: int = 0
    missed: int = 0
    marked: int = 0
    phantom: int = 0
    debris_sets: int = 0
    debris_missing: int = 0
    twos: List[int] = field(default_factory=list)

    def add(self, map_: ChainMap, visible: Set[Cell], filled: np.ndarray, debris: List[str]) -> None:
        """Count one set."""
        occupied = map_.grid > 0
        near = inflated(occupied, corners=False)
        self.visible += len(visible)
        self.missed += sum(not near[cell] for cell in visible)
        self.marked += int(occupied.sum())
        self.phantom += int((occupied & ~inflated(filled, corners=True)).sum())
        self.debris_sets += len(debris)
        self.debris_missing += sum(len(map_.cells.get(name, ())) == 0 for name in debris)


@pytest.mark.parametrize("scene", shipped_scenes())
def test_map_against_the_bodies(scene):
    cell = SimulatedCell(scene)
    try:
        cell.world.run(0.5)
        for _ in range(CALIBRATION_SETS):
            cell.next_set(calibrating=True)
        tally = Tally()
        for _ in range(2):
            tally.twos.append(int((cell.next_set(calibrating=False).grid == 2).sum()))
        cell.spawn_all()
        for robot in cell.world.robots.values():
            robot.drive(0.3, 0.0, 0.5)
        bodies = cell.world.bodies.values()
        debris = [body.name for body in bodies if body.kind == "Debris"]
        strangers = [body.name for body in bodies if not body.registered]
        unknown: Set[str] = set()
        for _ in range(BIRTH_SETS if strangers else 0):
            cell.next_set(calibrating=False)
        for _ in range(RUNNING_SETS):
            map_ = cell.next_set(calibrating=False)
            poses = dict(cell.world.transforms())
            tally.add(map_, visible_cells(cell.eyes, poses), filled_cells(cell.world, poses), debris)
            unknown |= {name for name in map_.cells if name.startswith("unknown_")}
    finally:
        cell.close()
    assert len(unknown) == len(strangers), f"{sorted(unknown)} for {strangers}"
    assert tally.twos == [0, 0], "cells of value 2 after calibration"
    assert tally.missed <= 0.01 * tally.visible, tally
    assert tally.phantom <= 0.01 * tally.marked, tally
    assert tally.debris_missing <= 0.01 * tally.debris_sets, tally


def test_the_measure_can_fail():
    cell = SimulatedCell("single")
    try:
        map_ = cell.next_set(calibrating=True)
        poses = dict(cell.world.transforms())
        tally = Tally()
        empty = ChainMap(np.zeros(GRID, np.int8), {})
        tally.add(empty, visible_cells(cell.eyes, poses), filled_cells(cell.world, poses), ["debris_1"])
        tally.add(ChainMap(np.ones(GRID, np.int8), map_.cells), set(), filled_cells(cell.world, poses), [])
    finally:
        cell.close()
    assert tally.visible == tally.missed > 500
    assert tally.debris_missing == 1
    assert tally.phantom > 0.5 * tally.marked


def test_synthetic_sets_know_their_truth():
    factory = SceneFactory(seed=3)
    try:
        made = factory.render(robots=2, debris=1)
        again = SceneFactory(seed=3)
        same = again.render(robots=2, debris=1)
        again.close()
    finally:
        factory.close()
    assert np.array_equal(made.clouds, same.clouds, equal_nan=True)
    assert set(np.unique(made.truth)) == {-2, -1, *range(len(made.bodies))}
    table = made.bodies.index("table")
    for camera in range(4):
        points = made.clouds[camera][made.truth[camera] == table][:, :3].astype(float)
        world = points @ made.poses[camera][:3, :3].T + made.poses[camera][:3, 3]
        assert 0.3 < np.median(world[:, 2]) < 0.75
        assert np.all(np.abs(world) < (0.7, 0.9, 0.95))
