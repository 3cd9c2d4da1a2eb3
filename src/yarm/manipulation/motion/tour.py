"""In which order, and bent which way, the arm goes through its checkpoints; and straight lines from one to the next.

The exact tour chooses order and inverse-kinematics branches together, as a shortest path over (checkpoints visited,
last one, its branch): M. Held, R. M. Karp, "A dynamic programming approach to sequencing problems", Journal of the
Society for Industrial and Applied Mathematics 10, 1962.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from yarm.geometry import FloatArray, IntArray
from yarm.manipulation.kinematics.forward import checked_joints, forward, forward_many
from yarm.manipulation.kinematics.inverse import inverse
from yarm.manipulation.kinematics.inverse_many import inverse_many
from yarm.manipulation.motion.checkpoints import Checkpoint
from yarm.robots.youbot import Joints

MOST_EXACT = 12
"""Checkpoints that the exact order is found for; each more doubles its work."""
STEPS = 60
"""Samples of a straight line on which the joints' continuity is checked."""
MOST_STEP_RAD = 0.35
"""A joint that moves by more between two samples has jumped to another branch."""
COURSEWORK_POINTS = 5


class Order(Enum):
    """How the order is found: the coursework's nearest neighbour in space, or the shortest tour of the joints."""

    GREEDY = "coursework"
    EXACT = "exact"


class TourError(ValueError):
    """No tour can be made; the message says why."""


@dataclass(frozen=True, eq=False)
class Tour:
    """An order with a configuration for each checkpoint.

    Attributes:
        names: of the checkpoints, in the order they are visited.
        joints: (n, 5), rad, of each.
        length_rad: way of the joints from the start through all of them (Euclidean, straight in joint space).
        order: how it was found.
        unreachable: checkpoints left out, with the reason.
    """

    names: Tuple[str, ...]
    joints: FloatArray
    length_rad: float
    order: Order
    unreachable: Dict[str, str]


class LineStatus(Enum):
    """Whether the end effector can go straight without a joint that jumps."""

    STRAIGHT = "straight"
    BROKEN = "broken"


@dataclass(frozen=True, eq=False)
class Line:
    """A straight way of the end effector.

    Attributes:
        status: whether it exists.
        joints: (points + 2, 5), rad, both ends among them; straight in joint space when there is none.
        reason: why there is none.
    """

    status: LineStatus
    joints: FloatArray
    reason: str = ""


def plan_tour(
    start: npt.ArrayLike,
    checkpoints: Sequence[Checkpoint],
    order: Order,
    fault: Optional[Callable[[Joints], str]] = None,
) -> Tour:
    """Order and configurations.

    Args:
        start: joints (5,), rad, where it begins; it does not return there.
        checkpoints: what is visited; those out of reach are left out and named.
        order: how.
        fault: says what is wrong with a configuration, for instance what it touches; empty when nothing is.

    Raises:
        TourError: nothing can be reached, or more than ``MOST_EXACT`` for the exact order.
    """
    here = checked_joints(start)
    choices, unreachable = {}, {}
    for index, point in enumerate(checkpoints):
        answer = inverse(point.pose)
        faults = ["" if fault is None else fault(q) for q in answer.solutions]
        good = [q for q, wrong in zip(answer.solutions, faults) if not wrong]
        if good:
            choices[index] = np.array(good)
        else:
            unreachable[point.name] = answer.reason or f"no configuration is free: {'; '.join(faults)}"
    reached = list(choices)
    if not reached:
        raise TourError(f"none of {len(checkpoints)} checkpoints can be reached: {unreachable}")
    if order is Order.EXACT and len(reached) > MOST_EXACT:
        raise TourError(f"the exact order is found for {MOST_EXACT} checkpoints at most, not {len(reached)}")
    branches = list(choices.values())
    if order is Order.EXACT:
        visited, joints = _exact(here, branches)
    else:
        visited, joints = _greedy(here, branches, [checkpoints[index].pose[:3, 3] for index in reached])
    ways = np.diff(np.vstack([here, joints]), axis=0)
    names = tuple(checkpoints[reached[index]].name for index in visited)
    return Tour(names, joints, float(np.linalg.norm(ways, axis=1).sum()), order, unreachable)


def straight_line(start: npt.ArrayLike, goal: npt.ArrayLike, points: int = COURSEWORK_POINTS) -> Line:
    """The end effector goes straight from one configuration to another; the tool's tilt and spin turn evenly.

    Every pose on the way lies in a plane of axis 1, so that it has an exact answer, and the branch is kept.

    Args:
        start: joints (5,), rad.
        goal: joints (5,), rad.
        points: between the two.
    """
    a, b = checked_joints(start), checked_joints(goal)
    direct = a + np.linspace(0.0, 1.0, points + 2)[:, None] * (b - a)
    shares = np.linspace(0.0, 1.0, STEPS * (points + 1) + 1)
    poses, fault = _line_poses(a, b, shares)
    if fault:
        return Line(LineStatus.BROKEN, direct, fault)
    batch = inverse_many(poses)
    # Joint 5 is known; the arc tangent gives it, as joint 1, up to a whole turn only.
    batch.q[:, :, 4] = np.where(np.isnan(batch.q[:, :, 4]), np.nan, (a[4] + shares * (b[4] - a[4]))[:, None])
    joints = np.empty((len(shares), 5))
    joints[0] = a
    for index in range(1, len(shares)):
        found, there = _nearest_of(batch.q[index], batch.within[index], joints[index - 1])
        step = float(np.max(np.abs(found - joints[index - 1]))) if there else math.inf
        if step > MOST_STEP_RAD:
            why = f"a joint would jump by {step:.2f} rad" if there else "no configuration within the limits"
            return Line(LineStatus.BROKEN, direct, f"{why} at {100.0 * shares[index]:.0f} % of the way")
        joints[index] = found
    if np.max(np.abs(joints[-1] - b)) > 1e-6:
        return Line(LineStatus.BROKEN, direct, "it would end in another branch")
    return Line(LineStatus.STRAIGHT, joints[::STEPS])


def _nearest_of(q: FloatArray, within: npt.NDArray[np.bool_], near: FloatArray) -> Tuple[FloatArray, bool]:
    """Of one pose's configurations (4, 5) the one within limits nearest to given joints, and whether there is one."""
    if not within.any():
        return near, False
    far = np.where(within, np.max(np.abs(q - near), axis=1), np.inf)
    return q[int(np.argmin(far))], True


def _line_poses(a: FloatArray, b: FloatArray, shares: FloatArray) -> Tuple[FloatArray, str]:
    """Poses (m, 4, 4) of the straight way, each in a plane of axis 1; or why there are none."""
    ends = [forward(q) for q in (a, b)]
    outs = [math.cos(q[0]) * pose[0, 3] + math.sin(q[0]) * pose[1, 3] for q, pose in zip((a, b), ends)]
    if outs[0] * outs[1] <= 0.0:
        return np.zeros((0, 4, 4)), "the hand is ahead of axis 1 at one end and behind it at the other"
    xyz = ends[0][:3, 3] + shares[:, None] * (ends[1][:3, 3] - ends[0][:3, 3])
    side = math.copysign(1.0, outs[0])
    heading = np.arctan2(side * xyz[:, 1], side * xyz[:, 0])
    tilt = a[1:4].sum() + shares * (b[1:4].sum() - a[1:4].sum())
    spin = a[4] + shares * (b[4] - a[4])
    # Rz(heading) Ry(tilt) Rz(-spin) is the forward kinematics' own rotation at these angles.
    poses = forward_many(np.column_stack([heading, tilt, np.zeros_like(tilt), np.zeros_like(tilt), spin]))
    poses[:, :3, 3] = xyz
    return poses, ""


def _greedy(
    start: FloatArray, branches: Sequence[FloatArray], positions: Sequence[FloatArray]
) -> Tuple[List[int], FloatArray]:
    """Always the checkpoint nearest in space, in the branch nearest to where the joints are."""
    here, at = start, forward(start)[:3, 3]
    left, visited, joints = list(range(len(branches))), [], []
    while left:
        index = min(left, key=lambda i: float(np.linalg.norm(positions[i] - at)))
        left.remove(index)
        here = branches[index][int(np.argmin(np.linalg.norm(branches[index] - here, axis=1)))]
        at = positions[index]
        visited.append(index)
        joints.append(here)
    return visited, np.array(joints)


def _exact(start: FloatArray, branches: Sequence[FloatArray]) -> Tuple[List[int], FloatArray]:
    """The order and branches with the shortest way of the joints."""
    nodes = np.concatenate(branches)
    owner: IntArray = np.repeat(np.arange(len(branches)), [len(b) for b in branches])
    between = np.linalg.norm(nodes[:, None] - nodes[None], axis=2)
    count = len(branches)
    cost = np.full((1 << count, len(nodes)), np.inf)
    came = np.full((1 << count, len(nodes)), -1)
    cost[1 << owner, np.arange(len(nodes))] = np.linalg.norm(nodes - start, axis=1)
    for visited in range(1, 1 << count):
        # The last node is one of those visited; where it is not, the cost is infinite.
        through = cost[visited][:, None] + between
        best = np.argmin(through, axis=0)
        arrived = through[best, np.arange(len(nodes))]
        for index in range(count):
            if visited >> index & 1:
                continue
            mine = np.flatnonzero(owner == index)
            after = visited | 1 << index
            better = mine[arrived[mine] < cost[after, mine]]
            cost[after, better] = arrived[better]
            came[after, better] = best[better]
    visited, node = (1 << count) - 1, int(np.argmin(cost[-1]))
    order, joints = [], []
    while node >= 0:
        order.append(int(owner[node]))
        joints.append(nodes[node])
        visited, node = visited & ~(1 << int(owner[node])), int(came[visited, node])
    return order[::-1], np.array(joints[::-1])
