"""Which surface a ray meets first, against distances that can be told by hand and the cameras' own ray caster."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

sys.path.insert(0, str(Path(__file__).resolve().parent))
from camera_samples import CAMERAS, cell

from yarm.calibration.depths import first_met
from yarm.geometry.solids import Shape, Solid
from yarm.sim.sensors.cameras import Eyes


def at(x, y, z, turn=(0.0, 0.0, 0.0)):
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
    pose[:3, 3] = x, y, z
    return pose


BOX = Solid(Shape.BOX, np.array([1.0, 2.0, 0.5]), at(0.0, 0.0, 0.25))
CYLINDER = Solid(Shape.CYLINDER, np.array([0.5, 1.0]), at(3.0, 0.0, 0.5))
BALL = Solid(Shape.SPHERE, np.array([0.5]), at(0.0, 5.0, 0.5))
EYE = np.array([0.0, 0.0, 2.0])


@pytest.mark.parametrize(
    ("to", "share"),
    [
        ((0.0, 0.0, 0.0), 0.75),
        ((0.49, 0.0, 0.5), 1.0),
        ((3.0, 0.0, 1.0), 1.0),
        ((0.0, 5.0, 0.5), 1.0 - 0.5 / np.hypot(5.0, 1.5)),
        ((9.0, 9.0, 0.0), 1.0),
        ((9.0, 9.0, 2.5), np.inf),
    ],
)
def test_what_a_ray_meets(to, share):
    ray = (np.array(to) - EYE)[None, :]
    met = first_met(EYE, ray, [BOX, CYLINDER, BALL])[0]
    assert met == pytest.approx(share)


def test_a_ray_along_a_face_and_without_floor():
    assert first_met(np.array([0.5, 0.0, 2.0]), np.array([[0.0, 0.0, -1.0]]), [BOX])[0] in (1.5, 2.0)
    assert np.isinf(first_met(EYE, np.array([[9.0, 9.0, -2.0]]), [BOX], floor=False)[0])
    assert np.isinf(first_met(EYE, np.array([[0.0, 0.0, 1.0]]), [BOX])[0]), "what lies behind is not met"


@pytest.mark.parametrize("camera", CAMERAS)
def test_as_the_cameras_see_it(camera):
    """Two implementations of one picture: the table, the part, the stand, robots and the arm of a shipped scene."""
    simulated = cell("1m1ma")
    eyes, pose = Eyes(1, noise=False), simulated.true_pose(camera)
    eyes.look_at(simulated.bodies, simulated.transforms)
    cloud = eyes.overhead_cloud(camera, simulated.transforms, 0)
    points = np.stack([cloud["x"], cloud["y"], cloud["z"]], axis=-1).reshape(-1, 3).astype(float)
    points = points[np.isfinite(points).all(axis=1)]
    met = first_met(pose[:3, 3], points @ pose[:3, :3].T, [*simulated.static, *simulated.moving])
    assert np.mean(np.abs(met - 1.0) < 1e-4) > 0.999
