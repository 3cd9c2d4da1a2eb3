"""What the simulations of the cell and of a room share: jobs of one thread, acknowledgements, pace, how a node ends."""

from __future__ import annotations

import queue
import signal
import threading
import time
from typing import Any, Callable, Dict, Optional, Tuple, Type

import rospy

from yarm.msg import StepAck
from yarm.params import ParamError
from yarm.ros.common.start import init_node
from yarm.sim.robots.errors import CommandError
from yarm.sim.robots.joint_path import JointPathError
from yarm.yaml_fields import SceneError

Job = Callable[[], None]
BACKLOG_S = 0.25
"""After a hold-up the loop makes up at most this much wall time, s."""
SHUTDOWN_S = 1.0


class SyncError(RuntimeError):
    """A participant of the lock-step did not answer; the message names it."""


class Jobs:
    """Everything that reaches a simulation, in one queue that its one thread works off.

    Attributes:
        acks: newest acknowledgement of each node: stamp, ns, and commands it says it has sent.
        commands: commands received from each node.
    """

    def __init__(self) -> None:
        """Nothing to do."""
        # Not a SimpleQueue: when a signal's handler outlasts its timeout, Python 3.11 waits for ever.
        self._jobs: queue.Queue[Job] = queue.Queue()
        self._warned: Dict[Tuple[str, str], bool] = {}
        self.acks: Dict[str, Tuple[int, int]] = {}
        self.commands: Dict[str, int] = {}

    def put(self, job: Job) -> None:
        """Have something done by the simulation's thread."""
        self._jobs.put(job)

    def work_until(self, deadline_s: float) -> None:
        """Do jobs as they come until a moment of time.monotonic(); without one left, at least those waiting."""
        while True:
            try:
                left = deadline_s - time.monotonic()
                job = self._jobs.get(timeout=left) if left > 0.0 else self._jobs.get_nowait()
            except queue.Empty:
                return
            job()

    def work_one(self, timeout_s: float) -> None:
        """Do the next job, waiting for one at most so long."""
        try:
            job = self._jobs.get(timeout=timeout_s)
        except queue.Empty:
            return
        job()

    def command(self, topic: str, message: Any, apply: Callable[[], str]) -> None:
        """Queue a command; ``apply`` answers a note (clamped ...) or raises why it was refused."""
        sender = str(getattr(message, "_connection_header", {}).get("callerid", "")).strip("/")

        def job() -> None:
            try:
                note = apply()
            except (CommandError, JointPathError) as error:
                self.warn_once(topic, f"refused: {error}")
            else:
                if note:
                    self.warn_once(topic, note)
            self.commands[sender] = self.commands.get(sender, 0) + 1

        self._jobs.put(job)

    def warn_once(self, topic: str, note: str) -> None:
        """Warn of a topic's fault the first time it happens; values after a colon do not make it new."""
        key = (topic, note.split(" ", 2)[0])
        if key not in self._warned:
            self._warned[key] = True
            rospy.logwarn("%s: %s (said once)", topic, note)

    def on_ack(self, message: StepAck) -> None:
        """Keep an acknowledgement; for a subscriber."""
        entry = (message.header.stamp.to_nsec(), int(message.commands_sent))
        self._jobs.put(lambda: self.acks.__setitem__(message.node.strip("/"), entry))


def missing_acks(jobs: Jobs, nodes: Tuple[str, ...], stamp_ns: int, counted: bool) -> Optional[str]:
    """Which node has not acknowledged a stamp, or whose commands have not all arrived; None when all is there.

    Commands are ``counted`` only for nodes that command the simulation; the Commander's are goals for other nodes.
    """
    for node in nodes:
        stamp, sent = jobs.acks.get(node, (-1, 0))
        if stamp != stamp_ns:
            return f"{node} has not acknowledged (newest: {stamp / 1e9:.4f} s)"
        got = jobs.commands.get(node, 0)
        if counted and got < sent:
            return f"{node} says it sent {sent} commands, {got} have arrived"
    return None


class Stopwatch:
    """Wall time spent in each part of the loop."""

    def __init__(self) -> None:
        """Start now."""
        self._spent: Dict[str, float] = {}
        self._mark = self._since = time.perf_counter()

    def lap(self, part: str) -> None:
        """Put the time since the last lap to a part's account."""
        now = time.perf_counter()
        self._spent[part] = self._spent.get(part, 0.0) + now - self._mark
        self._mark = now

    def take(self, frames: int) -> Tuple[float, Dict[str, float]]:
        """Seconds since the last call and milliseconds per frame of each part; starts afresh."""
        now = time.perf_counter()
        wall, self._since = now - self._since, now
        parts = {part: 1e3 * spent / max(frames, 1) for part, spent in self._spent.items()}
        self._spent = {}
        return wall, parts


class Pace:
    """Keeps a simulation from running ahead of real time."""

    def __init__(self, tick_s: float, factor: float) -> None:
        """Begin now.

        Args:
            tick_s: simulated time of a tick, s.
            factor: greatest simulated seconds per second; 0 for no limit.
        """
        self._tick_s, self._factor = tick_s, factor
        self._next_s = time.monotonic()

    def wait(self, jobs: Jobs, factor: Optional[float] = None) -> None:
        """Work off jobs until the next tick is due; ``factor`` stands in for the one given at the start."""
        limit = self._factor if factor is None else factor
        if limit <= 0.0:
            return
        self._next_s = max(self._next_s + self._tick_s / limit, time.monotonic() - BACKLOG_S)
        jobs.work_until(self._next_s)


def run_node(name: str, run: Callable[[threading.Event], None], *refusals: Type[Exception]) -> None:
    """Run a simulation's node.

    Signals only ask the loop to end: rospy's own handler would close the topics from within a publish of this same
    thread, whose lock is then taken twice, and the node would hang until it is killed.

    Args:
        name: of the node.
        run: the loop; it ends between two ticks when the event is set.
        refusals: what ends the node with a message and exit code 1, besides wrong parameters, scenes and lock-steps.
    """
    refused: Tuple[Type[Exception], ...] = (ParamError, SceneError, SyncError, *refusals)
    init_node(name, disable_signals=True)
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    try:
        run(stop)
    except refused as error:
        rospy.logfatal("%s", error)
        raise SystemExit(1) from error
    except rospy.ROSException:
        # Told to stop by the master: topics close under the loop's hands, some before the node is known to stop.
        rospy.rostime.wallsleep(SHUTDOWN_S)
        if not rospy.is_shutdown():
            raise
    finally:
        rospy.signal_shutdown("the simulation has ended")
