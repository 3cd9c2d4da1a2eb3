"""What the youBot is told by topics and services, between two ticks; what cannot be done is refused with the reason."""

from __future__ import annotations

import math
from collections import deque
from typing import Callable, Deque, Optional, Tuple

import numpy as np
import rospy
from geometry_msgs.msg import Twist
from std_srvs.srv import Empty, EmptyRequest, EmptyResponse
from trajectory_msgs.msg import JointTrajectory

from yarm.geometry import FloatArray
from yarm.manipulation.clearing.mission import Command
from yarm.manipulation.motion.commanded import commanded
from yarm.manipulation.motion.trajectory import Trajectory, TrajectoryError
from yarm.robots.youbot import NAME
from yarm.ros.common import names

VELOCITY_AGE_S = 0.5
"""Simulated time after which the base no longer follows a velocity, s."""


class FloorInbox:
    """Commands of others. What arrives waits for ``command``, which the simulation's thread calls."""

    def __init__(self, say: Callable[[str], None]) -> None:
        """Listen.

        Args:
            say: is told of what is taken.
        """
        self._say = say
        self.refused = ""
        """Why the newest command was refused; empty after one that was taken."""
        self._motions: Deque[JointTrajectory] = deque(maxlen=10)
        self._velocities: Deque[Twist] = deque(maxlen=10)
        self._suctions: Deque[bool] = deque(maxlen=10)
        self._later: Optional[Tuple[float, Trajectory]] = None
        self._velocity, self._heard_s = np.zeros(3), -math.inf
        self._heard = (
            rospy.Subscriber(names.ARM_COMMAND, JointTrajectory, self._motions.append, queue_size=10),
            rospy.Subscriber(names.YOUBOT_VELOCITY, Twist, self._velocities.append, queue_size=10),
        )
        self._services = (
            rospy.Service(names.gripper(NAME, "on"), Empty, self._on),
            rospy.Service(names.gripper(NAME, "off"), Empty, self._off),
        )

    def command(self, now_s: float, joints: FloatArray, refusal: str) -> Command:
        """What the robot is told now.

        Args:
            now_s: simulated time, s.
            joints: (5,), rad, where the arm's motion is.
            refusal: why nothing that has come is done; empty when it is.
        """
        while self._motions:
            self._take_motion(self._motions.popleft(), now_s, joints, refusal)
        while self._velocities:
            self._take_velocity(self._velocities.popleft(), now_s, refusal)
        suction: Optional[bool] = None
        while self._suctions:
            on = self._suctions.popleft()
            if refusal:
                self._refuse(names.gripper(NAME, "on" if on else "off"), refusal)
            else:
                suction, self.refused = on, ""
        motion: Optional[Trajectory] = None
        if self._later is not None and now_s >= self._later[0] and not refusal:
            motion, self._later = self._later[1], None
        velocity = self._velocity if now_s - self._heard_s <= VELOCITY_AGE_S else np.zeros(3)
        return Command(velocity, motion, suction)

    def _take_motion(self, message: JointTrajectory, now_s: float, joints: FloatArray, refusal: str) -> None:
        points = message.points
        rates = [p.velocities for p in points] if points and all(p.velocities for p in points) else None
        try:
            if refusal:
                raise TrajectoryError(refusal)
            times_s = [p.time_from_start.to_sec() for p in points]
            motion = commanded(message.joint_names, times_s, [p.positions for p in points], rates, joints)
        except (TrajectoryError, ValueError) as error:
            self._refuse(names.ARM_COMMAND, str(error))
            return
        self._later, self.refused = (max(now_s, message.header.stamp.to_sec()), motion), ""
        self._say(f"{names.ARM_COMMAND}: {len(points)} points, {motion.duration_s:.2f} s")

    def _take_velocity(self, message: Twist, now_s: float, refusal: str) -> None:
        wanted = [message.linear.x, message.linear.y, message.angular.z]
        if not all(map(math.isfinite, wanted)):
            refusal = f"velocity {wanted} must be 3 finite numbers"
        if refusal and (any(wanted) or self._velocity.any()):
            self._refuse(names.YOUBOT_VELOCITY, refusal)
        if refusal:
            self._velocity = np.zeros(3)
            return
        self._velocity, self._heard_s, self.refused = np.array(wanted), now_s, ""

    def _refuse(self, topic: str, reason: str) -> None:
        if reason != self.refused:
            rospy.logwarn("%s refused: %s", topic, reason)
        self.refused = reason

    def _on(self, _: EmptyRequest) -> EmptyResponse:
        self._suctions.append(True)
        return EmptyResponse()

    def _off(self, _: EmptyRequest) -> EmptyResponse:
        self._suctions.append(False)
        return EmptyResponse()
