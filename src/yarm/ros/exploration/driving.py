"""How what a pass wants reaches the base: a command to the multiplexer, or goals for ``move_base``."""

from __future__ import annotations

from typing import Protocol

import rospy
from actionlib_msgs.msg import GoalID
from geometry_msgs.msg import Twist
from move_base_msgs.msg import MoveBaseActionGoal, MoveBaseActionResult

from yarm.exploration.goal_relay import GoalRelay
from yarm.exploration.model import Command
from yarm.exploration.session import SessionStep
from yarm.geometry import Pose2
from yarm.ros.common import names
from yarm.ros.common.conversions import pose_message

ABORTED = 4
"""Of actionlib_msgs/GoalStatus."""


class Driving(Protocol):
    """Called from the loop alone."""

    def drive(self, step: SessionStep, now_s: float) -> int:
        """Send what a pass wants; how many commands went to the multiplexer."""

    def forget(self) -> None:
        """Time went backwards."""

    def connected(self) -> bool:
        """What is sent is heard."""


class DrivesItself:
    """One command a pass."""

    def __init__(self) -> None:
        """Advertise."""
        self._command = rospy.Publisher(names.TELEOP, Twist, queue_size=10, tcp_nodelay=True)

    def drive(self, step: SessionStep, now_s: float) -> int:
        """Send the command; zeros while it stands."""
        self._command.publish(twist_of(step.command))
        return 1

    def forget(self) -> None:
        """Nothing is kept."""

    def connected(self) -> bool:
        """Somebody hears the commands."""
        return int(self._command.get_num_connections()) > 0


class DrivesByMoveBase:
    """Goals for any node with the interface of ``move_base``; commands only for what is no drive to a goal.

    They share that node's source of the multiplexer: one of a higher priority would keep it out for a second each time.
    """

    def __init__(self, frame: str) -> None:
        """Advertise and listen.

        Args:
            frame: of the goals.
        """
        self._frame = frame
        self._relay = GoalRelay()
        self._name, self._serial = "", 0
        self._command = rospy.Publisher(names.NAVI, Twist, queue_size=10, tcp_nodelay=True)
        self._goal = rospy.Publisher(names.move_base("goal"), MoveBaseActionGoal, queue_size=10, tcp_nodelay=True)
        self._cancel = rospy.Publisher(names.move_base("cancel"), GoalID, queue_size=10, tcp_nodelay=True)
        self._results = rospy.Subscriber(
            names.move_base("result"), MoveBaseActionResult, self._on_result, queue_size=10
        )

    def drive(self, step: SessionStep, now_s: float) -> int:
        """Send a goal, take one back, or command."""
        order = self._relay.step(step)
        if order.goal is not None:
            self._send(order.goal, now_s)
        if order.cancel:
            self._cancel.publish(GoalID(id=self._name))
        if order.command is not None:
            self._command.publish(twist_of(order.command))
        return int(order.command is not None)

    def forget(self) -> None:
        """No goal is known."""
        self._relay = GoalRelay()

    def connected(self) -> bool:
        """Goals, cancellations and commands are heard."""
        return all(int(sender.get_num_connections()) > 0 for sender in (self._command, self._goal, self._cancel))

    def _send(self, goal: Pose2, now_s: float) -> None:
        self._serial += 1
        self._name = f"{rospy.get_name()}-{self._serial}-{now_s:.3f}"
        message = MoveBaseActionGoal()
        message.goal_id.id = self._name
        message.header.stamp = message.goal_id.stamp = rospy.Time.from_sec(now_s)
        message.goal.target_pose.header.stamp, message.goal.target_pose.header.frame_id = (
            message.header.stamp,
            self._frame,
        )
        message.goal.target_pose.pose = pose_message(goal.x, goal.y, 0.0, goal.yaw_rad)
        self._goal.publish(message)

    def _on_result(self, message: MoveBaseActionResult) -> None:
        if message.status.goal_id.id == self._name and message.status.status == ABORTED:
            rospy.logwarn("move_base has given up a goal: %s", message.status.text)


def twist_of(command: Command) -> Twist:
    """The message of a command."""
    message = Twist()
    message.linear.x, message.angular.z = command.v_mps, command.w_radps
    return message
