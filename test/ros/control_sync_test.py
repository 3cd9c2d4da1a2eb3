#!/usr/bin/env python3
"""Controls server and sander repeat exactly in lock-step; this test plays the Commander."""

from __future__ import annotations

import struct
import subprocess
import threading
import time
import unittest
from pathlib import Path
from typing import Dict, List, Optional

import rosnode
import rospy
import rostest
from actionlib_msgs.msg import GoalID
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from yarm.msg import MoveRobotActionGoal, MoveRobotActionResult, StepAck

from yarm.geometry.poses import quaternion_from_rpy
from yarm.ros.common import names
from yarm.ros.common.start import init_node

LAUNCH = Path(__file__).with_name("control_sync_cell.launch")
LOCK_STEP_S = 60.0
SETS = 480
WALL_LIMIT_S = 400.0
ROBOT, ARM = "ankurbot_1", "hc10_barc"


class Mission:
    """One run: goals at fixed camera sets, and what moved at each tick."""

    def __init__(self) -> None:
        self.changed = threading.Condition()
        self.ticks: List[bytes] = []
        self.sets = 0
        self.sent = 0
        self.results: Dict[str, str] = {}
        self.ack = rospy.Publisher(names.STEP_ACK, StepAck, queue_size=100)
        self.goals = {
            r: rospy.Publisher(names.move_robot(r) + "/goal", MoveRobotActionGoal, queue_size=10) for r in (ROBOT, ARM)
        }
        self.cancel = rospy.Publisher(names.move_robot(ROBOT) + "/cancel", GoalID, queue_size=10)
        self.subscribers = [rospy.Subscriber("/tf", TFMessage, self.on_tick, queue_size=1000)]
        self.subscribers += [
            rospy.Subscriber(names.move_robot(r) + "/result", MoveRobotActionResult, self.on_result) for r in self.goals
        ]

    def close(self) -> None:
        for thing in (*self.subscribers, self.ack, self.cancel, *self.goals.values()):
            thing.unregister()

    def ready(self) -> bool:
        return all(p.get_num_connections() > 0 for p in (*self.goals.values(), self.cancel))

    def on_tick(self, message: TFMessage) -> None:
        stamp = message.transforms[0].header.stamp
        begun = stamp.to_sec() > LOCK_STEP_S
        if begun:
            moved = sorted(message.transforms, key=lambda t: t.child_frame_id)
            with self.changed:
                self.ticks.append(b"".join(packed(t) for t in moved))
                self.changed.notify_all()
        if round(stamp.to_sec() * 60.0) % 2 == 0 and (begun or self.ready()):
            if begun:
                self.sets += 1
                self.act()
            self.ack.publish(StepAck(header=Header(stamp=stamp), node="control_sync", commands_sent=self.sent))

    def act(self) -> None:
        if self.sets == 5:
            self.send(ARM, "a", "CALIBRATION")
            self.send(ROBOT, "b", "False", 0.3, 1.2, 2.6)
        elif self.sets == 120:
            self.cancel.publish(GoalID(id="b"))
            self.sent += 1
        elif self.sets == 150:
            self.send(ROBOT, "c", "False", 0.4, 1.5, -2.9)
        elif self.sets == 330:
            self.send(ARM, "d", "ON")

    def send(self, robot: str, key: str, action: str, x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> None:
        goal = MoveRobotActionGoal(goal_id=GoalID(id=key))
        goal.goal.action = action
        position, q = goal.goal.target.position, goal.goal.target.orientation
        position.x, position.y, position.z = x, y, 0.89
        q.x, q.y, q.z, q.w = quaternion_from_rpy(0.0, 0.0, yaw)
        self.goals[robot].publish(goal)
        self.sent += 1

    def on_result(self, message: MoveRobotActionResult) -> None:
        self.results[message.status.goal_id.id] = message.result.message


def packed(transform) -> bytes:
    t, q = transform.transform.translation, transform.transform.rotation
    return transform.child_frame_id.encode() + struct.pack("<7d", t.x, t.y, t.z, q.x, q.y, q.z, q.w)


def run() -> Mission:
    """One mission with fresh nodes."""
    mission = Mission()
    cell: Optional[subprocess.Popen] = subprocess.Popen(["roslaunch", str(LAUNCH)])
    try:
        deadline = time.monotonic() + WALL_LIMIT_S
        with mission.changed:
            while len(mission.ticks) < 2 * SETS:
                assert cell.poll() is None, "the cell has stopped"
                assert time.monotonic() < deadline, f"only {len(mission.ticks)} ticks in {WALL_LIMIT_S} s"
                mission.changed.wait(timeout=1.0)
    finally:
        cell.terminate()
        cell.wait(timeout=60.0)
        mission.close()
        forget_the_dead()
    return mission


def forget_the_dead() -> None:
    """Have the master drop nodes that went without a word: it would end whichever node gets their old port."""
    _, dead = rosnode.rosnode_ping_all()
    rosnode.cleanup_master_blacklist(rospy.get_master().target, dead)


class SyncTest(unittest.TestCase):
    """Same goals, same motion, to the last bit."""

    def test_two_runs_are_the_same(self) -> None:
        first, second = run(), run()
        self.assertEqual(first.results.keys(), {"a", "b", "c", "d"})
        self.assertEqual(first.results, second.results)
        self.assertIn("cancelled", first.results["b"])
        self.assertIn("reached", first.results["c"])
        self.assertGreater(len(set(first.ticks)), SETS)
        differing = [i for i, pair in enumerate(zip(first.ticks[: 2 * SETS], second.ticks)) if pair[0] != pair[1]]
        self.assertEqual(differing[:5], [])


if __name__ == "__main__":
    init_node("control_sync")
    rostest.rosrun("yarm", "control_sync", SyncTest)
