#!/usr/bin/env python3
"""A cell whose registry does not come from the simulation: what is there is told, and a mission ends well.

The simulator plays the hardware: clouds, frames of cameras, robots and arm, nothing else. This test plays the person:
sees what lies on the part, names it, and takes it away when it was reached.
"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from yarm.msg import CommanderStatus, ObjectRegistry
from yarm.srv import SpawnObstacles, SpawnObstaclesRequest

from yarm.ros.common import names
from yarm.ros.common.conversions import MapSubscriber
from yarm.ros.common.start import init_node

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.commander_driver import CommanderDriver

ROBOT, ARM, PIECE = "ankurbot_1", "hc10_barc", "debris_1"
PART_M = (-0.5, 0.0, -0.35, 0.35)
"""The part, x from, to, y from, to, metres, as a person sees it."""
PART_TOP_M = 0.7
RESULTS = Path(os.environ["ROS_HOME"]) / "real_cell"


class RealCellTest(CommanderDriver):
    """The tests build on each other, in the order of their names."""

    LIMIT_S = 400.0

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        shutil.rmtree(RESULTS, ignore_errors=True)
        cls.present, cls.seen, cls.said, cls.reached = {}, set(), set(), set()
        rospy.Subscriber(names.OBJECT_REGISTRY, ObjectRegistry, cls.on_registry, queue_size=10)
        rospy.Subscriber(names.DIAGNOSTICS, DiagnosticArray, cls.on_diagnostics, queue_size=100)
        cls.map = MapSubscriber()
        cls.take_away = rospy.ServiceProxy("hardware/delete_obstacles", SpawnObstacles)

    @classmethod
    def on_registry(cls, message):
        with cls.condition:
            cls.sender = message._connection_header["callerid"]
            cls.present = {entry.name: entry for entry in message.entries}
            cls.condition.notify_all()

    @classmethod
    def on_diagnostics(cls, message):
        with cls.condition:
            cls.said |= {s.message for s in message.status if s.name == "cell_registry: the cell"}
            cls.condition.notify_all()

    @classmethod
    def on_status(cls, message):
        super().on_status(message)
        cls.reached |= {task.goal for task in message.tasks if task.status == "reached"}

    def lying(self):
        """Where something that nobody named lies on the part: middle of its cells, or nothing."""
        cell_map = self.map.newest()
        for thing in cell_map.objects.values() if cell_map else ():
            if thing.name.startswith("unknown"):
                x, y, z = (cell_map.spec.lower + (thing.cells + 0.5) * cell_map.spec.resolution).mean(axis=0)
                if PART_M[0] < x < PART_M[1] and PART_M[2] < y < PART_M[3] and z > PART_TOP_M:
                    return float(x), float(y)
        return None

    def test_1_what_is_there_is_told(self):
        self.wait(lambda: {"table", "stand", ARM, ROBOT} <= set(self.present), "the cell in the registry")
        self.assertEqual(self.sender, "/cell_registry")
        self.assertEqual(set(self.present), {"table", "stand", ARM, ROBOT})
        self.assertEqual(len(self.present["table"].shapes), len(self.present["table"].shape_frames))
        self.assertTrue(self.present["table"].shapes)

    def test_2_what_cannot_be_is_refused(self):
        for fields, expected in (
            ({"name": "table", "type": "Target"}, "name 'table' is taken"),
            ({"name": "a", "type": "Unregistered"}, "only a simulation"),
            ({"name": "a", "type": "Debris", "x": 9.0}, "x 9.0 must be within"),
        ):
            answer = self.spawn(SpawnObstaclesRequest(**fields))
            self.assertFalse(answer.success)
            self.assertIn(expected, answer.message)
        answer = self.delete(SpawnObstaclesRequest(name=ROBOT))
        self.assertFalse(answer.success)
        self.assertIn("with drivers stays", answer.message)

    def test_3_mission(self):
        self.enter(CommanderStatus.STARTED, current_state=True)
        self.enter(CommanderStatus.CALIBRATION, next_state=True)
        self.ended()
        self.enter(CommanderStatus.MENU, next_state=True)
        self.wait(self.lying, "something on the part")
        x, y = self.lying()
        answer = self.spawn(SpawnObstaclesRequest(name=PIECE, type="Debris", x=x + 0.03, y=y - 0.03, z=0.72))
        self.assertTrue(answer.success, answer.message)
        self.wait(lambda: PIECE in self.present, "the piece in the registry")
        self.begin_mission()
        self.wait(
            lambda: PIECE in self.reached and PIECE not in self.present, "the piece reached, and no longer told of"
        )
        self.assertTrue(self.take_away(SpawnObstaclesRequest(name=PIECE)).success)
        self.ended()

    def test_4_the_mission_has_left_a_proof_sheet(self):
        """Of a piece that no scene file knows, with what a cell without a simulator's truth can say."""
        self.wait(lambda: list(RESULTS.glob("by_hand/1m1ma/*/proof.html")), "the proof sheet")
        (sheet,) = RESULTS.glob("by_hand/1m1ma/*/proof.html")
        text = sheet.read_text(encoding="utf-8")
        self.assertRegex(text, f"Debris {PIECE}: reached")
        self.assertRegex(text, "hash of all decisions</td><td>[0-9a-f]{64}<")

    def test_5_a_piece_that_is_not_there_is_named(self):
        self.assertTrue(self.spawn(SpawnObstaclesRequest(name="ghost", type="Debris", x=2.0, y=-2.0, z=0.5)).success)
        self.wait(lambda: any("ghost was named, but nothing is seen of it" in s for s in self.said), "a word about it")
        self.assertTrue(self.delete(SpawnObstaclesRequest(name="ghost")).success)
        self.wait(lambda: "ghost" not in self.present, "it to be gone")


if __name__ == "__main__":
    init_node("real_cell_test")
    rostest.rosrun("yarm", "real_cell", RealCellTest, sys.argv)
