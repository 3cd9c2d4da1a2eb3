"""Why a goal has nobody, or a robot stands, and what would change it (docs/planning.md, "Why").

    answer = why("debris_1", Circumstances(request, plan, params))
    print(answer.text)

- A goal that a robot has no way to: the smallest change that gives it one, found by trying every single change of
  ``ChangeKind`` and then every pair of them, each by the complete search over cells and headings. Only a thing that
  borders on what the robot can reach can be the first of a change that helps, so only those are tried first. Where no
  two changes do, things that can go together, none of which may stay; that is a set to begin with, not the smallest.
- A goal that could be reached and has nobody: the ways of all robots, and what those serve that would be nearer.
- A robot that has a goal and stands: whose way, or place, shares cells with the next leg of its own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Callable, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import IntArray, Mask, wrap_angle
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import FleetPlan, Goal, PlanRequest, Robot, RobotPlan, Waypoint
from yarm.planning.scenes.oracle import inflated_cells
from yarm.planning.tasks.travel import Travel
from yarm.planning.verification.checker import sweep_of
from yarm.planning.why.changes import Change, ChangeKind, Crossing

MOVE_LIMIT_CELLS = 8
"""A thing is moved by at most so many columns before its removal is named in place of that."""
SHARED_SHOWN = 3
"""Shared cells written out in a text."""


@dataclass(frozen=True, eq=False)
class Cause:
    """One reason.

    Attributes:
        kind: ``unreachable``, ``fault``, ``refused``, ``waiting``, ``unassigned``, ``taken`` or ``none``.
        text: a sentence for a person.
        robot: the robot it is about; empty for none.
        others: whom it waits for, or who has what it might have had.
        changes: what would have to be different, all of it together; none when nothing of ``ChangeKind`` helps.
        cells: (n, 3) cells that two robots share.
        cost_cells: cost of the robot's way, cells; NaN where that says nothing.
    """

    kind: str
    text: str
    robot: str = ""
    others: Tuple[str, ...] = ()
    changes: Tuple[Change, ...] = ()
    cells: IntArray = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int64))
    cost_cells: float = math.nan


@dataclass(frozen=True, eq=False)
class Answer:
    """All reasons, the most helpful first, and one text."""

    subject: str
    causes: Tuple[Cause, ...]

    @property
    def text(self) -> str:
        """The reasons in one text, a line each."""
        return "\n".join(cause.text for cause in self.causes)


@dataclass(frozen=True, eq=False)
class Circumstances:
    """What is known when somebody asks.

    Attributes:
        request: map, robots, goals, and who serves which.
        plan: what was planned for it last; None when nothing was.
        params: the planner's.
        bare: masks of the robots that carry something, without it, by name: each at any heading, rad.
        refused: why somebody has given a goal back for good, by its name; it is not among the request's goals.
    """

    request: PlanRequest
    plan: Optional[FleetPlan] = None
    params: PlannerParams = field(default_factory=PlannerParams)
    bare: Mapping[str, Callable[[float], Mask]] = field(default_factory=dict)
    refused: Mapping[str, str] = field(default_factory=dict)


def why(subject: str, circumstances: Circumstances) -> Answer:
    """Why a goal is not served, or a robot does not go on.

    Args:
        subject: name of a goal or of a robot.
        circumstances: see there.

    Raises:
        KeyError: neither a goal nor a robot is called so; the message lists what there is.
    """
    request = circumstances.request
    robots = {robot.name: robot for robot in request.robots}
    if subject in circumstances.refused:
        return Answer(subject, (Cause("refused", f"{subject} was given back: {circumstances.refused[subject]}"),))
    if subject in request.goals:
        return Answer(subject, tuple(_about_goal(request.goals[subject], circumstances)))
    if subject in robots:
        return Answer(subject, tuple(_about_robot(robots[subject], circumstances)))
    known = ", ".join([*sorted(request.goals), *sorted(robots)]) or "nothing"
    raise KeyError(f"{subject} is neither a goal nor a robot; there is {known}")


def smallest_changes(crossing: Crossing) -> List[Tuple[Change, ...]]:
    """Every single change that gives a robot a way, the smallest first; pairs when no single one does.

    When no pair does either, one set of removals of which none can be left out. A thing whose removal would do is moved
    as little as does it too, by at most ``MOVE_LIMIT_CELLS``. In pairs things are removed, not moved.
    """
    removals = [Change(ChangeKind.REMOVE, name) for name in crossing.in_the_way()]
    general = crossing.general_changes()
    single = [_moved_instead(crossing, one) for one in [*removals, *general] if crossing.reached([one])]
    if single:
        return [(change,) for change in sorted(single, key=lambda change: change.size)]
    pairs: Dict[frozenset[Change], Tuple[Change, ...]] = {}
    for first in [*removals, *general]:
        behind = [Change(ChangeKind.REMOVE, name) for name in crossing.in_the_way([first])]
        for second in [*behind, *general]:
            if second != first and frozenset((first, second)) not in pairs and crossing.reached([first, second]):
                ordered = sorted((first, second), key=lambda change: change.size)
                pairs[frozenset((first, second))] = tuple(ordered)
    if not pairs:
        return _many(crossing)
    return sorted(pairs.values(), key=lambda pair: [change.size for change in reversed(pair)])


def _many(crossing: Crossing) -> List[Tuple[Change, ...]]:
    """Everything in the way removed, ring after ring, then put back where that does no harm."""
    gone: List[Change] = []
    while not crossing.reached(gone):
        ring = [Change(ChangeKind.REMOVE, name) for name in crossing.in_the_way(gone)]
        if not ring:
            return []
        gone += ring
    for change in list(gone):
        rest = [other for other in gone if other != change]
        gone = rest if crossing.reached(rest) else gone
    return [tuple(gone)]


def _moved_instead(crossing: Crossing, change: Change) -> Change:
    """The shortest move of a thing that does what its removal does; the removal when there is none."""
    if change.kind is not ChangeKind.REMOVE:
        return change
    moves = crossing.moves(change.thing, MOVE_LIMIT_CELLS)
    return next((move for move in moves if crossing.reached([move])), change)


def _about_goal(goal: Goal, circumstances: Circumstances) -> List[Cause]:
    request = circumstances.request
    served = {name: robot for robot, name in request.assignments.items()}
    able = [robot.name for robot in request.robots if goal.robot in ("", robot.name)]
    if not able:
        wanted = f"{goal.robot} only, which is not there" if goal.robot else "a mobile robot, and there is none"
        return [Cause("fault", f"{goal.name} is for {wanted}")]
    if goal.name in served:
        robot = next(one for one in request.robots if one.name == served[goal.name])
        return [*_about_robot(robot, circumstances)]
    crossings = {name: _crossing(name, goal, circumstances) for name in able}
    open_ways = [name for name, crossing in crossings.items() if not crossing.fault and crossing.reached()]
    if open_ways:
        return _unassigned(goal, open_ways, circumstances)
    causes = [_unreachable(crossing) for crossing in crossings.values()]
    return sorted(causes, key=_helpful)


def _crossing(robot: str, goal: Goal, circumstances: Circumstances) -> Crossing:
    return Crossing(circumstances.request, robot, goal, circumstances.params, circumstances.bare.get(robot))


def _helpful(cause: Cause) -> Tuple[object, ...]:
    """Causes with few and small changes first."""
    return not cause.changes, len(cause.changes), [change.size for change in cause.changes], cause.robot


def _unreachable(crossing: Crossing) -> Cause:
    robot, goal = crossing.robot.name, crossing.goal
    if crossing.fault:
        return Cause("fault", crossing.fault, robot)
    found = smallest_changes(crossing)
    if not found:
        text = f"{robot} cannot reach {goal.name} {tuple(goal.column)}, even with everything else removed"
        return Cause("unreachable", text, robot)
    ways = [" and ".join(map(str, changes)) for changes in found]
    also = f" (or: {'; or: '.join(ways[1:])})" if ways[1:] else ""
    text = f"{robot} cannot reach {goal.name} {tuple(goal.column)}; it could: {ways[0]}{also}"
    return Cause("unreachable", text, robot, changes=found[0])


def _unassigned(goal: Goal, able: Sequence[str], circumstances: Circumstances) -> List[Cause]:
    """Who could go, how far, and what they do instead."""
    request = circumstances.request
    travel = Travel(replace(request, assignments={}), circumstances.params)
    causes = []
    for robot in able:
        cost, _ = travel.distance(robot, goal)
        other = request.assignments.get(robot, "")
        if not other:
            text = f"{robot} could go to {goal.name} (cost {cost:.1f} cells) and serves nothing yet"
            causes.append(Cause("unassigned", text, robot, cost_cells=cost))
            continue
        other_cost, _ = travel.distance(robot, request.goals[other])
        text = (
            f"{robot} could go to {goal.name} (cost {cost:.1f} cells) but serves {other} (cost {other_cost:.1f} cells)"
        )
        causes.append(Cause("taken", text, robot, (other,), cost_cells=cost))
    return sorted(causes, key=lambda cause: (cause.cost_cells, cause.robot))


def _about_robot(robot: Robot, circumstances: Circumstances) -> List[Cause]:
    request = circumstances.request
    name = request.assignments.get(robot.name)
    if name is None:
        return [Cause("none", f"{robot.name} has no goal", robot.name)]
    goal = request.goals.get(name)
    if goal is None:
        return [Cause("fault", f"{robot.name} is assigned to {name}, which is not among the goals", robot.name)]
    crossing = _crossing(robot.name, goal, circumstances)
    if crossing.fault or not crossing.reached():
        return [_unreachable(crossing)]
    return _on_its_way(robot, name, circumstances)


def _on_its_way(robot: Robot, goal: str, circumstances: Circumstances) -> List[Cause]:
    """Of a robot that has a way to its goal: where it is sent next, or whom it waits for."""
    plan = circumstances.plan
    entry = plan.robots.get(robot.name) if plan is not None else None
    if plan is None or entry is None:
        return [Cause("none", f"{robot.name} has a way to {goal}; nothing is planned for it yet", robot.name)]
    if entry.step is not None:
        column = tuple(int(v) for v in entry.step.column)
        return [Cause("none", f"{robot.name} is on its way to {goal}: its next waypoint is {column}", robot.name)]
    reason = entry.reason or plan.reason or "the planner lets it wait"
    waits = _waits(robot, entry, plan, circumstances.request)
    return waits or [Cause("waiting", f"{robot.name} waits: {reason}", robot.name)]


def _waits(robot: Robot, entry: RobotPlan, plan: FleetPlan, request: PlanRequest) -> List[Cause]:
    """Whom a robot waits for: whose way, or place, its next leg meets."""
    if len(entry.path) < 2:
        return []
    leg = set(map(tuple, inflated_cells(sweep_of(request, robot, entry.path[1]).cells).tolist()))
    causes = []
    for other in request.robots:
        if other.name == robot.name:
            continue
        theirs = plan.robots.get(other.name)
        cells = _way(other, theirs.path if theirs is not None else (), request)
        shared = np.array(sorted(leg & {tuple(cell) for cell in cells.tolist()}), dtype=np.int64).reshape(-1, 3)
        if len(shared):
            moves = theirs is not None and theirs.step is not None
            what = "to pass" if moves else "to make room"
            shown = ", ".join(str(tuple(int(v) for v in cell)) for cell in shared[:SHARED_SHOWN])
            text = f"{robot.name} waits for {other.name} {what}: they share {len(shared)} cells, such as {shown}"
            causes.append(Cause("waiting", text, robot.name, (other.name,), cells=shared))
    return sorted(causes, key=lambda cause: (-len(cause.cells), cause.others))


def _way(robot: Robot, path: Sequence[Waypoint], request: PlanRequest) -> IntArray:
    """Cells (n, 3) that a robot sweeps along its way; those it has when it has none."""
    swept, at = [robot.cells], robot
    for point in path[1:]:
        swept.append(sweep_of(request, at, point).cells)
        turn = wrap_angle(point.yaw_rad - at.yaw_rad)
        turned = at.mask.turned(turn, request.spec) if abs(turn) > 1e-6 else at.mask
        mask = turned if at.mask_at is None else at.mask_at(point.yaw_rad)
        at = replace(at, column=point.column, yaw_rad=point.yaw_rad, mask=mask, position_m=None)
    cells: IntArray = np.unique(np.concatenate(swept), axis=0)
    return cells
