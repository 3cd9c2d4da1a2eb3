"""Everything that the youBot's simulation publishes."""

from __future__ import annotations

import math
from typing import Mapping, Sequence

import rospy
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion, TransformStamped, Vector3
from nav_msgs.msg import Path
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool
from tf2_msgs.msg import TFMessage

from yarm.console.floor_film import moving_poses
from yarm.geometry import FloatArray
from yarm.msg import ObjectRegistry, SafetyStatus, YoubotStatus
from yarm.robots.youbot import JOINT_NAMES, NAME, urdf_angles, urdf_rates
from yarm.ros.common import names
from yarm.ros.common.bodies import registry_message, transform_message
from yarm.sim.engine.youbot_floor import YoubotFloor
from yarm.sim.scenes.youbot_floor import floor_bodies


class FloorOutbox:
    """Publishers of a floor's world."""

    def __init__(self, world: YoubotFloor) -> None:
        """Advertise, and tell who is there."""
        self._world = world
        self._clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self._states = rospy.Publisher(names.ARM_JOINT_STATES, JointState, queue_size=10)
        self._tf = rospy.Publisher("/tf", TFMessage, queue_size=10)
        self._status = rospy.Publisher(names.youbot("status"), YoubotStatus, queue_size=10, latch=True)
        self._safety = rospy.Publisher(names.SAFETY_STATUS, SafetyStatus, queue_size=10, latch=True)
        self._path = rospy.Publisher(names.youbot("hand_path"), Path, queue_size=10, latch=True)
        self._grasping = rospy.Publisher(names.gripper(NAME, "grasping"), Bool, queue_size=10, latch=True)
        self._still = rospy.Publisher("/tf_static", TFMessage, queue_size=10, latch=True)
        self._registry = rospy.Publisher(names.OBJECT_REGISTRY, ObjectRegistry, queue_size=10, latch=True)
        bodies = floor_bodies(world.scene)
        fixed = {frame: pose for body in bodies for frame, pose in body.static_frames.items()}
        self._still.publish(transform_message(self._stamp, fixed))
        self._registry.publish(registry_message(self._stamp, bodies))
        self.grasping(False)

    @property
    def _stamp(self) -> rospy.Time:
        return rospy.Time.from_sec(self._world.time_s)

    def tick(self) -> None:
        """Clock and joints."""
        self._clock.publish(Clock(self._stamp))
        state = JointState(name=list(JOINT_NAMES), position=urdf_angles(self._world.robot.joints()).tolist())
        state.header.stamp = self._stamp
        state.velocity = urdf_rates(self._world.robot.joint_rates()).tolist()
        self._states.publish(state)

    def frames(self) -> None:
        """Robot and debris, each link a child of the world."""
        self._tf.publish(moving_frames(self._stamp, moving_poses(self._world)))

    def status(self, status: YoubotStatus) -> None:
        """How it stands; what the world knows is filled in."""
        world, robot = self._world, self._world.robot
        status.header.stamp, status.header.frame_id = self._stamp, names.WORLD_FRAME
        status.joints, status.held = robot.joints().tolist(), world.held()
        status.press = max(robot.cup.press_n().values(), default=0.0)
        status.debris = [piece.name for piece in world.scene.debris]
        status.in_bin = [world.in_bin(name) for name in status.debris]
        status.touches = world.wrong_touches()
        self._status.publish(status)

    def stop(self, reason: str) -> None:
        """Whether a person has stopped it: who and when, empty for nobody."""
        message = SafetyStatus(robots=[NAME], clearance_m=[math.inf], nearest=[""], stopped=[bool(reason)])
        message.header.stamp, message.header.frame_id = self._stamp, names.WORLD_FRAME
        message.reason, message.latched = reason, bool(reason)
        self._safety.publish(message)

    def hand_path(self, points: FloatArray) -> None:
        """The hand's way (n, 3) in the motion that begins, metres, world."""
        message = Path()
        message.header.stamp, message.header.frame_id = self._stamp, names.WORLD_FRAME
        upright = Quaternion(0.0, 0.0, 0.0, 1.0)
        message.poses = [PoseStamped(message.header, Pose(Point(*point), upright)) for point in points.tolist()]
        self._path.publish(message)

    def grasping(self, held: bool) -> None:
        """Whether something hangs on the cup."""
        self._grasping.publish(Bool(held))


def moving_frames(stamp: rospy.Time, poses: Mapping[str, Sequence[float]]) -> TFMessage:
    """Frames that hang on the world, from x, y, z, metres, and quaternion x, y, z, w of each."""
    message = TFMessage()
    for frame, pose in poses.items():
        entry = TransformStamped(child_frame_id=frame)
        entry.header.stamp, entry.header.frame_id = stamp, names.WORLD_FRAME
        entry.transform.translation, entry.transform.rotation = Vector3(*pose[:3]), Quaternion(*pose[3:])
        message.transforms.append(entry)
    return message
