"""The Commander without ROS: requests and events in, actions out; no clock, no threads, no messages.

    commander = Commander(params, tools)
    reply, actions = commander.request(Request(current_state=True), now_s)
    actions = commander.step(MapUpdate(cell_map), now_s)

The same events at the same times give the same actions. After the death of another one a new one goes on with
``take_up(memory, now_s)``, where ``memory`` is what the other one's ``memory(now_s)`` was last.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Dict, List, Optional, Tuple, Type

from yarm.commander.activity import Activity, Ending, Result, Stopping, cancel_all, stoppable
from yarm.commander.assignment import QueuedAssignments
from yarm.commander.calibration import Calibration
from yarm.commander.cell_state import CellState
from yarm.commander.cleanup import Cleanup
from yarm.commander.continuous import mission_for
from yarm.commander.events import (
    Action,
    Actions,
    ClockReset,
    DeleteDone,
    Event,
    GoalDone,
    Grasp,
    Hold,
    Level,
    Log,
    MapUpdate,
    Outcome,
    RegistryUpdate,
    SanderChange,
    ServerUpdate,
    SetAssociation,
    TaskView,
    Tick,
)
from yarm.commander.goals import Purpose
from yarm.commander.ledger import Ledger
from yarm.commander.memory import Memory, Work, restore, with_cell
from yarm.commander.mission import Mission
from yarm.commander.params import CommanderParams
from yarm.commander.requests import Request, Situation, decide
from yarm.commander.states import MISSION_STATES, TABLE, State, Trigger, check_table
from yarm.commander.supervision import Supervisor
from yarm.commander.take_up import TakeUp
from yarm.commander.tools import Tools
from yarm.planning.why.causes import Circumstances

WORKS: Dict[Type[Activity], Work] = {
    Calibration: Work.CALIBRATION,
    Mission: Work.MISSION,
    Cleanup: Work.CLEANUP,
}
"""What is remembered of each kind of work; the way to a stop has ended by itself when it is taken up."""


@dataclass(frozen=True)
class Reply:
    """Answer to a request; fields as in StateChange.srv."""

    success: bool
    message: str


@dataclass(frozen=True)
class Status:
    """What ``commander/status`` shows; fields as in CommanderStatus.msg."""

    state: State
    busy: bool
    tasks: Tuple[TaskView, ...]
    outcome: Ending
    reason: str
    elapsed_s: float


class Commander:
    """State machine and background work."""

    def __init__(self, params: CommanderParams, tools: Tools) -> None:
        """In state IDLE."""
        check_table(TABLE)
        self.params = params
        self.cell = CellState(params)
        self.state = State.IDLE
        self._tools = tools
        self._supervisor = Supervisor(self.cell)
        self._ledger = Ledger(self.cell)
        self._work: Optional[Activity] = None
        self._result = Result(Ending.NONE)
        self._last_tasks: Tuple[TaskView, ...] = ()
        self._entered_s = 0.0
        self._off_since_s: Optional[float] = None
        self._association: Optional[bool] = None
        self._map_seen_s: Optional[float] = None
        self._fault = ""
        self._resume: Optional[State] = None
        self._handlers: Dict[Type[object], Callable[..., List[Action]]] = {
            MapUpdate: self._on_map,
            RegistryUpdate: self._on_registry,
            ServerUpdate: self._on_server,
            GoalDone: self._on_goal_done,
            SanderChange: self._on_sander,
            Hold: self._on_hold,
            Grasp: self._on_grasp,
            DeleteDone: self._on_deleted,
            Tick: self._on_tick,
            ClockReset: self._on_clock_reset,
        }

    @property
    def busy(self) -> bool:
        """The state's work goes on."""
        return self._work is not None

    def status(self, now_s: float) -> Status:
        """What there is to show."""
        tasks = tuple(self._work.tasks()) if self._work is not None else self._last_tasks
        reason = self._fault or (self._work.reason if self._work is not None else self._result.reason)
        return Status(self.state, self.busy, tasks, self._result.outcome, reason, max(0.0, now_s - self._entered_s))

    def circumstances(self) -> Circumstances:
        """What there is to say why with: the newest map and, of a mission, its tasks and its newest plan.

        Raises:
            LookupError: no map has come yet.
        """
        if self.cell.map is None:
            raise LookupError("no planning_metadata yet: nothing is known of the cell")
        if isinstance(self._work, (Mission, Cleanup)):
            return self._work.circumstances()
        return self.cell.circumstances(self.cell.request(self.cell.open_goals(), {}), None)

    def objection(self, now_s: float) -> str:
        """Why nothing that moves may move, as far as the Commander can tell; empty when it may."""
        limit = self.params.stale_map_s
        if self._map_seen_s is None:
            return "no planning_metadata yet"
        if now_s - self._map_seen_s > limit:
            return f"no new planning_metadata for more than {limit:g} s"
        if isinstance(self._work, TakeUp):
            return self._work.reason
        if not self.cell.kinds:
            return "no object_registry yet"
        lost = self._lost_servers()
        gone = f"the action server of {', '.join(lost)} is lost" if lost else ""
        return gone or self.cell.hidden.fault(now_s, limit)

    def request(self, request: Request, now_s: float) -> Tuple[Reply, Actions]:
        """Answer a request for a change of state; the work it starts goes on in ``step``."""
        succeeded = self._result.outcome is Ending.SUCCEEDED
        verdict = decide(request, Situation(self.state, self.busy, succeeded, self._result.reason))
        row = verdict.transition
        if row is None:
            return Reply(False, verdict.message), ()
        stops = self.busy and row.trigger is Trigger.PREVIOUS
        self._resume = None
        actions = self._noted(self._enter(row.target, now_s, redo=row.source is not State.STARTED, stops=stops))
        message = f"state {int(row.target)} {row.target.name} entered"
        return Reply(True, message + ("; its work goes on in the background" if self.busy else "")), actions

    def step(self, event: Event, now_s: float) -> Actions:
        """Take in one event."""
        return self._noted(self._handlers[type(event)](event, now_s))

    def memory(self, now_s: float) -> Memory:
        """What another Commander must know to go on from here."""
        if isinstance(self._work, TakeUp):
            return self._work.memory
        work = next((work for kind, work in WORKS.items() if isinstance(self._work, kind)), Work.NOTHING)
        memory = Memory(
            now_s,
            self.state,
            work,
            resume=self._resume,
            entered_s=self._entered_s,
            outcome=self._result.outcome,
            reason=self._result.reason,
            association=self._association,
            off_since_s=self._off_since_s,
            shown=() if self.busy else self._last_tasks,
            jobs=self._work.jobs if isinstance(self._work, Mission) else (),
            steps=dict(self._work.interrupted) if isinstance(self._work, Mission) else {},
        )
        return with_cell(memory, self.cell)

    def take_up(self, memory: Memory, now_s: float) -> Actions:
        """Go on where another one was, before anything else has come in; its work waits for what it needs."""
        restore(self.cell, memory, now_s)
        self.state, self._entered_s, self._off_since_s = memory.state, memory.entered_s, memory.off_since_s
        self._result, self._last_tasks = Result(memory.outcome, memory.reason), memory.shown
        actions: List[Action] = [] if memory.association is None else [SetAssociation(memory.association)]
        if memory.work is Work.CALIBRATION:
            actions += self._enter(State.CALIBRATION, now_s, redo=True, stops=False)
        elif memory.work is not Work.NOTHING:
            mission = memory.work is Work.MISSION
            self._work = TakeUp(self.cell, memory, self._mission() if mission else Cleanup(self.cell, self._tools))
        self._resume = memory.resume
        doing = "" if memory.work is Work.NOTHING else f", {memory.work.value} goes on"
        text = f"taken up after the Commander's death: state {int(self.state)} {self.state.name}{doing}"
        return self._noted([Log(Level.WARN, text), *actions])

    def _noted(self, actions: List[Action]) -> Actions:
        for action in actions:
            if isinstance(action, SetAssociation):
                self._association = action.on
        return (*actions, *self._ledger.entries(actions))

    def _enter(self, state: State, now_s: float, redo: bool, stops: bool) -> List[Action]:
        actions: List[Action] = []
        leaving_mission = isinstance(self._work, (Mission, Cleanup))
        if self._work is not None:
            self._last_tasks = tuple(self._work.tasks())
        if stops and not leaving_mission:
            actions += cancel_all(self.cell, now_s, f"stopped on the way to {state.name}")
        self.state, self._entered_s, self._work = state, now_s, None
        self._ledger.entered(state)
        self._result = Result(Ending.STOPPED if stops else Ending.NONE)
        if state is State.STARTED:
            self._off_since_s = now_s
            actions.append(SetAssociation(False))
        if state is State.CALIBRATION:
            self._work = Calibration(self.cell, None if redo else self._off_since_s)
        elif state in MISSION_STATES:
            self._work = self._mission()
        elif state is State.CLEANUP:
            self._work = Cleanup(self.cell, self._tools)
        elif stops and stoppable(self.cell):
            self._work = Stopping(self.cell)
        if self._work is not None and not stops:
            self._last_tasks = ()
        actions.append(Log(Level.INFO, f"state {int(state)} {state.name}"))
        return actions + (self._work.start(now_s) if self._work is not None else []) + self._settle_work(now_s)

    def _mission(self) -> Mission:
        assignments = QueuedAssignments(self.cell.queue)
        return mission_for(self.cell, self._tools, assignments, self.state is State.BOUNDED)

    def _advance(self, now_s: float) -> List[Action]:
        """Let the work go on, unless a fault stops everything."""
        actions = self._overdue(now_s)
        if self._work is not None and not self._fault:
            actions += self._work.advance(now_s)
        return actions + self._settle_work(now_s)

    def _settle_work(self, now_s: float) -> List[Action]:
        """Take in the end of the work."""
        work = self._work
        if work is None or work.result is None:
            return []
        if isinstance(work, TakeUp):
            return self._carry_on(work, now_s)
        self._result, self._work = work.result, None
        if not isinstance(work, Stopping):
            self._last_tasks = tuple(work.tasks())
        self._ledger.ended(work.result)
        level = Level.WARN if work.result.outcome is Ending.FAILED else Level.INFO
        actions: List[Action] = [
            Log(level, f"{self.state.name} {work.result.outcome.value} {work.result.reason}".rstrip())
        ]
        resume = self._resume
        if self.state is State.CALIBRATION and resume is not None and work.result.outcome is Ending.SUCCEEDED:
            self._resume = None
            actions += self._enter(resume, now_s, redo=False, stops=False)
        return actions

    def _carry_on(self, taken: TakeUp, now_s: float) -> List[Action]:
        """Everything is there: the work goes on; on a clock that went back meanwhile, as after any such step."""
        if taken.clock_went_back:
            return self._on_clock_reset(ClockReset(), now_s)
        self._work = work = taken.work
        if isinstance(work, Mission):
            work.resume(taken.memory.jobs, taken.memory.steps, now_s)
            return []
        self._work = Cleanup(self.cell, self._tools)
        return self._work.start(now_s)

    def _overdue(self, now_s: float) -> List[Action]:
        actions: List[Action] = []
        for goal in self.cell.goals.overdue(now_s, self.params.cancel_timeout_s):
            text = f"{goal.robot} has not ended its cancelled goal within {self.params.cancel_timeout_s:g} s"
            actions.append(Log(Level.WARN, text))
            actions += self._on_goal_done(GoalDone(goal.robot, goal.serial, Outcome.LOST, text), now_s)
        return actions

    def _set_fault(self, fault: str, now_s: float) -> List[Action]:
        if fault == self._fault:
            return []
        self._fault = fault
        if not fault:
            return [Log(Level.INFO, "the fault is gone, the work goes on")]
        steps = self.cell.goals.of(Purpose.STEP, Purpose.HAND)
        actions: List[Action] = [Log(Level.WARN, fault)] if steps or self.busy else []
        for goal in steps:
            actions += self.cell.goals.cancel(goal.robot, now_s, fault)
        return actions

    def _find_fault(self, now_s: float) -> str:
        limit = self.params.stale_map_s
        if self.busy and self._map_seen_s is not None and now_s - self._map_seen_s > limit:
            return f"no new planning_metadata for more than {limit:g} s: every robot is stopped"
        lost = self._lost_servers()
        if self.busy and lost and not isinstance(self._work, (Calibration, TakeUp)):
            return f"the action server of {', '.join(lost)} is lost: every robot is stopped"
        seeing = self.busy and self._map_seen_s is not None
        return self.cell.hidden.fault(now_s, limit) if seeing else ""

    def _lost_servers(self) -> List[str]:
        return [name for name in self.cell.mobiles + self.cell.manipulators if name not in self.cell.connected]

    def _on_map(self, event: MapUpdate, now_s: float) -> List[Action]:
        self._map_seen_s = event.map.stamp_s
        self.cell.take_map(event.map, event.people)
        actions = self._set_fault(self._find_fault(now_s), now_s)
        actions += self._supervisor.on_map(now_s)
        return actions + self._advance(now_s)

    def _on_registry(self, event: RegistryUpdate, now_s: float) -> List[Action]:
        self.cell.kinds = dict(event.kinds)
        self.cell.shapes = dict(event.shapes)
        self.cell.pieces = dict(event.pieces)
        self.cell.registry_complete = bool(event.kinds) and event.complete
        return []

    def _on_server(self, event: ServerUpdate, now_s: float) -> List[Action]:
        if event.connected:
            self.cell.connected.add(event.robot)
        else:
            self.cell.connected.discard(event.robot)
            goal = self.cell.goals.active.get(event.robot)
            if goal is not None:
                done = GoalDone(event.robot, goal.serial, Outcome.LOST, "its action server is gone")
                return self._on_goal_done(done, now_s) + self._set_fault(self._find_fault(now_s), now_s)
        return self._set_fault(self._find_fault(now_s), now_s)

    def _on_goal_done(self, event: GoalDone, now_s: float) -> List[Action]:
        goal = self.cell.goals.end(event)
        if goal is None:
            return []
        self._ledger.goal_done(goal, event)
        if goal.purpose is Purpose.SWITCH:
            return self._supervisor.on_done(event)
        if goal.purpose is Purpose.HAND:
            self.cell.note_hand(goal, event)
        if self._work is None:
            return []
        return self._work.goal_done(goal, event, now_s) + self._advance(now_s)

    def _on_sander(self, event: SanderChange, now_s: float) -> List[Action]:
        self.cell.sander[event.robot] = event.state
        return []

    def _on_hold(self, event: Hold, now_s: float) -> List[Action]:
        self._ledger.hold(event)
        if event.held:
            self.cell.holds[event.robot] = event.reason
        else:
            self.cell.holds.pop(event.robot, None)
        return []

    def _on_grasp(self, event: Grasp, now_s: float) -> List[Action]:
        self.cell.grasping[event.robot] = event.grasping
        return []

    def _on_deleted(self, event: DeleteDone, now_s: float) -> List[Action]:
        if isinstance(self._work, (Mission, Cleanup)):
            return self._work.delete_done(event)
        return []

    def _on_tick(self, event: Tick, now_s: float) -> List[Action]:
        return self._set_fault(self._find_fault(now_s), now_s) + self._advance(now_s)

    def _on_clock_reset(self, event: ClockReset, now_s: float) -> List[Action]:
        """The simulator was started again: everything learnt is void; a mission starts over after calibration."""
        self.cell.goals.active.clear()
        self.cell.forget_poses()
        self._supervisor.reset()
        self._map_seen_s, self._fault, self._entered_s = None, "", now_s
        actions: List[Action] = [Log(Level.WARN, "simulated time went backwards: the simulator was started again")]
        if self.state in (State.IDLE, State.STARTED):
            self._off_since_s = now_s
            return actions
        resume = self.state if self.state in MISSION_STATES else self._resume
        actions += self._enter(State.CALIBRATION, now_s, redo=True, stops=False)
        self._resume = resume
        return actions
