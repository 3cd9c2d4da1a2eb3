"""Node ``move_base``: drives to goals over the known map; see ``yarm.navigation.move_base``.

The main thread owns the driving. It makes ``controller_frequency`` steps a second of simulated time, and of wall time
where nobody simulates. Services are answered at any time, in between.
"""

from __future__ import annotations

import math
import signal
import threading
from typing import List, Optional, Tuple

import rospy
from geometry_msgs.msg import PoseStamped
from move_base_msgs.msg import MoveBaseActionGoal
from nav_msgs.srv import GetPlan, GetPlanRequest, GetPlanResponse
from std_srvs.srv import Empty, EmptyRequest, EmptyResponse

from yarm.geometry import Pose2
from yarm.navigation.follower import Drive
from yarm.navigation.move_base import MoveBase, Observation, Status, Step
from yarm.params import ParamError
from yarm.ros.commander.reports import exact_time
from yarm.ros.common import names
from yarm.ros.common.goal_queue import GoalEvent
from yarm.ros.common.passes import Passes
from yarm.ros.common.start import init_node
from yarm.ros.navigation.goal_server import GoalServer, due_goals, goal_in_map
from yarm.ros.navigation.inputs import MoveBaseInputs
from yarm.ros.navigation.outputs import MoveBaseOutputs, path_message
from yarm.ros.navigation.params import MoveBaseNodeParams, move_base_params

PASS_S = 0.1
"""Lock-step: the room waits for everybody so often, simulated time."""
SIGNALS = (signal.SIGINT, signal.SIGTERM)
OVERTAKEN = "cancelled: another goal has come"
AGAIN = "simulated time went backwards"


class MoveBaseNode:
    """Ties topics, services and the action to the driving."""

    def __init__(self, params: MoveBaseNodeParams, stop: threading.Event) -> None:
        """Listen and advertise; nothing moves before :meth:`run`."""
        self._params = params
        self._stop = stop
        self._lock = threading.Lock()
        self._base = MoveBase(params)
        self._pose: Optional[Pose2] = None
        self._driving = False
        self._held: List[GoalEvent] = []
        self._outputs = MoveBaseOutputs(params)
        self._inputs = MoveBaseInputs(params)
        self._server = GoalServer(self._wake)
        self._goals = rospy.Publisher(f"{names.MOVE_BASE}/goal", MoveBaseActionGoal, queue_size=10)
        self._passes = Passes(PASS_S if params.sync else params.period_s, params.sync)
        self._subscriber = rospy.Subscriber(names.SIMPLE_GOAL, PoseStamped, self._on_simple_goal, queue_size=10)
        self._services = [
            *(rospy.Service(f"~{name}", GetPlan, self._on_make_plan) for name in ("make_plan", "NavfnROS/make_plan")),
            rospy.Service("~clear_costmaps", Empty, self._on_clear),
            rospy.Service("~clear_unknown_space", Empty, self._on_clear_unknown),
        ]

    def run(self) -> None:
        """Drive until the node is told to end; the robot is told to stand then."""
        try:
            while not (self._stop.is_set() or rospy.is_shutdown()):
                if self._passes.take_reset():
                    self._start_afresh()
                now_s = self._passes.wait(self._together())
                if self._params.sync and self._passes.take_repeated():
                    self._outputs.acknowledge(exact_time(self._passes.at_s))
                if now_s is not None:
                    self._pass(exact_time(now_s))
        finally:
            self._server.finish(Status.ABORTED, "the node ends")
            if self._driving and not rospy.is_shutdown():
                self._outputs.velocity(Drive())

    def _pass(self, now: rospy.Time) -> None:
        if self._steps_at(now.to_sec()):
            self._step(now)
        self._outputs.acknowledge(now)

    def _steps_at(self, now_s: float) -> bool:
        """Whether a pass of the lock-step is a step too; without lock-step every pass is one."""
        rate = self._params.controller_frequency
        return not self._params.sync or int(round(now_s * rate, 6)) > int(round((now_s - PASS_S) * rate, 6))

    def _together(self) -> bool:
        """Lock-step begins when nothing that is said can be lost."""
        return not self._params.sync or (self._outputs.connected() and self._inputs.together())

    def _step(self, now: rospy.Time) -> None:
        seen = self._inputs.observe(now.to_sec())
        with self._lock:
            self._pose = seen.pose
            self._take_goals(now)
            step = self._base.step(seen)
            grid, version = self._base.grid, (seen.map_count, *self._base.version)
            path, ahead, goal = self._base.path, self._base.ahead, self._base.goal
        self._say(step, seen, now)
        self._outputs.plans(path, ahead, goal, now)
        if grid is not None:
            self._outputs.costmaps(grid, version, seen.pose, now)
        self._server.keep_alive(now.to_sec())

    def _say(self, step: Step, seen: Observation, now: rospy.Time) -> None:
        for event in step.events:
            rospy.loginfo("move_base at %.1f s: %s", now.to_sec(), event)
        drive = step.drive
        if drive is None and self._driving:
            drive = Drive()
        self._driving = step.status is Status.ACTIVE
        if drive is not None:
            self._outputs.velocity(drive)
        if seen.pose is not None:
            self._server.place(seen.pose, self._params.map_frame, now)
        if step.status in (Status.SUCCEEDED, Status.ABORTED):
            self._server.finish(step.status, step.reason or "goal reached")

    def _take_goals(self, now: rospy.Time) -> None:
        """Goals and cancels that have come since the last step, in their order."""
        events = [*self._held, *self._server.events()]
        events, self._held = due_goals(events, now.to_sec()) if self._params.sync else (events, [])
        for event in events:
            if event.cancel:
                self._cancel(event)
            else:
                self._take(event, now)

    def _take(self, event: GoalEvent, now: rospy.Time) -> None:
        target = event.handle.get_goal().target_pose
        goal, fault = goal_in_map(target, self._params.map_frame, self._inputs.in_map)
        self._server.finish(Status.IDLE, OVERTAKEN)
        if goal is None:
            rospy.logwarn("%s: %s", names.MOVE_BASE, fault)
            self._base.cancel()
            self._server.refuse(event.handle, fault)
            return
        self._server.accept(event.handle)
        self._go(goal, now)

    def _go(self, goal: Pose2, now: rospy.Time) -> None:
        self._base.go(goal, now.to_sec())
        self._outputs.goal(goal, now)

    def _cancel(self, event: GoalEvent) -> None:
        if self._server.is_active(event.handle):
            self._base.cancel()
            self._server.finish(Status.IDLE, "cancelled")
        else:
            self._server.recall(event.handle, "cancelled before it was begun")

    def _start_afresh(self) -> None:
        with self._lock:
            self._base.forget()
        self._inputs.forget()
        self._outputs.forget()
        for event in self._held:
            if not event.cancel:
                self._server.refuse(event.handle, AGAIN)
        self._held = []
        self._server.forget(AGAIN)

    def _wake(self) -> None:
        """A goal is worked on at the next step."""

    def _on_simple_goal(self, message: PoseStamped) -> None:
        """A goal without a client goes the same way as all others, as the platform does it."""
        action = MoveBaseActionGoal()
        action.header.stamp = rospy.Time.now()
        action.goal.target_pose = message
        self._goals.publish(action)

    def _on_make_plan(self, request: GetPlanRequest) -> GetPlanResponse:
        """The way between two poses; a start without a frame is the robot's place."""
        response = GetPlanResponse()
        response.plan.header.frame_id = self._params.map_frame
        ends, fault = self._ends(request)
        if ends is None:
            rospy.logwarn("make_plan: %s", fault)
            return response
        with self._lock:
            way = self._base.make_plan(*ends, max(request.tolerance, 0.0))
        if way.reason:
            rospy.logdebug("make_plan: %s", way.reason)
            return response
        response.plan = path_message(way.path, ends[1], self._params.map_frame, rospy.Time.now())
        return response

    def _ends(self, request: GetPlanRequest) -> Tuple[Optional[Tuple[Pose2, Pose2]], str]:
        frame, in_map = self._params.map_frame, self._inputs.in_map
        if not math.isfinite(request.tolerance):
            return None, f"the tolerance {request.tolerance} is no number"
        goal, fault = goal_in_map(request.goal, frame, in_map)
        if goal is None:
            return None, fault
        if request.start.header.frame_id:
            start, fault = goal_in_map(request.start, frame, in_map)
            fault = fault.replace("goal", "start", 1)
        else:
            with self._lock:
                start, fault = self._pose, "no start is given, and the robot's place is not known"
        return (None, fault) if start is None else ((start, goal), "")

    def _on_clear(self, _: EmptyRequest) -> EmptyResponse:
        with self._lock:
            self._base.clear_costmaps()
        return EmptyResponse()

    def _on_clear_unknown(self, _: EmptyRequest) -> EmptyResponse:
        with self._lock:
            if self._pose is not None:
                self._base.clear_unknown_space(self._pose)
        return EmptyResponse()


def main() -> int:
    """Run the node; signals only ask the loop to end, so that the robot is told to stand first."""
    init_node(names.MOVE_BASE, disable_signals=True)
    stop = threading.Event()
    for number in SIGNALS:
        signal.signal(number, lambda *_: stop.set())
    try:
        params, told = move_base_params(rospy.get_param("~", {}), rospy.get_name())
        for sentence in told:
            rospy.loginfo("%s: %s", names.MOVE_BASE, sentence)
        MoveBaseNode(params, stop).run()
    except ParamError as error:
        rospy.logfatal("%s", error)
        return 1
    finally:
        rospy.signal_shutdown("move_base has ended")
    return 0
