#!/usr/bin/env python3
"""Node explorer and the gate behind it: a run, its services, sick sensors, a mapping that dies, the deadline."""

from __future__ import annotations

import os
import signal
import sys
import time
import unittest
from pathlib import Path

import rospy
import rostest
from rosgraph_msgs.msg import Log
from std_msgs.msg import Bool

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.explored_room import LIMIT_S, ExploredRoom
from yarm.exploration.deadline import SETTLE_S
from yarm.geometry import Pose2
from yarm.navigation.map_file import read_map
from yarm.ros.common.graph import node_pids
from yarm.ros.common.start import init_node
from yarm.sim.scenes.arena import Arena, Block

HALF_M = 2.0
THICK_M = 0.05


def wall(name, x, y, along_x, along_y):
    return Block(name, "wall", Pose2(x, y), (along_x, along_y, 0.6))


EDGE_M = HALF_M + THICK_M / 2
ROOM = Arena(
    "small",
    "custom",
    3,
    (-HALF_M, -HALF_M),
    (HALF_M, HALF_M),
    (
        wall("south", 0.0, -EDGE_M, 2 * EDGE_M, THICK_M),
        wall("north", 0.0, EDGE_M, 2 * EDGE_M, THICK_M),
        wall("west", -EDGE_M, 0.0, THICK_M, 2 * EDGE_M),
        wall("east", EDGE_M, 0.0, THICK_M, 2 * EDGE_M),
        wall("middle", 0.9, 0.9, 0.8, THICK_M),
    ),
    Pose2(-1.0, -0.5),
)
MAP = Path(os.environ.get("ROS_HOME", "/tmp")) / "explored" / "map.yaml"


class ExplorerTest(unittest.TestCase):
    room: ExploredRoom
    killed = 0
    """Process of the explorer that was killed."""

    @classmethod
    def setUpClass(cls):
        cls.room = ExploredRoom(ROOM, 3)
        cls.room.connect()

    def start(self):
        """A run of its own: the room as at first, and time begins again."""
        room = self.room
        room.renew(now_s=10.0 if room.status is None else 5.0)
        self.assertTrue(room.run(5.0, until=lambda: room.state() == "idle"), room.state())
        room.run(1.5)
        answer = room.ask("start")
        self.assertTrue(answer.success, answer.message)
        self.assertTrue(room.run(5.0, until=lambda: room.state() == "exploring"), room.status)

    def test_1_it_waits_for_the_start_and_names_what_it_waits_for(self):
        room = self.room
        room.run(2.0, pose=False)
        self.assertEqual((room.state(), room.status.moving), ("idle", False))
        self.assertIn("waits for ~start", room.status.reason)
        self.assertTrue(any("pose: not known yet" in text for text in room.status.sensors), room.status.sensors)
        self.assertFalse(room.ask("pause").success)
        self.assertEqual({command[1:] for command in room.told}, {(0.0, 0.0)})

    def test_2_it_explores_pauses_resumes_and_stops_with_the_map_on_disk(self):
        room = self.room
        self.start()
        room.run(12.0)
        self.assertGreater(room.status.travelled, 0.5)
        self.assertLess(room.believed().distance(room.map_from_world.compose(room.world.truth)), 0.05)
        self.assertTrue(room.ask("pause").success)
        room.run(1.0)
        rested = room.world.truth
        room.run(2.0)
        self.assertEqual((room.state(), room.world.truth), ("paused", rested))
        resume = rospy.Publisher("explore/resume", Bool, queue_size=1)
        while resume.get_num_connections() == 0:
            room.tick()
        resume.publish(Bool(True))
        self.assertTrue(room.run(20.0, until=lambda: room.state() == "exploring"))
        room.run(3.0)
        self.assertTrue(room.ask("stop").success)
        room.run(1.0)
        self.assertEqual((room.state(), room.status.reason), ("done", "stopped on request"))
        room.run_on("a saved map", lambda: room.status.saved != "")
        saved = read_map(Path(room.status.saved))
        self.assertAlmostEqual(saved.known_m2, room.status.known_m2, delta=0.5)
        self.assertEqual(Path(room.status.saved), MAP)

    def test_3_a_lost_scan_stops_it_within_half_a_second_and_it_goes_on(self):
        room = self.room
        self.start()
        room.run(3.0)
        lost_s = room.now_s
        self.assertTrue(room.run(1.0, until=lambda: room.told[-1][1:] == (0.0, 0.0), scan=False))
        self.assertLessEqual(room.now_s - lost_s, 0.5)
        room.run(1.0, scan=False)
        self.assertIn("scan: none newer than", room.status.reason)
        self.assertIn(f"since {lost_s:.1f} s; look at the camera", room.status.reason)
        self.assertTrue(room.run(2.0, until=lambda: room.status.reason == ""), room.status.reason)
        self.assertTrue(room.run(30.0, until=lambda: room.told[-1][1:] != (0.0, 0.0)))

    def test_3b_what_cannot_be_used_is_left_out_and_named_and_the_run_goes_on(self):
        room, said = self.room, []
        log = rospy.Subscriber("/rosout", Log, lambda entry: said.append(entry.msg), queue_size=1000)
        self.start()
        room.run(3.0)
        began, bumps = len(room.statuses), room.status.bumps
        for messages in room.nonsense():
            self.say_until_refused(messages, said)
        log.unregister()
        room.tick()
        self.assertEqual(room.status.bumps, bumps)
        room.run(5.0)
        self.assertEqual({status.state for status in room.statuses[began:]}, {"exploring"})
        self.assertEqual([text for status in room.statuses[began:] for text in status.sensors], [])
        self.assertLess(room.believed().distance(room.map_from_world.compose(room.world.truth)), 0.05)

    def say_until_refused(self, messages, said):
        """While time stands still: every message again and again until the log has named each."""
        left, end = dict(messages), time.monotonic() + LIMIT_S
        while left:
            self.assertLess(time.monotonic(), end, f"never named: {[wrong for _, _, wrong in left.values()]}")
            for publisher, message, _ in left.values():
                publisher.publish(message)
            time.sleep(0.1)
            told = list(said)
            left = {
                topic: given
                for topic, given in left.items()
                if not any(text.startswith(f"{topic} of ") and given[2] in text for text in told)
            }

    def test_4_a_mapping_that_dies_and_begins_anew_elsewhere(self):
        room = self.room
        self.start()
        room.run(15.0)
        known_m2 = room.status.known_m2
        room.run(1.0, pose=False)
        self.assertEqual(room.told[-1][1:], (0.0, 0.0))
        self.assertIn("pose: lost", room.status.reason)
        room.mapping_anew(room.world.truth.inverse())
        room.run(2.0)
        self.assertLess(room.status.known_m2, 0.8 * known_m2)
        good = MAP.with_name("map_last_good.yaml")
        room.run_on("the last good map", good.exists)
        self.assertAlmostEqual(read_map(good).known_m2, known_m2, delta=0.5)
        self.assertTrue(room.run(30.0, until=lambda: room.told[-1][1:] != (0.0, 0.0)), room.status.reason)

    def test_5_it_rests_at_the_deadline(self):
        room = self.room
        self.start()
        started_s, before = room.status.started.to_sec(), len(room.told)
        room.run(60.5)
        last_s = max(at_s for at_s, v, w in room.told[before:] if (v, w) != (0.0, 0.0))
        self.assertLessEqual(last_s, started_s + 60.0 - SETTLE_S)
        self.assertEqual((room.state(), room.status.reason), ("done", "the time is over"))
        self.assertFalse(room.ask("start").success)

    def test_6_a_killed_explorer_means_zero_at_once_and_past_the_deadline(self):
        room = self.room
        self.start()
        self.assertTrue(room.run(5.0, until=lambda: room.told[-1][1:] != (0.0, 0.0)))
        deadline_s, before = room.status.deadline.to_sec(), len(room.told)
        self.kill()
        killed_s = room.now_s
        room.run(0.6, alive=False)
        moving = [at_s for at_s, v, w in room.told[before:] if (v, w) != (0.0, 0.0)]
        self.assertLessEqual(max(moving, default=killed_s) - killed_s, 0.5)
        self.assert_rests(deadline_s + 5.0)

    def test_6b_killed_just_before_the_deadline_it_rests_from_the_deadline_on(self):
        room = self.room
        self.next_explorer()
        self.start()
        deadline_s = room.status.deadline.to_sec()
        room.run(deadline_s - 0.9 - room.now_s)
        self.assertNotEqual(room.told[-1][1:], (0.0, 0.0), "it is to be killed while it drives")
        self.kill()
        room.run(0.9, alive=False)
        self.assertAlmostEqual(room.now_s, deadline_s)
        self.assert_rests(deadline_s + 5.0)

    def kill(self):
        """End the explorer as a crash would."""
        type(self).killed = node_pids()["/explorer"]
        os.kill(self.killed, signal.SIGKILL)

    def next_explorer(self):
        """Wait for the one that is started in place of the killed one."""
        self.room.run_on(
            "the next explorer", lambda: node_pids().get("/explorer", 0) not in (0, self.killed), alive=False
        )

    def assert_rests(self, until_s):
        """Pass by pass from now on the robot stays where it is, and the gate goes on saying zero."""
        room, rested, before = self.room, self.room.world.truth, len(self.room.told)
        while room.now_s < until_s:
            room.tick(alive=False)
            self.assertEqual(room.world.truth, rested, f"at {room.now_s:.1f} s")
        said = room.told[before:]
        self.assertEqual({command[1:] for command in said}, {(0.0, 0.0)})
        self.assertLessEqual(until_s - said[-1][0], 1.0, "the gate goes on saying zero")

    def test_7_told_to_end_it_saves_the_map_first(self):
        room = self.room
        for asked in (signal.SIGINT, signal.SIGTERM):
            self.next_explorer()
            self.start()
            room.run(3.0)
            room.run_on("the map in it", lambda: room.status.known_m2 > 1.0)
            MAP.unlink(missing_ok=True)
            type(self).killed = node_pids()["/explorer"]
            os.kill(self.killed, asked)
            room.run_on("a map saved at the end", MAP.exists, alive=False)


if __name__ == "__main__":
    init_node("explorer_test")
    rostest.rosrun("yarm", "explorer_runs", ExplorerTest)
