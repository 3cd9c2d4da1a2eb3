"""Everything an experiment listens to, handed on to the recorder."""

from __future__ import annotations

import threading
from collections import deque
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Callable, Deque, Dict, List, Mapping, Optional, Set, Tuple

import numpy as np
import rospy
from geometry_msgs.msg import TransformStamped
from std_msgs.msg import Float32, Int8
from tf2_msgs.msg import TFMessage

from yarm.control.sander.states import SanderState
from yarm.experiments.run.recorder import ContactSample, PlanSample, Recorder, TaskSample
from yarm.geometry import Pose2, yaw_of_quaternion
from yarm.geometry.kinds import GOAL_KINDS, ObjectKind
from yarm.msg import (
    Clearance,
    CommanderStatus,
    Contacts,
    Decision,
    MoveRobotActionGoal,
    ObjectRegistry,
    PlanReport,
    SanderStatus,
    SimStatus,
)
from yarm.ros.common import names
from yarm.ros.common.checks import Doorkeeper, plan_fault, pose_fault, sim_fault
from yarm.ros.common.clock import ClockWatch
from yarm.ros.common.conversions import matrix_of_transform, pose2_of_transform

ENDED = ("reached", "backing_out", "unreachable", "failed")
"""Task statuses of goals the Commander is done with, well or not."""
DECLARED = ("reached", "backing_out")
POSE_ACTIONS = ("true", "false")
ARM_WORD_S = 5.0
"""Wall time that a sander, which speaks ten times a second, has to say whether it is paused, s."""
AHEAD_S = 0.5
"""What is stamped so long after the newest time is of the cell before, s."""
STATUSES = 200
"""Commander's statuses kept; one comes with each change, at least one a second."""


@dataclass
class Manipulator:
    """What is known of one manipulator: its sander's state, whether it was told to move, share of the raster done."""

    state: int = 0
    moving: Optional[bool] = None
    progress: float = 0.0

    def text(self) -> str:
        """For the progress line."""
        if self.state != SanderState.SCAN_TO_PATH:
            return f"state {self.state}"
        return f"{'sanding' if self.moving else 'paused'} {100 * self.progress:.0f} %"


@dataclass
class Snapshot:
    """The newest of everything, for the progress line and the mission's waits."""

    now_s: float = 0.0
    status: Optional[CommanderStatus] = None
    goals: Set[str] = field(default_factory=set)
    ended_s: Dict[str, float] = field(default_factory=dict)
    robots: Set[str] = field(default_factory=set)
    manipulators: Dict[str, Manipulator] = field(default_factory=dict)
    sim: Optional[SimStatus] = None


class ExperimentInputs:
    """Subscribes to all of it; every callback takes the lock, hands on, and is done.

    Attributes:
        begun_again: how often the cell has begun anew: its simulation was started again, and time went backwards.
    """

    def __init__(self, recorder: Recorder, begun: Callable[[float], None] = lambda now_s: None) -> None:
        """Listen from now on.

        Args:
            recorder: of what is heard.
            begun: called with the simulated time, s, when a mission's first decision comes, before it is recorded; the
                lock is held.
        """
        self._begun = begun
        self.lock = threading.Lock()
        self.recorder = recorder
        self.state = Snapshot()
        self.loop_ms: List[SimStatus] = []
        self.begun_again = 0
        self._declared: Set[str] = set()
        self._clock = ClockWatch()
        self._clock.on_reset(self.forget)
        self._statuses: Deque[CommanderStatus] = deque(maxlen=STATUSES)
        self._frames: Dict[str, str] = {}
        self._goal_frames: Dict[str, str] = {}
        self._flange_frames: Dict[str, str] = {}
        self._fixed: Dict[str, Pose2] = {}
        self._plan_door, self._goal_door = Doorkeeper(names.PLAN_REPORT), Doorkeeper("a robot's goal")
        self._sim_door = Doorkeeper(names.SIM_STATUS)
        self._robot_topics: Dict[str, List[rospy.Subscriber]] = {}
        self._subscribers = [
            rospy.Subscriber("/tf", TFMessage, self._on_tf, queue_size=100, tcp_nodelay=True),
            rospy.Subscriber("/tf_static", TFMessage, self._on_tf_static, queue_size=100),
            rospy.Subscriber(names.OBJECT_REGISTRY, ObjectRegistry, self._on_registry, queue_size=10),
            rospy.Subscriber(names.COMMANDER_STATUS, CommanderStatus, self._on_status, queue_size=100),
            rospy.Subscriber(names.PLAN_REPORT, PlanReport, self._on_plan, queue_size=100),
            rospy.Subscriber(names.DECISIONS, Decision, self._on_decision, queue_size=1000),
            rospy.Subscriber(names.SIM_CONTACTS, Contacts, self._on_contacts, queue_size=1000),
            rospy.Subscriber(names.SIM_CLEARANCE, Clearance, self._on_clearance, queue_size=100),
            rospy.Subscriber(names.SIM_STATUS, SimStatus, self._on_sim, queue_size=10),
        ]

    def saved(self) -> Tuple[Recorder, Dict[str, float], Set[str], int, float]:
        """What is worth being kept, as ``take_up`` takes it; the lock must be held."""
        return self.recorder, self.state.ended_s, self._declared, self.begun_again, self.state.now_s

    def take_up(self, ended_s: Mapping[str, float], declared: Set[str], begun_again: int) -> None:
        """Know what a process before has known, whose recorder this one has been given."""
        with self.lock:
            self.state.ended_s = {**ended_s, **self.state.ended_s}
            self._declared |= declared
            self.begun_again += begun_again

    def look_at_arms(self) -> None:
        """Note who pauses and who works now: what they were told meanwhile was not heard. Silent ones stay as known."""
        with self.lock:
            arms = list(self.state.manipulators)
        for arm in arms:
            with suppress(rospy.ROSException):
                found = rospy.wait_for_message(names.sander_status(arm), SanderStatus, timeout=ARM_WORD_S)
                with self.lock:
                    self.state.manipulators[arm].moving = found.enabled
                    if found.state == SanderState.SCAN_TO_PATH:
                        self.recorder.manipulator(found.header.stamp.to_sec(), arm, found.enabled)

    def forget(self) -> None:
        """The cell has begun anew, its time with it. Who is in it may have been told before its time was."""
        with self.lock:
            self.begun_again += 1
            arms = {arm: Manipulator() for arm in self.state.manipulators}
            self.state = Snapshot(goals=self.state.goals, robots=self.state.robots, manipulators=arms)
            self._declared.clear()
            self._statuses.clear()
            self.recorder.begin_again()

    def camera_sets(self) -> int:
        """Camera sets the simulator has published so far."""
        with self.lock:
            return 0 if self.state.sim is None else int(self.state.sim.camera_sets)

    def mean_loop_ms(self) -> Dict[str, float]:
        """Wall milliseconds a camera frame of each part of the simulator's loop, since ``loop_ms`` was emptied."""
        with self.lock:
            messages = list(self.loop_ms)
        parts: Dict[str, List[float]] = {}
        for message in messages:
            for part, value in zip(message.parts, message.ms_per_frame):
                parts.setdefault(part, []).append(value)
        return {part: float(np.mean(values)) for part, values in parts.items()}

    def status_at(self, limit_s: float) -> Optional[CommanderStatus]:
        """The newest of the Commander's statuses stamped at or before a simulated time; the lock must be held."""
        return next((m for m in reversed(self._statuses) if m.header.stamp.to_sec() <= limit_s), None)

    def _on_registry(self, message: ObjectRegistry) -> None:
        with self.lock:
            self.state.goals = {e.name for e in message.entries if e.object in GOAL_KINDS}
            self.state.robots = {e.name for e in message.entries if e.object == ObjectKind.MOBILE}
            self._frames = {e.seed_frame: e.name for e in message.entries if e.object == ObjectKind.MOBILE}
            self._goal_frames = {e.seed_frame: e.name for e in message.entries if e.object in GOAL_KINDS}
            arms = [e.name for e in message.entries if e.object == ObjectKind.MANIPULATOR]
            for arm in arms:
                self.state.manipulators.setdefault(arm, Manipulator())
            self._flange_frames = {e.seed_frame: e.name for e in message.entries if e.name in arms}
            self._take_fixed_goals()
        for robot in self.state.robots:
            self._follow(robot, [(names.move_robot(robot) + "/goal", MoveRobotActionGoal, self._on_goal)])
        for arm in arms:
            self._follow(
                arm,
                [
                    (names.motion_start_stop(arm), Int8, self._on_switch),
                    (names.sander_state(arm), Int8, self._on_sander),
                    (names.sander_progress(arm), Float32, self._on_raster),
                ],
            )

    def _follow(self, robot: str, topics: List[Tuple[str, type, object]]) -> None:
        if robot not in self._robot_topics:
            self._robot_topics[robot] = [
                rospy.Subscriber(topic, kind, callback, callback_args=robot, queue_size=100)
                for topic, kind, callback in topics
            ]

    def _on_tf(self, message: TFMessage) -> None:
        with self.lock:
            for transform in message.transforms:
                child = transform.child_frame_id.lstrip("/")
                robot, goal = self._frames.get(child), self._goal_frames.get(child)
                if child in self._flange_frames:
                    self._take_tool(self._flange_frames[child], transform)
                if robot is None and goal is None:
                    continue
                pose = pose2_of_transform(transform.transform)
                now_s = transform.header.stamp.to_sec()
                self.state.now_s = max(self.state.now_s, now_s)
                if robot is not None:
                    self.recorder.pose(now_s, robot, pose.x, pose.y, pose.yaw_rad)
                if goal is not None:
                    self.recorder.goal_pose(goal, pose.x, pose.y)

    def _take_tool(self, arm: str, stamped: TransformStamped) -> None:
        """Where a tool is, while it works on its raster."""
        if self.state.manipulators[arm].state == SanderState.SCAN_TO_PATH:
            pose = matrix_of_transform(stamped.transform)
            self.recorder.tool(stamped.header.stamp.to_sec(), arm, pose[:3, 3].tolist(), pose[:3, 2].tolist())

    def _on_tf_static(self, message: TFMessage) -> None:
        with self.lock:
            for transform in message.transforms:
                self._fixed[transform.child_frame_id.lstrip("/")] = pose2_of_transform(transform.transform)
            self._take_fixed_goals()

    def _take_fixed_goals(self) -> None:
        for frame, goal in self._goal_frames.items():
            pose = self._fixed.get(frame)
            if pose is not None:
                self.recorder.goal_pose(goal, pose.x, pose.y)

    def _on_status(self, message: CommanderStatus) -> None:
        with self.lock:
            if self.begun_again and message.header.stamp.to_sec() > self._clock.newest_s + AHEAD_S:
                return
            self.state.status = message
            self._statuses.append(message)
            self._note_ended(message)
            self.state.now_s = max(self.state.now_s, message.header.stamp.to_sec())
            tasks = [TaskSample(t.robot, t.goal, t.kind, t.status, t.reason) for t in message.tasks]
            self.recorder.tasks(message.header.stamp.to_sec(), tasks)

    def _note_ended(self, message: CommanderStatus) -> None:
        """When each goal ended; one that was given up and is tried again has not, one that was reached has."""
        for task in message.tasks:
            if task.status in ENDED:
                self.state.ended_s.setdefault(task.goal, message.header.stamp.to_sec())
                self._declared |= {task.goal} if task.status in DECLARED else set()
            elif task.goal not in self._declared:
                self.state.ended_s.pop(task.goal, None)

    def _on_plan(self, message: PlanReport) -> None:
        if self._plan_door.refuses(message, plan_fault(message)):
            return
        with self.lock:
            self.recorder.step(message.safe)
            for i, robot in enumerate(message.robots):
                path = tuple((cell.x, cell.y) for cell in message.paths[i].indices)
                sample = PlanSample(
                    robot,
                    message.goals[i],
                    message.statuses[i],
                    message.planning_ms,
                    message.robot_ms[i],
                    message.check_ms,
                    message.length_cells[i],
                    message.safe,
                    message.particles,
                    path,
                )
                self.recorder.plan(message.header.stamp.to_sec(), sample)

    def _on_contacts(self, message: Contacts) -> None:
        samples = [ContactSample(c.body_a, c.link_a, c.body_b, c.link_b, c.depth, c.kind) for c in message.contacts]
        with self.lock:
            self.recorder.contacts(message.header.stamp.to_sec(), samples)

    def _on_clearance(self, message: Clearance) -> None:
        with self.lock:
            for robot, nearest, distance in zip(message.robots, message.nearest, message.distances):
                self.recorder.clearance(message.header.stamp.to_sec(), robot, nearest, distance)

    def _on_decision(self, message: Decision) -> None:
        now_s = message.header.stamp.to_sec()
        with self.lock:
            if message.number == 1:
                self._begun(now_s)
            self.recorder.decision(now_s, message.number, message.kind, message.robot, message.goal, message.text)

    def _on_sim(self, message: SimStatus) -> None:
        if self._sim_door.refuses(message, sim_fault(message)):
            return
        with self.lock:
            self.state.sim = message
            self.recorder.in_bins(dict(zip(message.debris, message.bins)), message.lost)
            self.recorder.touched(message.header.stamp.to_sec(), message.touched)
            self.state.now_s = max(self.state.now_s, message.header.stamp.to_sec())
            self.loop_ms.append(message)

    def _on_goal(self, message: MoveRobotActionGoal, robot: str) -> None:
        if message.goal.action.lower() not in POSE_ACTIONS:
            return
        if self._goal_door.refuses(message, pose_fault(message.goal.target)):
            return
        target, q = message.goal.target.position, message.goal.target.orientation
        yaw = yaw_of_quaternion((q.x, q.y, q.z, q.w))
        with self.lock:
            self.recorder.waypoint(self.state.now_s, robot, target.x, target.y, yaw)

    def _on_switch(self, message: Int8, arm: str) -> None:
        with self.lock:
            manipulator = self.state.manipulators[arm]
            moving = message.data != 0
            if manipulator.state == SanderState.SCAN_TO_PATH and (moving or manipulator.moving):
                self.recorder.manipulator(self.state.now_s, arm, moving)
            manipulator.moving = moving

    def _on_sander(self, message: Int8, arm: str) -> None:
        with self.lock:
            self.state.manipulators[arm].state = message.data
            self._note_sander(arm)

    def _on_raster(self, message: Float32, arm: str) -> None:
        with self.lock:
            self.state.manipulators[arm].progress = message.data
            self._note_sander(arm)

    def _note_sander(self, arm: str) -> None:
        state = SanderState.of(self.state.manipulators[arm].state)
        if state is not None:
            self.recorder.sander(arm, state.words, self.state.manipulators[arm].progress)
