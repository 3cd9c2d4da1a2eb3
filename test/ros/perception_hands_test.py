#!/usr/bin/env python3
"""The word of a robot's hand reaches the map: what it holds is the robot's, what it lets go is debris in the next set.

The golden recording is played, with a robot told to have its tip over the piece of debris in it.
"""

from __future__ import annotations

import sys
import unittest
from dataclasses import replace
from pathlib import Path

import rostest
from tf2_msgs.msg import TFMessage

from yarm.ros.common.start import init_node

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from perception_player import Listener, Player

from support import golden
from yarm.ros.common import names
from yarm.ros.common.conversions import parse_map_metadata

SPACES = ("nodelets", "standalone")
ROBOT, PIECE = "ankurbot_1", "debris_9"
TIP_OVER_M = 0.14
HOLDS = {4: True, 6: False, 8: True}
"""What the hand says before each of these sets; the piece is there from set 3 on."""


def with_tip_over(golden_set: golden.GoldenSet) -> golden.GoldenSet:
    """A set in which the robot's tip is told to be over the piece, as soon as that is there."""
    frames = golden.from_bytes(TFMessage, golden_set.frames)
    by_name = {transform.child_frame_id: transform.transform for transform in frames.transforms}
    if PIECE not in by_name:
        return golden_set
    piece, tip = by_name[PIECE].translation, by_name[names.ee_frame(ROBOT)].translation
    tip.x, tip.y, tip.z = piece.x, piece.y, piece.z + TIP_OVER_M
    return replace(golden_set, frames=golden.to_bytes(frames))


def tell_hand(number: int, listener: Listener) -> None:
    """What the hand says before a set, if anything."""
    if number in HOLDS:
        listener.tell_hand(ROBOT, HOLDS[number])


class PerceptionHandsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        recording = golden.load()
        cls.recording = replace(recording, sets=tuple(with_tip_over(s) for s in recording.sets))
        played = Player(cls.recording, SPACES).play(tell_hand)
        maps = [[parse_map_metadata(golden.to_bytes(m)) for m in messages] for messages in played]
        cls.found = dict(zip(SPACES, maps))

    def test_it_is_carried_exactly_while_the_hand_says_so(self):
        held = {4, 5, 8, 9}
        for space, maps in self.found.items():
            self.assertEqual(len(maps), 10)
            for number, cell_map in enumerate(maps[3:], start=3):
                piece = cell_map.objects[PIECE]
                with self.subTest(space=space, set=number):
                    self.assertEqual(piece.carried is not None, number in held)
                    self.assertEqual(len(piece.cells) == 0, number in held)
                    self.assertEqual(piece.piece is None, number in held)

    def test_its_cells_are_then_the_robots(self):
        for maps in self.found.values():
            free, carried = maps[3], maps[4]
            robot = set(map(tuple, carried.objects[ROBOT].cells.tolist()))
            piece = set(map(tuple, free.objects[PIECE].cells.tolist()))
            self.assertTrue(piece)
            self.assertLessEqual(piece, robot)
            self.assertFalse(piece & set(map(tuple, free.objects[ROBOT].cells.tolist())))
            self.assertEqual(carried.objects[PIECE].carried.robot, ROBOT)
            self.assertAlmostEqual(carried.objects[PIECE].carried.position_m[2], -TIP_OVER_M, places=6)


if __name__ == "__main__":
    init_node("perception_hands_test")
    rostest.rosrun("yarm", "perception_hands_test", PerceptionHandsTest, sys.argv)
