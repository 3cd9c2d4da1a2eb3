"""States BOUNDED and BOUNDLESS, and the mobile robots' way home: plan, check, send, wait until all arrived, again."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Dict, List, Mapping, Optional, Sequence, Set, Tuple

from yarm.commander.activity import Activity, Ending
from yarm.commander.assignment import Assignments
from yarm.commander.cell_state import CellState
from yarm.commander.events import (
    Action,
    DeleteDone,
    DeleteObject,
    GoalDone,
    Level,
    Log,
    Outcome,
    ShowPlan,
    Target,
    TaskState,
    TaskView,
)
from yarm.commander.goals import ActiveGoal, Purpose
from yarm.commander.handling import Handling, Job
from yarm.commander.memory import Step
from yarm.commander.params import CheckSteps
from yarm.commander.recovery import way_in
from yarm.commander.steps import CheckedSteps, StepGuard, sendable, starts_alike
from yarm.commander.tools import Answer, Tools
from yarm.control.actions import MobileAction
from yarm.geometry import BoolArray, IntArray
from yarm.geometry.kinds import ObjectKind
from yarm.planning.model.types import FleetPlan, GoalKind, PlanRequest, PlanStatus, Robot, Waypoint
from yarm.planning.tasks.task import BODIES, Task, TaskStatus
from yarm.planning.verification.checker import check_release, robotless_map
from yarm.planning.why.causes import Circumstances

GIVEN_BACK = (PlanStatus.INFEASIBLE, PlanStatus.INVALID_GOAL)
"""What a plan may say of a robot's goal that somebody else may still reach, or nobody as the map is."""
PASSED, UNCHECKED, COMES_IN, REFUSED = "safe", "not asked", "not asked: straight in, free by the map", "refused: "
"""What the checker says of a step that is sent; REFUSED is followed by the reason."""
PLANNING = "a plan is being made"
"""Why nobody moves while one is."""
KEEP_CLEAR_COLUMNS = 1
"""An idle robot stays out of the private areas inflated by this many columns (0.6 m from the part)."""


class Mission(Activity):
    """Steps the fleet until nobody has a task left."""

    def __init__(self, cell: CellState, tools: Tools, assignments: Assignments, bounded: bool = False) -> None:
        """A mission.

        Args:
            cell: the cell as it is known.
            tools: planner and generator.
            assignments: how the world's task queue gives goals to robots.
            bounded: keep out of the manipulators' private areas.
        """
        super().__init__(cell)
        self._queue = cell.queue
        self._tools = tools
        self._assignments = assignments
        self._bounded = bounded
        self._hands = Handling(cell)
        self._guard = StepGuard(cell.params.recheck_count)
        self._not_before_s = -math.inf
        self._checked_s = -math.inf
        self._map_s = -math.inf
        self._refusals = 0
        self._quiet_since_s: Optional[float] = None
        self._stuck_since_s: Optional[float] = None
        self._outside: Dict[str, str] = {}
        self._asked: Optional[Tuple[PlanRequest, float, Answer]] = None
        self._planned: Optional[FleetPlan] = None
        self.interrupted: Dict[str, Step] = {}

    def start(self, now_s: float) -> List[Action]:
        """Forget the plans and tasks of the last mission."""
        self.cell.turns_finer = False
        self._assignments.start()
        self._tools.planner.reset()
        self._planned = None
        self._hands.start(now_s)
        return []

    @property
    def jobs(self) -> Tuple[Job, ...]:
        """What the hands are at."""
        return self._hands.jobs

    def resume(self, jobs: Sequence[Job], steps: Mapping[str, Step], now_s: float) -> None:
        """Go on with the queue's tasks as they are, from wherever everybody stands.

        Args:
            jobs: what the hands were at.
            steps: what each robot was sent. It ends that first if the checker still agrees: the turns that the planner
                knows lead nowhere from a heading in the midst of one.
            now_s: time, s.
        """
        self._tools.planner.reset()
        self.interrupted = dict(sorted(steps.items()))
        self._hands.resume(jobs, now_s)

    def advance(self, now_s: float) -> List[Action]:
        """One look at the newest map; plans when everybody has arrived."""
        world_map = self.cell.map
        actions = self._watch_progress(now_s)
        if world_map is None or world_map.stamp_s <= self._map_s:
            return actions
        self._map_s = world_map.stamp_s
        actions += self._watch(now_s) + self._hands.advance(now_s)
        if self.cell.goals.of(Purpose.STEP) or now_s < self._not_before_s:
            return actions
        if self._asked is None:
            actions += self._arrivals(now_s)
            coming_in = self._finish_steps(now_s) or self._bring_in(now_s)
            if coming_in:
                return actions + coming_in
            request = self._assign(now_s)
            if not self._queue.assignments:
                return actions + self._nothing_assigned(now_s)
            self._quiet_since_s = None
            self._asked = request, now_s, self._tools.ask(request)
        return actions + self._carry_out(now_s)

    def goal_done(self, goal: ActiveGoal, event: GoalDone, now_s: float) -> List[Action]:
        """A step, or a hand's work, has ended, well or not."""
        if goal.purpose is Purpose.HAND:
            return self._hands.goal_done(goal, event, now_s)
        if goal.purpose is not Purpose.STEP:
            return []
        self._guard.forget(goal.robot)
        if event.outcome is Outcome.SUCCEEDED:
            self._note(goal.robot, "")
            return []
        held = self.cell.holds.get(goal.robot, "")
        reason = goal.why or held or f"{event.outcome.value} {event.message}".rstrip()
        self._note(goal.robot, reason)
        if not goal.replans:
            self._not_before_s = max(self._not_before_s, now_s + self.cell.params.retry_s)
        return [Log(Level.WARN, f"{goal.robot} did not reach its waypoint: {reason}")]

    def delete_done(self, event: DeleteDone) -> List[Action]:
        """The simulator (or whoever keeps the cell) has answered, maybe for an earlier mission."""
        if event.success:
            if event.name in self._deleting():
                self._queue.deleted(event.name)
            return [Log(Level.INFO, f"{event.name} is deleted")]
        if any(task.goal.name == event.name and not task.on_map for task in self._queue.deleting):
            self._queue.deleted(event.name)
            return [Log(Level.INFO, f"{event.name} is gone already: {event.message}")]
        return [Log(Level.WARN, f"{event.name} was not deleted, it is tried again: {event.message}")]

    def tasks(self) -> List[TaskView]:
        """Every task: finished, assigned, waiting or unreachable."""
        views = {}
        for task in self._queue.finished:
            views[task.goal.name] = TaskView(task.robot, task.goal.name, task.kind, TaskState.REACHED, "", 0.0)
        views.update({view.goal: view for view in self._hands.tasks()})
        for robot, refusal in self._outside.items():
            status = TaskState.STOPPED if refusal else TaskState.BACKING_OUT
            views[f"inside/{robot}"] = TaskView(robot, f"inside/{robot}", GoalKind.CLEAR, status, refusal)
        for task in sorted(self._queue.tasks, key=lambda task: task.robot):
            if task.robot:
                views[task.goal.name] = self._assigned_view(task)
        unreachable = self._queue.unreachable
        for name, goal in sorted(self.cell.open_goals().items()):
            reason = unreachable.get(name)
            if name not in views:
                status = TaskState.UNREACHABLE if reason else TaskState.WAITING
                views[name] = TaskView("", name, goal.kind, status, reason or "")
        return list(views.values())

    def circumstances(self) -> Circumstances:
        """What the newest map, the tasks and the newest plan are, for whoever asks why."""
        return self.cell.circumstances(self._request(), self._planned)

    def _assigned_view(self, task: Task) -> TaskView:
        robot, goal = task.robot, task.goal
        tracked = self.cell.robots.get(robot)
        left = math.nan
        if tracked is not None and self.cell.map is not None:
            left = tracked.distance_to(self.cell.map.spec, goal.column)
        status = TaskState.MOVING if robot in self._on_the_way() else TaskState.ASSIGNED
        if goal.kind == GoalKind.CLEAR:
            status = TaskState.BACKING_OUT
        return TaskView(robot, goal.name, goal.kind, status, task.reason, left)

    def _note(self, robot: str, reason: str) -> None:
        if self._queue.task_of(robot) is not None:
            self._queue.note(robot, reason)

    def _deleting(self) -> List[str]:
        return [task.goal.name for task in self._queue.deleting]

    def _watch_progress(self, now_s: float) -> List[Action]:
        """A robot that is sent somewhere must come nearer, by its own pose, whatever anybody says."""
        params, goals = self.cell.params, self.cell.goals
        actions: List[Action] = []
        for goal in goals.of(Purpose.STEP):
            robot = self.cell.robots.get(goal.robot)
            if robot is not None:
                goals.note_progress(goal.robot, robot.x, robot.y, robot.yaw_rad, now_s)
            if now_s - goals.active[goal.robot].best_s > params.no_progress_s:
                held = self.cell.holds.get(goal.robot)
                why = f"held by the safety monitor: {held}" if held else "no obstacle reported"
                actions += goals.cancel(goal.robot, now_s, f"has not moved for {params.no_progress_s:g} s ({why})")
        return actions

    def _finish_steps(self, now_s: float) -> List[Action]:
        """One robot after the other that was interrupted on its way ends its step."""
        for name, step in list(self.interrupted.items()):
            del self.interrupted[name]
            robot, end = self.cell.robots.get(name), self.cell.waypoint_of(step.target)
            if robot is None or name in self.cell.unplanned or self.cell.seen_at(robot, end):
                continue
            if not self.cell.seen_between(robot, step.start, end):
                continue
            body = self.cell.robot_at(name, step.start, robot.cells)
            request = self._request({name: body})
            verdict = check_release(request, {name: (end,)}, {})
            if not verdict.safe:
                return [Log(Level.WARN, f"{name} does not end the step it was at: {verdict.reason}")]
            self._guard.watch(request, body, end)
            return [self._send_step(name, step.target, step.start, now_s, why=PASSED)]
        return []

    def _send_step(
        self,
        name: str,
        target: Target,
        start: Optional[Waypoint],
        now_s: float,
        via: Tuple[Target, ...] = (),
        why: str = "",
    ) -> Action:
        return self.cell.goals.send(name, Purpose.STEP, MobileAction.ABOUT_TIP.value, now_s, target, start, via, why)

    def _bring_in(self, now_s: float) -> List[Action]:
        """One robot after the other that stands outside the volume is sent straight back in, where there is a way."""
        self._outside = {name: self._outside.get(name, "") for name in self.cell.outside}
        for name in self._outside:
            robot = self.cell.robots[name]
            way = way_in(robot, self.cell.spec, self.cell.occupied_but(name))
            self._outside[name] = way.reason
            if way.target is not None:
                self._guard.watch_cells(name, way.cells)
                text = f"{name} is outside the mapped volume at ({robot.x:.2f}, {robot.y:.2f}) m: it comes straight in"
                return [Log(Level.WARN, text), self._send_step(name, way.target, None, now_s, why=COMES_IN)]
        return []

    def _watch(self, now_s: float) -> List[Action]:
        """Steps under way: something on the way, a goal that moved or vanished."""
        params, goals = self.cell.params, self.cell.goals
        actions: List[Action] = []
        for goal in goals.of(Purpose.STEP):
            if goal.robot not in self.cell.robots:
                actions += goals.cancel(goal.robot, now_s, f"{goal.robot} has left the map")
            elif self._aim_lost(goal.robot):
                actions += goals.cancel(goal.robot, now_s, "replan: its goal has moved or gone", replans=True)
        if (
            params.checking is CheckSteps.SEND_SAFE
            and now_s - self._checked_s >= params.recheck_s
            and goals.of(Purpose.STEP)
        ):
            self._checked_s = now_s
            actions += self._recheck(now_s)
        return actions

    def _aim_lost(self, robot: str) -> bool:
        task = self._queue.task_of(robot)
        if task is None or task.kind not in (*BODIES, GoalKind.BIN):
            return False
        now = self.cell.open_goals().get(task.goal.name)
        return now is None or now.column != task.goal.column

    def _recheck(self, now_s: float) -> List[Action]:
        goals = {**self._queue.goals, **self.cell.open_goals()}
        request = self.cell.request(goals, self._queue.assignments, foreseeing=False)
        actions: List[Action] = []
        occupied = robotless_map(request)
        for name in self.cell.outside:
            own = self.cell.robots[name].cells
            occupied[tuple(own[request.spec.contains(own)].T)] = False
        for robot, cells in self._guard.alarms(occupied):
            if not self._still_ahead(robot, cells):
                continue
            name = self._owner(cells)
            actions += self.cell.goals.cancel(robot, now_s, f"replan: {name} is in the way", replans=True)
            self._guard.forget(robot)
        return actions

    def _still_ahead(self, robot: str, cells: IntArray) -> bool:
        """Whether cells (n, 3) that a robot's step sweeps stop it when they are taken: all do."""
        return True

    def _on_the_way(self) -> Set[str]:
        """Robots that were sent somewhere and have not ended."""
        return {goal.robot for goal in self.cell.goals.of(Purpose.STEP)}

    def _places(self) -> Mapping[str, Robot]:
        """Robots that are planned for from elsewhere than where they stand."""
        return {}

    def _left(self) -> Optional[Mapping[str, float]]:
        """What each robot under way has left of its move, cells; None where all are idle at the same time."""
        return None

    def _owner(self, cells: IntArray) -> str:
        wanted = {tuple(index) for index in cells.tolist()}
        for name, found in (self.cell.map.objects if self.cell.map is not None else {}).items():
            if found.kind != ObjectKind.MOBILE and not wanted.isdisjoint(map(tuple, found.cells.tolist())):
                return name
        for name, hidden in self.cell.hidden.by_hider().items():
            if not wanted.isdisjoint(map(tuple, hidden.tolist())):
                return name
        return "something"

    def _arrivals(self, now_s: float) -> List[Action]:
        """Pop the tasks of robots that are where they were wanted, and delete what they reached."""
        actions: List[Action] = []
        goals, moving = {**self._queue.goals, **self.cell.open_goals()}, self._on_the_way()
        for robot, name in sorted(self._queue.assignments.items()):
            tracked, goal = self.cell.robots.get(robot), goals.get(name)
            if robot in moving or tracked is None or goal is None or not self.cell.at(tracked, goal):
                continue
            task = self._queue.pop(robot, now_s)
            self._stuck_since_s = None
            if task.kind is not GoalKind.CLEAR:
                actions.append(Log(Level.INFO, f"{robot} has reached {name}"))
            if task.kind is GoalKind.BIN or (task.kind is GoalKind.DEBRIS and self.cell.params.bins_used):
                actions += self._hands.reached(robot, task.goal, now_s)
            elif task.status is TaskStatus.DELETING:
                actions.append(self._deletion(name))
        actions += self._delete_again(now_s)
        return actions

    def _deletion(self, name: str) -> DeleteObject:
        found = self.cell.map.objects.get(name) if self.cell.map is not None else None
        return DeleteObject(name) if found is None else DeleteObject(name, self.cell.place_of(found))

    def _delete_again(self, now_s: float) -> List[Action]:
        actions: List[Action] = []
        for task in self._queue.deleting:
            name = task.goal.name
            if now_s - task.since_s > self.cell.params.delete_timeout_s:
                self._queue.ask_again(name, now_s)
                actions += [Log(Level.WARN, f"no answer to the deletion of {name}, asked again"), self._deletion(name)]
        return actions

    def _assign(self, now_s: float) -> PlanRequest:
        request = self.cell.request({}, {}, self._forbidden(), self._places())
        self._assignments.update(request, self.cell.open_goals(), now_s)
        self._assignments.process(self._full(request), self._keep_clear(), self.cell.hidden.movable, self._left())
        return replace(self._full(request), assignments=dict(self._queue.assignments))

    def _forbidden(self) -> Optional[BoolArray]:
        return self.cell.private_columns() if self._bounded else None

    def _request(self, places: Optional[Mapping[str, Robot]] = None) -> PlanRequest:
        """The newest map with the tasks as they are; robots in ``places`` stand there in it."""
        request = self._full(self.cell.request({}, {}, self._forbidden(), places))
        return replace(request, assignments=dict(self._queue.assignments))

    def _full(self, request: PlanRequest) -> PlanRequest:
        goals = {**self.cell.open_goals(), **self._queue.goals}
        objects = {name: cells for name, cells in request.objects.items() if name not in goals}
        return replace(request, goals=goals, objects=objects)

    def _keep_clear(self) -> Optional[BoolArray]:
        return self.cell.private_columns(KEEP_CLEAR_COLUMNS) if self.cell.manipulators else None

    def _nothing_assigned(self, now_s: float) -> List[Action]:
        if self._hands.busy or self._on_the_way():
            self.reason, self._quiet_since_s = self._hands.busy, None
            return []
        return self._idle(now_s)

    def _idle(self, now_s: float) -> List[Action]:
        """Nobody has a task: done after a while, unless goals remain that nobody can reach."""
        params = self.cell.params
        if self._quiet_since_s is None:
            self._quiet_since_s = now_s
        waited = now_s - self._quiet_since_s
        unreachable = self._queue.unreachable
        waits = [reason for _, reason in sorted(self._outside.items())] + [self._hands.waiting()]
        shut_out = [reason for reason in waits if reason]
        if unreachable or shut_out:
            name = sorted(unreachable)[0] if unreachable else ""
            self.reason = shut_out[0] if shut_out else f"{name} cannot be reached: {unreachable[name]}"
            self._not_before_s = now_s + params.retry_s
            if waited > params.give_up_s:
                self.finish(Ending.FAILED, self.reason)
            elif unreachable:
                return self._turn_finer(waited)
        elif self._queue.deleting:
            self.reason = f"waiting for the deletion of {', '.join(self._deleting())}"
        elif waited < params.linger_s:
            self.reason = "no task is open"
        else:
            self.finish(Ending.SUCCEEDED)
        return []

    def _turn_finer(self, waited_s: float) -> List[Action]:
        """When there has been no way for so long, robots make finer turns, too, from now on."""
        params = self.cell.params
        if waited_s <= params.finer_after_s or not params.finer_turns_deg or self.cell.turns_finer:
            return []
        self.cell.turns_finer = True
        self._tools.planner.reset()
        finer = ", ".join(f"{angle:g}" for angle in params.finer_turns_deg)
        return [Log(Level.WARN, f"{self.reason}; robots turn by {finer} deg, too (finer_turns_deg)")]

    def _carry_out(self, now_s: float) -> List[Action]:
        """Send what was planned, when it is there; what took longer than a map is held against the newest one."""
        answered = self._answered()
        if answered is None:
            self.reason = PLANNING
            return []
        request, asked_s, plan = answered
        if asked_s < now_s:
            asked, request = request, self._request()
            if not starts_alike(asked, request, plan) or any(map(self._aim_lost, asked.assignments)):
                return []
        self._planned = plan
        return self._send_steps(request, plan, now_s)

    def _answered(self) -> Optional[Tuple[PlanRequest, float, FleetPlan]]:
        """What was asked for, when, s, and the plan; None while it is being made. Whatever fails is asked for anew."""
        if self._asked is None:
            return None
        (request, asked_s, answer), self._asked = self._asked, None
        plan = answer()
        if plan is None:
            self._asked = request, asked_s, answer
            return None
        return request, asked_s, plan

    def _send_steps(self, request: PlanRequest, plan: FleetPlan, now_s: float) -> List[Action]:
        before_s = self._tools.stopwatch_s()
        checked = sendable(request, plan, self.cell.params.checking)
        check_ms = 1e3 * (self._tools.stopwatch_s() - before_s)
        self._refusals += bool(checked.refused)
        sent = tuple(checked.steps)
        actions: List[Action] = [ShowPlan(request, plan, sent, checked.refused, check_ms, self._refusals)]
        if checked.refused:
            kept = self.cell.params.checking is CheckSteps.SEND_SAFE
            verdict = "a step was not sent: " if kept else "a step was sent that the checker refuses: "
            actions.append(Log(Level.WARN, verdict + checked.refused))
        self._take_refusals(plan)
        if not checked.steps:
            return actions + self._stand_still(plan, checked, now_s)
        self.reason = checked.refused
        self._stuck_since_s = None
        robots = {robot.name: robot for robot in request.robots}
        for name, step in checked.steps.items():
            self._guard.watch(request, robots[name], step)
            start = Waypoint(robots[name].column, robots[name].yaw_rad)
            target, why = self.cell.target_of(step), self._passed(checked.refused)
            actions.append(self._send_step(name, target, start, now_s, why=why))
        return actions

    def _passed(self, refused: str) -> str:
        """What the checker says of a step that is sent; ``refused`` is what it has against the whole plan."""
        if self.cell.params.checking is CheckSteps.UNCHECKED:
            return UNCHECKED
        sent_all_the_same = refused and self.cell.params.checking is CheckSteps.REPORT
        return f"{REFUSED}{refused}" if sent_all_the_same else PASSED

    def _take_refusals(self, plan: FleetPlan) -> None:
        for name, robot_plan in sorted(plan.robots.items()):
            if robot_plan.status is not PlanStatus.SOLVED:
                self._note(name, f"{robot_plan.status.value}: {robot_plan.reason}")
            else:
                self._note(name, "")
            if robot_plan.status in GIVEN_BACK and robot_plan.goal and self._gives_back(name):
                self._assignments.reject(name, robot_plan.reason)

    def _gives_back(self, robot: str) -> bool:
        """Whether a robot's goal is given back when it has no way there."""
        return True

    def _stand_still(self, plan: FleetPlan, checked: CheckedSteps, now_s: float) -> List[Action]:
        """A plan moves nobody: the mission fails after a while."""
        params = self.cell.params
        self.reason = checked.refused or plan.reason or "the planner lets everybody wait"
        self._not_before_s = now_s + params.retry_s
        if self._stuck_since_s is None:
            self._stuck_since_s = now_s
        if now_s - self._stuck_since_s > params.give_up_s:
            self.finish(Ending.FAILED, self.reason)
            return []
        return [] if checked.refused else self._turn_finer(now_s - self._stuck_since_s)
