"""The camera watch on shipped scenes, robots on their way, Kinect noise on: false alarms, and a turned camera named.

``-s`` prints the figures that docs/perception.md gives.
"""

from __future__ import annotations

import sys
from itertools import product
from pathlib import Path
from typing import Dict, List, Sequence, Tuple

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from support.perception_chain import PerceptionChain
from support.simulated_cell import CAMERAS, SimulatedCell

SCENES = ("1m1ma", "2m1ma", "3m")
ONE_BOX = str(Path(__file__).parents[2] / "ros" / "console_scene.yaml")
"""A scene whose only static body is small: turns about the line of sight to it hardly show."""
SECONDS, SETS_A_SECOND, TICKS_A_LOOK = 10, 6, 10
WARN_DEG, TURN_DEG = 0.4, 1.0
AXES = ("pitch", "yaw")
Case = Tuple[int, str]
"""Camera from 0 and axis of its optical frame it is turned about; -1: none is turned."""
NONE: Case = (-1, "")
CASES: List[Case] = [NONE, *product(range(len(CAMERAS)), AXES)]


def turned(poses: List[np.ndarray], case: Case) -> List[np.ndarray]:
    """The cameras' poses (4, 4) as they are told in a case."""
    told = [np.array(pose) for pose in poses]
    if case[0] >= 0:
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_euler("xy"[AXES.index(case[1])], TURN_DEG, degrees=True).as_matrix()
        told[case[0]] = told[case[0]] @ turn
    return told


def watched(scene: str, cases: Sequence[Case]) -> Dict[Case, List[Dict[int, float]]]:
    """The watch's fits of every second, by case; all cases see the same clouds."""
    cell = SimulatedCell(scene)
    chains = {case: PerceptionChain() for case in cases}
    told = {case: turned(list(cell.eyes.overhead_poses), case) for case in cases}
    fits: Dict[Case, List[Dict[int, float]]] = {case: [] for case in cases}
    try:
        cell.spawn_all()
        for second in range(SECONDS):
            for robot in cell.world.robots.values():
                robot.drive(0.3, 0.0, 0.8 if second % 2 else -0.4)
            for _ in range(SETS_A_SECOND):
                clouds, frames = cell.next_clouds(TICKS_A_LOOK), dict(cell.world.transforms())
                for case, chain in chains.items():
                    chain.watch(clouds, told[case], cell.bodies(), frames)
            for case, chain in chains.items():
                fits[case].append(chain.turns())
    finally:
        for chain in chains.values():
            chain.close()
        cell.close()
    return fits


def measured(title: str, turns: List[float]) -> str:
    """A line of figures about fits, degrees."""
    named = sum(turn >= WARN_DEG for turn in turns)
    return f"{title}: {len(turns)} fits, {min(turns):.2f} to {max(turns):.2f} deg, called off in {named}\n"


@pytest.mark.parametrize("scene", SCENES)
def test_a_turned_camera_is_named_and_no_other(scene):
    fits = watched(scene, CASES)
    right = [turn for case, rows in fits.items() for row in rows for c, turn in row.items() if c != case[0]]
    unturned = [turn for row in fits[NONE] for turn in row.values()]
    sys.stdout.write("\n" + measured(f"{scene}, none turned", unturned))
    assert len(unturned) == SECONDS * len(CAMERAS)
    assert max(right) < WARN_DEG
    for axis in AXES:
        found = [row[case[0]] for case, rows in fits.items() if case[1] == axis for row in rows]
        sys.stdout.write(measured(f"{scene}, one turned by {TURN_DEG:g} deg ({axis})", found))
        assert len(found) == SECONDS * len(CAMERAS)
        assert min(found) >= WARN_DEG
        assert max(found) < 1.5 * TURN_DEG


def test_where_one_small_box_is_all_that_stands_no_camera_is_called_off():
    found = [turn for row in watched(ONE_BOX, [NONE])[NONE] for turn in row.values()]
    sys.stdout.write("\n" + measured("one box, none turned", found))
    assert len(found) > SECONDS * len(CAMERAS) // 2
    assert max(found) < WARN_DEG
