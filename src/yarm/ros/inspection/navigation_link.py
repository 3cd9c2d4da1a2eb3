"""The way to ``move_base``: goals and what becomes of them, plans, costmaps. Any node of that interface will do."""

from __future__ import annotations

import threading
from typing import Tuple

import rospy
from actionlib_msgs.msg import GoalID, GoalStatusArray
from geometry_msgs.msg import PoseStamped
from move_base_msgs.msg import MoveBaseActionGoal, MoveBaseActionResult
from nav_msgs.srv import GetPlan
from std_srvs.srv import Empty

from yarm.geometry import Pose2
from yarm.inspection.goal_watch import GoalWatch
from yarm.inspection.model import Outcome
from yarm.ros.common import names
from yarm.ros.common.conversions import pose_message


class NavigationLink:
    """One goal at a time. Thread-safe."""

    def __init__(self, frame: str) -> None:
        """Advertise and listen.

        Args:
            frame: of goals and plans.
        """
        self._frame = frame
        self._lock = threading.Lock()
        self._watch = GoalWatch()
        self._serial = 0
        self._name = ""
        self._heard = False
        self._goal = rospy.Publisher(names.move_base("goal"), MoveBaseActionGoal, queue_size=10, tcp_nodelay=True)
        self._cancel = rospy.Publisher(names.move_base("cancel"), GoalID, queue_size=10, tcp_nodelay=True)
        self._clear = rospy.ServiceProxy(names.move_base("clear_costmaps"), Empty)
        self._plan = rospy.ServiceProxy(names.move_base("make_plan"), GetPlan)
        self._subscribers = [
            rospy.Subscriber(
                names.move_base("status"), GoalStatusArray, self._on_status, queue_size=10, tcp_nodelay=True
            ),
            rospy.Subscriber(names.move_base("result"), MoveBaseActionResult, self._on_result, queue_size=10),
        ]

    def connected(self) -> bool:
        """Goals and cancellations are heard."""
        return all(int(publisher.get_num_connections()) > 0 for publisher in (self._goal, self._cancel))

    def heard(self) -> bool:
        """The server has said that it lives, ever since this node began."""
        return self._heard

    def forget(self) -> None:
        """Time went backwards: no goal is known."""
        with self._lock:
            self._watch, self._name = GoalWatch(), ""

    def send(self, goal: Pose2, now_s: float) -> None:
        """Drive to a pose; the goal before counts no more."""
        message = MoveBaseActionGoal()
        stamp = rospy.Time.from_sec(now_s)
        with self._lock:
            self._serial += 1
            self._name = f"{rospy.get_name()}-{self._serial}-{now_s:.3f}"
            self._watch.sent(self._name, now_s)
            message.goal_id.id = self._name
        message.header.stamp = message.goal_id.stamp = stamp
        message.goal.target_pose = self._stamped(goal, stamp)
        self._goal.publish(message)

    def cancel(self, now_s: float) -> None:
        """Take the goal back; nothing when there is none."""
        with self._lock:
            name, self._name = self._name, ""
        if name:
            self._cancel.publish(GoalID(id=name))

    def outcome(self, now_s: float) -> Tuple[Outcome, str]:
        """How the goal stands, and why it failed."""
        with self._lock:
            return self._watch.outcome(now_s)

    def gone(self, now_s: float) -> str:
        """What is wrong with the node; empty when it lives."""
        with self._lock:
            return self._watch.gone(now_s)

    def clear_costmaps(self) -> None:
        """Have what was seen in the way forgotten; in a thread of its own, so that nobody waits."""

        def clear() -> None:
            try:
                self._clear()
            except rospy.ServiceException as error:
                rospy.logwarn("clear_costmaps: %s", error)

        threading.Thread(target=clear, name="clear costmaps", daemon=True).start()

    def plannable(self, start: Pose2, goal: Pose2) -> bool:
        """Whether the navigation has a way from a pose to another, tolerance 0."""
        stamp = rospy.Time.now()
        try:
            answer = self._plan(self._stamped(start, stamp), self._stamped(goal, stamp), 0.0)
        except rospy.ServiceException as error:
            rospy.logwarn_throttle(5.0, f"make_plan: {error}")
            return False
        return len(answer.plan.poses) > 0

    def _stamped(self, pose: Pose2, stamp: rospy.Time) -> PoseStamped:
        message = PoseStamped(pose=pose_message(pose.x, pose.y, 0.0, pose.yaw_rad))
        message.header.stamp, message.header.frame_id = stamp, self._frame
        return message

    def _on_status(self, message: GoalStatusArray) -> None:
        self._heard = True
        known = {status.goal_id.id for status in message.status_list}
        with self._lock:
            self._watch.heard_status(known, rospy.get_time())

    def _on_result(self, message: MoveBaseActionResult) -> None:
        status = message.status
        with self._lock:
            stamp_s = message.header.stamp.to_sec()
            self._watch.heard_result(status.goal_id.id, status.status, status.text, stamp_s)
