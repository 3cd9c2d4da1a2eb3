"""A room that a rostest plays to the explorer: exact kinematics, a map from the true pose, one pass at a time."""

from __future__ import annotations

import math
import threading
import time
from typing import Callable, Dict, List, Optional

import rospy
from geometry_msgs.msg import TransformStamped, Twist
from nav_msgs.msg import OccupancyGrid
from nav_msgs.msg import Odometry as OdometryMessage
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage
from yarm.msg import BumperEvent, ExplorerStatus, StepAck

from yarm.experiments.explore.true_mapper import TrueMapper
from yarm.geometry import Pose2
from yarm.geometry.scans import Scan
from yarm.robots.turtlebot import COMMAND_TIMEOUT_S, DEPTH_CAMERA
from yarm.ros.common import names
from yarm.ros.common.conversions import pose2_of_pose, pose_message
from yarm.ros.navigation.maps import grid_message
from yarm.sim.kinematic.world import KinematicWorld
from yarm.sim.scenes.arena import Arena

LIMIT_S = 60.0
NODE_LIMIT_S = 120.0
PASS_S = 0.1
MAP_PASSES = 10
SCAN_FRAME = "camera_depth_frame"


def transform(parent: str, child: str, pose: Pose2, stamp: rospy.Time) -> TransformStamped:
    """A transform parent <- child in the plane."""
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id, message.header.stamp = parent, stamp
    message.transform.translation.x, message.transform.translation.y = pose.x, pose.y
    message.transform.rotation.z = math.sin(0.5 * pose.yaw_rad)
    message.transform.rotation.w = math.cos(0.5 * pose.yaw_rad)
    return message


def scan_message(scan: Scan, stamp: rospy.Time) -> LaserScan:
    """A laser scan."""
    message = LaserScan(
        angle_min=scan.angle_min_rad,
        angle_increment=scan.angle_increment_rad,
        range_min=scan.range_min_m,
        range_max=scan.range_max_m,
        ranges=scan.ranges.tolist(),
    )
    message.header.frame_id, message.header.stamp = SCAN_FRAME, stamp
    return message


class ExploredRoom:
    """The room, its robot, and what the explorer and the gate say.

    Attributes:
        status: the explorer's newest.
        told: every command that reached the base, with the time of the pass it came in.
        map_shift: pose of the world in the map frame: another after a mapping that began anew.
    """

    def __init__(self, arena: Arena, seed: int, now_s: float = 10.0) -> None:
        """Advertise and listen."""
        self.arena, self.seed = arena, seed
        self.changed = threading.Condition()
        self.status: Optional[ExplorerStatus] = None
        self.statuses: List[ExplorerStatus] = []
        self.told: List[tuple] = []
        self._acks: Dict[str, StepAck] = {}
        self._told_before, self._heard_ns = 0, -1
        self._ticks = round(now_s / PASS_S)
        self.renew()
        advertise = rospy.Publisher
        self._clock = advertise("/clock", Clock, queue_size=10, tcp_nodelay=True)
        self._tf = advertise("/tf", TFMessage, queue_size=10, tcp_nodelay=True)
        self._static = advertise("/tf_static", TFMessage, queue_size=1, latch=True)
        self._odom = advertise(names.ODOM, OdometryMessage, queue_size=10, tcp_nodelay=True)
        self._scan = advertise(names.SCAN, LaserScan, queue_size=10, tcp_nodelay=True)
        self._bumper = advertise(names.BUMPER, BumperEvent, queue_size=10, tcp_nodelay=True)
        self._map = advertise(names.MAP, OccupancyGrid, queue_size=1, latch=True)
        self._static.publish(TFMessage([transform("base_footprint", SCAN_FRAME, DEPTH_CAMERA, rospy.Time(0))]))
        rospy.Subscriber(names.BASE_VELOCITY, Twist, self._on_velocity, queue_size=100, tcp_nodelay=True)
        rospy.Subscriber(names.STEP_ACK, StepAck, self._on_ack, queue_size=100, tcp_nodelay=True)
        rospy.Subscriber(names.explorer("status"), ExplorerStatus, self._on_status, queue_size=100, tcp_nodelay=True)

    @property
    def now_s(self) -> float:
        """Simulated time."""
        return round(self._ticks * PASS_S, 6)

    def renew(self, now_s: Optional[float] = None) -> None:
        """The room as it was at first; with a time, simulated time goes on from there, and old answers are none."""
        self.world = KinematicWorld(self.arena, self.seed)
        self.mapping_anew(self.arena.start.inverse())
        if now_s is not None:
            with self.changed:
                self._ticks = round(now_s / PASS_S)
                self._told_before, self._heard_ns = len(self.told), -1
                self._acks.clear()

    def mapping_anew(self, map_from_world: Pose2) -> None:
        """The mapping begins with nothing, in a frame of its own."""
        self.map_from_world = map_from_world
        self._mapper = TrueMapper(self.arena.lower, self.arena.upper)

    def connect(self) -> None:
        """Wait until everybody listens."""
        outs = (self._clock, self._tf, self._odom, self._scan, self._bumper, self._map)
        end = time.monotonic() + LIMIT_S
        while min(out.get_num_connections() for out in outs) == 0:
            assert time.monotonic() < end, "the explorer never subscribed to everything"
            time.sleep(0.02)

    def tick(self, scan: bool = True, odometry: bool = True, pose: bool = True, alive: bool = True) -> None:
        """One pass: the robot moves on, measures, and everybody who is alive answers.

        Args:
            scan: the scan comes.
            odometry: odometry comes.
            pose: the mapping lives.
            alive: the explorer is expected to answer, and not only the gate.
        """
        v, w = self._command()
        self.world.step(v, w, PASS_S)
        self._ticks += 1
        stamp = rospy.Time(0, round(self.now_s * 1e9))
        reading = self.world.odometry()
        for event in self.world.take_bumps():
            self._bumper.publish(BumperEvent(bumper=int(event.bumper), state=int(event.pressed)))
        seen = self.world.scan()
        map_from_base = self.map_from_world.compose(self.world.truth)
        if pose:
            self._mapper.add(seen, self.world.truth)
            map_from_odom = map_from_base.compose(reading.pose.inverse())
            self._tf.publish(TFMessage([transform("map", "odom", map_from_odom, stamp)]))
            if self._ticks % MAP_PASSES == 0:
                self._map.publish(self._map_message(stamp))
        if odometry:
            message = OdometryMessage(child_frame_id="base_footprint")
            message.header.frame_id, message.header.stamp = "odom", stamp
            message.pose.pose = pose_message(reading.pose.x, reading.pose.y, 0.0, reading.pose.yaw_rad)
            self._odom.publish(message)
        if scan:
            self._scan.publish(scan_message(seen, stamp))
        self._clock.publish(Clock(stamp))
        self._await_answers(stamp, alive)

    def nonsense(self) -> List[Dict[str, tuple]]:
        """Rounds of messages that cannot be used: for each topic its publisher, a message, and what is wrong with it.

        A topic is in a round once: who refuses says so once in a while only.
        """
        now, old = rospy.Time.from_sec(self.now_s), rospy.Time(1)
        strange, flat, past = (scan_message(self.world.scan(), stamp) for stamp in (now, now, old))
        strange.header.frame_id, flat.angle_increment = "laser", 0.0
        nowhere, late = OdometryMessage(), OdometryMessage()
        nowhere.header.stamp, nowhere.pose.pose = now, pose_message(math.nan, 0.0, 0.0, 0.0)
        late.header.stamp, late.pose.pose = old, pose_message(5.0, 0.0, 0.0, 0.0)
        elsewhere, torn = self._map_message(now), self._map_message(now)
        elsewhere.header.frame_id, torn.data = "world", torn.data[:-1]
        return [
            {
                names.SCAN: (self._scan, strange, "frame 'laser' is not known in base_footprint"),
                names.ODOM: (self._odom, nowhere, "must be finite"),
                names.BUMPER: (self._bumper, BumperEvent(bumper=7, state=1), "bumper 7, state 1 mean nothing"),
                names.MAP: (self._map, elsewhere, "its frame is 'world', expected map"),
            },
            {
                names.SCAN: (self._scan, flat, "its beams turn by 0 rad"),
                names.ODOM: (self._odom, late, "its stamp 1.000 s is before"),
                names.MAP: (self._map, torn, f"{len(torn.data)} cells for"),
            },
            {names.SCAN: (self._scan, past, "its stamp 1.000 s is before")},
        ]

    def run(self, seconds: float, until: Optional[Callable[[], bool]] = None, **what: bool) -> bool:
        """Passes for so long, or until something is true; whether it became true."""
        for _ in range(round(seconds / PASS_S)):
            self.tick(**what)
            if until is not None and until():
                return True
        return until is None

    def run_on(self, what: str, until: Callable[[], bool], **how: bool) -> None:
        """Passes until something is true that does not happen in simulated time: a file, a node. It has a limit."""
        end = time.monotonic() + NODE_LIMIT_S
        while not until():
            assert time.monotonic() < end, f"never came: {what}; {self.status}"
            self.tick(**how)

    def state(self) -> str:
        """The explorer's."""
        return "" if self.status is None else str(self.status.state)

    def ask(self, service: str) -> Trigger:
        """Call one of the explorer's services, while time stands still."""
        name = names.explorer(service)
        rospy.wait_for_service(name, LIMIT_S)
        return rospy.ServiceProxy(name, Trigger)()

    def believed(self) -> Pose2:
        """Where the explorer says that it is."""
        return pose2_of_pose(self.status.pose)

    def _map_message(self, stamp: rospy.Time) -> OccupancyGrid:
        grid = self._mapper.map()
        message = grid_message(grid, "map", stamp)
        corner = self.map_from_world.compose(grid.origin)
        message.info.origin = pose_message(corner.x, corner.y, 0.0, corner.yaw_rad)
        return message

    def _command(self) -> tuple:
        """What the base does now: the newest command, unless it is too old."""
        if not self.told or self.now_s - self.told[-1][0] > COMMAND_TIMEOUT_S:
            return 0.0, 0.0
        return self.told[-1][1:]

    def _await_answers(self, stamp: rospy.Time, alive: bool) -> None:
        wanted = [names.GATE_NODE, *([names.EXPLORER_NODE] if alive else [])]

        def done() -> bool:
            acks = [self._acks.get(node) for node in wanted]
            if any(ack is None or ack.header.stamp < stamp for ack in acks):
                return False
            sent = sum(ack.commands_sent for ack in acks)
            return not alive or (len(self.told) - self._told_before >= sent and self._heard_ns >= stamp.to_nsec())

        end = time.monotonic() + LIMIT_S
        with self.changed:
            while not done():
                left = end - time.monotonic()
                if left <= 0.0:
                    sent = {node: ack.commands_sent for node, ack in self._acks.items()}
                    raise AssertionError(f"at {self.now_s:.1f} s no answer of {wanted}: {sent}, got {len(self.told)}")
                if not self.changed.wait(min(left, 0.2)):
                    self._clock.publish(Clock(stamp))

    def _is_old(self, stamp: rospy.Time) -> bool:
        """Whether it is from before time went back."""
        return stamp.to_sec() > self.now_s + 0.5 * PASS_S

    def _on_velocity(self, message: Twist) -> None:
        with self.changed:
            self.told.append((self.now_s, message.linear.x, message.angular.z))
            self.changed.notify_all()

    def _on_ack(self, message: StepAck) -> None:
        with self.changed:
            if not self._is_old(message.header.stamp):
                self._acks[message.node] = message
            self.changed.notify_all()

    def _on_status(self, message: ExplorerStatus) -> None:
        with self.changed:
            self.status = message
            self.statuses.append(message)
            if not self._is_old(message.header.stamp):
                self._heard_ns = message.header.stamp.to_nsec()
            self.changed.notify_all()
