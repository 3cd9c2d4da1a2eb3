"""A mission without a barrier: plan from where everybody will stand, check and release each move by itself.

Every look: what was sent and has been seen to end frees those that waited for it; a plan that was asked for long enough
ago takes effect if it still starts where the moves under way end; every move that waits for nobody is held by the
independent checker against the newest map, all moves under way and all robots that stand, and sent; the next plan is
asked for.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Dict, List, Mapping, Optional, Set, Tuple

from yarm.commander.assignment import Assignments
from yarm.commander.cell_state import CellState
from yarm.commander.events import Action, GoalDone, Level, Log, Outcome, ShowPlan, TaskState, TaskView
from yarm.commander.goals import ActiveGoal, Purpose
from yarm.commander.mission import PLANNING, Mission
from yarm.commander.params import CheckSteps, Execution
from yarm.commander.releases import SAME_TIME_S, SEEN_WITHIN_S, Releases
from yarm.commander.steps import CheckedSteps
from yarm.commander.tools import Tools
from yarm.geometry import IntArray
from yarm.planning.model.types import PlannedMove, PlanRequest, Robot, StepCheck, Waypoint
from yarm.planning.tasks.task import Task
from yarm.planning.verification.checker import Way, cells_beside, check_release, sweep_along

REPLAN_S = 0.5
"""A plan that covers everything is still made again after this long, s: the map may offer better."""


class ContinuousMission(Mission):
    """Keeps the fleet moving until nobody has a task left."""

    def __init__(self, cell: CellState, tools: Tools, assignments: Assignments, bounded: bool = False) -> None:
        """See ``Mission``."""
        super().__init__(cell, tools, assignments, bounded)
        self._releases = Releases(cell)
        self._asked_ends: Dict[str, Waypoint] = {}
        self._carried_out: Optional[PlanRequest] = None
        self._adopted_s = -math.inf
        self._refused: Dict[PlannedMove, float] = {}
        self._unsuitable: Dict[PlannedMove, float] = {}

    def advance(self, now_s: float) -> List[Action]:
        """One look at the newest map."""
        world_map = self.cell.map
        actions = self._watch_progress(now_s)
        if world_map is None or world_map.stamp_s <= self._map_s:
            return actions
        self._map_s = world_map.stamp_s
        actions += self._watch(now_s) + self._hands.advance(now_s) + self._look(now_s) + self._arrivals(now_s)
        coming_in = self._outside_first(now_s)
        if coming_in is not None:
            return actions + coming_in
        fresh = self._take_plan(now_s)
        actions += self._release(now_s, fresh)
        return actions + self._ask(now_s)

    def goal_done(self, goal: ActiveGoal, event: GoalDone, now_s: float) -> List[Action]:
        """A move, or a hand's work, has ended, well or not."""
        if goal.purpose is Purpose.STEP and goal.robot in self._releases.under_way:
            if event.outcome is Outcome.SUCCEEDED:
                self._releases.reported(goal.robot, now_s)
            else:
                self._releases.stopped(goal.robot, now_s)
                self._adopted_s = -math.inf
        return super().goal_done(goal, event, now_s)

    def _places(self) -> Dict[str, Robot]:
        return self._releases.ends

    def _left(self) -> Dict[str, float]:
        return self._releases.left_cells(self.cell.params.planner_params.turn_deg_per_cell)

    def _on_the_way(self) -> Set[str]:
        return super()._on_the_way() | set(self._releases.under_way)

    def _assigned_view(self, task: Task) -> TaskView:
        view = super()._assigned_view(task)
        if task.robot in self._releases.halting:  # told to stop: it no longer follows its goal, seen to stand or not
            view = replace(view, status=TaskState.ASSIGNED)
        others = self._releases.waits_for(task.robot) if view.status is TaskState.ASSIGNED else ()
        return replace(view, reason=f"waits for {', '.join(others)}") if others and not view.reason else view

    def _look(self, now_s: float) -> List[Action]:
        """What was sent and is seen to have ended."""
        actions: List[Action] = []
        for robot in self._releases.look(now_s).strayed:
            reason = f"says that it has arrived, and is not seen there within {SEEN_WITHIN_S:g} s"
            self._note(robot, reason)
            self._adopted_s = -math.inf
            self._not_before_s = max(self._not_before_s, now_s + self.cell.params.retry_s)
            actions.append(Log(Level.WARN, f"{robot} {reason}"))
        return actions

    def _outside_first(self, now_s: float) -> Optional[List[Action]]:
        """Steps of before the Commander's death are ended, and robots outside the volume come in, while others stand.

        None when nobody is in the way of the rest.
        """
        coming = any(goal.robot not in self._releases.under_way for goal in self.cell.goals.of(Purpose.STEP))
        if not coming and not self.cell.outside and not self.interrupted:
            return None
        if self._on_the_way() or now_s < self._not_before_s:
            return []
        return self._finish_steps(now_s) or self._bring_in(now_s) or None

    def _take_plan(self, now_s: float) -> bool:
        """The plan asked for takes effect when its time has come; whether one did."""
        if self._asked is None or now_s < self._asked[1] + self.cell.params.plan_delay_s - SAME_TIME_S:
            return False
        answered = self._answered()
        if answered is None:
            return False
        request, _, plan = answered
        if any(map(self._aim_lost, request.assignments)) or not self._releases.adopt(request, plan):
            return False
        self._carried_out, self._planned, self._adopted_s = request, plan, now_s
        self._unsuitable.clear()
        self._take_refusals(plan)
        return True

    def _gives_back(self, robot: str) -> bool:
        """Whether a robot's goal is given back when it has no way there: only from where it stands.

        What is in the way of one that still drives, an arm that is lifting off for instance, may be gone by then.
        """
        return robot not in self._releases.under_way

    def _release(self, now_s: float, fresh: bool) -> List[Action]:
        """Send everybody whose next move waits for nobody, if the checker agrees."""
        actions: List[Action] = []
        sent: List[str] = []
        refused = ""
        before_s = self._tools.stopwatch_s()
        found = [(index, move, robot) for index, move, robot in self._releases.ready(self._queue.assignments)]
        request = self._request(self._releases.seen) if found else None
        for index, move, robot in found:
            if request is None or self._refused.get(move, -math.inf) > now_s - self.cell.params.retry_s:
                continue
            verdict = self._verdict(request, move)
            if not verdict.safe:
                refused = refused or verdict.reason
                self._refused[move] = now_s
            if verdict.safe or self.cell.params.checking is CheckSteps.REPORT:
                actions.append(self._send(request, index, move, robot, now_s, self._passed(verdict.reason)))
                sent.append(move.robot)
        actions += self._send_onward(now_s)
        check_ms = 1e3 * (self._tools.stopwatch_s() - before_s)
        actions += self._note_standstill(sent, refused, fresh, now_s)
        return self._shown(tuple(sent), refused, check_ms, fresh) + actions

    def _send_onward(self, now_s: float) -> List[Action]:
        """Tell robots that come near to where they were sent how to go on, so that they need not brake there."""
        actions: List[Action] = []
        for index, move, robot in self._releases.onward(self._queue.assignments):
            if self._unsuitable.get(move, -math.inf) > now_s - self.cell.params.recheck_s + SAME_TIME_S:
                continue
            request = self._request(self._releases.seen)
            if self._verdict(request, move, self._releases.ways[robot.name]).safe:
                actions.append(self._send(request, index, move, robot, now_s, self._passed("")))
            else:
                self._unsuitable[move] = now_s
        return actions

    def _send(
        self, request: PlanRequest, index: int, move: PlannedMove, robot: Robot, now_s: float, why: str
    ) -> Action:
        by = self._releases.ways.get(robot.name, ())
        sweep = sweep_along(request, robot, (*by, move.end))
        self._releases.begin(robot, index, sweep)
        self._guard.watch_cells(robot.name, sweep.cells[request.spec.contains(sweep.cells)])
        target, via = self.cell.target_of(move.end), tuple(map(self.cell.target_of, by))
        return self._send_step(robot.name, target, Waypoint(robot.column, robot.yaw_rad), now_s, via, why)

    def _verdict(self, request: PlanRequest, move: PlannedMove, by: Tuple[Waypoint, ...] = ()) -> StepCheck:
        """The checker's, with the others under way from where they stood, and if that fails, from where they are seen.

        Either is proof: what they were given holds all that they have left, and so does, known to a cell, the way on
        from where they are seen.
        """
        if self.cell.params.checking is CheckSteps.UNCHECKED:
            return StepCheck(True)
        way, name = (*by, move.end), move.robot
        starts = {other: robot for other, robot in self._releases.starts.items() if other != name}
        from_start = replace(request, robots=tuple(starts.get(robot.name, robot) for robot in request.robots))
        verdict = check_release(from_start, {name: way}, _without(name, self._releases.given))
        if verdict.safe or not starts:
            return verdict
        return check_release(request, {name: way}, _without(name, self._releases.ways))

    def _shown(self, sent: Tuple[str, ...], refused: str, check_ms: float, fresh: bool) -> List[Action]:
        """A plan that takes effect, and whatever the checker has something against, for people."""
        if self._carried_out is None or self._planned is None or not (fresh or refused):
            return []
        self._refusals += bool(refused)
        shown = ShowPlan(self._carried_out, self._planned, sent, refused, check_ms, self._refusals)
        if not refused:
            return [shown]
        kept = self.cell.params.checking is CheckSteps.SEND_SAFE
        verdict = "a step was not sent: " if kept else "a step was sent that the checker refuses: "
        return [shown, Log(Level.WARN, verdict + refused)]

    def _note_standstill(self, sent: List[str], refused: str, fresh: bool, now_s: float) -> List[Action]:
        """Write down why nobody moves with a new plan, if nobody does."""
        if sent:
            self.reason, self._stuck_since_s = refused, None
        elif fresh and self._planned is not None and not self._on_the_way() and self._covers_all():
            return self._stand_still(self._planned, CheckedSteps({}, refused), now_s)
        return []

    def _ask(self, now_s: float) -> List[Action]:
        """Ask for the next plan, from where everybody will stand."""
        waits = self._asked is not None or now_s < self._not_before_s or bool(self._releases.halting)
        if waits or not self._plan_due(now_s):
            return []
        request = self._assign(now_s)
        if not self._queue.assignments:
            self._releases.forget_plan()
            return self._nothing_assigned(now_s)
        self._quiet_since_s = None
        request = replace(request, under_way=self._releases.cells)
        self._asked = request, now_s, self._tools.ask(request)
        self._asked_ends = self._releases.targets
        if not self._on_the_way():
            self.reason = self.reason or PLANNING
        return []

    def _plan_due(self, now_s: float) -> bool:
        """Whether what is carried out does not cover what is wanted, or is no longer new."""
        moved = self._asked_ends != self._releases.targets
        return moved or not self._covers_all() or now_s - self._adopted_s >= REPLAN_S - SAME_TIME_S

    def _covers_all(self) -> bool:
        """Whether the plan being carried out is for the goals that the robots have now."""
        return self._carried_out is not None and self._queue.assignments == self._carried_out.assignments

    def _still_ahead(self, robot: str, cells: IntArray) -> bool:
        """Whether cells (n, 3) of a sweep are in what is left of it, where the robot is seen now, or beside that."""
        if robot not in self._releases.under_way or robot not in self.cell.robots:
            return True
        return len(cells_beside(cells, self._releases.ahead(robot))) > 0


def _without(robot: str, ways: Mapping[str, Way]) -> Dict[str, Way]:
    return {name: way for name, way in ways.items() if name != robot}


def mission_for(cell: CellState, tools: Tools, assignments: Assignments, bounded: bool = False) -> Mission:
    """A mission carried out as parameter ``execution`` says."""
    kind = ContinuousMission if cell.params.execution == Execution.CONTINUOUS else Mission
    return kind(cell, tools, assignments, bounded)
