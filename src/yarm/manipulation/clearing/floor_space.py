"""Where the youBot's base may be on a floor, and the shortest ways there: cells and headings, moves any way it likes.

The base is a rectangle, its arm and what hangs on it a second one ahead of it that only tall things are in the way of.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Optional, Sequence, Tuple

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import dijkstra

from yarm.geometry import BoolArray, FloatArray, IntArray, Pose2, wrap_angle
from yarm.geometry.solids import Shape, Solid

CELL_M = 0.10
HEADINGS = 16
MARGIN_M = 0.05
"""Distance that the base keeps to everything."""
TURN_M_PER_RAD = 0.3
"""A turn costs as much as so many metres."""
JOIN_M = 0.16
"""A pose is joined to cells no farther away."""
ESCAPE_M = 0.5
"""So far away a base that stands too near to something looks for a cell to back off to."""
CREEP_M = 0.002
STEP_M = 0.03
BASE_X_M, BASE_Y_M = (-0.29, 0.29), (-0.19, 0.19)
"""The base's outline with its wheels, base frame (a test compares it with the model)."""
ARM_X_M, ARM_Y_M = (0.29, 0.52), (-0.11, 0.11)
"""What the arm takes up ahead of that while the base goes, with a piece on the cup."""


@dataclass(frozen=True)
class Standing:
    """A thing on the floor: name, outline as a rectangle's middle, heading and half sides, and its top, metres."""

    name: str
    place: Pose2
    half: Tuple[float, float]
    top_m: float


def standing(name: str, solid: Solid) -> Standing:
    """The outline of an upright solid, world."""
    half = solid.half_extent
    yaw = math.atan2(solid.pose[1, 0], solid.pose[0, 0]) if solid.shape == Shape.BOX else 0.0
    x, y, z = solid.pose[:3, 3].tolist()
    return Standing(name, Pose2(x, y, yaw), (float(half[0]), float(half[1])), z + float(half[2]))


class FloorSpace:
    """Free poses of the base among things that stay, and ways between them."""

    def __init__(self, half_m: float, things: Sequence[Standing], under_arm_m: float) -> None:
        """Lay the floor.

        Args:
            half_m: half its side.
            things: what stands on it.
            under_arm_m: what is no taller than this passes under the arm.
        """
        self._half, self._things, self._under_arm_m = half_m, tuple(things), under_arm_m
        self._count = round(2.0 * half_m / CELL_M)
        self._nodes = self._poses()
        self._open = self.free(self._nodes)
        self._graph: Optional[csr_matrix] = None

    def free(self, poses: FloatArray) -> BoolArray:
        """Which poses (n, 3) of the base, metres and rad, keep the margin to things and to the floor's edge; (n,)."""
        return np.asarray(self.gaps(poses) >= MARGIN_M)

    def gaps(self, poses: FloatArray) -> FloatArray:
        """Lower bounds (n,) of the base's distance to things and the floor's edge, metres; below 0 in an overlap."""
        least = self._to_edge(poses)
        for thing in self._things:
            least = np.minimum(least, self._to(thing, poses))
        return least

    def in_the_way(self, pose: Pose2) -> str:
        """What is too near to the base at a pose, with the distance; empty when nothing is."""
        row = np.array([[pose.x, pose.y, pose.yaw_rad]])
        found = [("the floor's edge", float(self._to_edge(row)[0]))]
        found += [(thing.name, float(self._to(thing, row)[0])) for thing in self._things]
        name, gap = min(found, key=lambda item: item[1])
        return "" if gap >= MARGIN_M else f"{name} is {max(gap, 0.0):.3f} m away, {MARGIN_M:g} m is kept"

    def straight(self, start: Pose2, goal: Pose2) -> bool:
        """Whether the base may go straight from one pose to another, turning evenly."""
        return bool(self.free(_between(start, goal)).all())

    def ways_from(self, start: Pose2) -> Ways:
        """Shortest ways from a pose to everywhere."""
        joined = self.joined(start)
        if not len(joined):
            joined = self._escapes(start)
        lengths = np.full(len(self._nodes), np.inf)
        before = np.full(len(self._nodes), -1, dtype=np.int64)
        if len(joined):
            graph = self._edges()
            first = np.array([_cost(self._nodes[node], start) for node in joined])
            rows, came, _ = dijkstra(graph, directed=False, indices=joined, return_predecessors=True, min_only=True)
            # One source stands for all: they are neighbours, and what tells them apart is shorter than a cell.
            lengths, before = rows + first.min(), came.astype(np.int64)
        return Ways(self, start, lengths, before)

    def joined(self, pose: Pose2) -> IntArray:
        """Cells and headings near to a pose that it may go to straight, the nearest two."""
        near = np.hypot(self._nodes[:, 0] - pose.x, self._nodes[:, 1] - pose.y) < JOIN_M
        turned = np.abs(_wrapped(self._nodes[:, 2] - pose.yaw_rad)) < 2.0 * math.pi / HEADINGS
        nodes = np.flatnonzero(near & turned & self._open)
        nodes = nodes[np.argsort([_cost(self._nodes[node], pose) for node in nodes], kind="stable")]
        good = [node for node in nodes.tolist() if self.straight(pose, self.node(node))]
        return np.array(good[:2], dtype=np.int64)

    def _escapes(self, pose: Pose2) -> IntArray:
        """The nearest free cell that a base which stands too near to something may back off to; none when all is near.

        On the way it comes no nearer to anything that is nearer than the margin.
        """
        near = np.hypot(self._nodes[:, 0] - pose.x, self._nodes[:, 1] - pose.y) < ESCAPE_M
        turned = np.abs(_wrapped(self._nodes[:, 2] - pose.yaw_rad)) < 2.0 * math.pi / HEADINGS
        nodes = np.flatnonzero(near & turned & self._open)
        least = np.minimum(self._gaps_to_each(np.array([[pose.x, pose.y, pose.yaw_rad]])), MARGIN_M) - CREEP_M
        for node in nodes[np.argsort([_cost(self._nodes[node], pose) for node in nodes], kind="stable")]:
            way = _between(pose, self.node(int(node)))
            if np.all(self._gaps_to_each(way) >= least):
                return np.array([node], dtype=np.int64)
        return np.zeros(0, dtype=np.int64)

    def _gaps_to_each(self, poses: FloatArray) -> FloatArray:
        """As ``gaps``, to the floor's edge and each thing by itself, (n, 1 + things)."""
        return np.stack([self._to_edge(poses), *(self._to(thing, poses) for thing in self._things)], axis=1)

    def node(self, index: int) -> Pose2:
        """Pose of a cell and heading."""
        x, y, yaw = self._nodes[index].tolist()
        return Pose2(x, y, yaw)

    def nodes_of(self, poses: FloatArray) -> Tuple[IntArray, BoolArray]:
        """Cell and heading that each of the poses (n, 3) is in, (n,), and whether it is on the floor at all, (n,)."""
        cells = np.floor((poses[:, :2] + self._half) / CELL_M).astype(int)
        inside = np.all((cells >= 0) & (cells < self._count), axis=1)
        turn = np.rint(poses[:, 2] / (2.0 * math.pi / HEADINGS)).astype(int) % HEADINGS
        x, y = np.clip(cells, 0, self._count - 1).T
        return (x * self._count + y) * HEADINGS + turn, np.asarray(inside)

    def _poses(self) -> FloatArray:
        places = -self._half + CELL_M * (np.arange(self._count) + 0.5)
        headings = 2.0 * math.pi * np.arange(HEADINGS) / HEADINGS
        grid = np.meshgrid(places, places, _wrapped(headings), indexing="ij")
        return np.stack([axis.ravel() for axis in grid], axis=1)

    def _edges(self) -> csr_matrix:
        if self._graph is None:
            n = self._count
            index = np.arange(len(self._nodes)).reshape(n, n, HEADINGS)
            pairs = [
                (index[:-1], index[1:]),
                (index[:, :-1], index[:, 1:]),
                (index[:-1, :-1], index[1:, 1:]),
                (index[:-1, 1:], index[1:, :-1]),
                (index, np.roll(index, -1, axis=2)),
            ]
            a = np.concatenate([pair[0].ravel() for pair in pairs])
            b = np.concatenate([pair[1].ravel() for pair in pairs])
            both = self._open[a] & self._open[b]
            a, b = a[both], b[both]
            turn = _wrapped(self._nodes[b, 2] - self._nodes[a, 2])
            way = self._nodes[b, :2] - self._nodes[a, :2]
            midway = np.column_stack([self._nodes[a, :2] + 0.5 * way, self._nodes[a, 2] + 0.5 * turn])
            clear = self.free(midway)
            a, b = a[clear], b[clear]
            lengths = (np.hypot(way[:, 0], way[:, 1]) + TURN_M_PER_RAD * np.abs(turn))[clear]
            self._graph = coo_matrix((lengths, (a, b)), shape=(len(self._nodes),) * 2).tocsr()
        return self._graph

    def _to_edge(self, poses: FloatArray) -> FloatArray:
        c, s = np.abs(np.cos(poses[:, 2])), np.abs(np.sin(poses[:, 2]))
        reach = [c * BASE_X_M[1] + s * BASE_Y_M[1], s * BASE_X_M[1] + c * BASE_Y_M[1]]
        return np.asarray(np.min([self._half - np.abs(poses[:, axis]) - reach[axis] for axis in (0, 1)], axis=0))

    def _to(self, thing: Standing, poses: FloatArray) -> FloatArray:
        gap = _rectangle_gaps(poses, BASE_X_M, BASE_Y_M, thing)
        if thing.top_m <= self._under_arm_m:
            return gap
        return np.minimum(gap, _rectangle_gaps(poses, ARM_X_M, ARM_Y_M, thing))


class Ways:
    """Shortest ways from one pose."""

    def __init__(self, space: FloorSpace, start: Pose2, lengths: FloatArray, before: IntArray) -> None:
        """What the search found.

        Args:
            space: of the ways.
            start: where they begin.
            lengths: (n,) to each cell and heading, metres; inf where none leads.
            before: (n,) the one before on the way.
        """
        self._space, self._start, self._lengths, self._before = space, start, lengths, before

    def lengths_to(self, poses: FloatArray) -> FloatArray:
        """About how long the way to each of the poses (n, 3) is, metres: that to its nearest cell; inf without one."""
        nodes, inside = self._space.nodes_of(poses)
        return np.where(inside, self._lengths[nodes], np.inf)

    def to(self, goal: Pose2) -> Tuple[Pose2, ...]:
        """Poses from one to the next of which the base may go straight, both ends among them; none without a way."""
        if self._space.straight(self._start, goal):
            return (self._start, goal)
        ends = [node for node in self._space.joined(goal).tolist() if math.isfinite(self._lengths[node])]
        if not ends:
            return ()
        node = min(ends, key=lambda index: float(self._lengths[index]))
        nodes: List[int] = []
        while node >= 0:
            nodes.append(node)
            node = int(self._before[node])
        return self._shortened([self._start, *(self._space.node(index) for index in nodes[::-1]), goal])

    def _shortened(self, way: List[Pose2]) -> Tuple[Pose2, ...]:
        """Leave out what can be passed straight."""
        kept, at = [way[0]], 0
        while at < len(way) - 1:
            ahead = next(
                index
                for index in range(len(way) - 1, at, -1)
                if index == at + 1 or self._space.straight(way[at], way[index])
            )
            kept.append(way[ahead])
            at = ahead
        return tuple(kept)


def _between(start: Pose2, goal: Pose2) -> FloatArray:
    """Poses (n, 3) of a straight way, the goal among them."""
    turn = wrap_angle(goal.yaw_rad - start.yaw_rad)
    steps = max(1, math.ceil((start.distance(goal) + TURN_M_PER_RAD * abs(turn)) / STEP_M))
    poses = [start.towards(goal, step / steps) for step in range(1, steps + 1)]
    return np.array([(p.x, p.y, p.yaw_rad) for p in poses])


def _cost(node: FloatArray, pose: Pose2) -> float:
    return math.hypot(node[0] - pose.x, node[1] - pose.y) + TURN_M_PER_RAD * abs(wrap_angle(node[2] - pose.yaw_rad))


def _wrapped(angles: FloatArray) -> FloatArray:
    return np.asarray(np.remainder(angles + math.pi, 2.0 * math.pi) - math.pi)


def _rectangle_gaps(
    poses: FloatArray, x_m: Tuple[float, float], y_m: Tuple[float, float], thing: Standing
) -> FloatArray:
    """Greatest gap (n,) along the axes of a base's rectangle and a thing's: no more than their distance."""
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    x, y = 0.5 * (x_m[0] + x_m[1]), 0.5 * (y_m[0] + y_m[1])
    half = np.array([0.5 * (x_m[1] - x_m[0]), 0.5 * (y_m[1] - y_m[0])])
    between = np.column_stack(
        [poses[:, 0] + c * x - s * y - thing.place.x, poses[:, 1] + s * x + c * y - thing.place.y]
    )
    turn = poses[:, 2] - thing.place.yaw_rad
    ct, st = np.abs(np.cos(turn)), np.abs(np.sin(turn))
    hx, hy = thing.half
    a, b = math.cos(thing.place.yaw_rad), math.sin(thing.place.yaw_rad)
    gaps = [
        np.abs(c * between[:, 0] + s * between[:, 1]) - half[0] - ct * hx - st * hy,
        np.abs(c * between[:, 1] - s * between[:, 0]) - half[1] - st * hx - ct * hy,
        np.abs(a * between[:, 0] + b * between[:, 1]) - hx - ct * half[0] - st * half[1],
        np.abs(a * between[:, 1] - b * between[:, 0]) - hy - st * half[0] - ct * half[1],
    ]
    return np.asarray(np.max(gaps, axis=0))
