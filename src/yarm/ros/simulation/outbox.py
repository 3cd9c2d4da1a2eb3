"""Everything the simulation publishes."""

from __future__ import annotations

from typing import Collection, Dict, List, Mapping, Union

import numpy as np
import numpy.typing as npt
import rospy
from geometry_msgs.msg import Point
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, PointCloud2
from std_msgs.msg import Bool
from tf2_msgs.msg import TFMessage

from yarm.geometry import FloatArray
from yarm.msg import (
    Clearance,
    Contact,
    Contacts,
    GripperState,
    JointControllerState,
    ObjectRegistry,
    SimStatus,
)
from yarm.robots.ankurbot import CASTERS
from yarm.ros.common import names
from yarm.ros.common.bodies import registry_message, transform_message
from yarm.ros.simulation.clouds import RawCloud, RawTransforms
from yarm.sim.engine.contacts import Contact as SimContact
from yarm.sim.engine.world import TICK_S, SimWorld
from yarm.sim.robots.ankurbot import Ankurbot
from yarm.sim.robots.arm import Arm
from yarm.sim.sensors.camera_model import KINECT, WRIST

CAMERAS = (1, 2, 3, 4)


class Outbox:
    """Publishers of the simulated cell; messages nobody listens to are not made."""

    def __init__(self, world: SimWorld, tells: bool = True) -> None:
        """Advertise; without ``tells`` nobody is told who is in the cell, only the drivers' frames."""
        self._world = world
        self._tells = tells
        self._clock = rospy.Publisher("/clock", Clock, queue_size=10, tcp_nodelay=True)
        self._tf = rospy.Publisher("/tf", TFMessage, queue_size=100, tcp_nodelay=True)
        self._tf_static = rospy.Publisher("/tf_static", TFMessage, queue_size=10, latch=True)
        self._registry = (
            rospy.Publisher(names.OBJECT_REGISTRY, ObjectRegistry, queue_size=10, latch=True) if tells else None
        )
        self._contacts = rospy.Publisher(names.SIM_CONTACTS, Contacts, queue_size=100)
        self._clearance = rospy.Publisher(names.SIM_CLEARANCE, Clearance, queue_size=100)
        self._status = rospy.Publisher(names.SIM_STATUS, SimStatus, queue_size=10)
        self._points = [rospy.Publisher(names.camera_points(n), PointCloud2, queue_size=1) for n in CAMERAS]
        self._clouds = [RawCloud(names.camera_optical_frame(n), KINECT.height, KINECT.width, 16) for n in CAMERAS]
        robots = (*world.robots, *world.arms)
        self._joints = {
            r: rospy.Publisher(names.joint_states(r), JointState, queue_size=10, tcp_nodelay=True) for r in robots
        }
        self._casters = {
            robot: [rospy.Publisher(names.caster_state(robot, c), JointControllerState, queue_size=10) for c in CASTERS]
            for robot in world.robots
        }
        self._wrist = {arm: rospy.Publisher(names.wrist_points(arm), PointCloud2, queue_size=1) for arm in world.arms}
        self._wrist_cloud = {
            arm: RawCloud(names.wrist_optical_frame(arm), WRIST.height, WRIST.width, 16) for arm in world.arms
        }
        self._grasping = {
            robot: rospy.Publisher(names.gripper(robot, "grasping"), Bool, queue_size=10, latch=True)
            for robot in world.hands
        }
        self._hands = {
            robot: rospy.Publisher(names.gripper(robot, "state"), GripperState, queue_size=10, tcp_nodelay=True)
            for robot in world.hands
        }
        self._told_grasping: Dict[str, bool] = {}
        self._transforms = RawTransforms(())

    def wrist_wanted(self, arm: str) -> bool:
        """Whether somebody listens to an arm's wrist camera."""
        return bool(self._wrist[arm].get_num_connections() > 0)

    def clearance_wanted(self) -> bool:
        """Whether somebody listens to the clearances."""
        return bool(self._clearance.get_num_connections() > 0)

    def objects(self, stamp: rospy.Time, cameras: Mapping[str, FloatArray]) -> None:
        """Registry and fixed frames; call at the start and whenever an object comes or goes."""
        poses = self._world.transforms()
        fixed = dict(cameras)
        scene = self._world.scene
        driven = {robot.name for robot in scene.robots} | {arm.name for arm in scene.arms}
        bodies = self._world.bodies.values()
        known = [body for body in bodies if (body.registered if self._tells else body.name in driven)]
        hidden = {frame for body in bodies if body not in known for frame in body.link_frames}
        for body in known:
            fixed.update(body.static_frames)
        self._transforms = RawTransforms([frame for frame in poses if frame not in fixed and frame not in hidden])
        self._tf_static.publish(transform_message(stamp, fixed))
        if self._registry is not None:
            self._registry.publish(registry_message(stamp, known))

    def tick(self, stamp: rospy.Time) -> None:
        """Clock, moving frames, joints."""
        self._clock.publish(Clock(stamp))
        self._tf.publish(self._transforms.fill(stamp, self._world.transforms()))
        robots: Dict[str, Union[Ankurbot, Arm]] = {**self._world.robots, **self._world.arms}
        for name, robot in robots.items():
            if self._joints[name].get_num_connections():
                message = JointState()
                message.header.stamp = stamp
                message.name, message.position, message.velocity = robot.joint_readings()
                self._joints[name].publish(message)
        for name, hand in self._world.hands.items():
            if self._told_grasping.get(name) is not hand.grasping:
                self._told_grasping[name] = hand.grasping
                self._grasping[name].publish(Bool(hand.grasping))
            if self._hands[name].get_num_connections():
                state = GripperState(grasping=hand.grasping)
                state.header.stamp = stamp
                self._hands[name].publish(state)
        for name in self._world.robots:
            if any(p.get_num_connections() for p in self._casters[name]):
                self._caster_states(name, stamp)

    def cloud(self, camera: int, stamp: rospy.Time, points: npt.NDArray[np.void]) -> None:
        """Cloud of overhead camera 1, 2, ..."""
        self._points[camera - 1].publish(self._clouds[camera - 1].fill(stamp, points))

    def wrist_cloud(self, arm: str, stamp: rospy.Time, points: npt.NDArray[np.void]) -> None:
        """Cloud of an arm's wrist camera."""
        self._wrist[arm].publish(self._wrist_cloud[arm].fill(stamp, points))

    def contacts(self, stamp: rospy.Time, contacts: List[SimContact]) -> None:
        """Contacts since the last message."""
        if self._contacts.get_num_connections():
            message = Contacts(contacts=[contact_message(contact) for contact in contacts])
            message.header.stamp, message.header.frame_id = stamp, names.WORLD_FRAME
            self._contacts.publish(message)

    def clearance(self, stamp: rospy.Time) -> None:
        """Least distances of robots and arms."""
        message = Clearance()
        message.header.stamp, message.header.frame_id = stamp, names.WORLD_FRAME
        for reading in self._world.clearances():
            message.robots.append(reading.robot)
            message.nearest.append(reading.nearest)
            message.distances.append(reading.distance_m)
        self._clearance.publish(message)

    def status(
        self, stamp: rospy.Time, factor: float, sets: int, parts_ms: Mapping[str, float], touched: Collection[str]
    ) -> None:
        """Health of the loop, and what has become of debris and of who may not touch (``touched``, pairs "a b")."""
        message = SimStatus(real_time_factor=factor, steps=self._world.steps, camera_sets=sets, run=1)
        message.header.stamp = stamp
        message.parts, message.ms_per_frame = list(parts_ms), list(parts_ms.values())
        message.debris = self._world.debris
        message.bins = [self._world.bin_of(name) for name in message.debris]
        message.touched = sorted(touched)
        message.lost = sum(hand.lost for hand in self._world.hands.values())
        self._status.publish(message)

    def _caster_states(self, name: str, stamp: rospy.Time) -> None:
        for publisher, reading in zip(self._casters[name], self._world.robots[name].caster_readings()):
            message = JointControllerState(set_point=reading.set_point, process_value=reading.angle)
            message.header.stamp = stamp
            message.process_value_dot, message.error = reading.speed, reading.set_point - reading.angle
            message.time_step, message.command = TICK_S, reading.torque
            publisher.publish(message)


def contact_message(contact: SimContact) -> Contact:
    """A contact as ground truth tells it."""
    return Contact(
        body_a=contact.a.body,
        link_a=contact.a.link,
        body_b=contact.b.body,
        link_b=contact.b.link,
        point=Point(*contact.point),
        depth=contact.depth_m,
        force=contact.force_n,
        allowed=contact.kind.value == "allowed",
        kind=contact.kind.value,
    )


def frame_poses(poses: List[FloatArray]) -> Dict[str, FloatArray]:
    """Overhead cameras' frames and poses."""
    return {names.camera_optical_frame(n): pose for n, pose in zip(CAMERAS, poses)}
