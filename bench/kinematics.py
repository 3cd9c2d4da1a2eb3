#!/usr/bin/env python3
"""Inverse kinematics of the youBot's arm: ours, PyKDL, TRAC-IK, EAIK and the coursework's formulas on the same poses.

    python3 bench/kinematics.py [--poses 10000] [--page bench/kinematics.md]

TRAC-IK (pip install pytracik==0.0.3) and EAIK (pip install --no-deps eaik==1.2.2) are peers, not dependencies: without
them their lines say so. Times are of the process's processors, so that other work beside it changes less. A row a pose
or batch goes to ``bench/data/kinematics.csv``; the table is made of those rows.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Callable, Dict, Iterator, List, Optional, Sequence, Tuple

import numpy as np
import PyKDL
import raw_rows

from yarm.experiments.run.tables import markdown_table
from yarm.geometry.urdf import expand_xacro
from yarm.manipulation.kinematics.coursework import (
    Mended,
    printed_forward_many,
    printed_inverse,
    transposed_jacobian,
)
from yarm.manipulation.kinematics.forward import forward_many
from yarm.manipulation.kinematics.inverse import inverse
from yarm.manipulation.kinematics.inverse_many import IkBatch, inverse_many
from yarm.manipulation.kinematics.iterative import damped_least_squares
from yarm.resources import resource
from yarm.robots.youbot import (
    LOWER_RAD,
    UPPER_RAD,
    mechanical_angles,
    random_joints,
    urdf_angles,
    within_limits,
)

CLOSE = 1e-6
STARTS = 20
SLOW_POSES = {"kdl": 2000, "tracik": 500, "eaik": 1000, "descent": 200, "creep": 30}
BATCHES = (100, 1000, 10_000)
TITLES = {
    "closed": "ours, closed form",
    **{f"batch{size}": f"ours, batches of {size}" for size in BATCHES},
    "descent": f"ours, damped least squares, up to {STARTS} restarts",
    "kdl1": "PyKDL LMA, 1 start",
    "kdl": f"PyKDL LMA, up to {STARTS} starts until within limits",
    "tracik": "TRAC-IK Speed, 5 ms",
    "eaik": "EAIK",
    "printed": "printed formulas, on the printed forward kinematics",
    "gamma": "printed, gamma mended",
    "theta5": "printed, gamma and theta5 mended",
    "arm": "the last, on the arm's forward kinematics",
    "creep_printed": "transposed Jacobian, the Jacobian as printed (error < 2e-4 counts)",
    "creep": "transposed Jacobian, the Jacobian mended",
}
"""Methods: name in the raw rows, and in the table."""
MENDED = {"printed": Mended(), "gamma": Mended(gamma=True), "theta5": Mended(gamma=True, theta5=True)}
HEADER = ("method", "poses", "solved", "within limits", "all branches", "us median", "us p99")
Solve = Callable[[np.ndarray], Sequence[Sequence[float]]]
Row = Dict[str, object]
"""One call: ``method``, number of its ``first`` pose and how many ``poses`` it was given, how many of these were
``solved``, solved ``within`` limits, and given with every branch (``complete``; empty where nobody asks for branches),
and ``us``, processor time a pose."""


def main() -> int:
    """Measure every method and write the table."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--poses", type=int, default=10_000)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--page", type=Path, help="Markdown page to write the table to")
    chosen = options.parse_args()
    q = random_joints(np.random.default_rng(chosen.seed), chosen.poses)
    poses = forward_many(q)
    print(f"seed {chosen.seed}, {chosen.poses} poses", flush=True)
    rows: List[Row] = []
    lines: List[Tuple[str, ...]] = []
    for name, part in chain(ours(poses), kdl(poses), tracik(poses), eaik(poses), printed(q, poses)):
        rows += part
        lines.append(line(TITLES[name], part))
        print("  ".join(lines[-1]), flush=True)
    raw_rows.save(raw_rows.DATA / "kinematics.csv", rows)
    table = markdown_table(HEADER, lines)
    if chosen.page is not None:
        command = f"python3 bench/kinematics.py --poses {chosen.poses} --seed {chosen.seed} --page {chosen.page}"
        text = chosen.page.read_text(encoding="utf-8") if chosen.page.is_file() else f"{BEGIN}\n{END}\n"
        before, after = text.partition(BEGIN)[0], text.partition(END)[2]
        chosen.page.write_text(f"{before}{BEGIN}\n`{command}`\n\n{table}\n{END}{after}", encoding="utf-8")
    return 0


BEGIN, END = "<!-- table -->", "<!-- end of table -->"


Measured = Iterator[Tuple[str, List[Row]]]
"""Methods with their rows, as they are measured."""


def line(title: str, rows: Sequence[Row]) -> Tuple[str, ...]:
    """A method's line of the table, of its rows."""
    if not rows:
        return (title, "not installed", *("",) * (len(HEADER) - 2))
    column = {key: np.array([row[key] for row in rows]) for key in rows[0]}
    count = int(column["poses"].sum())
    asked = rows[0]["complete"] != ""
    median, high = np.percentile(column["us"], (50, 99))
    digits = 1 if rows[0]["poses"] == 1 else 2
    return (
        title,
        str(count),
        f"{100.0 * column['solved'].sum() / count:.2f} %",
        f"{100.0 * column['within'].sum() / count:.2f} %",
        f"{100.0 * column['complete'].sum() / count:.1f} %" if asked else "no",
        f"{median:.{digits}f}",
        f"{high:.{digits}f}",
    )


def ours(poses: np.ndarray) -> Measured:
    """The closed form, one at a time and in batches, and damped least squares."""
    yield measured("closed", poses, lambda pose: inverse(pose).solutions, branches=True)
    for size in BATCHES:
        starts = range(0, len(poses), size)
        yield f"batch{size}", [batched(f"batch{size}", first, poses[first : first + size]) for first in starts]
    part = poses[: SLOW_POSES["descent"]]
    yield measured("descent", part, lambda pose: [damped_least_squares(pose, np.zeros(5), restarts=STARTS).q])


def batched(name: str, first: int, poses: np.ndarray) -> Row:
    """The row of one call for many poses."""
    batch, spent = timed(lambda: inverse_many(poses))
    assert isinstance(batch, IkBatch)
    reached = forward_many(np.nan_to_num(batch.q).reshape(-1, 5)).reshape(*batch.q.shape[:2], 4, 4)
    right = batch.within & (np.abs(reached - poses[:, None]).max(axis=(2, 3)) < CLOSE)
    solved = int(right.any(axis=1).sum())
    complete = sum(len(inverse(pose).solutions) == found for pose, found in zip(poses, right.sum(axis=1)))
    return row_of(name, first, len(poses), solved, solved, complete, spent / len(poses))


def kdl(poses: np.ndarray) -> Measured:
    """PyKDL's Levenberg-Marquardt from the middle, and from up to twenty starts."""
    table = (
        (-0.033, np.pi / 2, 0.145, np.pi),
        (0.155, 0.0, 0.0, np.pi / 2),
        (0.135, 0.0, 0.0, 0.0),
        (0.002, np.pi / 2, 0.0, -np.pi / 2),
        (0.0, np.pi, -0.185, np.pi),
    )
    chain = PyKDL.Chain()
    for a, alpha, d, theta in table:
        chain.addSegment(PyKDL.Segment(PyKDL.Joint(PyKDL.Joint.RotZ), PyKDL.Frame.DH(a, alpha, d, theta)))
    solver = PyKDL.ChainIkSolverPos_LMA(chain, np.array([[1.0], [1.0], [1.0], [0.3], [0.3], [0.3]]), 1e-8, 500)
    starts = [np.zeros(5), *random_joints(np.random.default_rng(0), STARTS - 1)]

    def solve(pose: np.ndarray, count: int) -> Sequence[Sequence[float]]:
        frame = PyKDL.Frame(PyKDL.Rotation(*pose[:3, :3].ravel().tolist()), PyKDL.Vector(*pose[:3, 3].tolist()))
        for start in starts[:count]:
            guess, found = PyKDL.JntArray(5), PyKDL.JntArray(5)
            for index in range(5):
                guess[index] = float(start[index])
            solver.CartToJnt(guess, frame, found)
            q = np.remainder([found[i] + np.pi for i in range(5)], 2.0 * np.pi) - np.pi
            if np.max(np.abs(forward_many(q[None])[0] - pose)) < CLOSE and (count == 1 or within_limits(q)):
                return [q]
        return []

    part = poses[: SLOW_POSES["kdl"]]
    yield measured("kdl1", part, lambda pose: solve(pose, 1))
    yield measured("kdl", part, lambda pose: solve(pose, STARTS))


def tracik(poses: np.ndarray) -> Measured:
    """TRAC-IK on the URDF; its threads race a wall clock, so that a busy machine costs it answers."""
    try:
        from trac_ik import TracIK  # noqa: PLC0415 (a peer that need not be there)
    except ImportError:
        yield "tracik", []
        return
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "arm.urdf"
        path.write_text(expand_xacro(resource("urdf", "manipulation", "youbot.urdf.xacro"), base="false"))
        solver = TracIK("arm_frame", "arm_link_ee", str(path), timeout=0.005, epsilon=1e-7, solver_type="Speed")
    middle = urdf_angles(0.5 * (np.array(LOWER_RAD) + np.array(UPPER_RAD)))

    def solve(pose: np.ndarray) -> Sequence[Sequence[float]]:
        found = solver.ik(pose[:3, 3], pose[:3, :3], seed_jnt_values=middle)
        return [] if found is None else [mechanical_angles(found)]

    yield measured("tracik", poses[: SLOW_POSES["tracik"]], solve)


def eaik(poses: np.ndarray) -> Measured:
    """EAIK (D. Ostermeier et al.), which derives a closed form from the axes; it knows no limits."""
    try:
        from eaik.IK_HP import HPRobot  # noqa: PLC0415
    except ImportError:
        yield "eaik", []
        return
    axes = np.array([[0, 0, 1], [0, 1, 0], [0, 1, 0], [0, 1, 0], [0, 0, -1]], dtype=float)
    offsets = np.array([[0, 0, 0], [0.033, 0, 0.145], [0, 0, 0.155], [0, 0, 0.135], [-0.002, 0, 0], [0, 0, 0.185]])
    robot = HPRobot(axes, offsets)

    def solve(pose: np.ndarray) -> Sequence[Sequence[float]]:
        found = robot.IK(pose)
        return [q for q, rough in zip(found.Q, found.is_LS) if not rough]

    yield measured("eaik", poses[: SLOW_POSES["eaik"]], solve, branches=True, all_limits=True)


def printed(q: np.ndarray, poses: np.ndarray) -> Measured:
    """The coursework's formulas on the forward kinematics it printed, and its iteration on the right ones."""
    own = printed_forward_many(q)
    for name, mended in MENDED.items():
        yield measured(name, own, one_of(mended), reach=printed_forward_many)
    yield measured("arm", poses, one_of(MENDED["theta5"]))
    part = poses[: SLOW_POSES["creep"]]
    middle = 0.5 * (np.array(LOWER_RAD) + np.array(UPPER_RAD))

    def creep(pose: np.ndarray, as_printed: bool) -> Sequence[Sequence[float]]:
        answer = transposed_jacobian(pose, middle, printed=as_printed)
        return [np.remainder(np.array(answer.q) + np.pi, 2.0 * np.pi) - np.pi] if answer.converged else []

    for name, as_printed in (("creep_printed", True), ("creep", False)):
        yield measured(name, part, partial(creep, as_printed=as_printed), close=2e-4)


def one_of(mended: Mended) -> Solve:
    """The printed formulas as a method."""

    def solve(pose: np.ndarray) -> Sequence[Sequence[float]]:
        found: Optional[Sequence[float]] = printed_inverse(pose, mended)
        return [] if found is None else [found]

    return solve


def measured(
    name: str,
    poses: np.ndarray,
    solve: Solve,
    branches: bool = False,
    all_limits: bool = False,
    close: float = CLOSE,
    reach: Callable[[np.ndarray], np.ndarray] = forward_many,
) -> Tuple[str, List[Row]]:
    """A row a pose: it counts as solved when an answer's own pose is within ``close`` of it, metres and entries."""
    rows = []
    for number, pose in enumerate(poses):
        answers, spent = timed(lambda pose=pose: solve(pose))
        q = np.array(answers, dtype=float).reshape(-1, 5)
        right = np.abs(reach(q) - pose).max(axis=(1, 2)) < close if len(q) else np.zeros(0, dtype=bool)
        complete: object = ""
        if branches:
            known = inverse(pose)
            wanted = len(known.solutions) + (len(known.beyond) if all_limits else 0)
            complete = int(right.sum() == wanted)
        within = int((right & within_limits(q)).any())
        rows.append(row_of(name, number, 1, int(right.any()), within, complete, spent))
    return name, rows


def row_of(name: str, first: int, poses: int, solved: int, within: int, complete: object, us: float) -> Row:
    """One call's row."""
    keys = ("method", "first", "poses", "solved", "within", "complete", "us")
    return dict(zip(keys, (name, first, poses, solved, within, complete, round(us, 3))))


def timed(call: Callable[[], object]) -> Tuple[object, float]:
    """What a call gives, and its processor time, microseconds."""
    begun = time.process_time_ns()
    result = call()
    return result, (time.process_time_ns() - begun) / 1e3


if __name__ == "__main__":
    raise SystemExit(main())
