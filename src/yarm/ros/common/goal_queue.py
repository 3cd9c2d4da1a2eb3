"""Action servers whose goals and cancels are queued, and worked on by the node's own loop.

actionlib's own timer dies when simulated time goes backwards and its callbacks come under its lock; here the loop
publishes the status and the callbacks only put things into a queue.
"""

from __future__ import annotations

import queue
from dataclasses import dataclass
from typing import Any, Callable, List, Optional

import rospy
from actionlib import ActionServer, ServerGoalHandle

from yarm.ros.common.checks import Doorkeeper, stamp_fault

STATUS_PERIOD_S = 0.2
MOST_EARLY = 50
"""Cancels kept whose goals have not come."""


@dataclass(frozen=True)
class GoalEvent:
    """A new goal, or the wish to cancel one."""

    handle: ServerGoalHandle
    cancel: bool


class GoalQueue(ActionServer):  # type: ignore[misc]
    """An action of which at most one goal is active."""

    status_list: List[Any]
    """actionlib's own: how every goal stands, and cancels whose goals have not come."""

    def __init__(self, name: str, action: Any, wake: Callable[[], None]) -> None:
        """Advertise the action.

        Args:
            name: relative name of the action.
            action: class of its messages.
            wake: called when a goal or cancel has come; must take no lock that a caller of this class holds.
        """
        self._wake = wake
        self._cancels = Doorkeeper(f"{name}/cancel")
        super().__init__(name, action, self._on_goal, self._on_cancel, auto_start=False)
        self._events: queue.SimpleQueue[GoalEvent] = queue.SimpleQueue()
        self._active: Optional[ServerGoalHandle] = None
        self._status_s = -1.0
        self.start()
        if self.status_timer is not None:
            self.status_timer.shutdown()

    def internal_goal_callback(self, goal: Any) -> None:
        """Take a goal in, then as usual."""
        super().internal_goal_callback(goal)
        self._arrived(goal)

    def internal_cancel_callback(self, goal_id: Any) -> None:
        """Take a cancel in, then as usual; one stamped in the future would cancel every goal until then.

        actionlib keeps each cancel whose goal it does not know, should that come late, and complains of all of those
        with each further cancel; here they are left aside, and at most ``MOST_EARLY`` others are kept.
        """
        if self._cancels.refuses(goal_id, stamp_fault(goal_id.stamp.to_sec(), rospy.get_time())):
            return
        with self.lock:
            others = [st for st in self.status_list if st.goal is None and st.status.goal_id.id != goal_id.id]
            self.status_list = [st for st in self.status_list if st.goal is not None]
            super().internal_cancel_callback(goal_id)
            self.status_list += others[-MOST_EARLY:]
        self._arrived(goal_id)

    def _arrived(self, message: Any) -> None:
        """A goal or cancel is in the queue."""
        self._wake()

    def _on_goal(self, handle: ServerGoalHandle) -> None:
        self._events.put(GoalEvent(handle, False))

    def _on_cancel(self, handle: ServerGoalHandle) -> None:
        self._events.put(GoalEvent(handle, True))

    def events(self) -> List[GoalEvent]:
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

    def goal(self) -> Any:
        """The active goal; None without one."""
        return None if self._active is None else self._active.get_goal()

    def take_active(self) -> Optional[ServerGoalHandle]:
        """The active goal's handle, which is to be ended now; none is active afterwards."""
        handle, self._active = self._active, None
        return handle

    def feedback(self, feedback: Any) -> None:
        """Send feedback on the active goal."""
        if self._active is not None:
            self._active.publish_feedback(feedback)

    def keep_alive(self, now_s: float) -> None:
        """Publish the status list a few times a second of simulated time."""
        if now_s < self._status_s or now_s - self._status_s >= STATUS_PERIOD_S:
            self._status_s = now_s
            self.publish_status()

    def forget_stamps(self) -> None:
        """Say a last time how all goals stand, and forget them; connections stay."""
        with self.lock:
            self.publish_status()
            self.status_list.clear()
            self.last_cancel = rospy.Time()
            self._status_s = -1.0
