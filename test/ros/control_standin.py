#!/usr/bin/env python3
"""A kinematic stand-in for simulator and perception: two bases, their seeds, caster angles and the clock.

``standin/event`` (String) misbehaves on demand: "silent", "talk", "freeze NAME", "thaw NAME", "remove NAME",
"add NAME", "restart" (time begins at 0 again, with everybody at rest).

Time does not run ahead of a controls server that a busy machine keeps waiting: whoever moves is given COMMAND_WAIT_S of
wall time at each tick for the command that the tick's seed brings.
"""

from __future__ import annotations

import math
import threading
import time
from typing import Dict, Set

import rospy
from geometry_msgs.msg import Pose, TransformStamped, Twist
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from shape_msgs.msg import SolidPrimitive
from std_msgs.msg import Float64, String
from yarm.msg import ObjectRegistry, RegisteredObject, TransformStampedVector

from yarm.control.base.controller import BaseCommand
from yarm.control.base.model import BaseModel
from yarm.geometry.poses import Pose2, quaternion_from_rpy
from yarm.ros.common import names
from yarm.ros.common.start import init_node

TICK_S = 1.0 / 60.0
COMMAND_WAIT_S = 1.0
STARTS = {"ankurbot_1": Pose2(1.0, 1.5, math.pi), "ankurbot_2": Pose2(-1.0, -1.5, 0.0)}


class StandIn:
    """Steps the bases at 60 Hz, twice as fast as real time."""

    def __init__(self) -> None:
        self.models = {name: BaseModel(start) for name, start in STARTS.items()}
        self.casters = {name: [0.0] * 4 for name in STARTS}
        self.twists: Dict[str, Twist] = {name: Twist() for name in STARTS}
        self.frozen: Set[str] = set()
        self.removed: Set[str] = set()
        self.silent = False
        self.tick = 0
        self.lock = threading.Condition()
        self.awaited: Set[str] = set()
        self.clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self.seeds = rospy.Publisher(names.SEED_TRANSFORMS, TransformStampedVector, queue_size=10)
        self.registry = rospy.Publisher(names.OBJECT_REGISTRY, ObjectRegistry, queue_size=1, latch=True)
        self.joints = {n: rospy.Publisher(names.joint_states(n), JointState, queue_size=10) for n in STARTS}
        for name in STARTS:
            rospy.Subscriber(names.cmd_vel(name), Twist, self.on_twist, name)
            for index, caster in enumerate(names.CASTERS):
                rospy.Subscriber(names.caster_command(name, caster), Float64, self.on_caster, (name, index))
        rospy.Subscriber("standin/event", String, self.on_event)
        self.registry.publish(ObjectRegistry(entries=[registered(name) for name in STARTS]))

    def on_twist(self, message: Twist, name: str) -> None:
        with self.lock:
            self.twists[name] = message
            self.awaited.discard(name)
            self.lock.notify_all()

    def on_caster(self, message: Float64, which: tuple) -> None:
        with self.lock:
            self.casters[which[0]][which[1]] = message.data

    def on_event(self, message: String) -> None:
        words = message.data.split()
        with self.lock:
            if words[0] in ("silent", "talk"):
                self.silent = words[0] == "silent"
            elif words[0] == "restart":
                self.tick = 0
                self.twists = {name: Twist() for name in STARTS}
            else:
                group = self.frozen if words[0] in ("freeze", "thaw") else self.removed
                (group.add if words[0] in ("freeze", "remove") else group.discard)(words[1])

    def moving(self) -> Set[str]:
        """Robots that move and have just been told where they are: each gets a new command for it."""
        seen = set() if self.silent else set(STARTS) - self.removed
        return {name for name in seen if self.twists[name].linear.x or self.twists[name].angular.z}

    def step(self) -> None:
        with self.lock:
            self.lock.wait_for(lambda: not self.awaited, timeout=COMMAND_WAIT_S)
            self.tick += 1
            now = rospy.Time.from_sec(self.tick * TICK_S)
            for name, model in self.models.items():
                if name not in self.frozen:
                    twist = self.twists[name]
                    casters = tuple(self.casters[name])
                    model.step(BaseCommand(casters, twist.linear.x, twist.angular.z), TICK_S)
            self.clock.publish(Clock(clock=now))
            for name, model in self.models.items():
                joints = JointState(name=[f"{c}_caster_joint" for c in names.CASTERS], position=list(model.casters))
                joints.header.stamp = now
                self.joints[name].publish(joints)
            self.awaited = self.moving()
            if not self.silent:
                self.seeds.publish(self.seed_message(now))

    def seed_message(self, now: rospy.Time) -> TransformStampedVector:
        message = TransformStampedVector()
        message.header.stamp = now
        for name, model in self.models.items():
            if name in self.removed:
                continue
            transform = TransformStamped(child_frame_id=names.ee_frame(name))
            transform.header.stamp = now
            t, q = transform.transform.translation, transform.transform.rotation
            t.x, t.y, t.z = model.pose.x, model.pose.y, 0.89
            q.x, q.y, q.z, q.w = quaternion_from_rpy(0.0, 0.0, model.pose.yaw_rad)
            message.transforms.append(transform)
            message.type.append("dynamic")
            message.frame.append(name)
            message.object.append("Mobile")
        return message


def registered(name: str) -> RegisteredObject:
    """Body, mast and arm as the registry tells them."""
    entry = RegisteredObject(name=name, object="Mobile", type="dynamic", seed_frame=names.ee_frame(name))
    solids = (
        (SolidPrimitive.CYLINDER, (0.45, 0.35), (0.0, 0.325)),
        (SolidPrimitive.BOX, (0.1, 0.1, 0.42), (0.0, 0.76)),
        (SolidPrimitive.BOX, (1.23, 0.08, 0.08), (0.665, 0.89)),
        (SolidPrimitive.SPHERE, (0.04,), (1.30, 0.89)),
    )
    for kind, dimensions, (x, z) in solids:
        pose = Pose()
        pose.position.x, pose.position.z, pose.orientation.w = x, z, 1.0
        entry.shapes.append(SolidPrimitive(type=kind, dimensions=list(dimensions)))
        entry.shape_poses.append(pose)
        entry.shape_frames.append(names.base_frame(name))
    return entry


if __name__ == "__main__":
    init_node("standin")
    standin = StandIn()
    while not rospy.is_shutdown():
        standin.step()
        time.sleep(TICK_S / 2.0)
