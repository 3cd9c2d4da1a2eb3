"""The Commander's links to the robots: one action client each, counted for lock-step, and the deletion service."""

from __future__ import annotations

import threading
from typing import Callable, Dict, List, Optional

import rospy
from actionlib import ActionClient, ClientGoalHandle, CommState
from actionlib_msgs.msg import GoalStatus

from yarm.commander.events import CancelGoal, DeleteDone, GoalDone, Outcome, SendGoal
from yarm.msg import MoveRobotAction, MoveRobotGoal
from yarm.ros.common import names
from yarm.ros.common.conversions import pose_message
from yarm.srv import SpawnObstacles, SpawnObstaclesRequest

OUTCOMES: Dict[int, Outcome] = {
    GoalStatus.SUCCEEDED: Outcome.SUCCEEDED,
    GoalStatus.PREEMPTED: Outcome.PREEMPTED,
    GoalStatus.ABORTED: Outcome.ABORTED,
    GoalStatus.REJECTED: Outcome.REJECTED,
    GoalStatus.RECALLED: Outcome.RECALLED,
    GoalStatus.LOST: Outcome.LOST,
}
"""Every terminal status; any other counts as LOST."""


class RobotLink:
    """Action client of one robot; results are handed on as GoalDone. Thread-safe."""

    def __init__(self, robot: str, on_done: Callable[[GoalDone], None]) -> None:
        """Connect; goals may be sent once ``connected``."""
        self.robot = robot
        self.sent = 0
        self._on_done = on_done
        self._client = ActionClient(names.move_robot(robot), MoveRobotAction)
        self._handles: Dict[int, ClientGoalHandle] = {}
        self._lock = threading.Lock()

    @property
    def connected(self) -> bool:
        """An action server listens to goals and cancels and publishes its status."""
        client = self._client
        publishers = (client.pub_goal, client.pub_cancel)
        return all(p.get_num_connections() > 0 for p in publishers) and client.status_sub.get_num_connections() > 0

    def send(self, action: SendGoal, height_m: float) -> None:
        """Send a goal for the end effector at its own height, metres."""
        goal = MoveRobotGoal(action=action.action)
        goal.target.orientation.w = 1.0
        if action.target is not None:
            goal.target = pose_message(action.target.x, action.target.y, height_m, action.target.yaw_rad)
        with self._lock:
            self.sent += 1
            handle = self._client.send_goal(goal, transition_cb=lambda h, n=action.serial: self._on_change(n, h))
            self._handles[action.serial] = handle

    def cancel(self, action: CancelGoal) -> None:
        """Cancel a goal; nothing when it has ended."""
        with self._lock:
            handle = self._handles.get(action.serial)
            if handle is not None:
                self.sent += 1
                handle.cancel()

    def close(self) -> None:
        """Forget every goal and disconnect."""
        with self._lock:
            self._handles.clear()
        self._client.stop()

    def _on_change(self, serial: int, handle: ClientGoalHandle) -> None:
        if handle.get_comm_state() != CommState.DONE:
            return
        outcome = OUTCOMES.get(handle.get_terminal_state(), Outcome.LOST)
        result = handle.get_result()
        message = result.message if result is not None else handle.get_goal_status_text()
        if outcome is Outcome.SUCCEEDED and result is not None and not result.flag:
            outcome = Outcome.ABORTED
        threading.Thread(target=self._drop, args=(serial,), daemon=True).start()
        self._on_done(GoalDone(self.robot, serial, outcome, message or ""))

    def _drop(self, serial: int) -> None:
        with self._lock:
            self._handles.pop(serial, None)


class Links:
    """The links to all robots."""

    def __init__(self, on_done: Callable[[GoalDone], None]) -> None:
        """No robots yet."""
        self._on_done = on_done
        self._links: Dict[str, RobotLink] = {}
        self._gone_sent = 0

    def follow(self, robots: List[str]) -> None:
        """Link to these robots, and no others."""
        for robot in [name for name in self._links if name not in robots]:
            link = self._links.pop(robot)
            self._gone_sent += link.sent
            link.close()
        for robot in robots:
            if robot not in self._links:
                self._links[robot] = RobotLink(robot, self._on_done)

    def reset(self) -> None:
        """Start afresh: goals are forgotten, the count begins at 0."""
        robots = list(self._links)
        self.follow([])
        self._gone_sent = 0
        self.follow(robots)

    def get(self, robot: str) -> Optional[RobotLink]:
        """The link to a robot."""
        return self._links.get(robot)

    def connected(self) -> Dict[str, bool]:
        """Which robots have an action server."""
        return {robot: link.connected for robot, link in sorted(self._links.items())}

    @property
    def sent(self) -> int:
        """Goals and cancels sent in this run."""
        return self._gone_sent + sum(link.sent for link in self._links.values())


def delete_object(name: str, on_done: Callable[[DeleteDone], None]) -> threading.Thread:
    """Call ``delete_obstacles`` in a thread of its own; the answer is handed on, and so is silence."""

    def call() -> None:
        service = rospy.ServiceProxy(names.DELETE_OBSTACLES, SpawnObstacles)
        try:
            answer = service(SpawnObstaclesRequest(name=name))
            on_done(DeleteDone(name, answer.success, answer.message))
        except rospy.ServiceException as error:
            on_done(DeleteDone(name, False, f"{names.DELETE_OBSTACLES}: {error}"))

    thread = threading.Thread(target=call, daemon=True)
    thread.start()
    return thread
