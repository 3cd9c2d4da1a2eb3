"""A picture of the cell, drawn without a display by the cameras' own ray casting."""

from __future__ import annotations

import math
from pathlib import Path
from typing import List, Sequence

import numpy as np
import numpy.typing as npt
from matplotlib import image

from yarm.geometry import FloatArray
from yarm.geometry.kinds import ObjectKind
from yarm.geometry.solids import Shape
from yarm.geometry.urdf import LinkSolid
from yarm.sim.engine.world import SimWorld
from yarm.sim.scenes.bodies import FramedSolid
from yarm.sim.scenes.specs import HALF_CELL_M
from yarm.sim.sensors.camera_model import FAR, FLOOR_RGB, CameraModel, SolidSet, looking_at
from yarm.sim.sensors.cameras import DepthCamera, best_rays

EYE_M = (5.3, -5.0, 4.1)
AIM_M = (-0.05, -0.05, 0.62)
LIGHT = (0.35, -0.50, 0.80)
"""Direction to the light, world."""
AMBIENT = 0.35
SKY = (0.93, 0.95, 0.97)
FLOOR = (0.86, 0.86, 0.85)
OUTSIDE_FLOOR = (0.80, 0.80, 0.80)
LINE = (0.68, 0.69, 0.70)
LINE_HALF_WIDTH_M = 0.008
TARGET_COLOUR = (0.10, 0.65, 0.25)
OVERSAMPLING = 2


def draw(
    world: SimWorld,
    width: int = 1280,
    height: int = 800,
    eye_m: Sequence[float] = EYE_M,
    aim_m: Sequence[float] = AIM_M,
) -> npt.NDArray[np.float64]:
    """Picture (height, width, 3), red, green, blue, 0 to 1, of a world; targets are green balls.

    Args:
        world: what is drawn.
        width: pixels.
        height: pixels.
        eye_m: from where, world.
        aim_m: what is in the middle, world.
    """
    n = OVERSAMPLING
    camera = DepthCamera(CameraModel(n * width, n * height, math.radians(50.0), 0.05, 30.0), best_rays())
    pose = looking_at(eye_m, aim_m)
    solids = SolidSet(_seen(world))
    seen = camera.render(pose, solids, solids.poses(world.transforms()))
    points = (camera.model.directions() * seen.depth[..., None]) @ pose[:3, :3].T + pose[:3, 3]
    colours = np.stack([(seen.rgb >> shift & 255) / 255.0 for shift in (16, 8, 0)], axis=-1)
    floor = seen.rgb == FLOOR_RGB
    colours[floor] = _floor_colours(points[floor])
    shaded = colours * _shading(points, pose[:3, 3])[..., None]
    shaded[seen.depth == FAR] = SKY
    result: npt.NDArray[np.float64] = shaded.reshape(height, n, width, n, 3).mean(axis=(1, 3))
    return np.clip(result, 0.0, 1.0)


def save(world: SimWorld, path: Path) -> None:
    """Write a picture of a world to a PNG file."""
    image.imsave(str(path), draw(world))


def _seen(world: SimWorld) -> List[FramedSolid]:
    """What there is to see."""
    items = [item for body in world.bodies.values() for item in body.solids]
    for body in world.bodies.values():
        if body.kind == ObjectKind.TARGET:
            ball = LinkSolid(Shape.SPHERE, (0.05,), np.eye(4), body.name, TARGET_COLOUR)
            items.append(FramedSolid(body.name, ball, np.eye(4)))
    return items


def _floor_colours(points: FloatArray) -> FloatArray:
    """Colour of floor points (n, 3): a line every half metre inside the mapped volume."""
    xy = points[:, :2]
    inside = np.all(np.abs(xy) <= HALF_CELL_M + LINE_HALF_WIDTH_M, axis=1)
    off_line = np.min(np.abs(xy - 0.5 * np.round(2.0 * xy)), axis=1) > LINE_HALF_WIDTH_M
    colours = np.where(inside[:, None], FLOOR, OUTSIDE_FLOOR)
    colours[inside & ~off_line] = LINE
    return colours


def _shading(points: FloatArray, eye: FloatArray) -> FloatArray:
    """Brightness (h, w) of surface points (h, w, 3), world, from the slope between neighbouring pixels."""
    across = np.gradient(points, axis=1)
    down = np.gradient(points, axis=0)
    normals = np.cross(across, down)
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
    facing = np.sum(normals * (eye - points), axis=-1, keepdims=True)
    normals = np.where(facing < 0.0, -normals, normals)
    light = np.asarray(LIGHT) / np.linalg.norm(LIGHT)
    brightness: FloatArray = AMBIENT + (1.0 - AMBIENT) * np.maximum(normals @ light, 0.0) * 1.15
    return brightness
