"""Node ``safety_monitor``: stops a mobile robot whose motion leaves too little room ahead.

Watches ``/tf``, the registry's known shapes, the grid (for what nobody registered) and the action goals. Event-driven
by ``/tf``, 30 times a second of simulated time.
"""

from __future__ import annotations

import threading
from typing import Dict, List, Optional, Sequence, Set, Tuple

import numpy as np
import rospy
from actionlib_msgs.msg import GoalID
from geometry_msgs.msg import TransformStamped, Twist
from tf2_msgs.msg import TFMessage

from yarm.control.actions import MobileAction
from yarm.geometry import CellMap, FloatArray, Pose2, transform_matrix, transform_points
from yarm.geometry.kinds import ObjectKind
from yarm.geometry.solids import Solid, surface_points
from yarm.msg import (
    CommanderStatus,
    MoveRobotActionGoal,
    MoveRobotActionResult,
    ObjectRegistry,
    RegisteredObject,
    SafetyStatus,
    StepAck,
)
from yarm.ros.commander.reports import exact_time
from yarm.ros.common import names
from yarm.ros.common.acks import step_ack
from yarm.ros.common.checks import Doorkeeper, pose_fault, present_s, registry_fault, transform_fault
from yarm.ros.common.clock import ClockWatch
from yarm.ros.common.conversions import MapSubscriber, matrix_of_transform
from yarm.ros.common.params import load_params
from yarm.ros.common.solids import solids_at_tip, solids_of
from yarm.ros.common.start import init_node
from yarm.ros.common.status_age import STALE_S, silence
from yarm.ros.common.tracks import TrackSubscriber
from yarm.ros.safety.people import PeoplePicture
from yarm.ros.safety.stop import StopService
from yarm.safety.clearance import Body, Foresight, Motion, column_boxes, way_ahead
from yarm.safety.loads import Load, loads_of, with_loads
from yarm.safety.monitor import Monitor, Seen, Verdict, bodies_for, own_goals
from yarm.safety.movers import Movers
from yarm.safety.params import SafetyParams
from yarm.safety.people import Walking, people_among
from yarm.safety.pulse import beat_in_background

MAP_AGE_S = 1.0
STAND_S = Foresight().time_to_stand_s(Motion(1.0))
"""Until a robot at 1 m/s stands, s; for the picture."""


class RobotWatch:
    """One mobile robot: its goals as they pass by, and the means to stop it."""

    def __init__(self, name: str) -> None:
        """Listen to the robot's action, and be ready to stop it."""
        self.goal_id = ""
        self.way: Tuple[Pose2, ...] = ()
        self.commands_sent = 0
        self.points: Optional[FloatArray] = None
        action = names.move_robot(name)
        self._cancel = rospy.Publisher(f"{action}/cancel", GoalID, queue_size=10)
        self._cmd_vel = rospy.Publisher(names.cmd_vel(name), Twist, queue_size=10, tcp_nodelay=True)
        self._subscribers = [
            rospy.Subscriber(f"{action}/goal", MoveRobotActionGoal, self._on_goal, queue_size=10, tcp_nodelay=True),
            rospy.Subscriber(f"{action}/result", MoveRobotActionResult, self._on_result, queue_size=10),
        ]

    def stop(self, cancel: bool) -> None:
        """Zero velocity, and with ``cancel`` the end of every goal."""
        if cancel:
            self._cancel.publish(GoalID())
        self._cmd_vel.publish(Twist())
        self.commands_sent += 1

    def close(self) -> None:
        """Let go of the robot."""
        for item in [*self._subscribers, self._cancel, self._cmd_vel]:
            item.unregister()

    def _on_goal(self, message: MoveRobotActionGoal) -> None:
        poses = [*message.goal.via, message.goal.target]
        if MobileAction.of(message.goal.action) is MobileAction.CALIBRATE or any(map(pose_fault, poses)):
            return  # the controls server refuses such a goal, and says so
        yaws = [2.0 * np.arctan2(pose.orientation.z, pose.orientation.w) for pose in poses]
        self.way = tuple(Pose2(p.position.x, p.position.y, float(yaw)) for p, yaw in zip(poses, yaws))
        self.goal_id = message.goal_id.id

    def _on_result(self, message: MoveRobotActionResult) -> None:
        if message.status.goal_id.id == self.goal_id:
            self.goal_id, self.way = "", ()


class SafetyMonitor:
    """Ties topics to the monitor's core."""

    def __init__(self, params: SafetyParams) -> None:
        """Subscribe; all work is done in the callback of ``/tf``."""
        self._params = params
        self._monitor = Monitor(params)
        self._movers = Movers(params.mover_mps)
        self._walking = Walking(params.person_mps, params.watched_s, params.mover_mps)
        self._people = PeoplePicture()
        self._lock = threading.Lock()
        self._entries: Dict[str, RegisteredObject] = {}
        self._solids: Dict[str, List[Tuple[str, Solid]]] = {}
        self._robots: Dict[str, RobotWatch] = {}
        self._frames: Dict[str, FloatArray] = {}
        self._stamps_s: Dict[str, float] = {}
        self._loaded: Optional[CellMap] = None  # the map that the loads are of
        self._loads: List[Load] = []
        self._commander = CommanderStatus()
        self._looked_s = -1.0
        self._blame = ""
        self._verdicts: Dict[str, Verdict] = {}
        self._status = rospy.Publisher(names.SAFETY_STATUS, SafetyStatus, queue_size=10)
        self._ack = rospy.Publisher(names.STEP_ACK, StepAck, queue_size=100, tcp_nodelay=True)
        self._doors = {name: Doorkeeper(name) for name in (names.OBJECT_REGISTRY, "/tf")}
        self._clock = ClockWatch()
        self._clock.on_reset(self._on_clock_reset)
        self._maps = MapSubscriber(lock_step=params.sync)
        self._tracks = TrackSubscriber(params.sync)
        self._stop = StopService(self._on_stop)
        self._subscribers = [
            rospy.Subscriber(names.OBJECT_REGISTRY, ObjectRegistry, self._on_registry, queue_size=10),
            rospy.Subscriber(names.COMMANDER_STATUS, CommanderStatus, self._on_commander, queue_size=10),
            rospy.Subscriber("/tf_static", TFMessage, self._on_tf_static, queue_size=100),
            rospy.Subscriber("/tf", TFMessage, self._on_tf, queue_size=2, tcp_nodelay=True),
        ]

    def spin(self) -> None:
        """Until the node is shut down."""
        beat_in_background(self._lock)
        rospy.spin()

    def _on_registry(self, message: ObjectRegistry) -> None:
        if self._doors[names.OBJECT_REGISTRY].refuses(message, registry_fault(message)):
            return
        with self._lock:
            self._entries = {entry.name: entry for entry in message.entries if entry.object != ObjectKind.TARGET}
            self._solids = {name: solids_of(entry) for name, entry in self._entries.items()}
            self._loaded, self._loads = None, []
            mobile = [name for name, entry in self._entries.items() if entry.object == ObjectKind.MOBILE]
            for name in [name for name in self._robots if name not in mobile]:
                self._robots.pop(name).close()
            for name in [name for name in mobile if name not in self._robots]:
                self._robots[name] = RobotWatch(name)

    def _on_commander(self, message: CommanderStatus) -> None:
        self._commander = message

    def _on_stop(self) -> None:
        """A person has stopped everything or released it: it takes effect before the next look."""
        with self._lock:
            if self._stop.reason:
                for robot in self._robots.values():
                    robot.stop(cancel=True)
            if self._looked_s >= 0.0:
                self._status.publish(self._message())

    def _on_clock_reset(self) -> None:
        with self._lock:
            self._verdicts = {}
            self._monitor.reset()
            self._movers.reset()
            self._looked_s = -1.0
            self._stamps_s.clear()
            self._maps.clear()
            self._tracks.clear()
            for robot in self._robots.values():
                robot.goal_id, robot.way, robot.commands_sent = "", (), 0

    def _on_tf_static(self, message: TFMessage) -> None:
        with self._lock:
            for transform in self._good(message, np.inf):
                self._frames[transform.child_frame_id.lstrip("/")] = matrix_of_transform(transform.transform)

    def _good(self, message: TFMessage, now_s: float) -> List[TransformStamped]:
        """The children of the world in a message whose numbers and stamps can be used."""
        door = self._doors["/tf"]
        return [
            transform
            for transform in message.transforms
            if transform.header.frame_id.lstrip("/") == names.WORLD_FRAME
            and not door.refuses(message, transform_fault(transform, now_s))
        ]

    def _on_tf(self, message: TFMessage) -> None:
        good = [] if rospy.is_shutdown() else self._good(message, present_s(self._params.sync))
        if not good:
            return
        now_s = max(transform.header.stamp.to_sec() for transform in good)
        if now_s - self._looked_s < 0.9 / self._params.rate_hz:
            return
        with self._lock:
            self._looked_s = now_s
            for transform in good:
                frame = transform.child_frame_id.lstrip("/")
                self._frames[frame] = matrix_of_transform(transform.transform)
                self._stamps_s[frame] = transform.header.stamp.to_sec()
            try:
                self._look(now_s)
            except rospy.ROSException:
                if not rospy.core.is_shutdown_requested():  # topics close while the last message is looked at
                    raise

    def _look(self, now_s: float) -> None:
        cell_map = self._maps.newest()
        if cell_map is not self._loaded:
            self._loaded = cell_map
            self._loads = [] if cell_map is None else loads_of(cell_map, self._solids, self._params.spacing_m)
        loads = self._loads
        looks = ((name, self._see(name, now_s, loads)) for name in self._robots)
        robots = {name: seen for name, seen in looks if seen is not None}
        everything = self._bodies(now_s)
        self._people.show(everything, STAND_S, now_s)
        allowed = own_goals([*self._given(now_s), *((load.robot, load.piece) for load in loads)])
        bodies = {name: bodies_for(name, everything, allowed.get(name, set())) for name in robots}
        self._verdicts = self._monitor.look(now_s, robots, bodies)
        for verdict in self._verdicts.values():
            if verdict.stop_now:
                self._blame = verdict.reason
                rospy.logwarn("stopped: %s", verdict.reason)
        for name, robot in self._robots.items():
            judged = self._verdicts.get(name)
            if self._stop.reason or (judged is not None and judged.held):
                robot.stop(judged is not None and judged.stop_now)
        message = self._message()
        self._status.publish(message)
        if self._params.sync:
            sent = sum(robot.commands_sent for robot in self._robots.values())
            self._ack.publish(step_ack(message.header.stamp, sent))

    def _given(self, now_s: float) -> List[Tuple[str, str]]:
        """Each robot with its goal, unless the Commander that gave it has not been heard of for STALE_S."""
        status = self._commander
        if silence(status, now_s, STALE_S):
            return []
        return [(task.robot, task.goal) for task in status.tasks if task.robot]

    def _see(self, name: str, now_s: float, loads: Sequence[Load]) -> Optional[Seen]:
        robot, entry = self._robots[name], self._entries[name]
        T_world_ee = self._frames.get(entry.seed_frame)
        if T_world_ee is None:
            return None
        if not self._solids[name]:
            robot.points = self._cells_about_tip(name)
        elif robot.points is None:
            robot.points = self._surface(name, T_world_ee)
        if robot.points is None:
            return None
        pose = Pose2(
            float(T_world_ee[0, 3]), float(T_world_ee[1, 3]), float(np.arctan2(T_world_ee[1, 0], T_world_ee[0, 0]))
        )
        age_s = now_s - self._stamps_s.get(entry.seed_frame, now_s)
        points = with_loads(name, robot.points, loads)
        robot.way = way_ahead(robot.way, pose)
        target = robot.way[-1] if robot.way else None
        return Seen(pose, float(T_world_ee[2, 3]), points, target, robot.goal_id, age_s, robot.way[:-1])

    def _surface(self, name: str, T_world_ee: FloatArray) -> Optional[FloatArray]:
        solids = solids_at_tip(self._entries[name], {**self._frames, self._entries[name].seed_frame: T_world_ee})
        if not solids:
            return None
        points = surface_points(solids, self._params.spacing_m)
        above: FloatArray = points[points[:, 2] + T_world_ee[2, 3] > 0.02]
        return above

    def _cells_about_tip(self, name: str) -> Optional[FloatArray]:
        """Middles (n, 3) of the cells of a robot that nobody drew, as the newest map has them, end effector's frame."""
        cell_map = self._maps.newest()
        found = None if cell_map is None else cell_map.objects.get(name)
        if cell_map is None or found is None or not len(found.cells):
            return None
        middles = cell_map.spec.lower + (found.cells + 0.5) * cell_map.spec.resolution
        return transform_points(np.linalg.inv(transform_matrix(found.position_m, found.quaternion)), middles)

    def _bodies(self, now_s: float) -> List[Body]:
        bodies = []
        for name, own in self._solids.items():
            solids = tuple(solid.seen_from(self._frames[f]) for f, solid in own if f in self._frames)
            if solids:
                bodies.append(Body(name, solids))
        known = {body.name for body in bodies}
        return bodies + self._from_map(now_s, known)

    def _from_map(self, now_s: float, known: Set[str]) -> List[Body]:
        """What only the grid knows: things nobody registered, and those without a drawing."""
        cell_map: Optional[CellMap] = self._maps.newest()
        if cell_map is None or not 0.0 <= now_s - cell_map.stamp_s < MAP_AGE_S:
            return []
        things = {
            name: thing.cells
            for name, thing in cell_map.objects.items()
            if name not in known and thing.kind != ObjectKind.TARGET and len(thing.cells)
            if thing.kind != ObjectKind.MOBILE or not self._solids.get(name)
        }
        self._movers.see(cell_map.stamp_s, cell_map.spec, things)
        age_s = now_s - cell_map.stamp_s
        shown = [
            Body(name, (), column_boxes(cell_map.spec, cells), self._movers.velocity(name), age_s)
            for name, cells in things.items()
        ]
        return list(people_among(shown, self._tracks.newest(cell_map.stamp_s), self._walking, now_s))

    def _message(self) -> SafetyStatus:
        stopped = self._stop.reason
        message = SafetyStatus(reason=stopped or self._blame, latched=bool(stopped))
        message.header.stamp = exact_time(self._looked_s)
        message.header.frame_id = names.WORLD_FRAME
        for name, verdict in self._verdicts.items():
            message.robots.append(name)
            message.clearance_m.append(verdict.ahead.distance_m)
            message.nearest.append(verdict.ahead.nearest)
            message.stopped.append(verdict.held or bool(stopped))
            message.person.append(verdict.apart.who)
            message.person_m.append(verdict.apart.distance_m)
            message.separation_m.append(verdict.apart.required_m)
        return message


def main() -> None:
    """Run the node until it is shut down."""
    init_node(names.SAFETY_NODE)
    SafetyMonitor(load_params(SafetyParams)).spin()
