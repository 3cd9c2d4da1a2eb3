"""Sends goals past the Commander, as the tests of what watches over the robots do."""

from __future__ import annotations

import time

import rospy
from actionlib import SimpleActionClient
from actionlib_msgs.msg import GoalStatus
from yarm.msg import MoveRobotGoal, Permission

from yarm.ros.common import names

PERMISSION_LIMIT_S = 60.0
STANDS = "stands: "
"""How every objection of the dead-man's switch begins."""


def send_when_permitted(client: SimpleActionClient, goal: MoveRobotGoal, limit_s: float) -> int:
    """Send a goal, again with each word of the Commander's while the dead-man's switch refuses it; give its end.

    Only the server knows when motion is permitted to it: the words that permit it reach a test earlier or later.

    Args:
        client: of a robot whose server is there.
        goal: what to send.
        limit_s: simulated seconds an accepted goal may take; then it is cancelled.

    Returns:
        one of actionlib_msgs/GoalStatus.

    Raises:
        AssertionError: still not permitted after ``PERMISSION_LIMIT_S`` of wall time.
    """
    deadline = time.monotonic() + PERMISSION_LIMIT_S
    while True:
        state: int = client.send_goal_and_wait(goal, rospy.Duration(limit_s), rospy.Duration(5.0))
        why = client.get_goal_status_text()
        if state != GoalStatus.REJECTED or not why.startswith(STANDS):
            return state
        left_s = deadline - time.monotonic()
        assert left_s > 0.0, f"no permission to move within {PERMISSION_LIMIT_S:g} s: {why}"
        rospy.wait_for_message(names.PERMISSION, Permission, timeout=left_s)
