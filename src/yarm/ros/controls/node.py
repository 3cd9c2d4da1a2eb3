"""Node ``multi_robot_controls_server``: one action server ``<robot>/move_robot`` for each robot that has a seed.

Event-driven: each message of ``seed_transforms`` is one tick. All work is done by one thread; callbacks only store
what has come and wake it. Without seeds it wakes ten times a second to notice that they are old.
"""

from __future__ import annotations

import fnmatch
import math
import threading
import time
from collections import deque
from dataclasses import dataclass
from typing import Deque, Dict, Optional, Sequence

import numpy as np
import rospy
from geometry_msgs.msg import Pose, TransformStamped

from yarm.control.base.controller import Outcome
from yarm.geometry import rpy_of_quaternion, wrap_angle
from yarm.geometry.kinds import ROBOT_KINDS
from yarm.msg import MoveRobotFeedback, ObjectRegistry, RegisteredObject, StepAck, TransformStampedVector
from yarm.robots import hc10
from yarm.ros.common import names
from yarm.ros.common.acks import step_ack
from yarm.ros.common.checks import Doorkeeper, ack_fault, present_s, registry_fault, seeds_fault, transform_fault
from yarm.ros.common.clock import JUMP_BACK_S, SAME_STAMP_S, ClockWatch
from yarm.ros.common.params import load_params
from yarm.ros.common.start import init_node
from yarm.ros.common.watchers import Watchers
from yarm.ros.controls.actions import MoveRobotServer
from yarm.ros.controls.arm import ArmUnit
from yarm.ros.controls.mobile import MobileUnit
from yarm.ros.controls.params import ControlsServerParams
from yarm.ros.controls.robots import RobotUnit, SeedPose, UnitFactory
from yarm.safety.pulse import Pulse

ROBOT_TYPES: Dict[str, UnitFactory] = {
    "ankurbot_*": MobileUnit,
    f"{hc10.NAME}*": ArmUnit,
}
WATCH_PERIOD_S = 0.1
SILENCE_S = 3.0
FAREWELL_S = 0.1
"""Wall time for the last commands to leave the node, s."""
JUMP_AHEAD_S = 0.1
"""Lock-step: a longer step ahead is its beginning; camera sets of before are not waited for, s."""


def register_robot_type(pattern: str, factory: UnitFactory) -> None:
    """Let the server drive robots whose names match a pattern ("cart_*"); call it before the node's ``main``.

    Raises:
        ValueError: the pattern is taken.
    """
    if pattern in ROBOT_TYPES:
        raise ValueError(f"robot type {pattern!r} is registered already; known: {', '.join(ROBOT_TYPES)}")
    ROBOT_TYPES[pattern] = factory


def robot_type(name: str) -> Optional[UnitFactory]:
    """What makes the unit of a robot: the last registered of those whose patterns match its name; None without one."""
    return next((make for pattern, make in reversed(ROBOT_TYPES.items()) if fnmatch.fnmatch(name, pattern)), None)


@dataclass
class _Robot:
    """One robot with its action server."""

    unit: RobotUnit
    server: MoveRobotServer
    pose: SeedPose
    seen_s: float
    goal_since_s: float = 0.0
    feedback_s: float = 0.0
    held_since_s: Optional[float] = None


class ControlsServer:
    """Ties seeds, action servers and robots together.

    Only the newest seeds count, except in lock-step, where no tick may be left out.
    """

    def __init__(self, params: ControlsServerParams) -> None:
        """Subscribe; work begins with ``spin``."""
        self._params = params
        self._robots: Dict[str, _Robot] = {}
        self._registry: Dict[str, RegisteredObject] = {}
        self._unknown: Dict[str, bool] = {}
        self._condition = threading.Condition()
        self._woken = False
        self._seeds: Deque[TransformStampedVector] = deque(maxlen=None if params.sync else 1)
        self._heard_s = time.monotonic()
        self._last_s = -np.inf
        self._ack_after: Optional[StepAck] = None
        self._lock_step_from_s = 0.0
        self._gone_sent = 0
        self._gone_received = 0
        self._gone_results = 0
        self._reset = False
        self._ack = rospy.Publisher(names.STEP_ACK, StepAck, queue_size=100, tcp_nodelay=True)
        self._watchers = Watchers(params, params.sync)
        self._doors = {
            name: Doorkeeper(name) for name in (names.OBJECT_REGISTRY, names.SEED_TRANSFORMS, names.STEP_ACK)
        }
        self._clock = ClockWatch()
        self._clock.on_reset(self._on_reset)
        self._subscribers = [
            rospy.Subscriber(names.OBJECT_REGISTRY, ObjectRegistry, self._on_registry, queue_size=10),
            rospy.Subscriber(
                names.SEED_TRANSFORMS, TransformStampedVector, self._on_seeds, queue_size=10, tcp_nodelay=True
            ),
        ]
        if params.sync and params.sync_after:
            self._subscribers.append(
                rospy.Subscriber(names.STEP_ACK, StepAck, self._on_ack, queue_size=100, tcp_nodelay=True)
            )

    def spin(self) -> None:
        """Work until the node is shut down."""
        rospy.on_shutdown(self._on_shutdown)
        pulse = Pulse()
        while not rospy.is_shutdown():
            pulse.beat()
            with self._condition:
                self._condition.wait_for(lambda: self._woken, timeout=WATCH_PERIOD_S)
                self._woken = False
                seeds, reset, self._reset = list(self._seeds), self._reset, False
            if reset and rospy.get_time() < self._last_s - JUMP_BACK_S:
                self._start_afresh()
            for message in seeds:
                if not self._ready(message):
                    break
                with self._condition:
                    if self._seeds and self._seeds[0] is message:
                        self._seeds.popleft()
                self._tick(message)
            self._watch()

    def _on_shutdown(self) -> None:
        """No robot drives on without its server; called before the topics close."""
        for robot in list(self._robots.values()):
            if robot.server.goal() is not None:
                robot.unit.cancel("the controls server is shutting down")
        time.sleep(FAREWELL_S)

    # Callbacks: store and wake.

    def _wake(self) -> None:
        with self._condition:
            self._woken = True
            self._condition.notify()

    def _on_registry(self, message: ObjectRegistry) -> None:
        if not self._doors[names.OBJECT_REGISTRY].refuses(message, registry_fault(message)):
            self._registry = {entry.name: entry for entry in message.entries}
            self._wake()

    def _entry(self, name: str) -> Optional[RegisteredObject]:
        return self._registry.get(name)

    def _on_seeds(self, message: TransformStampedVector) -> None:
        door, now_s = self._doors[names.SEED_TRANSFORMS], present_s(self._params.sync)
        if door.refuses(message, seeds_fault(message, now_s) or self._order_fault(message)):
            return
        kept = [not door.refuses(message, transform_fault(transform, now_s)) for transform in message.transforms]
        if not all(kept):
            message = with_seeds(message, kept)
        with self._condition:
            self._seeds.append(message)
            self._heard_s = time.monotonic()
        self._wake()

    def _order_fault(self, message: TransformStampedVector) -> str:
        """Seeds of the past are a new run of the simulator only when the clock has gone back, too."""
        stamp_s = message.header.stamp.to_sec()
        if stamp_s < self._last_s - JUMP_BACK_S <= rospy.get_time():
            return f"its stamp {stamp_s:.3f} s is older than that of the newest seeds, {self._last_s:.3f} s"
        return ""

    def _on_ack(self, message: StepAck) -> None:
        if self._doors[names.STEP_ACK].refuses(message, ack_fault(message)):
            return
        if message.node.rsplit("/", 1)[-1] == self._params.sync_after:
            self._ack_after = message
            self._wake()

    def _on_reset(self) -> None:
        with self._condition:
            self._reset = True
        self._wake()

    # The tick.

    def _ready(self, seeds: TransformStampedVector) -> bool:
        """Lock-step: the tick's joint angles, the sander's last answer and the commander's goals have all come."""
        if not self._params.sync:
            return True
        stamp_s = seeds.header.stamp.to_sec()
        if not all(robot.unit.ready(stamp_s) for robot in self._robots.values()):
            return False
        ack = self._ack_after
        if ack is None:
            return True
        if stamp_s - self._last_s > JUMP_AHEAD_S:
            self._lock_step_from_s = stamp_s
        set_s = math.floor(stamp_s * self._params.sync_set_hz + 0.25) / self._params.sync_set_hz
        if self._lock_step_from_s - SAME_STAMP_S < set_s and ack.header.stamp.to_sec() < set_s - SAME_STAMP_S:
            return False
        received = sum(self._received(robot) for robot in self._robots.values())
        return bool(received + self._gone_received >= ack.commands_sent)

    def _received(self, robot: _Robot) -> int:
        return robot.server.received.get(self._params.sync_after, 0)

    def _tick(self, seeds: TransformStampedVector) -> None:
        now_s = seeds.header.stamp.to_sec()
        if now_s < self._last_s - JUMP_BACK_S:
            self._start_afresh()
        self._last_s = now_s
        for transform, name, kind in zip(seeds.transforms, seeds.frame, seeds.object):
            if kind in ROBOT_KINDS:
                self._see(name, pose_of(transform), now_s)
        for name, robot in list(self._robots.items()):
            if now_s - robot.seen_s > self._params.gone_s:
                self._remove(name, f"{name} has been missing from the seeds for {self._params.gone_s:g} s")
            else:
                self._drive(name, robot, now_s)
        if self._params.sync:
            self._acknowledge(seeds)

    def _see(self, name: str, pose: SeedPose, now_s: float) -> None:
        robot = self._robots.get(name)
        if robot is None:
            unit_type = robot_type(name)
            if unit_type is None:
                if self._unknown.setdefault(name, True):
                    rospy.logwarn("%s: no robot type matches; known: %s", name, ", ".join(ROBOT_TYPES))
                    self._unknown[name] = False
                return
            unit = unit_type(name, self._params, self._entry, self._wake)
            robot = _Robot(unit, MoveRobotServer(names.move_robot(name), self._wake), pose, now_s)
            self._robots[name] = robot
            rospy.loginfo("%s (%s): %s is up", name, unit.kind, names.move_robot(name))
        robot.pose, robot.seen_s = pose, now_s

    def _drive(self, name: str, robot: _Robot, now_s: float) -> None:
        """Take in goals and cancels, act on the pose, report."""
        self._take_events(name, robot, now_s)
        age_s = now_s - robot.pose.stamp_s
        goal = robot.server.goal()
        objection = self._watchers.objection(now_s) if goal is not None and robot.unit.drives(goal) else ""
        if age_s > self._params.hold_s:
            self._hold_without_pose(name, robot, age_s, now_s)
        elif objection:
            since_s = now_s if robot.held_since_s is None else robot.held_since_s
            self._hold(name, robot, objection, now_s - since_s, now_s)
        else:
            robot.held_since_s = None
            end = robot.unit.tick(robot.pose, now_s)
            if end is not None:
                rospy.loginfo("%s: %s, %s", name, end[0].value, end[1])
                robot.server.finish(*end)
        goal = robot.server.goal()
        if goal is not None and now_s - robot.feedback_s >= 1.0 / self._params.feedback_hz:
            robot.feedback_s = now_s
            feedback = MoveRobotFeedback(
                time=now_s - robot.goal_since_s, robotname=name, robottype=str(robot.unit.kind)
            )
            if robot.unit.drives(goal):
                note_turns_left(feedback, robot.pose, goal.target)
            robot.unit.feedback(feedback)
            robot.server.feedback(feedback)
        robot.server.keep_alive(now_s)

    def _take_events(self, name: str, robot: _Robot, now_s: float) -> None:
        for event in robot.server.events():
            if event.cancel:
                if robot.server.is_active(event.handle):
                    robot.unit.cancel("cancelled by the client")
                    robot.server.finish(Outcome.PREEMPTED, "cancelled by the client")
                else:
                    robot.server.recall(event.handle)
                continue
            goal = event.handle.get_goal()
            refusal = robot.unit.refusal(goal) or (self._watchers.objection(now_s) if robot.unit.drives(goal) else "")
            if refusal:
                rospy.logwarn("%s: goal refused: %s", name, refusal)
                robot.server.reject(event.handle, refusal)
                continue
            if robot.server.goal() is not None:
                if not robot.unit.continues(goal):
                    robot.unit.cancel("replaced by a newer goal")
                robot.server.finish(Outcome.PREEMPTED, "replaced by a newer goal")
            robot.server.accept(event.handle)
            robot.goal_since_s = now_s
            robot.unit.start(goal)

    def _hold_without_pose(self, name: str, robot: _Robot, age_s: float, now_s: float) -> None:
        reason = f"no pose of {name} for {age_s:.1f} s, allowed {self._params.stale_s:g} s: stopped"
        self._hold(name, robot, reason, age_s, now_s)

    def _hold(self, name: str, robot: _Robot, reason: str, lasted_s: float, now_s: float) -> None:
        """Stand still for a reason that has lasted so long, s; give the goal up when it stays (a new one waits too)."""
        if robot.held_since_s is None:
            robot.held_since_s = now_s
            robot.unit.hold()
        if robot.server.goal() is None:
            return
        if min(lasted_s, now_s - robot.goal_since_s) > self._params.stale_s:
            rospy.logerr("%s: %s", name, reason)
            robot.unit.cancel(reason)
            robot.server.finish(Outcome.ABORTED, reason)
        else:
            rospy.logwarn_throttle(5.0, f"{name}: {reason}")

    def _watch(self) -> None:
        """Old seeds, seen from simulated time, when none come at all."""
        if time.monotonic() - self._heard_s > SILENCE_S:
            rospy.logwarn_throttle(
                10.0, f"nothing on {names.SEED_TRANSFORMS} for {SILENCE_S:g} s: are simulator and seed_tf_publisher up?"
            )
        now_s = rospy.get_time()
        if self._params.sync or now_s - self._last_s < self._params.hold_s:
            return
        for name, robot in self._robots.items():
            self._take_events(name, robot, now_s)
            self._hold_without_pose(name, robot, now_s - robot.pose.stamp_s, now_s)
            robot.server.keep_alive(now_s)

    def _acknowledge(self, seeds: TransformStampedVector) -> None:
        for robot in self._robots.values():
            robot.unit.acknowledge(seeds.header.stamp.to_sec())
        sent = sum(robot.unit.simulator_commands for robot in self._robots.values())
        results = sum(robot.server.results for robot in self._robots.values())
        self._ack.publish(step_ack(seeds.header.stamp, sent + self._gone_sent, results + self._gone_results))

    def _remove(self, name: str, reason: str) -> None:
        robot = self._robots.pop(name)
        robot.unit.cancel(reason)
        robot.server.close(reason)
        robot.unit.close()
        self._gone_sent += robot.unit.simulator_commands
        self._gone_received += self._received(robot)
        self._gone_results += robot.server.results

    def _start_afresh(self) -> None:
        """Simulated time went backwards: abort every goal and forget every stamp; servers and connections stay."""
        reason = "simulated time went backwards"
        rospy.logwarn("%s: every goal is aborted", reason)
        for robot in self._robots.values():
            robot.unit.reset()
            robot.server.forget(reason)
            robot.seen_s, robot.feedback_s, robot.held_since_s = 0.0, 0.0, None
        self._watchers.reset()
        self._last_s = -np.inf
        self._ack_after = None
        self._gone_sent = self._gone_received = self._gone_results = 0


def with_seeds(message: TransformStampedVector, kept: Sequence[bool]) -> TransformStampedVector:
    """The same seeds without those that are not kept."""
    found = TransformStampedVector(header=message.header)
    for field in ("transforms", "type", "frame", "object"):
        setattr(found, field, [value for value, keep in zip(getattr(message, field), kept) if keep])
    return found


def pose_of(transform: TransformStamped) -> SeedPose:
    """Pose of a seed from its transform."""
    t, q = transform.transform.translation, transform.transform.rotation
    return SeedPose(np.array((t.x, t.y, t.z)), np.array((q.x, q.y, q.z, q.w)), transform.header.stamp.to_sec())


def note_turns_left(feedback: MoveRobotFeedback, pose: SeedPose, target: Pose) -> None:
    """The published feedback's angles: target minus present roll, pitch and yaw, rad."""
    q = target.orientation
    left = rpy_of_quaternion((q.x, q.y, q.z, q.w)) - rpy_of_quaternion(pose.quaternion)
    feedback.delta_roll, feedback.delta_pitch, feedback.delta_yaw = (wrap_angle(float(angle)) for angle in left)


def main() -> None:
    """Run the node until it is shut down."""
    init_node("multi_robot_controls_server")
    ControlsServer(load_params(ControlsServerParams)).spin()
