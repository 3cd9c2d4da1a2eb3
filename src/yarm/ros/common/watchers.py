"""The dead-man's switch of whatever moves: listens to the safety monitor and to the Commander (docs/commander.md)."""

from __future__ import annotations

import threading

import rospy

from yarm.msg import Permission, SafetyStatus
from yarm.ros.common import names
from yarm.safety.heartbeat import DeadMansSwitch
from yarm.safety.params import GuardParams


class Watchers:
    """Says whether the safety monitor and the Commander let a node move what it moves. Thread-safe."""

    def __init__(self, params: GuardParams, lock_step: bool) -> None:
        """Subscribe; a person's stop counts whoever else is to be heard.

        Args:
            params: who must be heard, and how often.
            lock_step: the simulation itself waits for both with every camera set: without them no time passes.
        """
        ages_s = {names.SAFETY_NODE: params.monitor_age_s, names.COMMANDER_NODE: params.commander_age_s}
        self._lock = threading.Lock()
        self._switch = DeadMansSwitch(ages_s if params.guarded and not lock_step else {})
        self._subscribers = [
            rospy.Subscriber(names.SAFETY_STATUS, SafetyStatus, self._on_monitor, queue_size=10, tcp_nodelay=True)
        ]
        if params.guarded and not lock_step:
            self._subscribers.append(
                rospy.Subscriber(names.PERMISSION, Permission, self._on_commander, queue_size=10, tcp_nodelay=True)
            )

    def objection(self, now_s: float) -> str:
        """Why nothing may move at a simulated time, s, and what to do; empty when it may."""
        with self._lock:
            return self._switch.objection(now_s)

    def reset(self) -> None:
        """Simulated time went backwards."""
        with self._lock:
            self._switch.reset()

    def _on_monitor(self, message: SafetyStatus) -> None:
        with self._lock:
            self._switch.stop((message.reason or "no reason given") if message.latched else "")
        self._hear(names.SAFETY_NODE, message.header.stamp.to_sec(), "")

    def _on_commander(self, message: Permission) -> None:
        refusal = "" if message.granted else message.reason or "no reason given"
        self._hear(names.COMMANDER_NODE, message.header.stamp.to_sec(), refusal)

    def _hear(self, watcher: str, stamp_s: float, refusal: str) -> None:
        now_s = rospy.get_time()
        with self._lock:
            taken = self._switch.hear(watcher, stamp_s, now_s, refusal)
        if not taken:
            rospy.logwarn_throttle(
                5.0, f"heartbeat of {watcher} refused: its stamp {stamp_s:.3f} s is in the future of {now_s:.3f} s"
            )
