"""Node ``commander``: carries events to the Commander's core and does what it asks for.

Event-driven: each ``planning_metadata`` is one step, together with everything that came since the last one. A thread
wakes a few times a second of wall time only to notice silence; in lock-step a map that is late is waited for by
everybody, and only one that simulated time has passed is missing.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from functools import partial
from itertools import groupby
from typing import Any, Callable, Deque, Dict, List, Optional, Sequence, Type, Union

import numpy as np
import rospy
from std_msgs.msg import Bool, Int8

from yarm.commander.events import (
    Action,
    CancelGoal,
    ClockReset,
    Decision,
    DeleteObject,
    Event,
    Grasp,
    Hold,
    Level,
    Log,
    MapUpdate,
    SanderChange,
    SendGoal,
    ServerUpdate,
    SetAssociation,
    ShowPlan,
    Tick,
)
from yarm.commander.machine import Commander
from yarm.commander.params import CommanderParams, Execution
from yarm.commander.requests import Request
from yarm.commander.tools import Tools, at_once
from yarm.control.sander.states import SanderState
from yarm.geometry import CellMap
from yarm.geometry.kinds import ROBOT_KINDS, ObjectKind
from yarm.msg import CommanderStatus, GripperState, Permission, PlanReport, SafetyStatus, StepAck
from yarm.msg import Decision as DecisionMessage
from yarm.planning.baselines.planned_once import PlannedOnce
from yarm.planning.registry import PlannerUnavailableError, make_planner
from yarm.planning.why.causes import why
from yarm.ros.commander.background import OneAtATime, in_background
from yarm.ros.commander.hands import HandWords
from yarm.ros.commander.links import Links, delete_object
from yarm.ros.commander.markers import MarkerBoard
from yarm.ros.commander.memory import MemoryBook
from yarm.ros.commander.registry import RegistryWatch
from yarm.ros.commander.reports import decision_message, exact_time, plan_report, status_message, why_response
from yarm.ros.commander.results import ResultCount
from yarm.ros.commander.what_if import answered
from yarm.ros.common import names
from yarm.ros.common.acks import step_ack
from yarm.ros.common.checks import Doorkeeper, present_s, safety_fault
from yarm.ros.common.clock import SAME_STAMP_S, ClockWatch
from yarm.ros.common.conversions import MapSubscriber
from yarm.ros.common.params import load_params
from yarm.ros.common.start import init_node
from yarm.ros.common.tracks import TrackSubscriber
from yarm.safety.pulse import beat_in_background
from yarm.srv import (
    StateChange,
    StateChangeRequest,
    StateChangeResponse,
    WhatIf,
    WhatIfRequest,
    WhatIfResponse,
    Why,
    WhyRequest,
    WhyResponse,
)

WATCH_PERIOD_S = 0.2
"""Wall time between two looks for silence, s."""
SILENCE_S = 0.4
"""Without a map for this long, wall time, the watch takes over from the maps, s; in lock-step simulated time, too."""
PATIENCE_S = 0.1
"""Where everybody stands while a step is planned, a plan is waited for so long before the next map is taken, s."""
STATUS_PERIOD_S = 1.0


class CommanderNode:
    """Ties topics, service and actions to the core."""

    def __init__(self, params: CommanderParams) -> None:
        """Subscribe and advertise; work goes on in callbacks."""
        self._params = params
        planner = make_planner(params.planner, params.planner_params)
        planner = planner if params.replanning else PlannedOnce(planner)
        patience_s = PATIENCE_S if params.execution == Execution.STEPS else 0.0
        begin = at_once if params.sync else partial(in_background, patience_s=patience_s)
        tools = Tools(OneAtATime(planner), np.random.default_rng(params.seed), time.perf_counter, begin)
        self._core = Commander(params, tools)
        self._lock = threading.RLock()
        self._inbox: Deque[Event] = deque()
        self._results = ResultCount()
        self._links = Links(self._inbox.append, params.sync, self._results.came)
        self._book = MemoryBook()
        self._kinds: Dict[str, str] = {}
        self._sanders: Dict[str, rospy.Subscriber] = {}
        self._hands: Dict[str, rospy.Subscriber] = {}
        self._handed = HandWords(self._inbox.append)
        self._safety_said: Deque[SafetyStatus] = deque()
        self._held: Dict[str, str] = {}
        self._last_map_wall_s = -1.0
        self._shown: Optional[CommanderStatus] = None
        self._association = rospy.Publisher(names.STATIC_ASSOCIATION_SWITCH, Int8, queue_size=1, latch=True)
        self._status = rospy.Publisher(names.COMMANDER_STATUS, CommanderStatus, queue_size=10, latch=True)
        self._permission = rospy.Publisher(names.PERMISSION, Permission, queue_size=10, tcp_nodelay=True)
        self._report = rospy.Publisher(names.PLAN_REPORT, PlanReport, queue_size=100)
        self._decisions = rospy.Publisher(names.DECISIONS, DecisionMessage, queue_size=1000, tcp_nodelay=True)
        self._ack = rospy.Publisher(names.STEP_ACK, StepAck, queue_size=100, tcp_nodelay=True)
        self._markers = MarkerBoard()
        self._take_up()
        self._clock = ClockWatch()
        self._clock.on_reset(self._on_clock_reset)
        self._registry = RegistryWatch(self._on_registry, self._markers.show_bodies)
        self._safety_door = Doorkeeper(names.SAFETY_STATUS)
        self._safety = rospy.Subscriber(names.SAFETY_STATUS, SafetyStatus, self._on_safety, queue_size=10)
        self._tracks = TrackSubscriber(params.sync)
        self._maps = MapSubscriber(self._on_map, self._params.sync)
        self._acks = rospy.Subscriber(names.STEP_ACK, StepAck, self._on_ack, queue_size=100) if params.sync else None
        self._service = rospy.Service(names.COMMANDER_STATE, StateChange, self._on_request)
        self._why = rospy.Service(names.COMMANDER_WHY, Why, self._on_why)
        self._what_if = rospy.Service(names.COMMANDER_WHAT_IF, WhatIf, self._on_what_if)

    def _take_up(self) -> None:
        """Go on where the Commander before died, or begin; perception is switched accordingly, and not before."""
        memory = self._book.taken_up
        if memory is None:
            self._association.publish(Int8(data=0))
        else:
            self._do(self._core.take_up(memory, memory.stamp_s), memory.stamp_s)

    def spin(self) -> None:
        """Notice silence until the node is shut down. In lock-step it plans under its lock: the pulse goes on."""
        beat_in_background()
        while not rospy.is_shutdown():
            time.sleep(WATCH_PERIOD_S)
            if not rospy.is_shutdown():
                self._watch()

    def _watch(self) -> None:
        """Take over when no maps come. What lies in the inbox then is of one moment or another of wall time."""
        with self._lock:
            now_s = rospy.get_time()
            if self._silent(now_s):
                self._inbox.append(Tick())
                self._drain(now_s)
                self._permit(now_s)
                self._show(now_s)

    def _silent(self, now_s: float) -> bool:
        """In lock-step everybody waits for a map that is late; one that simulated time has passed is missing."""
        missing = not self._params.sync or self._core.cell.map is None or abs(now_s - self._stamp_s()) > SILENCE_S
        return missing and time.monotonic() - self._last_map_wall_s > SILENCE_S

    # Callbacks.

    def _on_map(self, cell_map: CellMap) -> None:
        with self._lock:
            self._last_map_wall_s = time.monotonic()
            self._take_holds(cell_map.stamp_s)
            if not self._results.take(cell_map.stamp_s):
                rospy.logwarn("lock-step: a result of before %.4f s has not come; it counts later", cell_map.stamp_s)
            if not self._handed.take(cell_map.stamp_s):
                rospy.logwarn("lock-step: no word of the hands at %.4f s; the newest counts", cell_map.stamp_s)
            self._inbox.append(MapUpdate(cell_map, self._tracks.newest(cell_map.stamp_s)))
            self._drain(cell_map.stamp_s)
            self._permit(cell_map.stamp_s)
            self._show(cell_map.stamp_s)
            if self._params.sync:
                self._acknowledge(cell_map.stamp_s)

    def _on_ack(self, message: StepAck) -> None:
        self._results.acknowledged(message.header.stamp.to_sec(), int(message.results_sent))

    def _on_request(self, message: StateChangeRequest) -> StateChangeResponse:
        with self._lock:
            now_s = self._stamp_s() if self._params.sync else rospy.get_time()
            request = Request(message.next_state, message.current_state, message.previous_state, message.jump_state)
            reply, actions = self._core.request(request, now_s)
            rospy.loginfo("request: %s", reply.message)
            self._remember(now_s)
            self._do(actions, now_s)
            self._show(now_s)
        return StateChangeResponse(reply.success, reply.message)

    def _on_why(self, question: WhyRequest) -> WhyResponse:
        """What it needs is taken at one moment; it is thought about while the work goes on."""
        try:
            with self._lock:
                asked = self._core.circumstances()
            return why_response(why(question.subject, asked), asked.request.spec)
        except LookupError as error:
            return WhyResponse(success=False, text=str(error.args[0]))

    def _on_what_if(self, question: WhatIfRequest) -> WhatIfResponse:
        """The cell is taken at one moment; its forks run in a process of their own, behind everything else."""
        with self._lock:
            cell_map, arms = self._core.cell.map, self._core.cell.manipulators
        return answered(question, cell_map, arms, self._params)

    def _on_registry(self, update: Event) -> None:
        with self._lock:
            self._inbox.append(update)
            self._kinds = dict(getattr(update, "kinds", {}))
            self._links.follow([n for n, kind in sorted(self._kinds.items()) if kind in ROBOT_KINDS])
            arms = [name for name, kind in self._kinds.items() if kind == ObjectKind.MANIPULATOR]
            mobiles = [name for name, kind in self._kinds.items() if kind == ObjectKind.MOBILE]
            handed = mobiles if self._params.bins_used else []
            self._hear(self._sanders, arms, names.sander_state, Int8, self._on_sander)
            self._handed.follow(handed)
            word, kind = ("state", GripperState) if self._params.sync else ("grasping", Bool)
            self._hear(self._hands, handed, lambda name: names.gripper(name, word), kind, self._on_grasping)

    @staticmethod
    def _hear(
        heard: Dict[str, rospy.Subscriber],
        robots: List[str],
        topic: Callable[[str], str],
        kind: Type[Union[Bool, GripperState, Int8]],
        callback: Callable[[Any, str], None],
    ) -> None:
        """Subscribe to a topic of each of these robots, and of no others."""
        for name in [name for name in heard if name not in robots]:
            heard.pop(name).unregister()
        for name in [name for name in robots if name not in heard]:
            heard[name] = rospy.Subscriber(topic(name), kind, callback, callback_args=name, queue_size=10)

    def _on_sander(self, message: Int8, arm: str) -> None:
        state = SanderState.of(message.data)
        if state is None:
            rospy.logwarn_throttle(10.0, f"{names.sander_state(arm)}: {message.data} is no state of a sander: ignored")
        else:
            self._inbox.append(SanderChange(arm, state))

    def _on_grasping(self, message: Union[Bool, GripperState], robot: str) -> None:
        """In lock-step it waits for the map of its time: whether it comes before or after that is chance."""
        if isinstance(message, Bool):
            self._inbox.append(Grasp(robot, bool(message.data)))
        else:
            self._handed.say(message.header.stamp.to_sec(), Grasp(robot, bool(message.grasping)))

    def _on_safety(self, message: SafetyStatus) -> None:
        """In lock-step it waits for the next map: whether it comes before or after that of its own time is chance."""
        if self._safety_door.refuses(message, safety_fault(message, present_s(self._params.sync))):
            return
        with self._lock:
            self._safety_said.append(message)
            if not self._params.sync:
                self._take_holds(np.inf)

    def _take_holds(self, before_s: float) -> None:
        while self._safety_said and self._safety_said[0].header.stamp.to_sec() < before_s - SAME_STAMP_S:
            self._take_hold(self._safety_said.popleft())

    def _take_hold(self, message: SafetyStatus) -> None:
        held = {name: message.reason for name, stopped in zip(message.robots, message.stopped) if stopped}
        for name in held.keys() | self._held.keys():
            if held.get(name) != self._held.get(name):
                self._inbox.append(Hold(name, name in held, held.get(name, "")))
        self._held = held

    def _on_clock_reset(self) -> None:
        with self._lock:
            self._inbox.clear()
            self._safety_said.clear()
            self._handed.forget()
            self._results.forget()
            self._maps.clear()
            self._tracks.clear()
            self._links.reset()
            self._inbox.append(ClockReset())
            self._drain(rospy.get_time())
            self._show(rospy.get_time())

    # The core.

    def _drain(self, now_s: float) -> None:
        for robot, connected in self._links.connected().items():
            if connected != (robot in self._core.cell.connected):
                self._step(ServerUpdate(robot, connected), now_s)
        if self._params.sync:
            self._inbox.extend(in_order([self._inbox.popleft() for _ in range(len(self._inbox))]))
        while self._inbox:
            self._step(self._inbox.popleft(), now_s)

    def _step(self, event: Event, now_s: float) -> None:
        """What is decided is written down before it is done."""
        actions = self._core.step(event, now_s)
        self._remember(now_s)
        self._do(actions, now_s)

    def _do(self, actions: tuple[Action, ...], now_s: float) -> None:
        for action in actions:
            if isinstance(action, SendGoal):
                self._send(action)
            elif isinstance(action, CancelGoal):
                link = self._links.get(action.robot)
                if link is not None:
                    link.cancel(action)
            elif isinstance(action, SetAssociation):
                self._association.publish(Int8(data=1 if action.on else 0))
            elif isinstance(action, DeleteObject):
                deletion = delete_object(action, self._inbox.append)
                if self._params.sync:
                    deletion.join()  # the simulation serves it now, while it waits for this step's acknowledgement
            else:
                self._tell(action, now_s)

    def _tell(self, action: Action, now_s: float) -> None:
        """What is only to be known."""
        if isinstance(action, ShowPlan):
            self._report.publish(plan_report(action, self._params.planner, self._stamp_s()))
            self._markers.show_plan(action, self._core.cell)
        elif isinstance(action, Decision):
            self._decisions.publish(decision_message(action, now_s))
        elif isinstance(action, Log):
            (rospy.logwarn if action.level is Level.WARN else rospy.loginfo)("%s", action.text)

    def _send(self, action: SendGoal) -> None:
        link = self._links.get(action.robot)
        found = self._core.cell.map.objects.get(action.robot) if self._core.cell.map is not None else None
        if link is not None:
            link.send(action, found.position_m[2] if found is not None else 0.0)

    def _stamp_s(self) -> float:
        return self._core.cell.map.stamp_s if self._core.cell.map is not None else 0.0

    def _show(self, now_s: float) -> None:
        status = self._core.status(now_s)
        message = status_message(status, now_s)
        shown = self._shown
        if (
            shown is None
            or not same_status(shown, message)
            or abs(now_s - shown.header.stamp.to_sec()) >= STATUS_PERIOD_S
        ):
            self._shown = message
            self._status.publish(message)
        self._markers.show_world(self._core.cell, status, now_s)

    def _remember(self, now_s: float) -> None:
        if self._book.kept:
            self._book.note(self._core.memory(now_s))

    def _permit(self, now_s: float) -> None:
        """The heartbeat of everything that moves; it is as old as the newest map."""
        objection = self._core.objection(now_s)
        message = Permission(granted=not objection, reason=objection)
        message.header.stamp = exact_time(self._stamp_s())
        message.header.frame_id = names.WORLD_FRAME
        self._permission.publish(message)

    def _acknowledge(self, stamp_s: float) -> None:
        self._ack.publish(step_ack(exact_time(stamp_s), self._links.sent))


def in_order(events: Sequence[Event]) -> List[Event]:
    """Events of one moment: those of several robots, whose order is chance, by robot; each robot's as they came."""
    ordered: List[Event] = []
    for _, group in groupby(events, key=lambda event: hasattr(event, "robot")):
        ordered += sorted(group, key=lambda event: str(getattr(event, "robot", "")))
    return ordered


def same_status(a: CommanderStatus, b: CommanderStatus) -> bool:
    """Whether two messages say the same, but for times and distances."""

    def key(message: CommanderStatus) -> List[object]:
        tasks = [(t.robot, t.goal, t.kind, t.status, t.reason) for t in message.tasks]
        return [message.state, message.busy, message.outcome, message.reason, tasks]

    return key(a) == key(b)


def main() -> None:
    """Run the node until it is shut down."""
    init_node(names.COMMANDER_NODE)
    try:
        node = CommanderNode(load_params(CommanderParams))
    except PlannerUnavailableError as error:
        rospy.logfatal("%s", error)
        raise SystemExit(1) from error
    node.spin()
