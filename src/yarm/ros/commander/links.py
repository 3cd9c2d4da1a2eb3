"""The Commander's links to the robots: one action client each, counted for lock-step, and the deletion service."""

from __future__ import annotations

import threading
from typing import Callable, Dict, List, Optional

import rospy
from actionlib import ActionClient, ClientGoalHandle, CommState
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from geometry_msgs.msg import Point

from yarm.commander.events import CancelGoal, DeleteDone, DeleteObject, GoalDone, Outcome, SendGoal
from yarm.msg import MoveRobotAction, MoveRobotActionResult, MoveRobotGoal
from yarm.ros.common import names
from yarm.ros.common.conversions import pose_message
from yarm.srv import SpawnObstacles, SpawnObstaclesRequest

LIVE = (GoalStatus.PENDING, GoalStatus.ACTIVE, GoalStatus.PREEMPTING, GoalStatus.RECALLING)
"""Every status of a goal that has not ended."""
SILENT_S = 2.0
"""An action server that has not said how its goals stand for so long has gone, or hangs, s."""
ASK_AGAIN_S = 1.0
"""Time after which a server is asked once more to end what was sent before, s."""
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
    """Action client of one robot; results are handed on as GoalDone. Thread-safe.

    Whatever was sent to the robot before the connection, by a Commander that is no more, is cancelled first; in
    lock-step, where none is started again, nothing was.
    """

    def __init__(
        self,
        robot: str,
        on_done: Callable[[GoalDone], None],
        lock_step: bool = False,
        on_result: Callable[[], None] = lambda: None,
    ) -> None:
        """Connect; goals may be sent once ``connected``. Every result is told, whosever, once it was handed on."""
        self.robot = robot
        self.sent = 0
        self._on_done = on_done
        self._lock_step = lock_step
        self._swept = lock_step
        self._asked: Optional[rospy.Time] = None
        self._heard = rospy.Time()
        self._client = ActionClient(names.move_robot(robot), MoveRobotAction)
        self._handles: Dict[int, ClientGoalHandle] = {}
        self._lock = threading.Lock()
        self._status = rospy.Subscriber(
            f"{names.move_robot(robot)}/status", GoalStatusArray, self._on_status, queue_size=10
        )
        self._results = rospy.Subscriber(
            f"{names.move_robot(robot)}/result", MoveRobotActionResult, lambda _: on_result(), queue_size=100
        )

    @property
    def connected(self) -> bool:
        """An action server listens to goals and cancels, and says that nothing of before is left and that it lives."""
        client = self._client
        publishers = (client.pub_goal, client.pub_cancel)
        linked = all(p.get_num_connections() > 0 for p in publishers) and client.status_sub.get_num_connections() > 0
        if self._lock_step:
            return linked
        with self._lock:
            silent = self._swept and (rospy.Time.now() - self._heard).to_sec() > SILENT_S
            if not linked or silent:
                self._swept, self._asked = False, None
            elif not self._swept:
                self._sweep()
            return linked and self._swept

    def _sweep(self) -> None:
        """Cancel everything up to now; what is sent later has a later stamp, and stays."""
        now = rospy.Time.now()
        if self._asked is None or abs((now - self._asked).to_sec()) > ASK_AGAIN_S:
            self._asked = now
            self._client.pub_cancel.publish(GoalID(stamp=now))

    def _on_status(self, message: GoalStatusArray) -> None:
        with self._lock:
            self._heard = max(self._heard, message.header.stamp)
            if self._asked is not None and message.header.stamp > self._asked and not self._swept:
                self._swept = all(status.status not in LIVE for status in message.status_list)

    def send(self, action: SendGoal, height_m: float) -> None:
        """Send a goal for the end effector at its own height, metres."""
        goal = MoveRobotGoal(action=action.action)
        goal.target.orientation.w = 1.0
        if action.target is not None:
            goal.target = pose_message(action.target.x, action.target.y, height_m, action.target.yaw_rad)
        goal.keep_off.points = [Point(x, y, 0.0) for x, y in action.keep_off.places]
        goal.keep_off.distance = action.keep_off.distance_m
        goal.via = [pose_message(pose.x, pose.y, height_m, pose.yaw_rad) for pose in action.via]
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
        self._status.unregister()
        self._results.unregister()
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

    def __init__(
        self,
        on_done: Callable[[GoalDone], None],
        lock_step: bool = False,
        on_result: Callable[[], None] = lambda: None,
    ) -> None:
        """No robots yet."""
        self._on_result = on_result
        self._on_done = on_done
        self._lock_step = lock_step
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
                self._links[robot] = RobotLink(robot, self._on_done, self._lock_step, self._on_result)

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


def delete_object(deletion: DeleteObject, on_done: Callable[[DeleteDone], None]) -> threading.Thread:
    """Call ``delete_obstacles`` in a thread of its own; the answer is handed on, and so is silence."""
    name = deletion.name

    def call() -> None:
        service = rospy.ServiceProxy(names.DELETE_OBSTACLES, SpawnObstacles)
        try:
            x, y, z = deletion.place_m
            answer = service(SpawnObstaclesRequest(name=name, x=x, y=y, z=z))
            on_done(DeleteDone(name, answer.success, answer.message))
        except rospy.ServiceException as error:
            on_done(DeleteDone(name, False, f"{names.DELETE_OBSTACLES}: {error}"))

    thread = threading.Thread(target=call, daemon=True)
    thread.start()
    return thread
