#!/usr/bin/env python3
"""The gate in lock-step: what it says unasked is counted, nothing before there is anything to stop; a person's stop."""

from __future__ import annotations

import sys
import time
from functools import partial
from pathlib import Path

import rospy
import rostest
from geometry_msgs.msg import Twist
from rosgraph_msgs.msg import Clock
from std_srvs.srv import SetBool
from yarm.msg import InspectionStatus, SafetyStatus, StepAck

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.listening import ListeningTest
from yarm.ros.common import names
from yarm.ros.common.start import init_node

INPUT = f"{names.GATE_NODE}/input"
REPEATS = 10
"""So often the held first moment is said."""


class VelocityGateTest(ListeningTest):
    limit_s = 60.0

    @classmethod
    def setUpClass(cls) -> None:
        cls.clock = rospy.Publisher("/clock", Clock, queue_size=10, tcp_nodelay=True)
        cls.lease = rospy.Publisher(names.inspector("status"), InspectionStatus, queue_size=10, tcp_nodelay=True)
        cls.wanted = rospy.Publisher(INPUT, Twist, queue_size=10, tcp_nodelay=True)
        cls.listen((names.STEP_ACK, StepAck), (names.BASE_VELOCITY, Twist), (names.SAFETY_STATUS, SafetyStatus))
        rospy.wait_for_service(names.SAFETY_STOP, cls.limit_s)
        cls.stop = staticmethod(rospy.ServiceProxy(names.SAFETY_STOP, SetBool))

    def tick(self, at_s: float) -> int:
        """A moment of the clock, said until it is answered; how many words the gate says it has said unasked."""
        stamp = rospy.Time.from_sec(at_s)
        before = len(self.kept[names.STEP_ACK])

        def answered() -> bool:
            return any(ack.header.stamp == stamp for ack in list(self.kept[names.STEP_ACK])[before:])

        end = time.monotonic() + self.limit_s
        while not answered():
            self.assertLess(time.monotonic(), end, f"no answer at {at_s:.2f} s")
            self.clock.publish(Clock(stamp))
            with self.changed:
                self.changed.wait(0.2)
        return int(self.kept[names.STEP_ACK][-1].commands_sent)

    def grant(self, at_s: float) -> None:
        """The inspector lives."""
        message = InspectionStatus()
        message.header.stamp = rospy.Time.from_sec(at_s)
        self.lease.publish(message)

    def begin(self) -> None:
        """The held first moment of a run: the clock stands, the inspector is heard of in the middle of it."""
        for i in range(REPEATS):
            self.assertEqual(self.tick(1.0), 0)
            if i == REPEATS // 2:
                self.grant(1.0)

    def turn(self, rate_radps: float) -> int:
        """A command, until the gate lets it through; how many were answered."""
        message, heard = Twist(), self.kept[names.BASE_VELOCITY]
        message.angular.z = rate_radps
        before, end = len(heard), time.monotonic() + self.limit_s
        while not heard[before:] or heard[-1].angular.z != rate_radps:
            self.assertLess(time.monotonic(), end, "the gate lets nothing through")
            count = len(heard)
            self.grant(1.1)
            self.wanted.publish(message)
            self.wait(partial(self.more_than, count), "an answer to a command")
        return len(heard) - before

    def more_than(self, count: int) -> bool:
        """Whether the base has heard more commands."""
        return len(self.kept[names.BASE_VELOCITY]) > count

    def run_of(self, heard_before: int) -> None:
        """A run: silence, a command, and zeros when no other follows, each of them counted."""
        heard = self.kept[names.BASE_VELOCITY]
        self.begin()
        self.assertEqual(len(heard), heard_before)
        self.assertEqual(self.tick(1.1), 0)
        answered = self.turn(0.6)
        own = [self.tick(1.0 + 0.1 * i) for i in range(2, 20)][-1]
        self.assertGreaterEqual(own, 2)
        self.wait(lambda: len(heard) == heard_before + answered + own, f"{own} zeros")
        self.assertEqual(heard[-1].angular.z, 0.0)

    def test_it_counts_what_it_says_from_the_first_command_on_in_every_run(self) -> None:
        self.run_of(0)
        self.run_of(len(self.kept[names.BASE_VELOCITY]))

    def test_on_a_persons_word_it_stops_at_once_and_passes_nothing_until_the_release(self) -> None:
        heard, said = self.kept[names.BASE_VELOCITY], self.kept[names.SAFETY_STATUS]
        self.begin()
        self.turn(0.6)
        before, own = len(heard), self.tick(1.1)
        answer = self.stop(True)
        self.assertTrue(answer.success)
        self.assertIn("stopped by /gate_counts", answer.message)
        self.wait(lambda: said and said[-1].latched, "the gate's word about the stop")
        self.assertEqual((said[-1].reason, list(said[-1].stopped)), (answer.message, [True]))
        self.wait(lambda: len(heard) > before, "a zero for the base, unasked")
        self.assertGreater(self.tick(1.1), own, "what it says for a stop is counted")
        message = Twist()
        message.angular.z = 0.5
        for _ in range(REPEATS):
            count = len(heard)
            self.grant(1.1)
            self.wanted.publish(message)
            self.wait(partial(self.more_than, count), "an answer to a command")
        self.assertEqual({word.angular.z for word in heard[before:]}, {0.0})
        self.assertTrue(self.stop(False).success)
        self.wait(lambda: not said[-1].latched, "the gate's word about the release")
        self.turn(0.4)


if __name__ == "__main__":
    init_node("gate_counts")
    rostest.rosrun("yarm", "velocity_gate", VelocityGateTest, sys.argv)
