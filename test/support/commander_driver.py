"""Drives the Commander in a rostest: asks for its states, follows its status and what touches what."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
import unittest
import xmlrpc.client
from contextlib import contextmanager
from typing import Any, Callable, Iterator, List, Set, Tuple

import psutil
import rospy
from yarm.msg import CommanderStatus, Contacts
from yarm.srv import SpawnObstacles, StateChange, StateChangeRequest, StateChangeResponse

from yarm.ros.common import names
from yarm.ros.common.status_age import STALE_S, silence


class CommanderDriver(unittest.TestCase):
    """Base of a rostest's cases; they share one set of subscribers and fail after a contact that none may have."""

    LIMIT_S = 180.0
    """Greatest wall time of a wait unless it says otherwise, s."""
    condition: threading.Condition
    status: CommanderStatus
    reasons: Set[str]
    was_busy: bool
    failures: List[str]

    @classmethod
    def setUpClass(cls) -> None:
        """Subscribe, and wait for the services."""
        cls.condition = threading.Condition()
        cls.status, cls.reasons, cls.was_busy, cls.failures = CommanderStatus(), set(), False, []
        rospy.Subscriber(names.COMMANDER_STATUS, CommanderStatus, cls.on_status, queue_size=100)
        rospy.Subscriber(names.SIM_CONTACTS, Contacts, cls.on_contacts, queue_size=1000)
        for service in (names.COMMANDER_STATE, names.SPAWN_OBSTACLES, names.DELETE_OBSTACLES):
            rospy.wait_for_service(service, timeout=cls.LIMIT_S)
        cls.change = rospy.ServiceProxy(names.COMMANDER_STATE, StateChange)
        cls.spawn = rospy.ServiceProxy(names.SPAWN_OBSTACLES, SpawnObstacles)
        cls.delete = rospy.ServiceProxy(names.DELETE_OBSTACLES, SpawnObstacles)

    @classmethod
    def on_status(cls, message: CommanderStatus) -> None:
        """Keep it, and every reason it has given since the last request."""
        with cls.condition:
            cls.status = message
            cls.was_busy |= message.busy
            cls.reasons |= {message.reason} | {task.reason for task in message.tasks}
            cls.condition.notify_all()

    @classmethod
    def on_contacts(cls, message: Contacts) -> None:
        """Keep what must never touch."""
        with cls.condition:
            cls.failures += [f"{c.body_a} {c.link_a} / {c.body_b}" for c in message.contacts if c.kind == "failure"]

    def tearDown(self) -> None:
        """Nothing has touched that must not."""
        with self.condition:
            self.assertEqual(self.failures, [])

    def told(self) -> str:
        """What a wait that ends in vain shows."""
        return f"{self.status}; reasons: {self.reasons}"

    def wait(self, ready: Callable[[], Any], what: str, limit_s: float = 0.0) -> None:
        """Until something is so, at most ``limit_s`` of wall time (0: ``LIMIT_S``)."""
        limit_s = limit_s or self.LIMIT_S
        deadline = time.monotonic() + limit_s
        with self.condition:
            while not ready():
                left = deadline - time.monotonic()
                self.assertGreater(left, 0.0, f"no {what} within {limit_s} s: {self.told()}")
                self.condition.wait(min(left, 0.5))

    def ask(self, **fields: Any) -> StateChangeResponse:
        """The answer to a request; reasons given before it are forgotten, and that there was work."""
        with self.condition:
            self.reasons.clear()
            type(self).was_busy = False
        return self.change(StateChangeRequest(**fields))

    def says(self, condition: Callable[[CommanderStatus], bool]) -> Callable[[], bool]:
        """Whether the Commander says so now: what it said too long ago, and is latched, does not count."""
        return lambda: not silence(self.status, rospy.get_time(), STALE_S) and condition(self.status)

    def enter(self, state: int, **fields: Any) -> None:
        """Ask for a state and wait until it is there."""
        answer = self.ask(**fields)
        self.assertTrue(answer.success, answer.message)
        self.wait(self.says(lambda status: status.state == state), f"state {state}")

    def begin_mission(self) -> None:
        """BOUNDLESS and at work, from whatever state without work allows it."""
        again = self.status.state == CommanderStatus.BOUNDLESS
        fields = {"current_state": True} if again else {"jump_state": CommanderStatus.BOUNDLESS}
        self.enter(CommanderStatus.BOUNDLESS, **fields)
        self.wait(lambda: self.was_busy, "work of the mission")

    def ended(self, outcome: str = "succeeded") -> None:
        """The state's work comes to its end, and this one."""
        self.wait(self.says(lambda status: not status.busy and status.outcome != ""), "end of the work")
        self.assertEqual(self.status.outcome, outcome, self.status)

    def cli(self, *arguments: str, timeout_s: float) -> Tuple[int, str]:
        """Exit code of commander_cli, which may take so much wall time, and what it prints."""
        script = os.path.join(os.environ["YARM_ROOT"], "scripts", "commander_cli")
        command = [sys.executable, script, *arguments, "--timeout", str(timeout_s)]
        done = subprocess.run(command, timeout=timeout_s + 30.0, check=False, capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr

    def pid_of(self, node: str) -> int:
        """Process of a node."""
        uri = rospy.get_master().lookupNode("/" + node)[2]
        return int(xmlrpc.client.ServerProxy(uri).getPid(rospy.get_name())[2])

    @contextmanager
    def stopped(self, node: str) -> Iterator[None]:
        """A node is frozen for a while, and its supervisor with it, which would replace it."""
        pid = self.pid_of(node)
        pids = [psutil.Process(pid).ppid(), pid]
        for each in pids:
            os.kill(each, signal.SIGSTOP)
        try:
            yield
        finally:
            for each in reversed(pids):
                os.kill(each, signal.SIGCONT)
