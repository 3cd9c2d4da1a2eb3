"""A camera's pose from its points on known static surfaces: point-to-plane ICP in six degrees of freedom.

Y. Chen and G. Medioni, "Object modeling by registration of multiple range images", ICRA 1991; trimmed as D. Chetverikov
et al., "The trimmed iterative closest point algorithm", ICPR 2002. Surfaces in view that leave a direction open leave
it to a weak prior about the pose that was told, and its deviation says so.

A camera in a body's plane of symmetry sees none of the faces that would tell where it is across: there only the body's
outline tells. ``sharpen`` compares each reading with the depth that a camera at a pose would read, so outlines count,
for the pose and for its deviation.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass, replace
from typing import Callable, Sequence, Tuple

import numpy as np
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from yarm.calibration.depths import first_met
from yarm.calibration.surfaces import nearest_surface
from yarm.geometry import FloatArray, IntArray, transform_points
from yarm.geometry.depth_noise import kinect_sigma
from yarm.geometry.solids import Solid

TRIMS_M = (0.3, 0.3, 0.25, 0.25, 0.2, 0.2, 0.15, 0.15, 0.1, 0.1, 0.08, 0.06, 0.05, 0.05, 0.05, 0.05)
"""Points farther from the nearest surface are others' points, a round each, metres."""
PRIOR_M, PRIOR_RAD = 0.1, math.radians(6.0)
"""Deviation of the pose that was told."""
MODEL_M = 0.003
"""Deviation of the surfaces themselves; what many points cannot average away."""
LEAST_POINTS = 300
LEAST_COS = 0.1
"""Surfaces seen at a flatter angle say nothing."""
MOVER_M = 0.1
"""A point nearer to a moving body may be that body's."""
CORRELATED = 12.0
"""As many points as this are as good as one: what the surfaces differ from their drawing is alike near by."""
NEAR_M = 0.35
"""Points within this of a solid, with the camera as it is told to be, are worth most; of the floor's few are taken."""
SHARP_M, SHARP_RAD = 0.002, 0.001
"""First steps of the search for the best outlines."""
CURVED = 2.5
"""So many such steps to either side, 5 mm and 2.5 mrad, tell how much worse other poses fit."""
OTHERS_SIGMAS = 3.0
"""A reading this many deviations off is another's, or on the wrong side of an outline; all such count alike."""


@dataclass(frozen=True, eq=False)
class Refined:
    """A camera's pose as its points tell it.

    Attributes:
        ok: whether there were points enough.
        reason: why not.
        pose: (4, 4) T_world_optical.
        moved_m: how far it is from where it was told to be, metres.
        turned_rad: by how much it is turned against that.
        sigma_m: deviation of its place, the worst direction, metres.
        sigma_rad: deviation of its turn, the worst axis, rad.
        significance: of the difference, in deviations: 3 is hardly ever chance.
        points: that lie on known surfaces.
        before_m: median distance, without sign, of these to the surfaces with the pose that was told.
        after_m: and with this one.
    """

    ok: bool
    reason: str
    pose: FloatArray
    moved_m: float = 0.0
    turned_rad: float = 0.0
    sigma_m: float = math.inf
    sigma_rad: float = math.inf
    significance: float = 0.0
    points: int = 0
    before_m: float = 0.0
    after_m: float = 0.0


def refine(
    points: FloatArray,
    sigmas: FloatArray,
    told: FloatArray,
    static: Sequence[Solid],
    movers: Sequence[Solid] = (),
    floor: bool = True,
    trims: Sequence[float] = TRIMS_M,
) -> Refined:
    """Where a camera is.

    Args:
        points: (n, 3) finite points in its optical frame, metres; a few thousand do.
        sigmas: (n,) deviation of each along its ray, metres.
        told: (4, 4) T_world_optical as it is told.
        static: known solids that do not move, with their poses in the world.
        movers: known solids that do, as they are now; points near them are left out.
        floor: whether z = 0 is a floor.
        trims: of each round, metres; a camera that can hardly be off needs fewer.
    """
    if len(points) < LEAST_POINTS or not (static or floor):
        return Refined(False, f"{len(points)} points, at least {LEAST_POINTS} near known surfaces are needed", told)
    pose = told.copy()
    information = np.zeros((6, 6))
    for trim in trims:
        row, distance, weight = _rows(points, sigmas, pose, static, movers, floor, trim)
        if len(distance) < LEAST_POINTS:
            text = f"{len(distance)} points near known static surfaces, at least {LEAST_POINTS} are needed"
            return Refined(False, text, told)
        information = (row * weight[:, None]).T @ row
        pull = _prior(pose, told)
        step = np.linalg.solve(information + pull[0], -(row * weight[:, None]).T @ distance - pull[1])
        pose = _stepped(pose, step)
    before = _residual(points, told, static, movers, floor)
    after = _residual(points, pose, static, movers, floor)
    found = Refined(True, "", pose, points=len(distance), before_m=before, after_m=after)
    return _weighed(found, told, information)


def pick(
    points: FloatArray, told: FloatArray, static: Sequence[Solid], rng: np.random.Generator, most: int
) -> IntArray:
    """Rows of a cloud that say most about where its camera is.

    Args:
        points: (n, 3) in its optical frame, metres; those that are not finite are left out.
        told: (4, 4) T_world_optical.
        static: known solids that do not move, with their poses in the world.
        rng: draws them.
        most: of those near solids, and half as many others.
    """
    finite = np.flatnonzero(np.isfinite(points).all(axis=1))
    world = transform_points(told, points[finite].astype(float))
    near = np.abs(nearest_surface(world, static, floor=False).distance) < NEAR_M
    kept = []
    for rows, count in ((finite[near], most), (finite[~near], most // 2)):
        kept.append(rows if len(rows) <= count else rng.choice(rows, count, replace=False))
    picked: IntArray = np.concatenate(kept)
    return picked


def calibrated(
    clouds: Sequence[FloatArray],
    told: FloatArray,
    static: Sequence[Solid],
    movers: Sequence[Solid],
    rng: np.random.Generator,
    most: int,
    rounds: int = 2,
) -> Refined:
    """Where a camera is, from pictures of a cell at rest: averaged, fitted to faces, then to outlines.

    Args:
        clouds: each (n, 3) in its optical frame, metres, NaN where nothing was in range; the same pixels in all.
        told: (4, 4) T_world_optical as it is told.
        static: known solids that do not move, with their poses in the world.
        movers: known solids that do, as they are now.
        rng: draws the points.
        most: points near solids, and half as many others.
        rounds: fits to faces, each from where the one before has ended.
    """
    sizes = sorted({len(cloud) for cloud in clouds})
    if len(sizes) > 1:
        text = f"clouds of {sizes[0]} to {sizes[-1]} points, organised ones are needed: the same pixels in each"
        return Refined(False, text, told)
    points, sigmas = averaged(clouds)
    rows = pick(points, told, static, rng, most)
    points, sigmas = points[rows], sigmas[rows]
    refined = Refined(True, "", told)
    for _ in range(rounds):
        refined = refine(points, sigmas, refined.pose, static, movers)
        if not refined.ok:
            return refined
    before = _residual(points, told, static, movers, floor=True)
    return replace(sharpen(refined, points, sigmas, told, static, movers), before_m=before)


def averaged(clouds: Sequence[FloatArray]) -> Tuple[FloatArray, FloatArray]:
    """One cloud of many pictures of a cell at rest, pixel by pixel, and the deviation of each depth.

    A reading farther than three deviations from its pixel's median is left out: somebody came by. So is a pixel that
    has fewer readings than half the pictures.

    Args:
        clouds: each (n, 3) in the optical frame, metres, NaN where nothing was in range; the same pixels in all.

    Returns:
        (n, 3) points, NaN where too little was seen, and (n,) metres.
    """
    depth = np.stack([cloud[:, 2] for cloud in clouds])
    with np.errstate(invalid="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # pixels without any reading
        middle = np.nanmedian(depth, axis=0)
        alike = np.abs(depth - middle) < OTHERS_SIGMAS * kinect_sigma(middle)
    count = alike.sum(axis=0)
    points = sum(np.where(kept[:, None], cloud, 0.0) for kept, cloud in zip(alike, clouds))
    points = points / np.maximum(count, 1)[:, None]
    points[2 * count < len(clouds)] = np.nan
    sigmas: FloatArray = kinect_sigma(points[:, 2]) / np.sqrt(np.maximum(count, 1))
    return points, sigmas


def sharpen(
    refined: Refined,
    points: FloatArray,
    sigmas: FloatArray,
    told: FloatArray,
    static: Sequence[Solid],
    movers: Sequence[Solid] = (),
) -> Refined:
    """The pose near that of ICP at which the depths, outlines with them, fit best (Powell's search).

    Args:
        refined: what ``refine`` made of them.
        points: (n, 3) finite points in the optical frame, metres; their noise must be small against the solids.
        sigmas: (n,) deviation of each along its ray, metres.
        told: (4, 4) T_world_optical as it was told.
        static: known solids that do not move, with their poses in the world; z = 0 is a floor.
        movers: known solids that do; readings near them, or of what they hide, are left out.

    Returns:
        Another pose, what it differs from the one that was told, and its deviations: how far from it the depths fit
        worse by more than chance. Points and distances as they were.
    """
    rays = points @ refined.pose[:3, :3].T
    origin = refined.pose[:3, 3]
    expected = origin + rays * first_met(origin, rays, static)[:, None]
    keep = np.isfinite(expected).all(axis=1)
    for places in (origin + rays, expected):
        keep[keep] &= nearest_surface(places[keep], movers, floor=False).distance > MOVER_M
    seen, deviation = points[keep], np.hypot(sigmas[keep], MODEL_M)
    scale = np.array([SHARP_RAD] * 3 + [SHARP_M] * 3)

    def misfit(step: FloatArray) -> float:
        pose = _stepped(refined.pose, step * scale)
        met = first_met(pose[:3, 3], seen @ pose[:3, :3].T, static)
        off = (1.0 - met) * seen[:, 2] / deviation
        return float(np.minimum(off**2, OTHERS_SIGMAS**2).sum())

    found = minimize(misfit, np.zeros(6), method="Powell", options={"xtol": 0.02, "ftol": 1e-7})
    reach = CURVED * scale
    bend = _curvature(lambda way: misfit(found.x + CURVED * way)) / np.outer(reach, reach)
    values, axes = np.linalg.eigh(0.5 * bend)
    information = (axes * np.maximum(values, 0.0)) @ axes.T
    return _weighed(replace(refined, pose=_stepped(refined.pose, found.x * scale)), told, information)


def _rows(
    points: FloatArray,
    sigmas: FloatArray,
    pose: FloatArray,
    static: Sequence[Solid],
    movers: Sequence[Solid],
    floor: bool,
    trim: float,
) -> Tuple[FloatArray, FloatArray, FloatArray]:
    """Derivatives (n, 6) of each point's distance by a turn and a shift of the camera, the distance, its weight."""
    rotated = points @ pose[:3, :3].T
    world = rotated + pose[:3, 3]
    near = nearest_surface(world, static, floor)
    rays = rotated / np.linalg.norm(rotated, axis=1)[:, None]
    cos = np.abs(np.sum(rays * near.normal, axis=1))
    keep = (np.abs(near.distance) < trim) & (cos > LEAST_COS)
    if movers:
        keep[keep] &= nearest_surface(world[keep], movers, floor=False).distance > MOVER_M
    normal, arm = near.normal[keep], rotated[keep]
    across = sigmas[keep] * cos[keep]
    deviation = np.hypot(across, MODEL_M)
    scaled = near.distance[keep] / np.maximum(3.0 * deviation, 0.3 * trim)
    weight = 1.0 / (deviation**2 * (1.0 + scaled**2))
    return np.hstack([np.cross(arm, normal), normal]), near.distance[keep], weight


def _curvature(misfit: Callable[[FloatArray], float]) -> FloatArray:
    """Second derivatives (6, 6) of a function of (6,) at 0, by steps of 1 to either side."""
    one = np.eye(6)
    middle = misfit(np.zeros(6))
    bend = np.diag([misfit(way) + misfit(-way) - 2.0 * middle for way in one])
    for i in range(6):
        for j in range(i):
            alike = misfit(one[i] + one[j]) + misfit(-one[i] - one[j])
            bend[i, j] = bend[j, i] = (alike - misfit(one[i] - one[j]) - misfit(one[j] - one[i])) / 4.0
    return bend


def _weighed(refined: Refined, told: FloatArray, information: FloatArray) -> Refined:
    """How far its pose is from the one that was told, and how sure that is by points of this (6, 6) information."""
    covariance = np.linalg.inv(information / CORRELATED + _prior(refined.pose, told)[0])
    moved_m, turned_rad = _apart(told, refined.pose)
    return replace(
        refined,
        moved_m=moved_m,
        turned_rad=turned_rad,
        sigma_m=math.sqrt(float(np.linalg.eigvalsh(covariance[3:, 3:])[-1])),
        sigma_rad=math.sqrt(float(np.linalg.eigvalsh(covariance[:3, :3])[-1])),
        significance=_significance(refined.pose, told, covariance),
    )


def _prior(pose: FloatArray, told: FloatArray) -> Tuple[FloatArray, FloatArray]:
    """Information (6, 6) of the pose that was told, and its pull (6,) at another."""
    information = np.diag([1.0 / PRIOR_RAD**2] * 3 + [1.0 / PRIOR_M**2] * 3)
    turn = Rotation.from_matrix(pose[:3, :3] @ told[:3, :3].T).as_rotvec()
    return information, information @ np.concatenate([turn, pose[:3, 3] - told[:3, 3]])


def _apart(told: FloatArray, pose: FloatArray) -> Tuple[float, float]:
    """How far two poses are apart, metres and rad."""
    apart = np.linalg.inv(told) @ pose
    turn = Rotation.from_matrix(apart[:3, :3]).as_rotvec()
    return float(np.linalg.norm(apart[:3, 3])), float(np.linalg.norm(turn))


def _significance(pose: FloatArray, told: FloatArray, covariance: FloatArray) -> float:
    turn = Rotation.from_matrix(pose[:3, :3] @ told[:3, :3].T).as_rotvec()
    change = np.concatenate([turn, pose[:3, 3] - told[:3, 3]])
    return math.sqrt(float(change @ np.linalg.solve(covariance, change)) / len(change))


def _stepped(pose: FloatArray, step: FloatArray) -> FloatArray:
    moved = np.eye(4)
    moved[:3, :3] = Rotation.from_rotvec(step[:3]).as_matrix() @ pose[:3, :3]
    moved[:3, 3] = pose[:3, 3] + step[3:]
    return moved


def _residual(
    points: FloatArray, pose: FloatArray, static: Sequence[Solid], movers: Sequence[Solid], floor: bool
) -> float:
    ones = np.ones(len(points))
    distance = _rows(points, ones, pose, static, movers, floor, TRIMS_M[0])[1]
    return float(np.median(np.abs(distance))) if len(distance) else 0.0
