"""Everything the simulated room publishes; messages that cost much are made only when somebody listens."""

from __future__ import annotations

from typing import FrozenSet, Mapping, Optional, Sequence

import rospy
from nav_msgs.msg import Odometry as OdometryMessage
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, JointState, LaserScan, PointCloud2
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from yarm.geometry import Pose2
from yarm.geometry.scans import Odometry
from yarm.msg import BumperEvent as BumperMessage
from yarm.msg import Contacts, SimStatus
from yarm.robots.turtlebot import WHEEL_JOINTS, WHEEL_RADIUS_M, Bumper, BumperEvent
from yarm.ros.common import names
from yarm.ros.rooms import messages
from yarm.ros.simulation.outbox import contact_message
from yarm.sim.engine.room import RoomWorld


class RoomOutbox:
    """Publishers of the simulated room."""

    def __init__(self, world: RoomWorld, map_pose: Optional[Pose2]) -> None:
        """Advertise, and say what never changes.

        Args:
            world: what is published.
            map_pose: of the map's frame in the world; None: nobody is told.
        """
        self._world = world
        self._clock = rospy.Publisher("/clock", Clock, queue_size=10, tcp_nodelay=True)
        self._tf = rospy.Publisher("/tf", TFMessage, queue_size=100, tcp_nodelay=True)
        self._tf_static = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        self._odom = rospy.Publisher(names.ODOM, OdometryMessage, queue_size=10, tcp_nodelay=True)
        self._pose = rospy.Publisher(names.SIM_POSE, OdometryMessage, queue_size=100)
        self._joints = rospy.Publisher(names.BASE_JOINTS, JointState, queue_size=10)
        self._scan = rospy.Publisher(names.SCAN, LaserScan, queue_size=10, tcp_nodelay=True)
        self._image = rospy.Publisher(names.DEPTH_IMAGE, Image, queue_size=2)
        self._info = rospy.Publisher(names.DEPTH_INFO, CameraInfo, queue_size=2)
        self._bumper = rospy.Publisher(names.BUMPER, BumperMessage, queue_size=10, tcp_nodelay=True)
        self._cloud = rospy.Publisher(names.BUMPER_CLOUD, PointCloud2, queue_size=10, tcp_nodelay=True)
        self._contacts = rospy.Publisher(names.SIM_CONTACTS, Contacts, queue_size=100)
        self._status = rospy.Publisher(names.SIM_STATUS, SimStatus, queue_size=10)
        self._arena = rospy.Publisher(names.SIM_ARENA, MarkerArray, queue_size=1, latch=True)
        self._pressed: FrozenSet[Bumper] = frozenset()
        self._arena.publish(MarkerArray(markers=messages.arena_markers(world.arena.blocks)))
        if map_pose is not None:
            start = messages.transform(names.WORLD_FRAME, names.MAP_FRAME, map_pose, rospy.Time(0))
            self._tf_static.publish(TFMessage([start]))

    def clock(self, stamp: rospy.Time) -> None:
        """Simulated time."""
        self._clock.publish(Clock(stamp))

    def motion(self, stamp: rospy.Time) -> None:
        """What wheels and gyro say, its transform, and the truth."""
        odometry = self._world.odometry
        self._tf.publish(TFMessage([messages.transform(names.ODOM_FRAME, names.BASE_FOOTPRINT, odometry.pose, stamp)]))
        self._odom.publish(messages.odometry_message(odometry, names.ODOM_FRAME, stamp))
        if self._pose.get_num_connections():
            truth = Odometry(self._world.time_s, self._world.truth, *self._world.robot.speed())
            self._pose.publish(messages.odometry_message(truth, names.WORLD_FRAME, stamp))
        if self._joints.get_num_connections():
            angles, speeds = self._world.robot.wheel_readings()
            joints = JointState(name=list(WHEEL_JOINTS), position=angles.tolist())
            joints.velocity = (speeds / WHEEL_RADIUS_M).tolist()
            joints.header.stamp = stamp
            self._joints.publish(joints)
        contacts = self._world.contacts.take()
        if self._contacts.get_num_connections():
            message = Contacts(contacts=[contact_message(contact) for contact in contacts])
            message.header.stamp, message.header.frame_id = stamp, names.WORLD_FRAME
            self._contacts.publish(message)

    def bumps(
        self, stamp: rospy.Time, events: Sequence[BumperEvent], pressed: FrozenSet[Bumper], always: bool = False
    ) -> None:
        """Changes of the bumper, and its cloud while anything is pressed and once after, or always."""
        for event in events:
            state = BumperMessage.PRESSED if event.pressed else BumperMessage.RELEASED
            self._bumper.publish(BumperMessage(bumper=int(event.bumper), state=state))
        if (always or pressed or self._pressed) and self._cloud.get_num_connections():
            self._cloud.publish(messages.bumper_cloud(pressed, stamp))
        self._pressed = pressed

    def scan(self, stamp: rospy.Time) -> None:
        """The laser scan."""
        self._scan.publish(messages.scan_message(self._world.scan(), stamp))

    def depth(self, stamp: rospy.Time) -> None:
        """Depth image and camera, each when somebody listens to it."""
        if self._image.get_num_connections():
            self._image.publish(messages.image_message(self._world.depth(), stamp))
        if self._info.get_num_connections():
            self._info.publish(messages.camera_info(stamp))

    def status(self, stamp: rospy.Time, factor: float, scans: int, parts_ms: Mapping[str, float]) -> None:
        """Health of the loop."""
        message = SimStatus(real_time_factor=factor, steps=self._world.steps, camera_sets=scans, run=1)
        message.header.stamp = stamp
        message.parts, message.ms_per_frame = list(parts_ms), list(parts_ms.values())
        self._status.publish(message)
