"""What every planner is given and gives back (docs/planning.md).

A motion to a waypoint is: turn about the end effector to the waypoint's yaw, then translate straight to the centre of
its column. All robots of a fleet move at the same time and are not synchronised on the way, so what a robot sweeps
from one waypoint to the next is taken as occupied during the whole step.

What makes a step safe (the promise of ``yarm``, and what the checker verifies):

- *Sweep* of a robot: the cells of its mask at the start, at every angle of the turn, and along the translation of its
  mask at the new heading (``Robot.mask_at``; without it, of the turned mask): every cell that a mask cell, a unit
  square, overlaps on the straight line between the two column centres (a diagonal move takes both cells beside it).
  Where the mask at the new heading is known, only cells count in the turn that it, turned back, overlaps too. A robot
  that stays, with a goal or without, sweeps the cells it has.
- *Robot-less map*: ``PlanRequest.occupied`` without the cells of assigned goals.
- A sweep never overlaps an occupied cell of the robot-less map, nor another robot's sweep.
- Margin: no cell of a sweep is one of the 26 neighbours of an occupied cell, or of a cell of another robot's sweep.
  The margin counts once between two robots. Cells that are neighbours at the start already (an occupied cell, or a
  cell another robot stands on, beside the robot's present cells) may stay neighbours during this step, never more.
- The border of the volume has no margin, but no cell of a sweep may lie outside. A robot that starts partly outside may
  be outside only within the box around the volume and its present cells, so it can never go further out.

Robots without a goal are not assigned, but the planner may ask them to step aside: then they have a ``RobotPlan`` with
an empty goal and a step, which is to be sent like any other. Robots absent from ``FleetPlan.robots`` stay.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Callable, Collection, Mapping, Optional, Protocol, Sequence, Tuple

import numpy as np

from yarm.geometry import BoolArray, FloatArray, GridSpec, IntArray, Mask

Column = Tuple[int, int]
"""A column of cells (x, y) of the grid."""


class GoalKind(str, Enum):
    """What a goal is: equal to the word of the registry and of scene files."""

    CLEAR = "Clear"
    """A place the task queue sends an idle robot to."""
    BIN = "Bin"
    """Over a bin, for the robot that carries something there."""
    DEBRIS = "Debris"
    TARGET = "Target"
    HOME = "Home"

    def __str__(self) -> str:
        """The word."""
        return str(self.value)


class PlanStatus(Enum):
    """How planning ended, for one robot or for the fleet (then the worst of them)."""

    SOLVED = "SOLVED"
    INFEASIBLE = "INFEASIBLE"
    TIMEOUT = "TIMEOUT"
    INVALID_START = "INVALID_START"
    INVALID_GOAL = "INVALID_GOAL"


@dataclass(frozen=True, eq=False)
class Robot:
    """A mobile robot as the planner sees it.

    Attributes:
        name: unique name.
        column: column of the end effector, in the grid.
        yaw_rad: heading, rad, world.
        mask: its cells relative to the end effector's column at this heading; may reach out of the grid.
        position_m: end effector x, y, metres, world; None for the centre of its column.
        carries: name of what it has in its hand, also in its mask; empty for nothing.
        home_yaw_rad: heading whose turns it keeps to, rad, world: between two headings that they lead to (a turn of its
            was cut off, something pushed it) it may turn to either of them. None for none.
        mask_at: its mask at any heading, rad, ``mask`` at its present one. None when only that one is known: it is then
            turned, cells and all, so that it grows, and where a robot may go depends on the heading it has.
        turns_deg: turns about its end effector that it may make, deg; None for those of the planner's parameters.
    """

    name: str
    column: Column
    yaw_rad: float
    mask: Mask
    position_m: Optional[Tuple[float, float]] = None
    carries: str = ""
    home_yaw_rad: Optional[float] = None
    mask_at: Optional[Callable[[float], Mask]] = None
    turns_deg: Optional[Tuple[float, ...]] = None

    @property
    def cells(self) -> IntArray:
        """Absolute cells (n, 3) it occupies now, possibly outside the grid."""
        return self.mask.at(self.column)


@dataclass(frozen=True, eq=False)
class Goal:
    """Somewhere an end effector is wanted.

    Attributes:
        name: unique name.
        kind: what it is.
        column: column the end effector must reach.
        cells: (n, 3) cells of the debris in the live grid, cleared while it is somebody's goal; (0, 3) for a target.
        yaw_rad: heading wanted on arrival, rad; None for any.
        robot: name of the only robot that may serve it; empty for any.
        onward: columns to one of which a robot goes from here with what it takes; none when it is done here.
    """

    name: str
    kind: GoalKind
    column: Column
    cells: IntArray = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int64))
    yaw_rad: Optional[float] = None
    robot: str = ""
    onward: Tuple[Column, ...] = ()


@dataclass(frozen=True, eq=False)
class PlanRequest:
    """One planning step: the world as it is now and who is wanted where.

    Attributes:
        spec: the grid.
        occupied: (gx, gy, gz) true where something stands, goals included, but nowhere in the cells of the request's
            robots, see ``without_robots``.
        robots: every mobile robot, those without a goal too (they are obstacles that may be asked to step aside).
        goals: goals by name; those not assigned are plain obstacles.
        assignments: name of the goal of each robot that has one.
        objects: cells (n, 3) of everything else by name, for reasons that name it.
        forbidden: (gx, gy) columns that no cell of an assigned robot may enter (mode BOUNDED); None for none.
        under_way: cells (n, 3) swept by the moves being made now, by robot; these robots are in ``robots`` where their
            moves end, and stand somewhere in these cells. None when everybody stands; ``FleetPlan.moves`` is then not
            asked for.
    """

    spec: GridSpec
    occupied: BoolArray
    robots: Tuple[Robot, ...]
    goals: Mapping[str, Goal]
    assignments: Mapping[str, str]
    objects: Mapping[str, IntArray] = field(default_factory=dict)
    forbidden: Optional[BoolArray] = None
    under_way: Optional[Mapping[str, IntArray]] = None


def without_robots(spec: GridSpec, occupied: BoolArray, robots: Sequence[Robot]) -> BoolArray:
    """A map (gx, gy, gz) without the cells in which robots stand: what ``PlanRequest.occupied`` wants."""
    left: BoolArray = np.array(occupied, dtype=np.bool_)
    for robot in robots:
        cells = robot.cells
        left[tuple(cells[spec.contains(cells)].T)] = False
    return left


def without_things(
    spec: GridSpec, occupied: BoolArray, things: Mapping[str, IntArray], gone: Collection[str]
) -> BoolArray:
    """A map (gx, gy, gz) without some of the things (n, 3) in it; what one shares with another stays until both go."""
    left: BoolArray = np.array(occupied, dtype=np.bool_)
    inside = {name: np.asarray(cells)[spec.contains(cells)] for name, cells in things.items()}
    for name in gone:
        left[tuple(inside[name].T)] = False
    for name in things.keys() - set(gone):
        left[tuple(inside[name].T)] = occupied[tuple(inside[name].T)]
    return left


@dataclass(frozen=True)
class Waypoint:
    """Where an end effector is sent: the centre of a column, with a heading, rad, world."""

    column: Column
    yaw_rad: float


@dataclass(frozen=True)
class PlannedMove:
    """One move of a joint plan, an order of single moves.

    Attributes:
        robot: who makes it.
        start: where from.
        end: where to.
        after: indices of earlier moves of other robots whose sweeps, with the margin, are not disjoint from its own.
        behind: robots of whose moves under way (``PlanRequest.under_way``) the same is true.
    """

    robot: str
    start: Waypoint
    end: Waypoint
    after: Tuple[int, ...] = ()
    behind: Tuple[str, ...] = ()


@dataclass(frozen=True)
class RobotPlan:
    """The plan of one robot.

    Attributes:
        robot: its name.
        goal: name of its goal; empty for a robot that only steps aside.
        status: how planning ended for it.
        reason: what stands in the way, in a sentence a person can act on; empty when SOLVED.
        path: waypoints from the present pose (first) to the goal (last, when SOLVED).
        step: waypoint to send now; None when the robot stays where it is.
        length_cells: length of the path in cells.
        planning_ms: wall time spent on this robot, ms; for reports only, decides nothing.
    """

    robot: str
    goal: str
    status: PlanStatus
    reason: str = ""
    path: Tuple[Waypoint, ...] = ()
    step: Optional[Waypoint] = None
    length_cells: float = 0.0
    planning_ms: float = 0.0


def _no_columns() -> IntArray:
    return np.zeros((0, 2), dtype=np.int64)


class Graph(Protocol):
    """The graph that a plan was searched on, for display; made when it is looked at."""

    @property
    def particles(self) -> IntArray:
        """Columns (n, 2) of the particles used."""

    @property
    def edges(self) -> IntArray:
        """Edges (m, 2), pairs of indices into ``particles``."""


@dataclass(frozen=True, eq=False)
class GivenGraph:
    """A graph that is there already; see ``Graph``."""

    particles: IntArray = field(default_factory=_no_columns)
    edges: IntArray = field(default_factory=_no_columns)


@dataclass(frozen=True, eq=False)
class FleetPlan:
    """The plan of the fleet: what to send now, and what was thought.

    Attributes:
        status: the worst status of the robots; INFEASIBLE too when it is proved that they cannot all reach their goals,
            though each could without the others (those that must do without have TIMEOUT).
        reason: the reason of the robot with the worst status.
        robots: plan by robot name, for every robot that has a goal or is asked to step aside.
        iterations: rounds of the search.
        planning_ms: wall time of the whole step, ms.
        graph: what was searched on, for display.
        moves: the joint plan in its order, when ``PlanRequest.under_way`` asks for it and the planner has one.
        particles: how many its searches needed, the most that one added counted; 0 where none needed any.
    """

    status: PlanStatus
    reason: str
    robots: Mapping[str, RobotPlan]
    iterations: int = 0
    planning_ms: float = 0.0
    graph: Graph = field(default_factory=GivenGraph)
    moves: Tuple[PlannedMove, ...] = ()
    particles: int = 0


class FleetPlanner(Protocol):
    """A planner that is asked again at every step; it remembers its previous plan until reset."""

    def plan(self, request: PlanRequest, rng: np.random.Generator) -> FleetPlan:
        """Plan one step for the fleet; never raises for a hard or impossible instance, the status says it."""

    def reset(self) -> None:
        """Forget the previous plan (new mission, clock gone backwards)."""


@dataclass(frozen=True)
class StepCheck:
    """Verdict of the independent checker on one step of the fleet.

    Attributes:
        safe: true when nothing touches.
        reason: who would touch what, where; empty when safe.
        cells: (n, 3) cells in dispute.
    """

    safe: bool
    reason: str = ""
    cells: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
