"""Node ``room_simulation``: a TurtleBot in a room, with the topics, frames and rates of a real one (docs/ros_api.md).

One thread owns the world. Each round of its loop is a tick of physics; odometry, scans and the clock go out when they
are due. In between it works off commands, until real time has caught up or, in lock-step, until everyone has answered.
"""

from __future__ import annotations

import threading
import time
from functools import partial
from typing import Optional

import rospy
from geometry_msgs.msg import Twist
from tf2_msgs.msg import TFMessage

from yarm.experiments.inspect.eyes import Camera
from yarm.geometry import Pose2
from yarm.msg import StepAck
from yarm.ros.common import names
from yarm.ros.common.params import load_params
from yarm.ros.rooms.outbox import RoomOutbox
from yarm.ros.rooms.params import RoomSimulationParams
from yarm.ros.rooms.rgb import RgbOutbox
from yarm.ros.simulation.loop import Jobs, Pace, Stopwatch, SyncError, run_node
from yarm.sim.engine.room import TICK_S, TICKS_PER_SCAN, RoomWorld
from yarm.sim.scenes.arena import load_arena
from yarm.sim.scenes.layout_file import find_layout

TICKS_PER_PASS = 10
"""In lock-step participants are waited for once in so many ticks: the explorer's ten passes a second."""
START_TICKS = 100
"""Lock-step begins at this tick: a time of 0 would mean that no time is known."""
HOLD_S = 0.2
"""Wall time after which a moment that is held for the participants is published again, s."""


class RoomInbox(Jobs):
    """Commands and acknowledgements.

    Attributes:
        map_ns: newest stamp of the transform map -> odom, ns.
    """

    def __init__(self, world: RoomWorld, sync: bool) -> None:
        """Subscribe."""
        super().__init__()
        self._world = world
        self.map_ns = -1
        self._velocity = rospy.Subscriber(
            names.BASE_VELOCITY, Twist, self._on_velocity, queue_size=10, tcp_nodelay=True
        )
        if sync:
            rospy.Subscriber(names.STEP_ACK, StepAck, self.on_ack, queue_size=100, tcp_nodelay=True)
            rospy.Subscriber("/tf", TFMessage, self._on_tf, queue_size=100, tcp_nodelay=True)

    def commanded(self) -> bool:
        """Somebody is connected whose commands would arrive."""
        return int(self._velocity.get_num_connections()) > 0

    def _on_velocity(self, message: Twist) -> None:
        v, w = message.linear.x, message.angular.z

        def apply() -> str:
            clamped = self._world.drive(v, w)
            return f"linear.x {v:.3f} m/s, angular.z {w:.3f} rad/s clamped to the base's limits" if clamped else ""

        self.command(names.BASE_VELOCITY, message, apply)

    def _on_tf(self, message: TFMessage) -> None:
        for found in message.transforms:
            if (found.header.frame_id, found.child_frame_id) == (names.MAP_FRAME, names.ODOM_FRAME):
                self.put(partial(setattr, self, "map_ns", found.header.stamp.to_nsec()))


class RoomSimulationNode:
    """The simulated room on ROS."""

    def __init__(self, params: RoomSimulationParams, stop: threading.Event) -> None:
        """Build the arena and advertise everything.

        Args:
            params: what the node is set to.
            stop: set from outside to end :meth:`run` between two ticks.

        Raises:
            SceneError: the arena's or the layout's file is faulty.
        """
        self._params = params
        self._stop = stop
        layout = find_layout(params.layout) if params.layout else None
        arena = load_arena(params.arena) if layout is None else layout.arena
        self._world = RoomWorld(arena, params, params.seed, params.gui)
        self._watch = Stopwatch()
        self._scans = 0
        self._outbox = RoomOutbox(self._world, self._map_pose())
        seed = arena.seed if params.seed < 0 else params.seed
        self._rgb = None if layout is None else RgbOutbox(self._world, Camera(layout, seed), params.rgb_rate)
        self._inbox = RoomInbox(self._world, params.sync)

    def run(self) -> None:
        """Simulate until the node is shut down."""
        pace = Pace(TICK_S, self._params.real_time_factor)
        if self._params.sync:
            self._begin_together()
        while self._running():
            self._inbox.work_until(0.0)
            self._watch.lap("inbox")
            self._world.tick()
            self._watch.lap("physics")
            self._publish()
            if self._params.sync and self._world.ticks % TICKS_PER_PASS == 0:
                self._wait_for_participants()
            pace.wait(self._inbox)
            self._watch.lap("wait")
        self._world.close()

    def _map_pose(self) -> Optional[Pose2]:
        """Of the map in the world: boxes of a layout are given in the map, which is then the world."""
        if self._params.layout:
            return Pose2(0.0, 0.0)
        return self._world.arena.start if self._params.map_at_start else None

    def _running(self) -> bool:
        return not (self._stop.is_set() or rospy.is_shutdown())

    def _publish(self) -> None:
        """Everything that is due at this tick. The clock comes last: who acts on it finds the rest under way.

        In lock-step it comes with scans only: nobody acts in between, and every message wakes every node.
        """
        world = self._world
        stamp = self._stamp()
        if world.odometry_due():
            self._outbox.motion(stamp)
            together = self._params.sync and world.ticks % TICKS_PER_PASS == 0
            self._outbox.bumps(stamp, world.take_bumps(), world.pressed, always=together)
        self._watch.lap("publish")
        if world.scan_due():
            self._outbox.scan(stamp)
            self._scans += 1
            self._watch.lap("scan")
            if world.frame % self._params.depth_every == 0:
                self._outbox.depth(stamp)
                self._watch.lap("depth")
        if self._rgb is not None and self._rgb.publish(stamp):
            self._watch.lap("rgb")
        if world.scan_due() or (world.odometry_due() and not self._params.sync):
            self._outbox.clock(stamp)
        if world.scan_due():
            self._status(stamp)

    def _stamp(self) -> rospy.Time:
        return rospy.Time(*divmod(self._world.time_ns, 1_000_000_000))

    def _status(self, stamp: rospy.Time) -> None:
        scans = max(1, round(self._params.status_period / (TICKS_PER_SCAN * TICK_S)))
        if self._scans % scans == 0:
            wall_s, parts = self._watch.take(scans)
            self._outbox.status(stamp, scans * TICKS_PER_SCAN * TICK_S / max(wall_s, 1e-9), self._scans, parts)

    def _begin_together(self) -> None:
        """Hold the lock-step's first moment, saying it again and again, until every participant has answered it."""
        self._world.ticks = START_TICKS
        limit = time.monotonic() + self._params.sync_timeout
        missing = self._missing()
        while self._running() and missing is not None:
            if time.monotonic() > limit:
                raise SyncError(f"lock-step cannot start: {missing}; waited {self._params.sync_timeout:g} s")
            self._publish()
            self._inbox.work_until(time.monotonic() + HOLD_S)
            missing = self._missing()
            if missing is None and self._params.participants and not self._inbox.commanded():
                missing = f"nobody is connected to {names.BASE_VELOCITY}"

    def _wait_for_participants(self) -> None:
        limit = time.monotonic() + self._params.sync_timeout
        missing = self._missing()
        while self._running() and missing is not None:
            if time.monotonic() > limit:
                raise SyncError(
                    f"lock-step at {self._world.time_s:.2f} s: {missing}; waited {self._params.sync_timeout:g} s"
                )
            self._inbox.work_one(0.1)
            missing = self._missing()
        self._watch.lap("lock-step")

    def _missing(self) -> Optional[str]:
        """Who has not answered this tick; None when everybody has."""
        now_ns = self._world.time_ns
        if self._params.wait_for_map and self._inbox.map_ns < now_ns:
            return f"no transform map -> odom of this scan (newest: {self._inbox.map_ns / 1e9:.2f} s)"
        sent = 0
        for node in self._params.participants:
            stamp_ns, commands = self._inbox.acks.get(node, (-1, 0))
            if stamp_ns != now_ns:
                return f"{node} has not acknowledged (newest: {stamp_ns / 1e9:.2f} s)"
            sent += commands
        # Commands come by way of the multiplexer, so it is their number in all that counts.
        got = sum(self._inbox.commands.values())
        return f"the participants say they sent {sent} commands, {got} have arrived" if got < sent else None


def main() -> None:
    """Run the node."""
    run_node("room_simulation", lambda stop: RoomSimulationNode(load_params(RoomSimulationParams), stop).run())
