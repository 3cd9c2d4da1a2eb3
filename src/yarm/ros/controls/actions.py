"""Action server of one robot: its goals counted by their senders."""

from __future__ import annotations

from typing import Any, Callable, Dict

import rospy
from actionlib import ServerGoalHandle

from yarm.control.base.controller import Outcome
from yarm.msg import MoveRobotAction, MoveRobotResult
from yarm.ros.common.goal_queue import GoalQueue


class MoveRobotServer(GoalQueue):
    """``<robot>/move_robot``: at most one goal is active; a new one preempts it."""

    def __init__(self, name: str, wake: Callable[[], None]) -> None:
        """Advertise the action; arguments as of the queue."""
        self.received: Dict[str, int] = {}
        self.results = 0
        super().__init__(name, MoveRobotAction, wake)

    def _arrived(self, message: Any) -> None:
        """Count it by its sender."""
        header: Dict[str, str] = getattr(message, "_connection_header", None) or {}
        sender = header.get("callerid", "").rsplit("/", 1)[-1]
        with self.lock:
            self.received[sender] = self.received.get(sender, 0) + 1
        super()._arrived(message)

    def publish_result(self, status: Any, result: Any) -> None:
        """Count it, as usual else."""
        self.results += 1
        super().publish_result(status, result)

    @staticmethod
    def reject(handle: ServerGoalHandle, reason: str) -> None:
        """Refuse a goal."""
        handle.set_rejected(MoveRobotResult(flag=False, message=reason), reason)

    @staticmethod
    def recall(handle: ServerGoalHandle) -> None:
        """Confirm the cancel of a goal that is not being pursued."""
        handle.set_canceled(MoveRobotResult(flag=False, message="cancelled before it was begun"), "cancelled")

    def finish(self, outcome: Outcome, message: str) -> None:
        """End the active goal; nothing happens without one."""
        handle = self.take_active()
        if handle is None:
            return
        result = MoveRobotResult(flag=outcome is Outcome.SUCCEEDED, message=message)
        ends: Dict[Outcome, Callable[[MoveRobotResult, str], None]] = {
            Outcome.SUCCEEDED: handle.set_succeeded,
            Outcome.PREEMPTED: handle.set_canceled,
            Outcome.ABORTED: handle.set_aborted,
        }
        ends[outcome](result, message)

    def forget(self, reason: str) -> None:
        """Abort what is active, refuse what waits, and forget every goal and stamp; connections stay."""
        for event in self.events():
            if not event.cancel:
                self.reject(event.handle, reason)
        self.finish(Outcome.ABORTED, reason)
        with self.lock:
            self.forget_stamps()
            self.received.clear()
            self.results = 0

    def close(self, reason: str) -> None:
        """Abort what is active and withdraw the action."""
        rospy.loginfo("%s withdrawn: %s", self.ns, reason)
        received, results = dict(self.received), self.results
        self.forget(reason)
        self.received, self.results = received, results
        self.stop()
