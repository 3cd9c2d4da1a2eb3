#!/usr/bin/env python3
"""A walk through the simulated cell is one track: reported at once, never lost, with the right velocity.

All times are simulated. The person's way is known from ``tracks_scene.yaml``: two walks, there and back.
"""

from __future__ import annotations

import sys
import threading
import unittest
from pathlib import Path
from typing import Dict, List, Tuple

import numpy as np
import rospy
import rostest
import yaml
from std_msgs.msg import Int8
from yarm.msg import SafetyStatus, TrackedObject, TrackedObjects

from yarm.ros.common import names
from yarm.ros.common.start import init_node

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.participant import Participant

SCENE = yaml.safe_load((Path(__file__).resolve().parent / "tracks_scene.yaml").read_text())
LIMIT_S = 500.0
BORDER_M = 2.5
SPAWN = SCENE["events"][0]["do"]["spawn"]
HALF_M = SPAWN["size"][0] / 2
NEAR_M = 0.35
"""A track whose middle is this near to the person's, seen from above, is the person's."""
REPORTED_S = 0.1
SETTLED_S = 0.5
VELOCITY_MPS = 0.2
PLACE_M = 0.1
LATENCY_S, CLEARANCE_M, UNWATCHED_MPS, WATCHED_S = 0.2, 0.03, 1.6, 1.0
"""Of the safety monitor, config/cell/safety_monitor.yaml."""
LATE_S = 0.15
"""Greatest age of a track when the monitor looks at it, s."""
Sample = Tuple[float, List[TrackedObject]]


class Walk:
    """One way of the person's, from an event of the scene."""

    def __init__(self, event: Dict, start: np.ndarray) -> None:
        """The event that moves it, and where it stands before, x and y."""
        self.start, self.start_s = start, event["when"]["time"]
        way = np.array([event["do"]["dx"], event["do"]["dy"]])
        self.velocity = event["do"]["speed"] * way / np.linalg.norm(way)
        self.end = start + way
        outside_m = abs(start[0]) - BORDER_M - HALF_M
        self.contact_s = self.start_s + outside_m / abs(self.velocity[0])
        self.inside_s = self.contact_s + 2 * HALF_M / abs(self.velocity[0])
        self.leaving_s = self.contact_s + 2 * BORDER_M / abs(self.velocity[0])

    def at(self, time_s: float) -> np.ndarray:
        """Where the person is."""
        return self.start + (time_s - self.start_s) * self.velocity

    def tracks(self, samples: List[Sample]) -> List[Tuple[float, List[TrackedObject]]]:
        """The person's tracks that show, set by set, from the first contact until it begins to leave the volume."""
        found = []
        for time_s, objects in samples:
            if self.contact_s <= time_s < self.leaving_s:
                place = self.at(time_s)
                near = [o for o in objects if np.hypot(o.position.x - place[0], o.position.y - place[1]) < NEAR_M]
                found.append((time_s, [o for o in near if o.last_seen.to_sec() == time_s]))
        return found


class TracksTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        """Take part in the lock-step until both walks are over."""
        out, walk, back = (event for event in SCENE["events"] if "move" in event["do"])
        there = Walk(walk, np.array([SPAWN["x"] + out["do"]["dx"], SPAWN["y"] + out["do"]["dy"]]))
        cls.walks = {"there": there, "back": Walk(back, there.end)}
        cls.samples: List[Sample] = []
        cls.safety: List[SafetyStatus] = []
        over = threading.Event()
        participant = Participant()
        running = rospy.Publisher(names.STATIC_ASSOCIATION_SWITCH, Int8, queue_size=1, latch=True)
        running.publish(Int8(data=1))

        def on_tracks(message: TrackedObjects) -> None:
            cls.samples.append((message.header.stamp.to_sec(), message.objects))
            if cls.samples[-1][0] > cls.walks["back"].leaving_s + 2.0:
                over.set()
            participant.took(message.header.stamp)

        rospy.Subscriber(names.SAFETY_STATUS, SafetyStatus, cls.safety.append, queue_size=1000, tcp_nodelay=True)
        rospy.Subscriber(names.TRACKED_OBJECTS, TrackedObjects, on_tracks, queue_size=1000, tcp_nodelay=True)
        assert over.wait(LIMIT_S), f"the walks were not over within {LIMIT_S:.0f} s of wall time"

    def test_a_walk_has_one_identity_and_the_next_one_another(self) -> None:
        ids = {name: {o.id for _, own in walk.tracks(self.samples) for o in own} for name, walk in self.walks.items()}
        for name, found in ids.items():
            self.assertEqual(len(found), 1, f"{name}: {found}")
        self.assertNotEqual(ids["there"], ids["back"])

    def test_it_is_reported_soon_after_its_first_contact_with_the_volume(self) -> None:
        for name, walk in self.walks.items():
            first_s = next(time_s for time_s, own in walk.tracks(self.samples) if own)
            rospy.loginfo(f"{name}: reported {first_s - walk.contact_s:.3f} s after the first contact")
            self.assertLessEqual(first_s - walk.contact_s, REPORTED_S, name)

    def test_it_is_never_lost(self) -> None:
        for name, walk in self.walks.items():
            seen = [bool(own) for time_s, own in walk.tracks(self.samples) if time_s > walk.inside_s]
            self.assertGreater(len(seen), 60, name)
            lost = [i for i in range(len(seen) - 1) if not seen[i] and not seen[i + 1]]
            self.assertEqual(lost, [], f"{name}: lost for more than one set")

    def test_its_velocity_and_place_are_right(self) -> None:
        for name, walk in self.walks.items():
            off, away = [], []
            for time_s, own in walk.tracks(self.samples):
                if time_s < walk.contact_s + SETTLED_S or not own:
                    continue
                track, place = own[0], walk.at(time_s)
                v = np.array([track.velocity.x, track.velocity.y])
                off.append(float(np.linalg.norm(v - walk.velocity)))
                away.append(float(np.hypot(track.position.x - place[0], track.position.y - place[1])))
            rospy.loginfo(
                f"{name}: velocity off by at most {max(off):.3f} m/s, place by {max(away):.3f} m, {len(off)} sets"
            )
            self.assertLess(max(off), VELOCITY_MPS, name)
            self.assertLess(max(away), PLACE_M, name)

    def test_the_monitor_says_how_far_the_standing_robot_must_be_from_the_person(self) -> None:
        """ISO/TS 15066 with a robot at rest: the person's way while the robot reacts, and a clearance."""
        for name, walk in self.walks.items():
            own = {o.id for _, objects in walk.tracks(self.samples) for o in objects}
            first_s = next(time_s for time_s, objects in walk.tracks(self.samples) if objects)
            words = [w for w in self.safety if first_s + LATE_S < w.header.stamp.to_sec() < walk.leaving_s]
            self.assertGreater(len(words), 60, name)
            self.assertEqual({w.person[0] for w in words}, {f"unknown_{number}" for number in own}, name)
            self.assertTrue(all(0.0 < w.person_m[0] < 2.0 * BORDER_M for w in words), name)
            for word in words:
                watched_s = word.header.stamp.to_sec() - first_s
                low = UNWATCHED_MPS if watched_s < WATCHED_S else float(np.linalg.norm(walk.velocity)) - VELOCITY_MPS
                self.assertGreaterEqual(word.separation_m[0], low * LATENCY_S + CLEARANCE_M, name)
                if watched_s > WATCHED_S + LATE_S:
                    high = float(np.linalg.norm(walk.velocity)) + 3.0 * VELOCITY_MPS
                    self.assertLessEqual(word.separation_m[0], high * (LATENCY_S + LATE_S) + CLEARANCE_M, name)

    def test_nobody_is_left_when_it_has_gone(self) -> None:
        self.assertEqual([o.id for o in self.samples[-1][1]], [])
        self.assertEqual((self.safety[-1].person, self.safety[-1].separation_m), ([""], (0.0,)))

    def test_numbers_are_sane(self) -> None:
        for _, objects in self.samples:
            for tracked in objects:
                covariance = np.array(tracked.covariance).reshape(6, 6)
                self.assertTrue(np.allclose(covariance, covariance.T))
                self.assertGreater(np.linalg.eigvalsh(covariance).min(), 0.0)
                self.assertGreaterEqual(tracked.age_s, 0.0)


if __name__ == "__main__":
    init_node("tracks")
    rostest.rosrun("yarm", "tracks", TracksTest, sys.argv)
