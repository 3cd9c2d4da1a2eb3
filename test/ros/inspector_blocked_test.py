#!/usr/bin/env python3
"""A viewpoint is blocked by what nobody knows: the robot backs off, and the round ends with all boxes, at home."""

from __future__ import annotations

import sys
from pathlib import Path

import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from move_base_msgs.msg import MoveBaseActionGoal, MoveBaseActionResult
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from std_srvs.srv import Trigger
from yarm.msg import Contacts, InspectionStatus, TagVerdict

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.links import linked
from support.listening import ListeningTest
from yarm.inspection.model import Stage
from yarm.resources import resource
from yarm.ros.common import names
from yarm.ros.common.conversions import pose2_of_pose
from yarm.ros.common.start import init_node
from yarm.sim.scenes.layout_file import find_layout

LAYOUT = find_layout(str(resource("test", "ros", "inspector_blocked.yaml")))
KNOWN = 4
"""Boxes that are to be visited; the fifth stands in the way."""
NAMED = {TagVerdict.BLANK: 0, **{number: number for number in range(1, 16)}}
STATUS, TRUTH, CONTACTS = names.inspector("status"), names.SIM_POSE, names.SIM_CONTACTS
GOAL, RESULT = names.move_base("goal"), names.move_base("result")
ENDS = (Stage.DONE, Stage.FAILED)
SAID, BACKED_OFF = "/rosout", "recovers (backed off)"
LEAST_BACK_M, BACKING_S = 0.2, 5.0
"""Backing off is 0.4 m long, and takes less than that; it ends early where the map has something behind."""


class InspectorBlockedTest(ListeningTest):
    """The round begins when the test hears everything; what is asserted is asserted of the whole history."""

    limit_s = 800.0

    @classmethod
    def setUpClass(cls) -> None:
        cls.listen()
        kinds = {STATUS: InspectionStatus, TRUTH: Odometry, CONTACTS: Contacts}
        kinds[SAID] = Log
        for topic, kind in {**kinds, GOAL: MoveBaseActionGoal, RESULT: MoveBaseActionResult}.items():
            cls.keep(topic, kind, most=100000)
        cls.start = rospy.ServiceProxy(names.inspector("start"), Trigger)
        cls.start.wait_for_service(cls.limit_s)

    def test_the_round_ends_with_every_box_although_a_view_is_blocked(self) -> None:
        me = rospy.get_name().strip("/")
        heard = (("inspector", STATUS), ("inspector", GOAL), ("move_base", RESULT), ("room_simulation", TRUTH))
        for sender, topic in (*heard, ("room_simulation", CONTACTS)):
            self.ask(lambda sender=sender, topic=topic: linked(sender, topic, me), f"{topic} of {sender}")
        self.assertTrue(self.start().success)
        end = self.wait(lambda: next((s for s in self.kept[STATUS] if s.stage in ENDS), None), "the end of the round")
        self.assertEqual((end.stage, end.reason), (Stage.DONE, ""))
        self.assertEqual(sorted(verdict.box for verdict in end.verdicts), list(range(1, KNOWN + 1)))
        for verdict in end.verdicts:
            if verdict.tag == TagVerdict.NONE:
                self.assertTrue(verdict.reason, verdict.box)
            else:
                self.assertEqual(NAMED[verdict.tag], LAYOUT.tags[verdict.box - 1], verdict)
        self.assertGreaterEqual(sum(verdict.tag != TagVerdict.NONE for verdict in end.verdicts), KNOWN - 1)
        self.assert_a_goal_was_blocked()
        self.assert_it_backed_off()
        truth = self.wait(
            lambda: next((m for m in self.kept[TRUTH] if m.header.stamp >= end.header.stamp), None),
            "the place at the end",
        )
        self.assertLess(pose2_of_pose(truth.pose.pose).distance(LAYOUT.start), 0.10)
        touches = [c for message in self.kept[CONTACTS] for c in message.contacts if c.kind == "failure"]
        self.assertEqual([f"{c.body_a}-{c.body_b}" for c in touches], [])

    def assert_a_goal_was_blocked(self) -> None:
        """Some goal where the fifth box stands was given up or taken back, and every other one reached."""
        goals = {g.goal_id.id: pose2_of_pose(g.goal.target_pose.pose) for g in self.kept[GOAL]}
        ended = {r.status.goal_id.id: r.status for r in self.kept[RESULT] if r.status.goal_id.id in goals}
        failed = [name for name, status in ended.items() if status.status != GoalStatus.SUCCEEDED]
        self.assertTrue(failed, [status.text for status in ended.values()])
        for name in failed:
            self.assertLess(goals[name].distance(LAYOUT.boxes[KNOWN].pose), 0.6, ended[name].text)

    def assert_it_backed_off(self) -> None:
        """It has said so, and by the truth it has then left its place."""
        said = self.wait(
            lambda: next((said for said in self.kept[SAID] if BACKED_OFF in said.msg), None),
            f"a move_base that {BACKED_OFF}",
        )
        since = [m for m in self.kept[TRUTH] if 0.0 <= (m.header.stamp - said.header.stamp).to_sec() <= BACKING_S]
        places = [pose2_of_pose(message.pose.pose) for message in since]
        self.assertGreater(max(place.distance(places[0]) for place in places), LEAST_BACK_M, places[::25])


if __name__ == "__main__":
    init_node("inspector_blocked_test")
    rostest.rosrun("yarm", "inspector_blocked", InspectorBlockedTest, sys.argv)
