"""States BOUNDED and BOUNDLESS, and the mobile robots' way home: plan, check, send, wait until all arrived, again."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Callable, Dict, List, Optional

import numpy as np

from yarm.commander.assignment import Assignments
from yarm.commander.goals import ActiveGoal, Purpose
from yarm.commander.messages import Action, DeleteDone, DeleteObject, GoalDone, Outcome, Say, ShowPlan, TaskView
from yarm.commander.steps import CheckedSteps, StepGuard, safe_part, steps_of
from yarm.commander.work import Work
from yarm.commander.world import World
from yarm.geometry import BoolArray, IntArray
from yarm.planning.checker import robotless_map
from yarm.planning.types import FleetPlan, FleetPlanner, Goal, PlanRequest, PlanStatus

GIVEN_BACK = (PlanStatus.INFEASIBLE, PlanStatus.INVALID_GOAL)
"""What a plan may say of a robot's goal that somebody else may still reach, or nobody as the map is."""
KEEP_CLEAR_COLUMNS = 1
"""An idle robot stays out of the private areas grown by this many columns (0.6 m from the part)."""


@dataclass(frozen=True)
class Tools:
    """What a mission works with.

    Attributes:
        planner: plans a step for the fleet.
        rng: its random generator.
        stopwatch_s: wall time for reports; decides nothing.
    """

    planner: FleetPlanner
    rng: np.random.Generator
    stopwatch_s: Callable[[], float] = lambda: 0.0


class Mission(Work):
    """Steps the fleet until nobody has a task left."""

    def __init__(self, world: World, tools: Tools, assignments: Assignments, bounded: bool = False) -> None:
        """A mission.

        Args:
            world: the world.
            tools: planner and generator.
            assignments: who serves which goal.
            bounded: keep out of the manipulators' private areas.
        """
        super().__init__(world)
        self._tools = tools
        self._assignments = assignments
        self._bounded = bounded
        self._guard = StepGuard(world.params.recheck_count)
        self._not_before_s = -math.inf
        self._checked_s = -math.inf
        self._map_s = -math.inf
        self._quiet_since_s: Optional[float] = None
        self._stuck_since_s: Optional[float] = None
        self._aims: Dict[str, Goal] = {}
        self._deleting: Dict[str, float] = {}
        self._notes: Dict[str, str] = {}
        self._finished: Dict[str, TaskView] = {}

    def start(self, now_s: float) -> List[Action]:
        """Forget the plans of the last mission."""
        self._tools.planner.reset()
        return []

    def advance(self, now_s: float) -> List[Action]:
        """One look at the newest map; plans when everybody has arrived."""
        world_map = self.world.map
        if world_map is None or world_map.stamp_s <= self._map_s:
            return []
        self._map_s = world_map.stamp_s
        actions = self._watch(now_s)
        if self.world.goals.of(Purpose.STEP) or now_s < self._not_before_s:
            return actions
        actions += self._arrivals(now_s)
        request = self._assign()
        if not self._assignments.pairs:
            self._idle(now_s)
            return actions
        self._quiet_since_s = None
        return actions + self._plan(request, now_s)

    def goal_done(self, goal: ActiveGoal, event: GoalDone, now_s: float) -> List[Action]:
        """A step has ended, well or not."""
        if goal.purpose is not Purpose.STEP:
            return []
        self._guard.forget(goal.robot)
        if event.outcome is Outcome.SUCCEEDED:
            self._notes.pop(goal.robot, None)
            return []
        held = self.world.holds.get(goal.robot, "")
        reason = goal.why or held or f"{event.outcome.value} {event.message}".rstrip()
        self._notes[goal.robot] = reason
        if not goal.why.startswith("replan"):
            self._not_before_s = max(self._not_before_s, now_s + self.world.params.retry_s)
        return [Say("warn", f"{goal.robot} did not reach its waypoint: {reason}")]

    def delete_done(self, event: DeleteDone) -> List[Action]:
        """The simulator (or whoever keeps the cell) has answered."""
        if event.success:
            self._deleting.pop(event.name, None)
            return [Say("info", f"{event.name} is deleted")]
        return [Say("warn", f"{event.name} was not deleted, it is tried again: {event.message}")]

    def tasks(self) -> List[TaskView]:
        """Every task: finished, assigned, waiting or unreachable."""
        views = dict(self._finished)
        for robot, aim in sorted(self._assignments.pairs.items()):
            views[aim] = self._assigned_view(robot, self._assignments.goals[aim])
        for name, goal in sorted(self.world.open_goals().items()):
            reason = self._assignments.unreachable.get(name)
            if name not in views and name not in self._deleting:
                views[name] = TaskView("", name, goal.kind, "unreachable" if reason else "waiting", reason or "")
        return list(views.values())

    def _assigned_view(self, robot: str, goal: Goal) -> TaskView:
        tracked = self.world.robots.get(robot)
        left = math.nan
        if tracked is not None and self.world.map is not None:
            left = tracked.distance_to(self.world.map.spec, goal.column)
        moving = robot in {g.robot for g in self.world.goals.of(Purpose.STEP)}
        status = "backing_out" if goal.kind == "Clear" else ("moving" if moving else "assigned")
        return TaskView(robot, goal.name, goal.kind, status, self._notes.get(robot, ""), left)

    def _watch(self, now_s: float) -> List[Action]:
        """Steps under way: progress, something on the way, a goal that moved or vanished."""
        params, goals = self.world.params, self.world.goals
        actions: List[Action] = []
        for goal in goals.of(Purpose.STEP):
            robot = self.world.robots.get(goal.robot)
            if robot is None:
                actions += goals.cancel(goal.robot, now_s, f"{goal.robot} has left the map")
                continue
            goals.note_progress(goal.robot, robot.x, robot.y, robot.yaw_rad, now_s)
            if now_s - goals.active[goal.robot].best_s > params.no_progress_s:
                held = self.world.holds.get(goal.robot)
                why = f"held by the safety monitor: {held}" if held else "no obstacle reported"
                actions += goals.cancel(goal.robot, now_s, f"has not moved for {params.no_progress_s:g} s ({why})")
            elif self._aim_lost(goal.robot):
                actions += goals.cancel(goal.robot, now_s, "replan: its goal has moved or gone")
        if params.check_steps and now_s - self._checked_s >= params.recheck_s and goals.of(Purpose.STEP):
            self._checked_s = now_s
            actions += self._recheck(now_s)
        return actions

    def _aim_lost(self, robot: str) -> bool:
        aim = self._aims.get(robot)
        if aim is None or aim.kind not in ("Debris", "Target"):
            return False
        now = self.world.open_goals().get(aim.name)
        return now is None or now.column != aim.column

    def _recheck(self, now_s: float) -> List[Action]:
        request = self.world.request({**self._assignments.goals, **self.world.open_goals()}, self._assignments.pairs)
        actions: List[Action] = []
        for robot, cells in self._guard.alarms(robotless_map(request)):
            name = self._owner(cells)
            actions += self.world.goals.cancel(robot, now_s, f"replan: {name} is in the way")
            self._guard.forget(robot)
        return actions

    def _owner(self, cells: IntArray) -> str:
        wanted = {tuple(cell) for cell in cells.tolist()}
        for name, found in (self.world.map.objects if self.world.map is not None else {}).items():
            if found.kind != "Mobile" and not wanted.isdisjoint(map(tuple, found.cells.tolist())):
                return name
        return "something"

    def _arrivals(self, now_s: float) -> List[Action]:
        """Pop the tasks of robots that are where they were wanted, and delete what they reached."""
        actions: List[Action] = []
        goals = {**self._assignments.goals, **self.world.open_goals()}
        for robot, name in sorted(self._assignments.pairs.items()):
            tracked, goal = self.world.robots.get(robot), goals.get(name)
            if tracked is None or goal is None or not self.world.at(tracked, goal):
                continue
            self._assignments.pop(robot)
            self._notes.pop(robot, None)
            if goal.kind != "Clear":
                self._finished[name] = TaskView(robot, name, goal.kind, "reached", "", 0.0)
                actions.append(Say("info", f"{robot} has reached {name}"))
            if goal.kind in ("Debris", "Target"):
                self.world.leaving.add(name)
                self._deleting[name] = now_s
                actions.append(DeleteObject(name))
        actions += self._delete_again(now_s)
        return actions

    def _delete_again(self, now_s: float) -> List[Action]:
        actions: List[Action] = []
        for name, since_s in sorted(self._deleting.items()):
            if now_s - since_s > self.world.params.delete_timeout_s:
                self._deleting[name] = now_s
                actions += [Say("warn", f"no answer to the deletion of {name}, asked again"), DeleteObject(name)]
        return actions

    def _assign(self) -> PlanRequest:
        forbidden = self.world.private_columns() if self._bounded else None
        request = self.world.request({}, {}, forbidden)
        self._assignments.update(request, self.world.open_goals())
        self._assignments.process(self._full(request), self._keep_clear())
        return replace(self._full(request), assignments=dict(self._assignments.pairs))

    def _full(self, request: PlanRequest) -> PlanRequest:
        goals = {**self.world.open_goals(), **self._assignments.goals}
        objects = {name: cells for name, cells in request.objects.items() if name not in goals}
        return replace(request, goals=goals, objects=objects)

    def _keep_clear(self) -> Optional[BoolArray]:
        return self.world.private_columns(KEEP_CLEAR_COLUMNS) if self.world.manipulators else None

    def _idle(self, now_s: float) -> None:
        """Nobody has a task: done after a while, unless goals remain that nobody can reach."""
        params = self.world.params
        if self._quiet_since_s is None:
            self._quiet_since_s = now_s
        waited = now_s - self._quiet_since_s
        unreachable = self._assignments.unreachable
        if unreachable:
            name = sorted(unreachable)[0]
            self.reason = f"{name} cannot be reached: {unreachable[name]}"
            self._not_before_s = now_s + params.retry_s
            if waited > params.give_up_s:
                self.finish("failed", self.reason)
        elif self._deleting:
            self.reason = f"waiting for the deletion of {', '.join(sorted(self._deleting))}"
        elif waited < params.linger_s:
            self.reason = "no task is open"
        else:
            self.finish("succeeded")

    def _plan(self, request: PlanRequest, now_s: float) -> List[Action]:
        plan = self._tools.planner.plan(request, self._tools.rng)
        before_s = self._tools.stopwatch_s()
        checked = safe_part(request, plan) if self.world.params.check_steps else CheckedSteps(steps_of(plan))
        check_ms = 1e3 * (self._tools.stopwatch_s() - before_s)
        actions: List[Action] = [ShowPlan(request, plan, tuple(checked.steps), checked.refused, check_ms)]
        if checked.refused:
            actions.append(Say("warn", f"a step was not sent: {checked.refused}"))
        self._take_refusals(plan)
        if not checked.steps:
            self._stand_still(plan, checked, now_s)
            return actions
        self.reason = checked.refused
        self._stuck_since_s = None
        self._aims = {r: request.goals[g] for r, g in request.assignments.items() if g in request.goals}
        robots = {robot.name: robot for robot in request.robots}
        for name, step in checked.steps.items():
            self._guard.watch(request, robots[name], step)
            actions.append(self.world.goals.send(name, Purpose.STEP, "False", now_s, self.world.target_of(step)))
        return actions

    def _take_refusals(self, plan: FleetPlan) -> None:
        for name, robot_plan in sorted(plan.robots.items()):
            if robot_plan.status is not PlanStatus.SOLVED:
                self._notes[name] = f"{robot_plan.status.value}: {robot_plan.reason}"
            else:
                self._notes.pop(name, None)
            if robot_plan.status in GIVEN_BACK and robot_plan.goal:
                self._assignments.reject(name, robot_plan.reason)

    def _stand_still(self, plan: FleetPlan, checked: CheckedSteps, now_s: float) -> None:
        params = self.world.params
        self.reason = checked.refused or plan.reason or "the planner lets everybody wait"
        self._not_before_s = now_s + params.retry_s
        if self._stuck_since_s is None:
            self._stuck_since_s = now_s
        if now_s - self._stuck_since_s > params.give_up_s:
            self.finish("failed", self.reason)
