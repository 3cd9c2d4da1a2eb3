"""Node ``run_exploration``: follows one exploration to its end, scores it by the truth, writes the results."""

from __future__ import annotations

import threading
import time
from collections import deque
from pathlib import Path
from typing import Any, Callable, Deque, Dict, Optional

import rospy
from nav_msgs.msg import OccupancyGrid
from nav_msgs.msg import Odometry as OdometryMessage

from yarm.console.results import FILM
from yarm.experiments.explore.cost import RunCost
from yarm.experiments.explore.judge import Judge, Watcher
from yarm.experiments.explore.live import WATCHED_S, LiveRecorder
from yarm.experiments.explore.record import ExploreRecord
from yarm.exploration.deadline import SETTLE_S
from yarm.exploration.model import LOOP_S, Command, Event
from yarm.exploration.params import ExploreParams
from yarm.exploration.session import State
from yarm.geometry import Pose2
from yarm.msg import Contacts, ExplorerEvent, ExplorerStatus, StepAck
from yarm.params import build, infos
from yarm.robots import turtlebot
from yarm.ros.common import names
from yarm.ros.common.acks import step_ack
from yarm.ros.common.conversions import pose2_of_pose
from yarm.ros.common.params import load_params
from yarm.ros.common.start import init_node
from yarm.ros.console.filmer import filmer_of
from yarm.ros.experiment.console import say
from yarm.ros.experiment.usage import UsageMeter
from yarm.ros.exploration.experiment_params import ExplorationRunParams
from yarm.ros.exploration.progress import progress_line
from yarm.ros.exploration.results import write_results
from yarm.ros.navigation.maps import grid_fault, grid_of
from yarm.sim.scenes.arena import load_arena

PROGRESS_S = 1.0
POLL_S = 0.05
ENDED = (State.DONE.value, State.FAILED.value)
CUT_SHORT = "ROS is shutting down"
KEPT_EARLY = 200
"""Poses and contacts that are kept until it is known when the run began."""


class Exploration:
    """Listens, tells, and keeps the record. Every callback takes the lock."""

    def __init__(self, params: ExplorationRunParams, explore: ExploreParams) -> None:
        """Listen from now on.

        Args:
            params: of this node.
            explore: limits of the explorer that is followed.
        """
        self._params = params
        self._explore = explore
        self._arena = load_arena(params.arena)
        self.judge = Judge(self._arena)
        self._watcher = Watcher(self.judge, self._arena.start)
        self._recorder = LiveRecorder(self._arena, explore, params.seed, self._watcher, self._arena.start)
        self._lock = threading.Lock()
        self._status: Optional[ExplorerStatus] = None
        self._started_s: Optional[float] = None
        self._early: Deque[Callable[[], None]] = deque(maxlen=KEPT_EARLY)
        self._now_s = 0.0
        self._running = False
        self._said_wall, self._said_s = 0.0, 0.0
        self._meter = UsageMeter()
        self.cost: Optional[RunCost] = None
        self._ack = rospy.Publisher(names.STEP_ACK, StepAck, queue_size=10)
        self._subscribers = [
            rospy.Subscriber(names.explorer("status"), ExplorerStatus, self._on_status, queue_size=100),
            rospy.Subscriber(names.explorer("events"), ExplorerEvent, self._on_event, queue_size=1000),
            rospy.Subscriber(names.explorer("map"), OccupancyGrid, self._on_map, queue_size=1),
            rospy.Subscriber(names.SIM_POSE, OdometryMessage, self._on_truth, queue_size=1000),
            rospy.Subscriber(names.SIM_CONTACTS, Contacts, self._on_contacts, queue_size=1000),
        ]

    def _say_ready(self) -> None:
        """Lock-step: the explorer waits for this before its first pass."""
        if all(subscriber.get_num_connections() for subscriber in self._subscribers):
            self._ack.publish(step_ack(rospy.Time.from_sec(rospy.get_time()), 0))

    def run(self) -> str:
        """Follow the run to its end; what went wrong, empty when nothing did."""
        fault = self._wait_for(self._has_started, self._params.start_limit_s, "the explorer has not started")
        if not fault:
            self._meter.start()
            began_s, began = self._now(), time.monotonic()
            fault = self._wait_for(self._has_ended, None, "")
            self.cost = self._cost(self._now() - began_s, time.monotonic() - began)
        return fault or self._wait_for(self._is_watched, None, "")

    def record(self, fault: str) -> ExploreRecord:
        """What was recorded."""
        with self._lock:
            status = self._status
            state, reason = ("", "") if status is None else (status.state, status.reason)
            limit_s = self._explore.time_limit_s
            over = status is not None and status.left <= 1.0
            early_s = limit_s if status is None or over else status.elapsed + SETTLE_S
            done = state == State.DONE.value and not over and not fault
            return self._recorder.finish(min(early_s, limit_s), done, fault or reason, self._watcher.first_seen)

    def _cost(self, sim_s: float, wall_s: float) -> RunCost:
        nodes = self._meter.finish(round(sim_s / LOOP_S))
        return RunCost(sim_s, wall_s, tuple(sorted(nodes, key=lambda node: -node.cpu_share)))

    def _now(self) -> float:
        with self._lock:
            return self._now_s

    def _has_started(self) -> bool:
        return self._started_s is not None

    def _has_ended(self) -> bool:
        return self._status is not None and str(self._status.state) in ENDED

    def _is_watched(self) -> bool:
        assert self._status is not None and self._started_s is not None
        end_s = self._started_s + self._status.elapsed + SETTLE_S
        if self._status.left <= 1.0:
            end_s = self._started_s + self._explore.time_limit_s
        return bool(self._now_s >= end_s + WATCHED_S)

    def _wait_for(self, done: Callable[[], bool], limit_s: Optional[float], what: str) -> str:
        began = moved = time.monotonic()
        moved_s = -1.0
        while not self._is(done):
            if rospy.is_shutdown():
                return CUT_SHORT
            now = time.monotonic()
            with self._lock:
                now_s, reason = self._now_s, "" if self._status is None else self._status.reason
            if now_s > moved_s:
                moved_s, moved = now_s, now
            if limit_s is not None and now - began > limit_s:
                return f"{what} within {limit_s:.0f} s of wall time: {reason or 'nothing heard from it'}"
            if now - moved > self._params.stall_limit_s:
                return f"simulated time has stood still at {now_s:.1f} s for {self._params.stall_limit_s:.0f} s"
            self._tell()
            if self._status is None or self._status.state == State.IDLE.value:
                self._say_ready()
            time.sleep(POLL_S)
        return ""

    def _is(self, done: Callable[[], bool]) -> bool:
        with self._lock:
            return done()

    def _tell(self) -> None:
        """At most one line a second of wall time."""
        now = time.monotonic()
        if now - self._said_wall < PROGRESS_S:
            return
        with self._lock:
            status, share, bumps, now_s = self._status, self._recorder.share, self._recorder.bumps, self._now_s
        rate = (now_s - self._said_s) / (now - self._said_wall) if self._said_wall else 0.0
        self._said_wall, self._said_s = now, now_s
        if status is None:
            say("waiting for the explorer")
            return
        say(progress_line(status, rate, share, bumps))

    def _once_started(self, take: Callable[[], None]) -> None:
        """Take in what may be older than the word that the run has begun, and come before it."""
        self._early.append(take)
        while self._started_s is not None and self._early:
            self._early.popleft()()

    def _since_start(self, stamp: rospy.Time) -> float:
        return float("-inf") if self._started_s is None else float(stamp.to_sec()) - self._started_s

    def _on_status(self, message: ExplorerStatus) -> None:
        with self._lock:
            self._status = message
            self._now_s = max(self._now_s, message.header.stamp.to_sec())
            if self._started_s is None and message.moving:
                self._started_s = message.started.to_sec()
            believed = pose2_of_pose(message.pose) if message.has_pose else Pose2(float("nan"), float("nan"))
            twist = message.command
            command = Command(twist.linear.x, twist.angular.z)
            at_s = self._since_start(message.header.stamp)
            self._recorder.passed(at_s, message.behaviour, believed, command, message.pass_ms)

    def _on_event(self, message: ExplorerEvent) -> None:
        event = Event(message.t, message.kind, tuple(zip(message.names, message.values)))
        with self._lock:
            self._running = self._running or ("to", State.EXPLORING.value) in event.details
            if self._running:
                self._recorder.event(event)

    def _on_map(self, message: OccupancyGrid) -> None:
        fault = grid_fault(message)
        if fault:
            rospy.logwarn("%s: a map is left out: %s", names.explorer("map"), fault)
            return
        grid = grid_of(message)
        with self._lock:
            self._recorder.map(max(0.0, self._since_start(message.header.stamp)), grid)

    def _on_truth(self, message: OdometryMessage) -> None:
        with self._lock:
            self._now_s = max(self._now_s, message.header.stamp.to_sec())
            self._once_started(lambda: self._take_truth(message))

    def _take_truth(self, message: OdometryMessage) -> None:
        self._recorder.truth(self._since_start(message.header.stamp), pose2_of_pose(message.pose.pose))

    def _on_contacts(self, message: Contacts) -> None:
        with self._lock:
            self._once_started(lambda: self._take_contacts(message))

    def _take_contacts(self, message: Contacts) -> None:
        for contact in message.contacts:
            bodies = {contact.body_a, contact.body_b}
            others = bodies - {turtlebot.TYPE, "floor"}
            if turtlebot.TYPE in bodies and len(others) == 1:
                at_s = self._since_start(message.header.stamp)
                self._recorder.touch(at_s, others.pop(), contact.point.x, contact.point.y)


def main() -> int:
    """Run the node; exit code 0 only when the run kept the rules and mapped what was asked for."""
    init_node("run_exploration")
    params = load_params(ExplorationRunParams)
    explore = followed_params()
    exploration = Exploration(params, explore)
    filmer = filmer_of(f"{params.arena}/{params.seed}", params.film_hz)
    fault = exploration.run()
    record = exploration.record(fault)
    folder = Path(params.folder)
    success, table = write_results(record, exploration.judge, folder, fault, exploration.cost)
    if filmer is not None:
        filmer.end().write(folder / FILM)
    say("\n" + table + f"\n\nresults and pictures: {folder.resolve()}")
    return 0 if success else 1


def followed_params() -> ExploreParams:
    """Limits of the explorer that is followed, as it was started with them."""
    found: Dict[str, Any] = rospy.get_param(names.EXPLORER_NODE, {})
    known = {name for name, _, _ in infos(ExploreParams)}
    return build(ExploreParams, {name: value for name, value in found.items() if name in known})
