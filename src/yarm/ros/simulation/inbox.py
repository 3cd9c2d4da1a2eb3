"""Everything that reaches the simulation: commands, acknowledgements, services. One queue, worked off by one thread."""

from __future__ import annotations

import queue
import struct
import threading
import time
from functools import partial
from typing import Any, Callable, Dict, Optional, Tuple

import rospy
from geometry_msgs.msg import Twist
from std_msgs.msg import Float32, Float64
from trajectory_msgs.msg import JointTrajectory

from yarm.msg import CommanderStatus, StepAck
from yarm.ros import names
from yarm.sim.joint_path import JointPathError
from yarm.sim.robots import CommandError
from yarm.sim.world import SpawnError, World
from yarm.srv import SpawnObstacles, SpawnObstaclesResponse

Job = Callable[[], None]
SERVICE_TIMEOUT_S = 30.0
HEADING_STATES = ("assigned", "moving", "reached", "backing_out")


class Inbox:
    """Turns messages into jobs for the simulation's thread, counts commands by sender, and keeps what was last said.

    Attributes:
        acks: newest acknowledgement of each node: stamp, ns, and commands it says it has sent.
        commands: commands received from each node.
        metadata_ns: newest stamp of planning_metadata, ns.
        commander_state: name of the Commander's state, empty while unknown.
        raster: share of the manipulator's raster done.
    """

    def __init__(self, world: World, spawn: Callable[[Any], str], delete: Callable[[str], str], sync: bool) -> None:
        """Subscribe and advertise; ``spawn`` and ``delete`` do the services' work and return what was done."""
        self._world = world
        # Not a SimpleQueue: when a signal's handler outlasts its timeout, Python 3.11 waits for ever.
        self._jobs: queue.Queue[Job] = queue.Queue()
        self._warned: Dict[Tuple[str, str], bool] = {}
        self._driven_s: Dict[str, float] = {}
        self.acks: Dict[str, Tuple[int, int]] = {}
        self.commands: Dict[str, int] = {}
        self.metadata_ns = -1
        self.commander_state = ""
        self.raster = 0.0
        self._subscribe_robots()
        rospy.Subscriber(names.COMMANDER_STATUS, CommanderStatus, self._on_commander, queue_size=10)
        if sync:
            rospy.Subscriber(names.STEP_ACK, StepAck, self._on_ack, queue_size=100, tcp_nodelay=True)
            rospy.Subscriber(names.PLANNING_METADATA, rospy.AnyMsg, self._on_metadata, queue_size=10)
        self._services = [
            rospy.Service(names.SPAWN_OBSTACLES, SpawnObstacles, partial(self._serve, spawn)),
            rospy.Service(names.DELETE_OBSTACLES, SpawnObstacles, partial(self._serve, lambda r: delete(r.name))),
        ]

    def work_until(self, deadline_s: float) -> None:
        """Do jobs as they come until a moment of time.monotonic(); without one left, at least those waiting."""
        while True:
            try:
                left = deadline_s - time.monotonic()
                job = self._jobs.get(timeout=left) if left > 0.0 else self._jobs.get_nowait()
            except queue.Empty:
                return
            job()

    def work_one(self, timeout_s: float) -> None:
        """Do the next job, waiting for one at most so long."""
        try:
            job = self._jobs.get(timeout=timeout_s)
        except queue.Empty:
            return
        job()

    def stop_the_silent(self, timeout_s: float) -> None:
        """Stop each robot that was told to move and then nothing for so long, s of simulated time; 0 for never."""
        now_s = self._world.time_s
        for robot in [robot for robot, said_s in self._driven_s.items() if 0.0 < timeout_s < now_s - said_s]:
            del self._driven_s[robot]
            self._world.robots[robot].drive(0.0, 0.0, self._world.params.wheel_speed_limit)
            self.warn_once(names.cmd_vel(robot), f"nothing for {timeout_s:g} s while it moved: stopped")

    def _subscribe_robots(self) -> None:
        for robot in self._world.robots:
            rospy.Subscriber(
                names.cmd_vel(robot), Twist, partial(self._on_drive, robot), queue_size=10, tcp_nodelay=True
            )
            for caster in names.CASTERS:
                topic = names.caster_command(robot, caster)
                rospy.Subscriber(
                    topic, Float64, partial(self._on_caster, robot, caster), queue_size=10, tcp_nodelay=True
                )
        for arm in self._world.arms:
            topic = names.joint_path_command(arm)
            rospy.Subscriber(topic, JointTrajectory, partial(self._on_path, arm), queue_size=10, tcp_nodelay=True)
            rospy.Subscriber(names.sander_progress(arm), Float32, self._on_raster, queue_size=10)

    def _command(self, topic: str, message: Any, apply: Callable[[], str]) -> None:
        """Queue a command; ``apply`` answers a note (clamped ...) or raises why it was refused."""
        sender = str(getattr(message, "_connection_header", {}).get("callerid", "")).strip("/")

        def job() -> None:
            try:
                note = apply()
            except (CommandError, JointPathError) as error:
                self.warn_once(topic, f"refused: {error}")
            else:
                if note:
                    self.warn_once(topic, note)
            self.commands[sender] = self.commands.get(sender, 0) + 1

        self._jobs.put(job)

    def warn_once(self, topic: str, note: str) -> None:
        """Warn of a topic's fault the first time it happens; values after a colon do not make it new."""
        key = (topic, note.split(" ", 2)[0])
        if key not in self._warned:
            self._warned[key] = True
            rospy.logwarn("%s: %s (said once)", topic, note)

    def _on_drive(self, robot: str, message: Twist) -> None:
        limit = self._world.params.wheel_speed_limit

        def apply() -> str:
            v, w = message.linear.x, message.angular.z
            clamped = self._world.robots[robot].drive(v, w, limit)
            if v or w:
                self._driven_s[robot] = self._world.time_s
            else:
                self._driven_s.pop(robot, None)
            return f"linear.x {v:.3f} m/s clamped to {limit:.3f}" if clamped else ""

        self._command(names.cmd_vel(robot), message, apply)

    def _on_caster(self, robot: str, caster: str, message: Float64) -> None:
        def apply() -> str:
            clamped = self._world.robots[robot].steer(caster, message.data)
            return f"angle {message.data:.3f} rad clamped to [-pi, pi]" if clamped else ""

        self._command(names.caster_command(robot, caster), message, apply)

    def _on_path(self, arm: str, message: JointTrajectory) -> None:
        def apply() -> str:
            points = [point.positions for point in message.points]
            times = [point.time_from_start.to_sec() for point in message.points]
            return "; ".join(self._world.arms[arm].follow(message.joint_names, points, times))

        self._command(names.joint_path_command(arm), message, apply)

    def _on_raster(self, message: Float32) -> None:
        self._jobs.put(lambda: setattr(self, "raster", float(message.data)))

    def _on_commander(self, message: CommanderStatus) -> None:
        def job() -> None:
            self.commander_state = message.state_name
            goals = {t.robot: t.goal for t in message.tasks if t.robot and t.status in HEADING_STATES}
            self._world.contacts.set_goals(goals)

        self._jobs.put(job)

    def _on_ack(self, message: StepAck) -> None:
        entry = (message.header.stamp.to_nsec(), int(message.commands_sent))
        self._jobs.put(lambda: self.acks.__setitem__(message.node.strip("/"), entry))

    def _on_metadata(self, message: Any) -> None:
        _, secs, nsecs = struct.unpack_from("<III", message._buff)
        self._jobs.put(lambda: setattr(self, "metadata_ns", secs * 1_000_000_000 + nsecs))

    def _serve(self, work: Callable[[Any], str], request: Any) -> SpawnObstaclesResponse:
        done = threading.Event()
        answer = SpawnObstaclesResponse(False, f"the simulation did not answer within {SERVICE_TIMEOUT_S:.0f} s")

        def job() -> None:
            try:
                answer.message = work(request)
                answer.success = True
            except SpawnError as error:
                answer.message = str(error)
            done.set()

        self._jobs.put(job)
        done.wait(SERVICE_TIMEOUT_S)
        return answer


def missing_acks(inbox: Inbox, nodes: Tuple[str, ...], stamp_ns: int, counted: bool) -> Optional[str]:
    """Which node has not acknowledged a stamp, or whose commands have not all arrived; None when all is there.

    Commands are ``counted`` only for nodes that command the simulation; the Commander's are goals for other nodes.
    """
    for node in nodes:
        stamp, sent = inbox.acks.get(node, (-1, 0))
        if stamp != stamp_ns:
            return f"{node} has not acknowledged (newest: {stamp / 1e9:.4f} s)"
        got = inbox.commands.get(node, 0)
        if counted and got < sent:
            return f"{node} says it sent {sent} commands, {got} have arrived"
    return None
