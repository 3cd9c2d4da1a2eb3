"""The coursework's tasks, each run and summed up in rows of a table."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray, transform_matrix
from yarm.geometry.solids import Shape, Solid
from yarm.manipulation.coverage.floor import BaseWay, Floor, field_way, lay_floor, planned_way
from yarm.manipulation.coverage.spanning_tree import Coverage, cover, visits
from yarm.manipulation.kinematics.coursework import Mended, printed_forward_many, printed_inverse
from yarm.manipulation.kinematics.forward import forward_many
from yarm.manipulation.kinematics.inverse import inverse
from yarm.manipulation.motion.checkpoints import ArmScene, Obstacle, moved_obstacles
from yarm.manipulation.motion.tour import Line, LineStatus, Order, Tour, plan_tour, straight_line
from yarm.manipulation.motion.trajectory import (
    Trajectory,
    arm_limits,
    check_limits,
    jerk_limited,
    quintic,
    through_waypoints,
    trapezoid,
)
from yarm.manipulation.obstacles.physics import ArmWatch, ArmWorld, TaskPlayed, play_task, unwatched
from yarm.manipulation.obstacles.ways import Variant, plan_ways
from yarm.robots.hc10 import station_boxes
from yarm.robots.youbot import random_joints

CLOSE = 1e-6
POSES = 2000
SPREAD_M = 0.005
"""Obstacles of a seed other than 0 stand up to so far from where the scene has them."""
FLOOR_HALF_M = 2.5
FLOOR_CELL_M = 0.25
BASE_RADIUS_M = 0.35
BASE_START = (-2.0, -1.2)
BASE_GOALS = ((-1.8, 0.0), (1.8, 0.0), (1.2, 1.9), (-2.0, 1.6))
Rows = List[Tuple[str, ...]]


@dataclass(frozen=True, eq=False)
class TaskResult:
    """What a task came to.

    Attributes:
        title: of its table.
        header: of the table.
        rows: of the table.
        faults: what is not as it must be.
    """

    title: str
    header: Tuple[str, ...]
    rows: Rows
    faults: Tuple[str, ...]


@dataclass(frozen=True, eq=False)
class TourResult:
    """Tours of one set of checkpoints, and the lines between the exact one's."""

    task: TaskResult
    tours: Dict[Order, Tour]
    lines: Tuple[Line, ...]
    motion: Trajectory


@dataclass(frozen=True, eq=False)
class ObstacleResult:
    """The obstacle task by each method; ``scene`` is where its obstacles stood."""

    task: TaskResult
    scene: ArmScene
    played: Dict[str, TaskPlayed]


@dataclass(frozen=True, eq=False)
class FloorResult:
    """A floor covered, and a base's ways through checkpoints."""

    task: TaskResult
    floor: Floor
    coverage: Coverage
    ways: Dict[str, BaseWay]
    goals: Tuple[FloatArray, ...]
    obstacles: Tuple[Obstacle, ...]


def kinematics(seed: int) -> TaskResult:
    """The closed form beside what was printed, on the same configurations."""
    q = random_joints(np.random.default_rng(seed), POSES)
    poses, printed = forward_many(q), printed_forward_many(q)
    rows: Rows = []
    shares = []
    for name, wanted, solve, reach in (
        ("closed form, every branch", poses, lambda pose: inverse(pose).solutions, forward_many),
        ("printed formulas, on their own forward kinematics", printed, _printed(Mended()), printed_forward_many),
        ("the same, gamma mended", printed, _printed(Mended(gamma=True)), printed_forward_many),
        ("the same, gamma and theta5 mended", printed, _printed(Mended(True, True)), printed_forward_many),
        ("the same, on the arm's forward kinematics", poses, _printed(Mended(True, True)), forward_many),
    ):
        share, branches, micros = _solved(wanted, solve, reach)
        shares.append(share)
        rows.append((name, f"{100.0 * share:.1f} %", f"{branches:.2f}", f"{micros:.1f}"))
    faults = () if shares[0] == 1.0 else (f"the closed form solved {100.0 * shares[0]:.2f} % of {POSES} poses",)
    return TaskResult(f"inverse kinematics, {POSES} poses", ("method", "solved", "answers a pose", "us"), rows, faults)


def tours(scene: ArmScene) -> TourResult:
    """Greedy and exact order, straight lines between checkpoints, and every way of timing them."""
    found = {order: plan_tour(scene.start, scene.checkpoints, order) for order in Order}
    exact = found[Order.EXACT]
    ends = np.vstack([scene.start, exact.joints])
    lines = tuple(straight_line(a, b) for a, b in zip(ends[:-1], ends[1:]))
    points = np.vstack([ends[0], *(line.joints[1:] for line in lines)])
    limits = arm_limits()
    motion = through_waypoints(points, limits)
    rows: Rows = [
        (f"order: {order.value}", f"{tour.length_rad:.2f} rad", " ".join(tour.names)) for order, tour in found.items()
    ]
    straight = sum(line.status is LineStatus.STRAIGHT for line in lines)
    rows.append(("straight lines of the hand", f"{straight} of {len(lines)}", _reasons(lines)))
    faults = [f"{name}: {reason}" for name, reason in exact.unreachable.items()]
    for name, motions in (
        ("quintic, from point to point", [quintic(a, b, limits) for a, b in zip(ends[:-1], ends[1:])]),
        ("trapezoid", [trapezoid(a, b, limits) for a, b in zip(ends[:-1], ends[1:])]),
        ("jerk-limited", [jerk_limited(a, b, limits) for a, b in zip(ends[:-1], ends[1:])]),
        (f"TOPP-RA through all {len(points)} points", [motion]),
    ):
        checks = [check_limits(one, limits) for one in motions]
        speed, push = max(check.speed for check in checks), max(check.acceleration for check in checks)
        rows.append(
            (name, f"{sum(one.duration_s for one in motions):.2f} s", f"{speed:.2f} / {push:.2f} of the limits")
        )
        faults += [f"{name} exceeds a limit" for check in checks if not check.kept]
    header = ("tour of " + str(len(scene.checkpoints)) + " checkpoints", "result", "")
    return TourResult(TaskResult("tour", header, rows, tuple(faults)), found, lines, motion)


def play_tour(scene: ArmScene, motion: Trajectory, watch: ArmWatch) -> None:
    """Play a tour's motion in physics for somebody who looks on."""
    with ArmWorld(scene) as world:
        world.play([motion], watch)


def obstacles(
    scene: ArmScene, seed: int, watched: Callable[[ArmScene], ArmWatch] = lambda _: unwatched
) -> ObstacleResult:
    """The five checkpoints among obstacles by each method, played in physics.

    Args:
        scene: the task.
        seed: of the obstacles' places and the planner.
        watched: gives what looks on while the arm goes our way, for where the obstacles stand.
    """
    rng = np.random.default_rng(seed)
    moved = scene if seed == 0 else replace(scene, obstacles=tuple(moved_obstacles(scene.obstacles, rng, SPREAD_M)))
    played, rows = {}, []
    for variant in Variant:
        begun = time.process_time()
        ways = plan_ways(moved, variant, seed)
        planned_s = time.process_time() - begun
        for solid in (True, False) if variant is Variant.TURN_EXTEND_RETRACT else (True,):
            name = variant.value if solid else f"{variant.value}, obstacles yield"
            watch = watched(moved) if variant is Variant.YARM else unwatched
            played[name] = play_task(moved, ways, solid, watch)
            rows.append(_row(name, played[name], planned_s, len(moved.checkpoints)))
    ours = played[Variant.YARM.value]
    faults = [f"{leg.goal}: {leg.reason}" for leg in ours.legs if not leg.reached]
    faults += [f"touched: {pair}" for leg in ours.legs for pair in leg.touches]
    faults += [] if ours.reached == len(moved.checkpoints) else [f"reached {ours.reached} checkpoints only"]
    header = ("method", "reached", "touches", "simulated s", "planning s", "why not")
    return ObstacleResult(TaskResult("obstacle task, in physics", header, rows, tuple(faults)), moved, played)


def floors() -> FloorResult:
    """The cell's floor covered round table and stand, and a base's ways through checkpoints on it."""
    things = tuple(
        Obstacle(box.name, Solid(Shape.BOX, box.size, transform_matrix(box.centre, (0.0, 0.0, 0.0, 1.0))))
        for box in station_boxes()
    )
    floor = lay_floor(FLOOR_HALF_M, FLOOR_CELL_M, things, BASE_RADIUS_M)
    coverage = cover(floor.free, floor.cell(np.array(BASE_START)))
    entered = visits(coverage.cells, floor.free.shape)
    goals = tuple(np.array(goal) for goal in BASE_GOALS)
    start = np.array(BASE_START)
    fine = lay_floor(FLOOR_HALF_M, 0.1, things, BASE_RADIUS_M)
    ways = {
        "potential field": field_way(start, goals, things, BASE_RADIUS_M),
        "planned": planned_way(start, goals, fine),
    }
    rows: Rows = [
        ("closed round", f"{len(coverage.round)} cells", "each once"),
        ("covered after it, in no block", f"{len(coverage.loose)} cells", f"{len(coverage.after)} steps"),
        ("out of reach", f"{len(coverage.unreachable)} cells", ""),
    ]
    rows += [(f"base, {name}", f"{way.reached} of {len(goals)} checkpoints", way.reason) for name, way in ways.items()]
    faults = []
    if int((entered > 0).sum()) + len(coverage.unreachable) != int(floor.free.sum()):
        faults.append("a free cell was left out")
    if ways["planned"].reached < len(goals):
        faults.append(f"the planned way ended early: {ways['planned'].reason}")
    header = (f"floor of {int(floor.free.sum())} free cells", "result", "")
    return FloorResult(TaskResult("coverage", header, rows, tuple(faults)), floor, coverage, ways, goals, things)


def _printed(mended: Mended) -> Callable[[FloatArray], Sequence[Sequence[float]]]:
    def solve(pose: FloatArray) -> Sequence[Sequence[float]]:
        found: Optional[Sequence[float]] = printed_inverse(pose, mended)
        return () if found is None else (found,)

    return solve


def _solved(
    poses: FloatArray,
    solve: Callable[[FloatArray], Sequence[Sequence[float]]],
    reach: Callable[[FloatArray], FloatArray],
) -> Tuple[float, float, float]:
    """Share of poses with a right answer, right answers a pose, and median processor time of one, microseconds."""
    solved, right, times = 0, 0, []
    for pose in poses:
        begun = time.process_time_ns()
        answers = solve(pose)
        times.append((time.process_time_ns() - begun) / 1e3)
        if len(answers):
            good = np.abs(reach(np.array(answers)) - pose).max(axis=(1, 2)) < CLOSE
            solved += bool(good.any())
            right += int(good.sum())
    return solved / len(poses), right / len(poses), float(np.median(times))


def _reasons(lines: Sequence[Line]) -> str:
    return "; ".join(sorted({line.reason for line in lines if line.reason}))


def _row(name: str, played: TaskPlayed, planned_s: float, count: int) -> Tuple[str, ...]:
    first = next((leg.reason for leg in played.legs if not leg.reached), "")
    return (
        name,
        f"{played.reached} of {count}",
        str(played.touches),
        f"{played.duration_s:.1f}",
        f"{planned_s:.2f}",
        first,
    )
