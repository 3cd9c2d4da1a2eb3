#!/usr/bin/env python3
"""Lock-step of the simulated cell, with this test as every other node."""

from __future__ import annotations

import hashlib
import math
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path
from typing import Any, Dict, List, Tuple

import rospy
import rostest
from geometry_msgs.msg import Twist
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from yarm.msg import CommanderStatus, MapMetaData, ObjectRegistry, SimStatus, StepAck

from yarm.resources import resource
from yarm.ros.common import names
from yarm.ros.common.start import init_node

WALL_LIMIT_S = 90.0
START_S = 20.0
SETS = 30
PATIENCE_S, IMPATIENCE_S = 60.0, 5.0
"""The lock-step's wait for a participant, where all answer and where one does not, s."""


EVENTS = f"""
name: events
fixtures: [table]
robots:
  - {{name: ankurbot_1, type: ankurbot, x: 2.0, y: 2.0, heading_deg: 180}}
events:
  - {{when: {{time: {START_S + 0.5}}}, do: {{camera: 2, enabled: false}}}}
  - {{when: {{time: {START_S + 1.5}}}, do: {{camera: 2, enabled: true}}}}
  - when: {{state: BOUNDLESS, after: 1.0}}
    do: {{spawn: {{type: Debris, name: late, x: -0.2, y: 0.0, z: 0.755}}}}
  - {{when: {{time: {START_S + 2.0}}}, do: {{delete: late}}}}
"""


class Everyone:
    """Plays controls server and Commander: acknowledges, drives, and hashes what it is shown."""

    def __init__(self, mute_after: int = 10**9, short: bool = False, greets_only: bool = False) -> None:
        """Be silent after so many ticks and before ``waits_for`` are connected; when ``short`` claim one command more.

        With ``greets_only`` just the first tick that is heard is acknowledged.
        """
        self.greets_only = greets_only
        self.changed = threading.Condition()
        self.mute_after, self.short = mute_after, short
        self.sent = 0
        self.poses: List[str] = []
        self.clouds: Dict[int, str] = {}
        self.first_status_s = -1.0
        self.first_heard_s = math.inf
        self.gaps_s: List[float] = []
        self._last_s = -1.0
        self._ack = rospy.Publisher(names.STEP_ACK, StepAck, queue_size=100)
        self._metadata = rospy.Publisher(names.PLANNING_METADATA, MapMetaData, queue_size=100)
        self._drive = rospy.Publisher(names.cmd_vel("ankurbot_1"), Twist, queue_size=100)
        self.waits_for: Tuple[rospy.Publisher, ...] = (self._drive,)
        self._subscribers = [
            rospy.Subscriber("/tf", TFMessage, self.on_tick, queue_size=100),
            rospy.Subscriber(names.SIM_STATUS, SimStatus, self.on_status, queue_size=10),
            rospy.Subscriber(names.camera_points(2), rospy.AnyMsg, self.on_cloud, queue_size=100, buff_size=1 << 24),
        ]

    def close(self) -> None:
        for thing in (*self._subscribers, self._ack, self._metadata, self._drive):
            thing.unregister()

    def on_status(self, message: SimStatus) -> None:
        if self.first_status_s < 0.0:
            self.first_status_s = message.header.stamp.to_sec()

    def on_tick(self, message: TFMessage) -> None:
        stamp = message.transforms[0].header.stamp
        self.first_heard_s = min(self.first_heard_s, time.monotonic())
        if not all(publisher.get_num_connections() for publisher in self.waits_for):
            return
        if self._last_s >= 0.0:
            self.gaps_s.append(stamp.to_sec() - self._last_s)
        self._last_s = stamp.to_sec()
        if stamp.to_sec() >= START_S:
            digest = hashlib.sha256(b"".join(struct.pack("<7d", *_numbers(t)) for t in message.transforms))
            self.poses.append(digest.hexdigest())
            if len(self.poses) > self.mute_after:
                return
            command = Twist()
            command.linear.x = 0.01 * len(self.poses)
            self._drive.publish(command)
            self.sent += 1
        if self.greets_only and self.gaps_s:
            return
        sent = self.sent + int(self.short and self.sent > 9)
        self._ack.publish(StepAck(header=Header(stamp=stamp), node=rospy.get_name(), commands_sent=sent))
        with self.changed:
            self.changed.notify_all()

    def sees_again(self) -> bool:
        """Whether a cloud has come since the scripted end of the camera's darkness."""
        return any(stamp_ns / 1e9 > START_S + 1.5 for stamp_ns in list(self.clouds))

    def on_cloud(self, message: Any) -> None:
        _, secs, nsecs = struct.unpack_from("<III", message._buff)
        stamp = rospy.Time(secs, nsecs)
        if stamp.to_sec() >= START_S:
            self.clouds[stamp.to_nsec()] = hashlib.sha256(message._buff[12:]).hexdigest()
        self._metadata.publish(MapMetaData(header=Header(stamp=stamp)))
        self._ack.publish(StepAck(header=Header(stamp=stamp), node="commander"))


def _numbers(transform: Any) -> Tuple[float, ...]:
    t, q = transform.transform.translation, transform.transform.rotation
    return (t.x, t.y, t.z, q.x, q.y, q.z, q.w)


class SyncTest(unittest.TestCase):
    """Each check starts its own simulation."""

    @property
    def me(self) -> str:
        return rospy.get_name().strip("/")

    def start(self, **params: Any) -> subprocess.Popen:
        values = {
            "scene": "single",
            "sync": True,
            "sync_start": START_S,
            "real_time_factor": 0.0,
            "sync_timeout": PATIENCE_S,
            "tick_participants": [self.me, "hc10_state_machine"],
            "set_participants": ["commander"],
            **params,
        }
        rospy.set_param("/simulation", values)
        command = [sys.executable, str(resource("scripts", "simulation"))]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.addCleanup(process.wait, WALL_LIMIT_S)
        self.addCleanup(process.terminate)
        return process

    def run_sets(self) -> Tuple[List[str], List[str]]:
        everyone = Everyone()
        process = self.start()
        limit = time.monotonic() + WALL_LIMIT_S
        with everyone.changed:
            while len(everyone.poses) < 2 * SETS + 4:
                self.assertIsNone(process.poll(), "the simulation ended")
                self.assertLess(time.monotonic(), limit, f"only {len(everyone.poses)} ticks came")
                everyone.changed.wait(1.0)
        process.terminate()
        process.wait(WALL_LIMIT_S)
        everyone.close()
        self.assertEqual(everyone.first_status_s, START_S, "sim/status says when the cell is live, and not before")
        self.assertLess(max(everyone.gaps_s), 0.41, "no clock of another node sees an interruption")
        stamps = sorted(everyone.clouds)[:SETS]
        return everyone.poses[: 2 * SETS], [everyone.clouds[stamp] for stamp in stamps]

    def test_a_two_runs_are_the_same_byte_for_byte(self) -> None:
        poses, clouds = self.run_sets()
        again_poses, again_clouds = self.run_sets()
        self.assertEqual(poses, again_poses)
        self.assertEqual(clouds, again_clouds)
        self.assertGreater(len(set(poses)), SETS, "the robot moves")
        self.assertEqual(len(set(clouds)), SETS, "every cloud has its own noise")

    def ending(self, everyone: Everyone, process: subprocess.Popen) -> str:
        output, _ = process.communicate(timeout=WALL_LIMIT_S)
        everyone.close()
        self.assertEqual(process.returncode, 1)
        return output

    def test_b_a_silent_participant_is_named(self) -> None:
        everyone = Everyone(mute_after=7)
        output = self.ending(everyone, self.start(sync_timeout=IMPATIENCE_S))
        self.assertEqual(len(everyone.poses), 8, "time stands still")
        self.assertIn(f"{self.me} has not acknowledged", output)

    def test_c_commands_said_to_be_sent_are_waited_for(self) -> None:
        output = self.ending(*self.pair(short=True, sync_timeout=IMPATIENCE_S))
        self.assertIn(f"{self.me} says it sent", output)

    def test_d_a_participant_that_never_comes_is_named(self) -> None:
        everyone, process = self.pair(tick_participants=[self.me, "sander"], sync_start=2.0)
        output = self.ending(everyone, process)
        self.assertRegex(output, "lock-step cannot start: nothing heard from .*sander")
        waited_s = time.monotonic() - everyone.first_heard_s
        self.assertGreater(waited_s, 6.0, "a slow machine has longer to start everybody than simulated time says")

    def test_d_a_participant_that_only_greets_is_named(self) -> None:
        everyone = Everyone(greets_only=True)
        output = self.ending(everyone, self.start(sync_start=3.0))
        self.assertRegex(output, f"lock-step cannot start: nothing heard from {self.me}.* after 3 s")

    def test_e_scripted_events_happen_at_their_times(self) -> None:
        scene = Path(tempfile.mkdtemp(prefix="yarm_test_")) / "events.yaml"
        scene.write_text(EVENTS, encoding="utf-8")
        everyone = Everyone()
        seen: List[Tuple[float, List[str]]] = []
        registry = rospy.Subscriber(
            names.OBJECT_REGISTRY,
            ObjectRegistry,
            lambda m: seen.append((m.header.stamp.to_sec(), [e.name for e in m.entries])),
            queue_size=100,
        )
        state = rospy.Publisher(names.COMMANDER_STATUS, CommanderStatus, queue_size=1, latch=True)
        state.publish(CommanderStatus(state_name="BOUNDLESS"))
        everyone.waits_for += (state,)
        process = self.start(scene=str(scene), wait_for_metadata=False, set_participants=[])
        limit = time.monotonic() + WALL_LIMIT_S
        while not (seen and seen[-1][0] >= START_S + 2.0 and "late" not in seen[-1][1] and everyone.sees_again()):
            self.assertIsNone(process.poll(), "the simulation ended")
            self.assertLess(time.monotonic(), limit, f"only these came: {seen}")
            rospy.rostime.wallsleep(0.05)
        registry.unregister()
        state.unregister()
        clouds = sorted(stamp / 1e9 - START_S for stamp in everyone.clouds)
        everyone.close()
        present = [(round(stamp - START_S, 1), "late" in entries) for stamp, entries in seen if stamp > START_S]
        self.assertEqual([there for _, there in present], [True, False])
        self.assertEqual([at for at, _ in present], [1.0, 2.0])
        self.assertTrue(any(at < 0.5 for at in clouds))
        self.assertFalse(any(0.55 < at < 1.5 for at in clouds), "camera 2 is off")
        self.assertTrue(any(at > 1.5 for at in clouds))

    def pair(self, short: bool = False, **params: Any) -> Tuple[Everyone, subprocess.Popen]:
        everyone = Everyone(short=short)
        return everyone, self.start(**params)


if __name__ == "__main__":
    init_node("simulation_sync_test")
    rostest.rosrun("yarm", "simulation_sync", SyncTest)
