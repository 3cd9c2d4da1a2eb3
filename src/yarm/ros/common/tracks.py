"""What perception follows and nobody registered, from ``tracked_objects``."""

from __future__ import annotations

import math
import threading
from collections import deque
from typing import Deque, Tuple

import numpy as np
import rospy

from yarm.msg import TrackedObject, TrackedObjects
from yarm.ros.common import names
from yarm.ros.common.checks import Doorkeeper, present_s, tracks_fault
from yarm.ros.common.clock import SAME_STAMP_S
from yarm.safety.people import Tracked, sigma_of

HIDDEN_S = 1.0
"""Who has not shown for longer is not waited for: where it may be grows without end."""
KEPT = 8


class TrackSubscriber:
    """The newest words on what is followed; faulty ones are left out, their sender named. Thread-safe."""

    def __init__(self, lock_step: bool) -> None:
        """Subscribe; in lock-step words count from the next map on: whether they come before their own is chance."""
        self._lock_step = lock_step
        self._lock = threading.Lock()
        self._kept: Deque[Tuple[float, Tuple[Tracked, ...]]] = deque(maxlen=KEPT)
        self._door = Doorkeeper(names.TRACKED_OBJECTS)
        self._subscriber = rospy.Subscriber(
            names.TRACKED_OBJECTS, TrackedObjects, self._on_message, queue_size=10, tcp_nodelay=True
        )

    def _on_message(self, message: TrackedObjects) -> None:
        if self._door.refuses(message, tracks_fault(message, present_s(self._lock_step))):
            return
        stamp_s = message.header.stamp.to_sec()
        shown = [one for one in message.objects if stamp_s - one.last_seen.to_sec() <= HIDDEN_S]
        with self._lock:
            self._kept.append((stamp_s, tuple(_tracked(one, stamp_s) for one in shown)))

    def newest(self, map_s: float) -> Tuple[Tracked, ...]:
        """What is followed.

        Args:
            map_s: stamp of the newest map; in lock-step only what is older counts.
        """
        before_s = map_s - SAME_STAMP_S if self._lock_step else math.inf
        with self._lock:
            return next((tracks for stamp_s, tracks in reversed(self._kept) if stamp_s < before_s), ())

    def clear(self) -> None:
        """Forget everything (clock gone backwards)."""
        with self._lock:
            self._kept.clear()


def _tracked(one: TrackedObject, stamp_s: float) -> Tracked:
    covariance = np.array(one.covariance).reshape(6, 6)
    return Tracked(
        int(one.id),
        (one.position.x, one.position.y, one.position.z),
        (one.velocity.x, one.velocity.y),
        (one.extent.x, one.extent.y, one.extent.z),
        sigma_of(covariance[:2, :2]),
        sigma_of(covariance[3:5, 3:5]),
        float(one.age_s),
        stamp_s,
    )
