#!/usr/bin/env python3
"""Two manipulators in one scene: each has its own sander, area and supervision."""

from __future__ import annotations

import sys
import threading
import time
import unittest
from typing import Callable, Dict, List

import rospy
import rostest
from visualization_msgs.msg import Marker
from yarm.msg import (
    CommanderStatus,
    Contacts,
    MoveRobotActionResult,
    ObjectRegistry,
    SanderStatus,
    SimStatus,
)
from yarm.srv import StateChange

from yarm.control.sander.states import SanderState
from yarm.ros.common import names
from yarm.ros.common.start import init_node
from yarm.ros.common.status_age import STALE_S, silence

FIRST, SECOND = "hc10_barc", "hc10_barc_2"
AREAS = {FIRST: "SPACE=SWITCH/AREA=1,19,28,43,0,10", SECOND: "SPACE=SWITCH/AREA=30,48,6,21,0,10"}
PARTS = {FIRST: (-1.25, 1.10), SECOND: (1.25, -1.10)}
HALF_PART_M = (0.20, 0.30)
SANDED_ON = 0.05
"""Share of its raster that the second arm must do while the first one is paused."""
WALL_LIMIT_S = 800.0


class TwoArmsTest(unittest.TestCase):
    """From IDLE to both sanding, then the debris of the scene falls beside the first arm's tool."""

    def setUp(self) -> None:
        self.deadline = time.monotonic() + WALL_LIMIT_S
        self.condition = threading.Condition()
        self.status = CommanderStatus()
        self.sander: Dict[str, List[SanderStatus]] = {FIRST: [], SECOND: []}
        self.answers: Dict[str, str] = {}
        self.rasters: Dict[str, Marker] = {}
        self.present: Dict[str, str] = {}
        self.failures: List[str] = []
        for arm in (FIRST, SECOND):
            self.follow(names.sander_status(arm), SanderStatus, self.sander[arm].append)
            self.follow(names.sander_raster(arm), Marker, lambda m, arm=arm: self.rasters.__setitem__(arm, m))
            result = f"{names.move_robot(arm)}/result"
            self.follow(result, MoveRobotActionResult, lambda m, arm=arm: self.on_result(arm, m))
        self.follow(names.COMMANDER_STATUS, CommanderStatus, lambda m: setattr(self, "status", m))
        self.follow(names.OBJECT_REGISTRY, ObjectRegistry, self.on_registry)
        self.follow(names.SIM_CONTACTS, Contacts, self.on_contacts)
        rospy.wait_for_service(names.COMMANDER_STATE, timeout=120.0)
        self.service = rospy.ServiceProxy(names.COMMANDER_STATE, StateChange)

    def follow(self, topic: str, kind: type, note: Callable[[object], object]) -> None:
        def on_message(message: object) -> None:
            with self.condition:
                note(message)
                self.condition.notify_all()

        rospy.Subscriber(topic, kind, on_message, queue_size=1000)

    def on_result(self, arm: str, message: MoveRobotActionResult) -> None:
        if message.result.message.startswith("SPACE="):
            self.answers[arm] = message.result.message

    def on_registry(self, message: ObjectRegistry) -> None:
        self.present = {entry.name: entry.object for entry in message.entries}

    def on_contacts(self, message: Contacts) -> None:
        self.failures += [
            f"{c.body_a} {c.link_a} / {c.body_b} {c.link_b}" for c in message.contacts if c.kind == "failure"
        ]

    def wait(self, condition: Callable[[], bool], what: str) -> None:
        with self.condition:
            while not condition():
                left = self.deadline - time.monotonic()
                self.assertGreater(left, 0.0, f"waited for {what}; status: {self.status}; {self.newest()}")
                self.assertFalse(rospy.is_shutdown(), f"shut down while waiting for {what}")
                self.condition.wait(min(left, 1.0))

    def newest(self) -> Dict[str, str]:
        return {arm: str(heard[-1:]) for arm, heard in self.sander.items()}

    def ask(self, state: int, **fields: object) -> None:
        none = {"next_state": False, "current_state": False, "previous_state": False, "jump_state": 0}
        answer = self.service(**{**none, **fields})
        self.assertTrue(answer.success, answer.message)
        self.wait(
            lambda: not silence(self.status, rospy.get_time(), STALE_S) and self.status.state == state, f"state {state}"
        )

    def sands(self, arm: str) -> bool:
        heard = self.sander[arm][-1]
        return heard.state == int(SanderState.SCAN_TO_PATH) and heard.enabled and heard.progress > 0.0

    def test_debris_near_one_pauses_that_one_alone(self) -> None:
        rospy.wait_for_message(names.SIM_STATUS, SimStatus, timeout=120.0)  # the lock-step has begun
        self.wait(lambda: bool(self.present), "object_registry")
        arms = {name for name, kind in self.present.items() if kind == "Manipulator"}
        self.assertEqual(arms, {FIRST, SECOND})
        fixtures = {"table", "stand", f"{SECOND}_table", f"{SECOND}_stand"}
        self.assertEqual({name for name, kind in self.present.items() if kind == "Obstacle"}, fixtures)

        self.ask(CommanderStatus.STARTED, current_state=True)
        self.ask(CommanderStatus.CALIBRATION, next_state=True)
        self.wait(lambda: not self.status.busy and bool(self.status.outcome), "the calibration")
        self.assertEqual(self.status.outcome, "succeeded", self.status)
        self.wait(lambda: set(self.answers) == set(AREAS), "the answers of both arms")
        self.assertEqual(self.answers, AREAS)

        self.wait(lambda: self.sands(FIRST) and self.sands(SECOND), "both to sand")
        self.wait(lambda: set(self.rasters) == {FIRST, SECOND}, "both rasters")
        for arm, (x, y) in PARTS.items():
            for point in self.rasters[arm].points:
                self.assertLess(abs(point.x - x), HALF_PART_M[0], f"{arm}'s raster at {point}")
                self.assertLess(abs(point.y - y), HALF_PART_M[1], f"{arm}'s raster at {point}")

        self.wait(lambda: "debris_1" in self.present, "the debris on the first part")
        self.wait(lambda: not self.sander[FIRST][-1].enabled, "the first arm's pause")
        with self.condition:
            mark, paused_at = len(self.sander[SECOND]) - 1, self.sander[FIRST][-1].progress
            begun_at = self.sander[SECOND][mark].progress
        self.wait(lambda: self.sander[SECOND][-1].progress > begun_at + SANDED_ON, "the second arm to sand on")
        with self.condition:
            self.assertTrue(all(heard.enabled for heard in self.sander[SECOND][mark:]), "the second arm paused, too")
            self.assertFalse(self.sander[FIRST][-1].enabled)
            self.assertLess(self.sander[FIRST][-1].progress - paused_at, 0.02)
            self.assertEqual(self.failures, [], "contacts by ground truth")


if __name__ == "__main__":
    init_node("two_arms_test")
    rostest.rosrun("yarm", "two_arms_test", TwoArmsTest, sys.argv)
