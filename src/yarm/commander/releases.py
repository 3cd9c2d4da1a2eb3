"""Moves that were released: who is on the way where, until it is seen there."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Dict, List, Mapping, Optional, Tuple

import numpy as np

from yarm.commander.cell_state import CellState, TrackedRobot, standing_as
from yarm.geometry import IntArray, wrap_angle
from yarm.planning.fleet.release import ReleaseOrder, moves_of
from yarm.planning.model.types import Column, FleetPlan, PlannedMove, PlanRequest, Robot, Waypoint
from yarm.planning.verification.checker import Sweep, cells_beside, sweep_along, sweep_of

SEEN_WITHIN_S = 1.0
"""A robot that says it has arrived must be seen there within this, s."""
ONWARD_M = 1.0
"""A robot is told how to go on when it has so far to go, metres: it brakes from 1 m/s within 0.45 m."""
SHARPEST_RAD = math.radians(60.0)
"""At a sharper corner it stops first."""
SAME_YAW_RAD = math.radians(0.5)
"""Headings this near are the same: there is no turn."""
STILL_M, STILL_RAD, STILL_S = 0.01, math.radians(0.5), 0.2
"""A robot stands that has moved by less than this, metres and rad, for so long, s."""
SAME_TIME_S = 1e-6
"""Times closer than this are the same, s."""


@dataclass(frozen=True, eq=False)
class Released:
    """A move under way.

    Attributes:
        robot: as it stood when its move was released.
        end: where it was sent.
        cells: (n, 3) cells it may touch until it is seen there.
        there: the robot as it will stand at the end.
        reported_s: when it said that it has arrived; None when it has not.
        via: where it goes by and has not passed yet.
        began: where the leg to the first of those, or to the end, began.
        given: all waypoints that it was given since it stood.
        halted_s: when it was told to stop, or said that it has stopped, short of its end; None when it was not.
    """

    robot: Robot
    end: Waypoint
    cells: IntArray
    there: Robot
    began: Column
    given: Tuple[Waypoint, ...]
    reported_s: Optional[float] = None
    via: Tuple[Waypoint, ...] = ()
    halted_s: Optional[float] = None

    @property
    def way(self) -> Tuple[Waypoint, ...]:
        """Waypoints not passed yet, the end last."""
        return (*self.via, self.end)


@dataclass(frozen=True)
class Endings:
    """What a look has shown of the moves under way.

    Attributes:
        arrived: robots seen where they were sent.
        strayed: robots that say they have arrived and are not seen there.
        stand: robots that stopped short and are seen to stand.
    """

    arrived: Tuple[str, ...] = ()
    strayed: Tuple[str, ...] = ()
    stand: Tuple[str, ...] = ()


class Releases:
    """The plan being carried out, and the moves under way."""

    def __init__(self, cell: CellState) -> None:
        """Nothing under way, no plan."""
        self._cell = cell
        self.under_way: Dict[str, Released] = {}
        self._order = ReleaseOrder(())
        self._goals: Mapping[str, str] = {}
        self._ahead: Dict[str, Tuple[TrackedRobot, IntArray]] = {}
        self._sweeps: Dict[PlannedMove, IntArray] = {}
        self._looks: Dict[Tuple[str, PlannedMove], Tuple[float, bool]] = {}
        self._still: Dict[str, Tuple[float, TrackedRobot]] = {}

    @property
    def ends(self) -> Dict[str, Robot]:
        """Robots under way, as they will stand."""
        return {name: released.there for name, released in self.under_way.items()}

    @property
    def starts(self) -> Dict[str, Robot]:
        """Robots under way, as they stood when their moves were released."""
        return {name: released.robot for name, released in self.under_way.items()}

    @property
    def seen(self) -> Dict[str, Robot]:
        """Robots under way, as they are seen now; one that is not seen as it stood when its move was released."""
        return {name: self._seen(released) for name, released in self.under_way.items()}

    @property
    def targets(self) -> Dict[str, Waypoint]:
        """Where the robots under way were sent."""
        return {name: released.end for name, released in self.under_way.items()}

    @property
    def ways(self) -> Dict[str, Tuple[Waypoint, ...]]:
        """By what the robots under way still go to where they were sent."""
        return {name: released.way for name, released in self.under_way.items()}

    @property
    def given(self) -> Dict[str, Tuple[Waypoint, ...]]:
        """All that robots under way were given since they stood."""
        return {name: released.given for name, released in self.under_way.items()}

    @property
    def cells(self) -> Dict[str, IntArray]:
        """What the moves under way sweep."""
        return {name: released.cells for name, released in self.under_way.items()}

    def left_cells(self, turn_deg_per_cell: float) -> Dict[str, float]:
        """What the robots under way have left of their ways, cells; turns count as planned ones do."""
        left: Dict[str, float] = {}
        for name, released in self.under_way.items():
            robot = self._seen(released)
            places = np.array([robot.column, *(waypoint.column for waypoint in released.way)], dtype=float)
            turn_deg = math.degrees(abs(wrap_angle(released.end.yaw_rad - robot.yaw_rad)))
            way = float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())
            left[name] = way + turn_deg / turn_deg_per_cell
        return left

    def begin(self, robot: Robot, index: int, sweep: Sweep) -> None:
        """A move of the plan is sent, to a robot that stands, or to one under way that goes on with it."""
        end = self._order.release(index).end
        there = self._cell.robot_at(robot.name, end, sweep.end)
        before = self.under_way.get(robot.name)
        if before is None:
            self.under_way[robot.name] = Released(robot, end, sweep.cells, there, robot.column, (end,))
            return
        cells = np.unique(np.concatenate([before.cells, sweep.cells]), axis=0)
        self.under_way[robot.name] = replace(
            before, end=end, cells=cells, there=there, given=(*before.given, end), via=before.way, reported_s=None
        )
        self._ahead.pop(robot.name, None)

    def reported(self, robot: str, now_s: float) -> None:
        """A robot says that it has arrived; whether it is seen there, the next look shows."""
        self.under_way[robot] = replace(self.under_way[robot], reported_s=now_s)

    def stopped(self, robot: str, now_s: float) -> None:
        """A robot stops short: its move never ends, and what waits for it waits for another plan.

        Until it is seen to stand, it may be anywhere in what was left of its way: its word comes before it has braked.
        """
        self.under_way[robot] = replace(self.under_way[robot], halted_s=now_s, reported_s=None)
        self._still.pop(robot, None)

    @property
    def halting(self) -> Tuple[str, ...]:
        """Robots that stop short and are not seen to stand yet."""
        return tuple(sorted(name for name, released in self.under_way.items() if released.halted_s is not None))

    def look(self, now_s: float) -> Endings:
        """Take in where robots are seen that say they have arrived."""
        for name, released in self.under_way.items():
            self.under_way[name] = self._behind(released, self._cell.robots.get(name))
        arrived: List[str] = []
        strayed: List[str] = []
        stand = [name for name in self.halting if self._stands(name, now_s)]
        for name, released in sorted(self.under_way.items()):
            tracked = self._cell.robots.get(name)
            if tracked is None or released.reported_s is None:
                continue
            if tracked.column == released.end.column and self._cell.seen_at(tracked, released.end):
                arrived.append(name)
                self._order.finish(name)
            elif now_s - released.reported_s > SEEN_WITHIN_S:
                strayed.append(name)
        for name in (*arrived, *strayed, *stand):
            del self.under_way[name]
        return Endings(tuple(arrived), tuple(strayed), tuple(stand))

    def _stands(self, name: str, now_s: float) -> bool:
        """Whether a robot that stops short is seen to stand; so counts one that is not seen, or never comes to rest."""
        tracked, halted_s = self._cell.robots.get(name), self.under_way[name].halted_s
        if tracked is None or (halted_s is not None and now_s - halted_s > self._cell.params.cancel_timeout_s):
            return True
        since_s, there = self._still.setdefault(name, (now_s, tracked))
        turned = abs(wrap_angle(tracked.yaw_rad - there.yaw_rad))
        if math.dist((tracked.x, tracked.y), (there.x, there.y)) > STILL_M or turned > STILL_RAD:
            self._still[name] = now_s, tracked
            return False
        return now_s - since_s >= STILL_S - SAME_TIME_S

    def adopt(self, request: PlanRequest, plan: FleetPlan) -> bool:
        """Carry a plan out from now on; false when it does not start where the moves under way end."""
        now = self._cell.request({}, {}, places=self.ends)
        same = len(now.robots) == len(request.robots)
        if not same or not all(self._same_place(a, b) for a, b in zip(now.robots, request.robots)):
            return False
        still = [name for name in request.under_way or {} if name in self.under_way]
        self._order = ReleaseOrder(moves_of(request, plan), still, self._passed)
        self._sweeps, self._looks = {}, {}
        self._goals = {name: entry.goal for name, entry in plan.robots.items()}
        return True

    def forget_plan(self) -> None:
        """Nothing more of the plan is released."""
        self._order = ReleaseOrder(())

    def waits_for(self, robot: str) -> Tuple[str, ...]:
        """Other robots that a standing robot's next move waits for, in order."""
        index = self._order.next_of(robot)
        return () if index is None else tuple(name for name in self._order.waits_for(index) if name != robot)

    def ready(self, assignments: Mapping[str, str]) -> List[Tuple[int, PlannedMove, Robot]]:
        """Moves that may be released, with their robots as they stand; those planned for another goal are left out."""
        robots = {robot.name: robot for robot in self._cell.request({}, {}).robots}
        found = []
        for index in self._order.ready():
            move = self._order.moves[index]
            robot = robots.get(move.robot)
            wanted = self._goals.get(move.robot, "") == assignments.get(move.robot, "")
            if robot is not None and wanted and move.robot not in self.under_way and self._starts(robot, move.start):
                found.append((index, move, robot))
        return found

    def onward(self, assignments: Mapping[str, str]) -> List[Tuple[int, PlannedMove, Robot]]:
        """Moves that robots under way may go on with before they brake, with the robots as they are seen.

        Such a move needs no turn, waits for nobody else, and leads on at no sharp corner; and the robot comes near to
        where it was sent, so that no more is given away than is needed.
        """
        found = []
        for name, released in sorted(self.under_way.items()):
            index, tracked = self._order.onward(name), self._cell.robots.get(name)
            sent = self._cell.goals.active.get(name)
            ending = released.reported_s is not None or sent is None or sent.cancelled_s is not None
            if index is None or tracked is None or ending or name in self._cell.holds:
                continue
            move = self._order.moves[index]
            wanted = self._goals.get(name, "") == assignments.get(name, "")
            if wanted and self._leads_on(released, tracked, move):
                found.append((index, move, self._seen(released)))
        return found

    def _leads_on(self, released: Released, tracked: TrackedRobot, move: PlannedMove) -> bool:
        yaws = (tracked.nominal_yaw_rad, move.start.yaw_rad, move.end.yaw_rad)
        turns = any(abs(wrap_angle(yaw - released.end.yaw_rad)) > SAME_YAW_RAD for yaw in yaws)
        if turns or move.start.column != released.end.column:
            return False
        corners = [place.column for place in released.way]
        points = [(tracked.x, tracked.y), *map(self._cell.spec.column_centre, corners)]
        left_m = sum(math.dist(a, b) for a, b in zip(points, points[1:]))
        before, at, after = (released.began, *corners)[-2], move.start.column, move.end.column
        if at in (before, after) or left_m > ONWARD_M:
            return False
        return abs(wrap_angle(_direction(at, after) - _direction(before, at))) <= SHARPEST_RAD

    def _behind(self, released: Released, tracked: Optional[TrackedRobot]) -> Released:
        """The move with the corners that its robot is seen to have passed behind it."""
        if tracked is None or not released.via:
            return released
        corner = released.via[0].column
        (x, y), heading = self._cell.spec.column_centre(corner), _direction(corner, released.way[1].column)
        if (tracked.x - x) * math.cos(heading) + (tracked.y - y) * math.sin(heading) <= 0.0:
            return released
        return self._behind(replace(released, via=released.via[1:], began=corner), tracked)

    def ahead(self, robot: str) -> IntArray:
        """Cells (n, 3) that a robot under way sweeps from where it is seen now."""
        released, tracked = self.under_way[robot], self._cell.robots[robot]
        seen, cells = self._ahead.get(robot, (None, released.cells))
        if seen is not tracked:
            cells = sweep_along(self._cell.request({}, {}), self._seen(released), released.way).cells
            self._ahead[robot] = tracked, cells
        return cells

    def _seen(self, released: Released) -> Robot:
        name = released.robot.name
        tracked = self._cell.robots.get(name)
        if tracked is None:
            return released.robot
        at = (tracked.x, tracked.y)
        return standing_as(tracked, at, released.robot.carries)

    def _passed(self, robot: str, move: PlannedMove) -> bool:
        """Whether a move is apart, with the margin, from all that a robot under way was given and has not passed yet.

        The way ahead is known to a cell, from the middle of the column in which the robot is seen; so what it was given
        counts as far as it is beside that, too. Looked at again after ``recheck_s``.
        """
        mover, stamp_s = self._cell.robots.get(move.robot), self._cell.map.stamp_s if self._cell.map else 0.0
        known = robot in self.under_way and robot in self._cell.robots
        if not known or mover is None or move.robot in self.under_way:
            return False
        looked_s, past = self._looks.get((robot, move), (-math.inf, False))
        if stamp_s < looked_s + self._cell.params.recheck_s - SAME_TIME_S:
            return past
        if move not in self._sweeps:
            self._sweeps[move] = sweep_of(self._cell.request({}, {}), standing_as(mover), move.end).cells
        sweep, ahead = self._sweeps[move], self.ahead(robot)
        given = self.under_way[robot].cells
        past = not len(cells_beside(sweep, ahead)) and not len(cells_beside(sweep, cells_beside(given, ahead)))
        self._looks[robot, move] = stamp_s, past
        return past

    def _starts(self, robot: Robot, place: Waypoint) -> bool:
        off = abs(wrap_angle(robot.yaw_rad - place.yaw_rad))
        return robot.column == place.column and off <= math.radians(self._cell.params.heading_tolerance_deg)

    def _same_place(self, robot: Robot, other: Robot) -> bool:
        return robot.name == other.name and self._starts(robot, Waypoint(other.column, other.yaw_rad))


def _direction(start: Column, end: Column) -> float:
    return math.atan2(end[1] - start[1], end[0] - start[0])
