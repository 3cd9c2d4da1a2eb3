"""Independent proof that one step of the fleet touches nothing; shares no code with any planner.

The planners work on column images and tables; this module works on the motion itself. A robot is a set of solid cells.
On the way to a waypoint each cell's square first turns about the end effector (dense angles, each square tested exactly
against the cells it may overlap), then slides to the centre of the waypoint's column (the hexagon a sliding square
sweeps, tested exactly; both by separating axes, S. Gottschalk, M. C. Lin, D. Manocha, "OBBTree", SIGGRAPH 1996). When
the robot's cells at the new heading are known (``Robot.mask_at``) they slide in place of the turned squares, and what
is swept in the turn is what both the cells before it, turned on, and those after it, turned back, overlap. Every
grid cell whose interior is overlapped is swept, and so is every cell the robot occupies at the start. This is done for
the motion planned, from column centre to column centre, and, when the end effector stands off its column's centre,
again for the motion it will really make from there.

A step is safe when, for each robot that moves,

* no cell swept by either motion is occupied in the robot-less map, nor swept by another robot, moving or not;
* no cell swept by the planned motion has such a cell among its 26 neighbours. Perceived cells are noisy: what is beside
  a robot's present cells already, an occupied cell or one another robot stands on, may stay a neighbour;
* no cell of the planned motion is outside the grid. A robot that starts partly outside may not reach further out on any
  side;
* no swept column is forbidden. A robot that starts in forbidden columns may only end with fewer of them.

Cells that two robots both claim at the start are not held against them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Collection, List, Mapping, Optional, Sequence, Tuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage
from scipy.spatial import cKDTree

from yarm.geometry import BoolArray, FloatArray, IntArray, Mask
from yarm.planning.model.types import FleetPlan, PlanRequest, Robot, StepCheck, Waypoint

PENETRATION_M = 1e-6
"""Squares that overlap by less, metres, only touch."""
ARC_CELLS = 0.1
"""Largest way of a robot's outermost point between two angles that are looked at, cells."""
HALF_TURN_RAD = math.radians(179.0)
"""From here on a turn may go either way round, so both are swept."""
ROUNDED_M = 0.22
"""A base leaves a leg no earlier than this before a corner that it drives round, metres."""
KEPT_MOTIONS = 256
"""Motions that are remembered, of some ten kilobytes each."""
Way = Sequence[Waypoint]
"""Waypoints in order, the last of them the end."""
_CODE = np.int64(1) << 20


@dataclass(frozen=True, eq=False)
class Sweep:
    """What one robot occupies from the start of a step to its end.

    Attributes:
        robot: its name.
        start: (n, 3) cells at the start, possibly outside the grid.
        cells: (m, 3) every cell touched on the way, the start included.
        real: (p, 3) the same for the motion from where the end effector really is.
        end: (k, 3) cells at the end.
        moves: false for a robot that stays.
    """

    robot: str
    start: IntArray
    cells: IntArray
    real: IntArray
    end: IntArray
    moves: bool


def check_step(request: PlanRequest, plan: FleetPlan) -> StepCheck:
    """Verdict on the steps of a plan, for the fleet and the map they were made for."""
    unknown = sorted(set(plan.robots) - {robot.name for robot in request.robots})
    if unknown:
        return StepCheck(False, f"the plan moves {', '.join(unknown)}, which the request does not have")
    sweeps: List[Sweep] = []
    for robot in request.robots:
        entry = plan.robots.get(robot.name)
        step = None if entry is None else entry.step
        if step is not None and not math.isfinite(step.yaw_rad):
            return StepCheck(False, f"{robot.name} is sent to a heading of {step.yaw_rad}, which is not finite")
        sweeps.append(sweep_of(request, robot, step))
    occupied = robotless_map(request)
    for verdict in (_check_borders(request, sweeps), _check_map(request, sweeps, occupied), _check_pairs(sweeps)):
        if not verdict.safe:
            return verdict
    return StepCheck(True)


def check_release(request: PlanRequest, released: Mapping[str, Way], under_way: Mapping[str, Way]) -> StepCheck:
    """Verdict on moves that are to be released while others are being made.

    A robot under way may be anywhere in its sweep, from where it is in the request, until it has been seen at its end.
    It was held against the map when it was released, and is again with every look.

    Args:
        request: the map of now; robots where they stand, those under way where they were last seen, or somewhere on
            their way before that, with their headings there.
        released: where robots are to be sent, and by what: those that stand, or go on from what they are doing.
        under_way: where the other robots under way were sent, and by what they still go.
    """
    sweeps: List[Sweep] = []
    for robot in request.robots:
        way = released.get(robot.name, under_way.get(robot.name, ()))
        faulty = next((step for step in way if not math.isfinite(step.yaw_rad)), None)
        if faulty is not None:
            return StepCheck(False, f"{robot.name} is sent to a heading of {faulty.yaw_rad}, which is not finite")
        sweeps.append(sweep_along(request, robot, way) if way else sweep_of(request, robot, None))
    unknown = sorted({*released, *under_way} - {robot.name for robot in request.robots})
    if unknown or not under_way.keys().isdisjoint(released):
        doubled = sorted(set(released) & set(under_way))
        return StepCheck(False, f"not in the request, or under way already: {', '.join(unknown + doubled)}")
    starting = [sweep for sweep in sweeps if sweep.robot in released]
    occupied = robotless_map(request)
    verdicts = (
        _check_borders(request, starting),
        _check_map(request, starting, occupied),
        _check_pairs(sweeps, released),
    )
    return next((verdict for verdict in verdicts if not verdict.safe), StepCheck(True))


def robotless_map(request: PlanRequest) -> BoolArray:
    """(gx, gy, gz) occupied cells but those of goals that are assigned."""
    occupied: BoolArray = np.array(request.occupied, dtype=np.bool_)
    for name in request.assignments.values():
        if name in request.goals:
            cells = request.goals[name].cells
            occupied[tuple(cells[request.spec.contains(cells)].T)] = False
    return occupied


def sweep_of(request: PlanRequest, robot: Robot, step: Waypoint | None) -> Sweep:
    """Everything a robot touches on its way to a waypoint; None for a robot that stays."""
    start = _distinct(robot.cells)
    if step is None:
        return Sweep(robot.name, start, start, start, start, False)
    size = np.asarray(request.spec.resolution[:2])
    lower = np.asarray(request.spec.lower[:2])
    centre = lower + (np.asarray(robot.column) + 0.5) * size
    target = lower + (np.asarray(step.column) + 0.5) * size
    angle = math.remainder(step.yaw_rad - robot.yaw_rad, 2.0 * math.pi)
    turned = None if robot.mask_at is None else robot.mask_at(step.yaw_rad).cells
    cells, end = _motion(start, turned, lower, size, centre, target, angle)
    real = cells
    if robot.position_m is not None and not np.allclose(robot.position_m, centre, rtol=0.0, atol=PENETRATION_M):
        real, _ = _motion(start, turned, lower, size, np.asarray(robot.position_m, dtype=float), target, angle)
    return Sweep(robot.name, start, cells, real, end, True)


def sweep_along(request: PlanRequest, robot: Robot, way: Way) -> Sweep:
    """Everything a robot touches on its way by waypoints to the last of them; at least one.

    It may drive round the corner at a waypoint, on an arc inside it, which lies between the legs and the short cut from
    ``ROUNDED_M`` before the waypoint to as far behind it. So the short cut counts as a leg does, margin and all.
    """
    first = leg = sweep_of(request, robot, way[0])
    cells, real = [first.cells], [first.real]
    before = np.asarray(robot.column)
    for at, to in zip(way, way[1:]):
        mask = Mask.from_cells(leg.end, at.column, at.yaw_rad)
        standing = Robot(robot.name, at.column, at.yaw_rad, mask, mask_at=robot.mask_at)
        corner, onward = np.asarray(at.column), np.asarray(to.column)
        short_cut = _short_cut(request, leg.end, before, corner, onward)
        leg, before = sweep_of(request, standing, to), corner
        cells += [short_cut, leg.cells]
        real += [short_cut, leg.real]
    touched, really = (_distinct(np.concatenate(parts)) for parts in (cells, real))
    return Sweep(robot.name, first.start, touched, really, leg.end, True)


def _short_cut(request: PlanRequest, cells: IntArray, before: IntArray, corner: IntArray, onward: IntArray) -> IntArray:
    """Cells touched from a leg to the next one, past the corner at which a robot would have the cells (n, 3)."""
    size, lower = np.asarray(request.spec.resolution[:2]), np.asarray(request.spec.lower[:2])
    at = lower + (corner + 0.5) * size
    ends = []
    for other in (before, onward):
        leg = (other - corner) * size
        length = float(np.linalg.norm(leg))
        ends.append(at + leg * (min(ROUNDED_M, length / 2.0) / length if length > 0.0 else 0.0))
    columns, heights = _columns(cells)
    squares = _Squares(lower + (columns + 0.5) * size - at, size)
    return _lifted(squares.slid(lower, ends[0], ends[1], 0.0), heights)


def _motion(
    start: IntArray,
    turned: Optional[IntArray],
    lower: FloatArray,
    size: FloatArray,
    pivot: FloatArray,
    target: FloatArray,
    angle: float,
) -> Tuple[IntArray, IntArray]:
    """Cells swept, and cells at the end, of a turn about the pivot and a slide of the pivot to the target.

    Args:
        start: (n, 3) cells before the turn.
        turned: (m, 3) cells after it, x and y from the pivot's column; None for those before it, turned.
        lower: corner of the grid, m.
        size: of a cell, m.
        pivot: where the end effector is, m.
        target: where it goes, m.
        angle: of the turn, rad.

    Returns:
        arrays that cannot be written to: the legs of a way that is looked at again and again are reckoned once.
    """
    cells = tuple(None if part is None else part.astype(np.int64).tobytes() for part in (start, turned))
    places = tuple(part.astype(float).tobytes() for part in (lower, size, pivot, target))
    return _known_motion(cells, places, angle)


@lru_cache(maxsize=KEPT_MOTIONS)
def _known_motion(
    cells: Tuple[Optional[bytes], ...], places: Tuple[bytes, ...], angle: float
) -> Tuple[IntArray, IntArray]:
    start, turned = (None if part is None else np.frombuffer(part, np.int64).reshape(-1, 3) for part in cells)
    lower, size, pivot, target = (np.frombuffer(part) for part in places)
    assert start is not None
    columns, heights = _columns(start)
    before = _Squares(lower + (columns + 0.5) * size - pivot, size)
    ways = [angle] if abs(angle) < HALF_TURN_RAD else [angle, angle - math.copysign(2.0 * math.pi, angle)]
    parts = [_lifted(before.at(lower, pivot, np.zeros(1)), heights)]
    turning = [_lifted(before.at(lower, pivot, before.angles(signed)), heights) for signed in ways]
    after, left = before, angle
    if turned is not None:
        columns, heights = _columns(turned)
        after, left = _Squares(columns * size, size), 0.0
        back = [_lifted(after.at(lower, pivot, -after.angles(signed)), heights) for signed in ways]
        turning = [_common(forth, again) for forth, again in zip(turning, back)]
    end = after.at(lower, target, np.array([left]))
    parts += [*turning, _lifted(np.concatenate([after.slid(lower, pivot, target, left), end]), heights)]
    found = _distinct(np.concatenate(parts)), _lifted(end, heights)
    for array in found:
        array.flags.writeable = False
    return found


def chessboard_clearance(occupied: BoolArray, sweeps: List[Sweep]) -> int:
    """Least number of free cells between a moving robot's sweep and anything else; -1 when something is overlapped."""
    least = max(occupied.shape)
    shape = np.asarray(occupied.shape)
    distance = ndimage.distance_transform_cdt(~occupied, metric="chessboard") if occupied.any() else None
    for sweep in sweeps:
        inside = sweep.cells[np.all((sweep.cells >= 0) & (sweep.cells < shape), axis=1)]
        if sweep.moves and distance is not None and len(inside):
            least = min(least, int(distance[tuple(inside.T)].min()) - 1)
    for i, first in enumerate(sweeps):
        for second in sweeps[i + 1 :]:
            if first.moves or second.moves:
                least = min(least, _gap(first.cells, second.cells) - 1)
    return least


@dataclass(frozen=True, eq=False)
class _Squares:
    """Rectangles of one cell's size, centred at (m, 2) metres from the pivot they turn about."""

    centres: FloatArray
    size: FloatArray

    def angles(self, angle: float) -> FloatArray:
        """Angles to look at between 0 and the given one, rad."""
        reach = float(np.linalg.norm(np.abs(self.centres) + self.size / 2.0, axis=1).max())
        count = math.ceil(abs(angle) * reach / (ARC_CELLS * float(self.size.min())))
        return np.linspace(0.0, angle, count + 1)

    def at(self, lower: FloatArray, pivot: FloatArray, angles: FloatArray) -> IntArray:
        """(k, 3) source square and cell x, y of every overlap at any of the angles."""
        return self._overlaps(lower, np.tile(pivot, (len(angles), 1)), angles, np.zeros(2))

    def slid(self, lower: FloatArray, pivot: FloatArray, target: FloatArray, angle: float) -> IntArray:
        """The same while the squares, turned by the angle, slide from one pivot to the other."""
        way = target - pivot
        count = max(1, math.ceil(float(np.max(np.abs(way) / self.size))))
        middles = pivot + (np.arange(count)[:, None] + 0.5) / count * way
        return self._overlaps(lower, middles, np.full(count, angle), way / count / 2.0)

    def _overlaps(self, lower: FloatArray, pivots: FloatArray, angles: FloatArray, half_way: FloatArray) -> IntArray:
        """Overlaps of the squares at pivots (a, 2), angles (a,), while they slide from ``-half_way`` to ``+half_way``.

        Two convex shapes overlap when their shadows overlap on the normals of all their sides: the grid's axes, the
        turned square's axes and the normal of the way. Those of the grid rule out most, each by x or y alone.
        """
        turned_x = np.column_stack([np.cos(angles), np.sin(angles)])
        turned_y = np.column_stack([-turned_x[:, 1], turned_x[:, 0]])
        half = self.size / 2.0
        reach = np.ceil((np.linalg.norm(self.size) / 2.0 + np.abs(half_way)) / self.size).astype(np.int64)

        def reached(axis: FloatArray) -> FloatArray:
            """Distance of centres along axes (a, 2) or (1, 2) from which on shadows do not overlap, (a,) metres."""
            own = half[0] * np.abs((axis * turned_x).sum(axis=-1)) + half[1] * np.abs((axis * turned_y).sum(axis=-1))
            limit: FloatArray = own + np.abs(axis @ half_way) + np.abs(axis) @ half - PENETRATION_M
            return limit

        cells, apart, near = [], [], []
        for k, axis in enumerate(np.eye(2)[:, None, :]):
            centres = pivots[:, None, k] + self.centres[:, 0] * turned_x[:, None, k]
            centres = centres + self.centres[:, 1] * turned_y[:, None, k]
            home = np.floor((centres - lower[k]) / self.size[k]).astype(np.int64)
            cells.append(home[:, :, None] + np.arange(-reach[k], reach[k] + 1))
            apart.append(lower[k] + (cells[k] + 0.5) * self.size[k] - centres[:, :, None])
            near.append(np.abs(apart[k]) < reached(axis)[:, None, None])
        at, source, i, j = np.nonzero(near[0][:, :, :, None] & near[1][:, :, None, :])
        x, y = apart[0][at, source, i], apart[1][at, source, j]
        overlap = np.ones(len(at), dtype=bool)
        axes = [turned_x, turned_y]
        if np.any(half_way):
            axes.append(np.array([[-half_way[1], half_way[0]]]) / np.linalg.norm(half_way))
        for axis in axes:
            along = np.broadcast_to(axis, turned_x.shape)
            overlap &= np.abs(x * along[at, 0] + y * along[at, 1]) < reached(axis)[at]
        at, source, i, j = at[overlap], source[overlap], i[overlap], j[overlap]
        return _distinct(np.column_stack([source, cells[0][at, source, i], cells[1][at, source, j]]))


def _distinct(rows: IntArray) -> IntArray:
    """Distinct rows (k, 3) of whole numbers, ordered; a table of flags is far quicker than sorting."""
    if len(rows) == 0:
        return rows
    lowest = rows.min(axis=0)
    nx, ny, nz = (int(n) for n in rows.max(axis=0) - lowest + 1)
    x, y, z = (rows - lowest).T
    flags = np.zeros(nx * ny * nz, dtype=bool)
    flags[(x * ny + y) * nz + z] = True
    found = np.flatnonzero(flags)
    result: IntArray = np.column_stack([found // (ny * nz), found // nz % ny, found % nz]) + lowest
    return result


def _columns(cells: IntArray) -> Tuple[IntArray, List[IntArray]]:
    """Distinct columns (m, 2) of cells (n, 3), and the z of each."""
    lowest = cells[:, :2].min(axis=0)
    ny = int(cells[:, 1].max() - lowest[1]) + 1
    keys, index = np.unique((cells[:, 0] - lowest[0]) * ny + cells[:, 1] - lowest[1], return_inverse=True)
    by_column = cells[np.argsort(index, kind="stable"), 2]
    heights = np.split(by_column, np.cumsum(np.bincount(index))[:-1])
    return np.column_stack([keys // ny, keys % ny]) + lowest, heights


def _lifted(touched: IntArray, heights: List[IntArray]) -> IntArray:
    """Cells (n, 3) of touched columns (k, 3: source, x, y), each as high as its source."""
    counts = np.array([len(z) for z in heights])
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    repeat = counts[touched[:, 0]]
    base = np.repeat(touched, repeat, axis=0)
    within = np.arange(len(base)) - np.repeat(np.cumsum(repeat) - repeat, repeat)
    z = np.concatenate(heights)[starts[base[:, 0]] + within]
    return _distinct(np.column_stack([base[:, 1], base[:, 2], z]))


def _check_borders(request: PlanRequest, sweeps: List[Sweep]) -> StepCheck:
    shape = np.asarray(request.spec.shape[:2])
    for sweep in sweeps:
        if not sweep.moves:
            continue
        for sign in (-1, 1):
            edge = np.zeros(2, dtype=np.int64) if sign < 0 else shape - 1
            allowed = np.maximum(0, (sign * (sweep.start[:, :2] - edge)).max(axis=0))
            out = np.any(sign * (sweep.cells[:, :2] - edge) > allowed, axis=1)
            if out.any():
                return _fault(f"{sweep.robot} would leave the mapped volume", sweep.cells[out])
        if request.forbidden is not None:
            verdict = _check_forbidden(request.forbidden, sweep)
            if not verdict.safe:
                return verdict
    return StepCheck(True)


def _check_forbidden(forbidden: BoolArray, sweep: Sweep) -> StepCheck:
    def count(cells: IntArray) -> IntArray:
        columns = np.unique(cells[:, :2], axis=0)
        inside = columns[np.all((columns >= 0) & (columns < forbidden.shape), axis=1)]
        result: IntArray = inside[forbidden[tuple(inside.T)]]
        return result

    before, during, after = count(sweep.start), count(sweep.cells), count(sweep.end)
    if len(during) and len(after) >= len(before):
        cells = np.column_stack([during, np.zeros(len(during), dtype=np.int64)])
        return _fault(f"{sweep.robot} would enter forbidden columns", cells)
    return StepCheck(True)


def _check_map(request: PlanRequest, sweeps: List[Sweep], occupied: BoolArray) -> StepCheck:
    near = _grown(occupied)
    standing: IntArray = np.argwhere(occupied)
    for sweep in sweeps:
        if not sweep.moves:
            continue
        for cells in (sweep.cells, sweep.real):
            inside = cells[request.spec.contains(cells)]
            overlapped = inside[occupied[tuple(inside.T)]]
            if len(overlapped):
                return _fault(f"{sweep.robot} would touch {_name_at(request, overlapped)}", overlapped)
        cells = sweep.cells[request.spec.contains(sweep.cells)]
        margin = near
        beside = cells_beside(standing, sweep.start)
        if len(beside):
            others = occupied.copy()
            others[tuple(beside.T)] = False
            margin = _grown(others)
        close = cells[margin[tuple(cells.T)]]
        if len(close):
            where = np.zeros_like(occupied)
            where[tuple(close.T)] = True
            culprit = np.argwhere(occupied & _grown(where))
            name = _name_at(request, culprit)
            return _fault(f"{sweep.robot} would come within one cell of {name}", close)
    return StepCheck(True)


def _check_pairs(sweeps: List[Sweep], released: Optional[Collection[str]] = None) -> StepCheck:
    """Whether two robots of which one moves would touch; of which one is released now, when that is given."""
    for i, first in enumerate(sweeps):
        for second in sweeps[i + 1 :]:
            if released is not None and first.robot not in released and second.robot not in released:
                continue
            if not (first.moves or second.moves):
                continue
            claimed = _common(first.start, second.start)
            for one, other in ((first.cells, second.cells), (first.real, second.real)):
                touched = _without(_common(one, other), claimed)
                if len(touched):
                    return _fault(f"{first.robot} and {second.robot} would touch", touched)
            close = _close_cells(first, second)
            if len(close):
                return _fault(f"{first.robot} and {second.robot} would come within one cell of each other", close)
    return StepCheck(True)


def _close_cells(first: Sweep, second: Sweep) -> IntArray:
    """Cells swept by the first beside cells swept by the second, but where they stand beside each other already."""
    one = _without(first.cells, cells_beside(first.start, second.start))
    other = _without(second.cells, cells_beside(second.start, first.start))
    return cells_beside(one, other)


def cells_beside(cells: IntArray, others: IntArray) -> IntArray:
    """Which of the cells (n, 3) are, or have among their 26 neighbours, one of the others (m, 3)."""
    if not len(cells) or not len(others):
        return cells[:0]
    low = np.maximum(cells.min(axis=0), others.min(axis=0)) - 1
    high = np.minimum(cells.max(axis=0), others.max(axis=0)) + 1
    if np.any(low > high):
        return cells[:0]
    cells = cells[np.all((cells >= low) & (cells <= high), axis=1)]
    others = others[np.all((others >= low) & (others <= high), axis=1)]
    near = np.zeros(high - low + 1, dtype=bool)
    near[tuple((others - low).T)] = True
    result: IntArray = cells[_grown(near)[tuple((cells - low).T)]]
    return result


def _common(first: IntArray, second: IntArray) -> IntArray:
    result: IntArray = first[np.isin(_codes(first), _codes(second))]
    return result


def _without(cells: IntArray, others: IntArray) -> IntArray:
    result: IntArray = cells[~np.isin(_codes(cells), _codes(others))] if len(others) else cells
    return result


def _grown(occupied: BoolArray) -> BoolArray:
    inflated: BoolArray = ndimage.binary_dilation(occupied, np.ones((3, 3, 3), dtype=bool))
    return inflated


def _codes(cells: IntArray) -> npt.NDArray[np.int64]:
    """One number for each cell, inside the grid or not."""
    codes: npt.NDArray[np.int64] = ((cells[:, 0] + _CODE // 2) * _CODE + cells[:, 1] + _CODE // 2) * 256 + cells[:, 2]
    return codes


def _gap(first: IntArray, second: IntArray) -> int:
    """Least chessboard distance between cells (n, 3) and (m, 3)."""
    distance, _ = cKDTree(first).query(second, p=math.inf)
    return int(distance.min())


def _name_at(request: PlanRequest, cells: IntArray) -> str:
    """Name of the object that has one of the cells."""
    wanted = _codes(cells)
    everything = {**request.objects, **{name: goal.cells for name, goal in request.goals.items()}}
    for name, own in everything.items():
        if np.isin(_codes(np.asarray(own, dtype=np.int64).reshape(-1, 3)), wanted).any():
            return name
    return "an unknown object"


def _fault(reason: str, cells: IntArray) -> StepCheck:
    x, y, z = (int(v) for v in cells[0])
    return StepCheck(False, f"{reason} at cell ({x}, {y}, {z}), {len(cells)} in all", cells.astype(float))
