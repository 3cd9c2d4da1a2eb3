"""The action ``move_base``: goals with their reasons as texts of the results."""

from __future__ import annotations

from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

import rospy
from actionlib import ServerGoalHandle
from geometry_msgs.msg import PoseStamped
from move_base_msgs.msg import MoveBaseAction, MoveBaseFeedback, MoveBaseResult

from yarm.geometry import Pose2
from yarm.navigation.move_base import Status
from yarm.ros.common import names
from yarm.ros.common.checks import pose_fault
from yarm.ros.common.conversions import pose2_of_pose
from yarm.ros.common.goal_queue import GoalEvent, GoalQueue
from yarm.ros.navigation.outputs import stamped_pose

InMap = Callable[[str], Optional[Pose2]]
"""Pose of a frame in the map; None when it is not known there."""


def goal_in_map(goal: PoseStamped, map_frame: str, in_map: InMap) -> Tuple[Optional[Pose2], str]:
    """A goal's pose in the map, or why it cannot be one."""
    fault = pose_fault(goal.pose)
    if fault:
        return None, f"goal refused: {fault}"
    frame = goal.header.frame_id.lstrip("/")
    if not frame:
        return None, f"goal refused: it has no frame; give {map_frame} or one that transforms lead to"
    pose = pose2_of_pose(goal.pose)
    if frame == map_frame:
        return pose, ""
    placed = in_map(frame)
    if placed is None:
        return None, f"goal refused: no transform leads from {map_frame} to its frame {frame!r}"
    return placed.compose(pose), ""


def due_goals(events: Sequence[GoalEvent], now_s: float) -> Tuple[List[GoalEvent], List[GoalEvent]]:
    """Those events that count at a pass of the lock-step, and those that wait for the next, each in their order.

    A goal counts from the pass after its stamp on: within the pass it is sent in it may come early or late. What comes
    after a goal that waits, waits too.
    """
    for i, event in enumerate(events):
        if not event.cancel and event.handle.get_goal_id().stamp.to_sec() > now_s - 1e-6:
            return list(events[:i]), list(events[i:])
    return list(events), []


class GoalServer(GoalQueue):
    """``move_base``: at most one goal is active; a new one preempts it."""

    def __init__(self, wake: Callable[[], None]) -> None:
        """Advertise the action."""
        super().__init__(names.MOVE_BASE, MoveBaseAction, wake)

    @staticmethod
    def refuse(handle: ServerGoalHandle, reason: str) -> None:
        """End a goal that was never driven to."""
        handle.set_accepted()
        handle.set_aborted(MoveBaseResult(), reason)

    @staticmethod
    def recall(handle: ServerGoalHandle, reason: str) -> None:
        """Confirm the cancel of a goal that is not being pursued."""
        handle.set_canceled(MoveBaseResult(), reason)

    def finish(self, status: Status, reason: str) -> None:
        """End the active goal; IDLE: it was cancelled. Nothing happens without one."""
        handle = self.take_active()
        if handle is None:
            return
        ends: Dict[Status, Callable[[Any, str], None]] = {
            Status.SUCCEEDED: handle.set_succeeded,
            Status.ABORTED: handle.set_aborted,
            Status.IDLE: handle.set_canceled,
        }
        ends[status](MoveBaseResult(), reason)

    def place(self, pose: Pose2, frame: str, stamp: rospy.Time) -> None:
        """Feedback: where the robot is."""
        self.feedback(MoveBaseFeedback(base_position=stamped_pose(pose, frame, stamp)))

    def forget(self, reason: str) -> None:
        """End everything, and forget every goal and stamp; connections stay."""
        for event in self.events():
            if not event.cancel:
                self.refuse(event.handle, reason)
        self.finish(Status.ABORTED, reason)
        self.forget_stamps()
