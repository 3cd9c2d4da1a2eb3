"""Everything that reaches the simulation: commands, acknowledgements, services. One queue, worked off by one thread."""

from __future__ import annotations

import struct
import threading
from functools import partial
from typing import Any, Callable, Dict

import rospy
from geometry_msgs.msg import Twist
from std_msgs.msg import Float32, Float64
from std_srvs.srv import Empty, EmptyRequest, EmptyResponse
from trajectory_msgs.msg import JointTrajectory

from yarm.commander.events import TaskState
from yarm.msg import CommanderStatus, SanderStatus, StepAck
from yarm.ros.common import names
from yarm.ros.simulation.loop import Jobs
from yarm.sim.engine.world import SimWorld, SpawnError
from yarm.sim.robots.hand import SuctionHand
from yarm.srv import SpawnObstacles, SpawnObstaclesResponse

SERVICE_TIMEOUT_S = 30.0
UNANSWERED = f"the simulation did not answer within {SERVICE_TIMEOUT_S:.0f} s"
HEADING_STATES = tuple(
    state.value
    for state in (
        TaskState.REACHED,
        TaskState.ASSIGNED,
        TaskState.MOVING,
        TaskState.BACKING_OUT,
        TaskState.PICKING,
        TaskState.CARRYING,
        TaskState.DROPPING,
    )
)
"""Of a task whose robot may touch its goal; of several tasks of a robot the one that stands last here says which."""


class Inbox(Jobs):
    """Turns messages into jobs for the simulation's thread, counts commands by sender, and keeps what was last said.

    Attributes:
        metadata_ns: newest stamp of planning_metadata, ns.
        commander_state: name of the Commander's state, empty while unknown.
        raster: share of its raster that each manipulator has done; those that have said nothing are not in it.
    """

    def __init__(self, world: SimWorld, spawn: Callable[[Any], str], delete: Callable[[Any], str], sync: bool) -> None:
        """Subscribe and advertise; ``spawn`` and ``delete`` do the services' work and return what was done."""
        self._world = world
        super().__init__()
        self._driven_s: Dict[str, float] = {}
        self._watched_s: Dict[str, float] = {}
        self.metadata_ns = -1
        self.commander_state = ""
        self.raster: Dict[str, float] = {}
        self._subscribe_robots()
        rospy.Subscriber(names.COMMANDER_STATUS, CommanderStatus, self._on_commander, queue_size=10)
        if sync:
            rospy.Subscriber(names.STEP_ACK, StepAck, self.on_ack, queue_size=100, tcp_nodelay=True)
            rospy.Subscriber(names.PLANNING_METADATA, rospy.AnyMsg, self._on_metadata, queue_size=10)
        self._services = [
            rospy.Service(names.SPAWN_OBSTACLES, SpawnObstacles, partial(self._serve, spawn)),
            rospy.Service(names.DELETE_OBSTACLES, SpawnObstacles, partial(self._serve, delete)),
        ]
        for robot, hand in world.hands.items():
            for name, switch in (("on", hand.on), ("off", hand.off)):
                self._services.append(
                    rospy.Service(names.gripper(robot, name), Empty, partial(self._serve_switch, switch))
                )

    def stop_the_silent(self, timeout_s: float) -> None:
        """Stop each robot that was told to move and then nothing for so long, s of simulated time; 0 for never."""
        now_s = self._world.time_s
        for robot in [robot for robot, said_s in self._driven_s.items() if 0.0 < timeout_s < now_s - said_s]:
            del self._driven_s[robot]
            self._world.robots[robot].drive(0.0, 0.0, self._world.params.wheel_speed_limit)
            self.warn_once(names.cmd_vel(robot), f"nothing for {timeout_s:g} s while it moved: stopped")

    def stop_the_unwatched(self, timeout_s: float) -> None:
        """Stop each arm whose sander has said nothing for so long, s of simulated time; 0 for never.

        One that no sander has spoken for is left to whoever sends it trajectories.
        """
        now_s = self._world.time_s
        for arm in [arm for arm, said_s in self._watched_s.items() if 0.0 < timeout_s < now_s - said_s]:
            del self._watched_s[arm]
            if self._world.arms[arm].path.moving:
                self._world.arms[arm].brake()
                topic = names.sander_status(arm)
                self.warn_once(topic, f"nothing for {timeout_s:g} s while the arm moved: stopped")

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
        for robot, hand in self._world.hands.items():
            topic = names.lift_command(robot)
            rospy.Subscriber(topic, Float64, partial(self._on_lift, topic, hand), queue_size=10, tcp_nodelay=True)
        for arm in self._world.arms:
            topic = names.joint_path_command(arm)
            rospy.Subscriber(topic, JointTrajectory, partial(self._on_path, arm), queue_size=10, tcp_nodelay=True)
            rospy.Subscriber(names.sander_progress(arm), Float32, partial(self._on_raster, arm), queue_size=10)
            topic = names.sander_status(arm)
            rospy.Subscriber(topic, SanderStatus, partial(self._on_sander, arm), queue_size=10, tcp_nodelay=True)

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

        self.command(names.cmd_vel(robot), message, apply)

    def _on_caster(self, robot: str, caster: str, message: Float64) -> None:
        def apply() -> str:
            clamped = self._world.robots[robot].steer(caster, message.data)
            return f"angle {message.data:.3f} rad clamped to [-pi, pi]" if clamped else ""

        self.command(names.caster_command(robot, caster), message, apply)

    def _on_lift(self, topic: str, hand: SuctionHand, message: Float64) -> None:
        def apply() -> str:
            hand.lift_to(message.data)
            return ""

        self.command(topic, message, apply)

    def _on_path(self, arm: str, message: JointTrajectory) -> None:
        def apply() -> str:
            points = [point.positions for point in message.points]
            times = [point.time_from_start.to_sec() for point in message.points]
            return "; ".join(self._world.arms[arm].follow(message.joint_names, points, times))

        self.command(names.joint_path_command(arm), message, apply)

    def _on_raster(self, arm: str, message: Float32) -> None:
        self.put(lambda: self.raster.__setitem__(arm, float(message.data)))

    def _on_sander(self, arm: str, _: SanderStatus) -> None:
        self.put(lambda: self._watched_s.__setitem__(arm, self._world.time_s))

    def _on_commander(self, message: CommanderStatus) -> None:
        def job() -> None:
            self.commander_state = message.state_name
            tasks = [t for t in message.tasks if t.robot and t.status in HEADING_STATES]
            goals = {t.robot: t.goal for t in sorted(tasks, key=lambda t: HEADING_STATES.index(t.status))}
            self._world.contacts.set_goals({robot: self._world.meant(goal, robot) for robot, goal in goals.items()})

        self.put(job)

    def _on_metadata(self, message: Any) -> None:
        _, secs, nsecs = struct.unpack_from("<III", message._buff)
        self.put(lambda: setattr(self, "metadata_ns", secs * 1_000_000_000 + nsecs))

    def _serve_switch(self, switch: Callable[[], None], _: EmptyRequest) -> EmptyResponse:
        """Do it between two ticks, and answer when it is done.

        Raises:
            rospy.ServiceException: the simulation is too busy.
        """
        done = threading.Event()

        def job() -> None:
            switch()
            done.set()

        self.put(job)
        if not done.wait(SERVICE_TIMEOUT_S):
            raise rospy.ServiceException(UNANSWERED)
        return EmptyResponse()

    def _serve(self, work: Callable[[Any], str], request: Any) -> SpawnObstaclesResponse:
        done = threading.Event()
        answer = SpawnObstaclesResponse(False, UNANSWERED)

        def job() -> None:
            try:
                answer.message = work(request)
                answer.success = True
            except SpawnError as error:
                answer.message = str(error)
            done.set()

        self.put(job)
        done.wait(SERVICE_TIMEOUT_S)
        return answer
