"""Action server of one robot: goals and cancels are queued, and worked on by the node's tick.

actionlib's own timer dies when simulated time goes backwards and its callbacks come under its lock; here the tick
publishes the status and the callbacks only put things into a queue.
"""

from __future__ import annotations

import queue
from dataclasses import dataclass
from typing import Callable, Dict, List, Optional

import rospy
from actionlib import ActionServer, ServerGoalHandle
from actionlib_msgs.msg import GoalID

from yarm.control.base_controller import Outcome
from yarm.msg import MoveRobotAction, MoveRobotActionGoal, MoveRobotFeedback, MoveRobotGoal, MoveRobotResult

STATUS_PERIOD_S = 0.2


@dataclass(frozen=True)
class Event:
    """A new goal, or the wish to cancel one."""

    handle: ServerGoalHandle
    cancel: bool


class MoveRobotServer(ActionServer):
    """``<robot>/move_robot``: at most one goal is active; a new one preempts it."""

    def __init__(self, name: str, wake: Callable[[], None]) -> None:
        """Advertise the action.

        Args:
            name: relative name of the action.
            wake: called when a goal or cancel has come; must take no lock that a caller of this class holds.
        """
        self._wake = wake
        super().__init__(name, MoveRobotAction, self._on_goal, self._on_cancel, auto_start=False)
        self._events: queue.SimpleQueue[Event] = queue.SimpleQueue()
        self._active: Optional[ServerGoalHandle] = None
        self._status_s = -1.0
        self.received: Dict[str, int] = {}
        self.start()
        if self.status_timer is not None:
            self.status_timer.shutdown()

    def internal_goal_callback(self, goal: MoveRobotActionGoal) -> None:
        """Count the goal by its sender, then as usual."""
        super().internal_goal_callback(goal)
        self._count(goal)

    def internal_cancel_callback(self, goal_id: GoalID) -> None:
        """Count the cancel by its sender, then as usual."""
        super().internal_cancel_callback(goal_id)
        self._count(goal_id)

    def _count(self, message: object) -> None:
        header: Dict[str, str] = getattr(message, "_connection_header", None) or {}
        sender = header.get("callerid", "").rsplit("/", 1)[-1]
        with self.lock:
            self.received[sender] = self.received.get(sender, 0) + 1
        self._wake()

    def _on_goal(self, handle: ServerGoalHandle) -> None:
        self._events.put(Event(handle, False))

    def _on_cancel(self, handle: ServerGoalHandle) -> None:
        self._events.put(Event(handle, True))

    def events(self) -> List[Event]:
        """Everything that has come since the last call, in order."""
        found = []
        while not self._events.empty():
            found.append(self._events.get_nowait())
        return found

    def is_active(self, handle: ServerGoalHandle) -> bool:
        """Whether a goal is the one being pursued."""
        return self._active is not None and self._active == handle

    def accept(self, handle: ServerGoalHandle) -> None:
        """Make a goal the active one."""
        handle.set_accepted()
        self._active = handle

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
        handle, self._active = self._active, None
        if handle is None:
            return
        result = MoveRobotResult(flag=outcome is Outcome.SUCCEEDED, message=message)
        ends: Dict[Outcome, Callable[[MoveRobotResult, str], None]] = {
            Outcome.SUCCEEDED: handle.set_succeeded,
            Outcome.PREEMPTED: handle.set_canceled,
            Outcome.ABORTED: handle.set_aborted,
        }
        ends[outcome](result, message)

    def goal(self) -> Optional[MoveRobotGoal]:
        """The active goal."""
        return None if self._active is None else self._active.get_goal()

    def feedback(self, feedback: MoveRobotFeedback) -> None:
        """Send feedback on the active goal."""
        if self._active is not None:
            self._active.publish_feedback(feedback)

    def keep_alive(self, now_s: float) -> None:
        """Publish the status list a few times a second of simulated time."""
        if now_s < self._status_s or now_s - self._status_s >= STATUS_PERIOD_S:
            self._status_s = now_s
            self.publish_status()

    def forget(self, reason: str) -> None:
        """Abort what is active, refuse what waits, and forget every goal and stamp; connections stay."""
        for event in self.events():
            if not event.cancel:
                self.reject(event.handle, reason)
        self.finish(Outcome.ABORTED, reason)
        with self.lock:
            self.publish_status()
            self.status_list.clear()
            self.last_cancel = rospy.Time()
            self.received.clear()
            self._status_s = -1.0

    def close(self, reason: str) -> None:
        """Abort what is active and withdraw the action."""
        rospy.loginfo("%s withdrawn: %s", self.ns, reason)
        received = dict(self.received)
        self.forget(reason)
        self.received = received
        self.stop()
