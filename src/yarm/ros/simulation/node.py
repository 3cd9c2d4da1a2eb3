"""Node ``simulation``: the cell in PyBullet, with the topics, frames and rates of a real one (docs/ros_api.md).

One thread owns the world. Each round of its loop is a tick: physics, clock, frames, joints; every second tick the
cameras. In between it works off the inbox, until real time has caught up or, in lock-step, until everyone has answered.
"""

from __future__ import annotations

import threading
import time
from typing import Any, Dict, Optional, Set, Tuple

import rospy

from yarm.geometry.kinds import ContactKind
from yarm.ros.common import names
from yarm.ros.common.params import load_params
from yarm.ros.common.requests import spawn_spec
from yarm.ros.simulation.inbox import Inbox
from yarm.ros.simulation.loop import Pace, Stopwatch, SyncError, missing_acks, run_node
from yarm.ros.simulation.outbox import CAMERAS, Outbox, frame_poses
from yarm.ros.simulation.params import SimulationParams
from yarm.safety.pulse import Pulse
from yarm.sim.engine.world import STEPS_PER_SECOND, STEPS_PER_TICK, TICK_S, SimWorld, SpawnError
from yarm.sim.scenes.events import Event, Script, Situation
from yarm.sim.scenes.scene import load_scene, scene_path, without_shapes
from yarm.sim.scenes.specs import NOT_DRAWN
from yarm.sim.sensors.cameras import Eyes, best_rays
from yarm.sim.sensors.rays_embree import EmbreeRays

STEPS_PER_SET = 2 * STEPS_PER_TICK
WIND_ON_STEPS = 96
"""Steps from one camera set to the next on the way to the lock-step's start: 0.4 s is no interruption to anybody."""
SYNC_EVENT_TICKS = 30
"""In lock-step, events are looked at this often, so that those that wait for messages fire at the same tick."""
FRESH_NS = 500_000_000
WARM_UP_FACTOR = 0.25
"""Simulated seconds per second while somebody is still being started: a slow machine has longer for it."""
STEADY_TICKS = 60
"""Lock-step starts when for so many ticks no participant's newest word was older than that: each has spoken again."""


class SimulationNode:
    """The simulated cell on ROS."""

    def __init__(self, params: SimulationParams, stop: threading.Event) -> None:
        """Build the scene and advertise everything.

        Args:
            params: what the node is set to.
            stop: set from outside to end :meth:`run` between two ticks.

        Raises:
            SceneError: the scene file is faulty.
            SpawnError: its bodies overlap.
        """
        self._params = params
        self._stop = stop
        scene = load_scene(params.scene, params.seed if params.vary else -1)
        scene = without_shapes(scene) if params.shapes == NOT_DRAWN else scene
        self._world = SimWorld(scene, params, gui=params.gui, hands=params.hands)
        rays = best_rays()
        if isinstance(rays, EmbreeRays):
            rospy.logwarn("the C++ ray caster is not built: Embree stands in, and cameras are ten times slower")
        self._eyes = Eyes(scene.seed if params.seed < 0 else params.seed, params.depth_noise, rays)
        self._script = Script(scene.events)
        self._off: Tuple[int, ...] = ()
        self._version = -1
        present = {names.sander_node(arm) for arm in self._world.arms}
        absent = set(params.arm_participants) - present
        self._tick_participants = tuple(node for node in params.tick_participants if node not in absent)
        self._live = not params.sync
        self._just_live = False
        self._sets = 0
        self._frames_since_status = 0
        self._reported: Dict[Tuple[str, str], bool] = {}
        self._touched: Set[str] = set()
        self._watch = Stopwatch()
        self._pulse = Pulse()
        self._outbox = Outbox(self._world, params.registry)
        self._inbox = Inbox(self._world, self._serve_spawn, self._serve_delete, params.sync)

    def run(self) -> None:
        """Simulate until the node is shut down."""
        self._pace = Pace(TICK_S, self._params.real_time_factor)
        if self._params.sync:
            self._warm_up()
        while self._running():
            self._advance()
            stamp_ns, is_set = self._publish()
            if self._params.sync:
                self._wait_for_participants(stamp_ns, is_set)
            self._pace.wait(self._inbox)
            self._watch.lap("wait")
        self._world.close()

    def _running(self) -> bool:
        self._pulse.beat()
        return not (self._stop.is_set() or rospy.is_shutdown())

    def _advance(self) -> None:
        self._inbox.work_until(0.0)
        self._run_script()
        self._inbox.stop_the_silent(self._params.cmd_vel_timeout)
        self._inbox.stop_the_unwatched(self._params.arm_timeout)
        self._watch.lap("inbox")
        for robot in self._world.tick():
            self._inbox.warn_once(
                names.cmd_vel(robot), "angular.z left out: the wheels are parallel, no turning centre"
            )
        self._watch.lap("physics")

    def _publish(self) -> Tuple[int, bool]:
        """Publish the tick; its stamp, ns, and whether it was a camera set."""
        stamp = rospy.Time(*divmod(self._world.time_ns, 1_000_000_000))
        if self._version != self._world.version:
            self._version = self._world.version
            self._outbox.objects(stamp, frame_poses(list(self._eyes.overhead_poses)))
            self._eyes.look_at(self._world.bodies, self._world.transforms())
        self._outbox.tick(stamp)
        self._watch.lap("tick")
        tick = round(self._world.time_s / TICK_S)
        if tick % 2 == 0:
            self._camera_set(stamp, tick // 2)
        return stamp.to_nsec(), tick % 2 == 0

    def _camera_set(self, stamp: rospy.Time, frame: int) -> None:
        poses = self._world.transforms()
        for camera in CAMERAS:
            if camera in self._off:
                continue
            points = self._eyes.overhead_cloud(camera, poses, frame)
            self._watch.lap("cameras")
            self._outbox.cloud(camera, stamp, points)
            self._watch.lap("publish")
        for number, arm in enumerate(self._world.arms):
            if frame % 2 == 0 and self._outbox.wrist_wanted(arm):
                optical = poses[names.wrist_optical_frame(arm)]
                self._outbox.wrist_cloud(arm, stamp, self._eyes.wrist_cloud(optical, poses, frame, number))
                self._watch.lap("wrist")
        self._sets += 1
        self._frames_since_status += 1
        self._ground_truth(stamp)
        if self._live:
            self._status(stamp)

    def _status(self, stamp: rospy.Time) -> None:
        """Every status period; in lock-step also at once when it begins, for those who wait for it."""
        passed_s = self._frames_since_status * 2 * TICK_S
        if self._just_live or passed_s >= self._params.status_period - 1e-9:
            wall_s, parts = self._watch.take(self._frames_since_status)
            self._outbox.status(stamp, passed_s / max(wall_s, 1e-9), self._sets, parts, self._touched)
            self._frames_since_status = 0
            self._just_live = False

    def _ground_truth(self, stamp: rospy.Time) -> None:
        contacts = self._world.contacts.take()
        for contact in contacts:
            key = (f"{contact.a.body} {contact.a.link}", f"{contact.b.body} {contact.b.link}")
            if contact.kind is ContactKind.FAILURE and key not in self._reported:
                self._reported[key] = True
                self._touched.add(" ".join(sorted((contact.a.body, contact.b.body))))
                rospy.logwarn(
                    "contact at %.3f s: %s touches %s, %.4f m deep (said once)", stamp.to_sec(), *key, contact.depth_m
                )
        self._outbox.contacts(stamp, contacts)
        if self._sets % self._params.clearance_every == 0 and self._outbox.clearance_wanted():
            self._outbox.clearance(stamp)
        self._watch.lap("truth")

    def _wait_for_participants(self, stamp_ns: int, is_set: bool) -> None:
        limit = time.monotonic() + self._params.sync_timeout
        while self._running():
            self._inbox.work_until(0.0)
            missing = self._missing(stamp_ns, is_set)
            if missing is None:
                break
            if time.monotonic() > limit:
                raise SyncError(
                    f"lock-step at {stamp_ns / 1e9:.4f} s: {missing}; waited {self._params.sync_timeout:g} s"
                )
            self._inbox.work_one(0.1)
        self._watch.lap("lock-step")

    def _missing(self, stamp_ns: int, is_set: bool) -> Optional[str]:
        params = self._params
        if is_set and params.wait_for_metadata and self._inbox.metadata_ns != stamp_ns:
            return f"no planning_metadata of this set (newest: {self._inbox.metadata_ns / 1e9:.4f} s)"
        missing = missing_acks(self._inbox, self._tick_participants, stamp_ns, counted=True)
        if missing is None and is_set:
            missing = missing_acks(self._inbox, params.set_participants, stamp_ns, counted=False)
        return missing

    def _warm_up(self) -> None:
        """Let time, but not physics, run until all participants keep up, then wind it on to the lock-step's start.

        Once is not enough: who has answered a tick may still be without its connection to somebody else.
        """
        begin = round(self._params.sync_start * STEPS_PER_SECOND / STEPS_PER_SET) * STEPS_PER_SET
        steady_ticks = 0
        while self._running() and steady_ticks < STEADY_TICKS:
            self._world.steps += STEPS_PER_TICK
            if self._world.steps >= begin:
                unheard = self._unheard() or "participants come and go"
                raise SyncError(f"lock-step cannot start: {unheard} after {self._params.sync_start:g} s")
            self._publish()
            self._pace.wait(self._inbox, WARM_UP_FACTOR if self._unheard() else 1.0)
            steady_ticks = 0 if self._unheard() else steady_ticks + 1
        while self._running() and self._world.steps < begin - STEPS_PER_SET:
            ahead = (self._world.steps + WIND_ON_STEPS) // STEPS_PER_SET * STEPS_PER_SET
            self._world.steps = min(ahead, begin - STEPS_PER_SET)
            self._wait_for_participants(*self._publish())
        self._world.steps = begin - STEPS_PER_TICK
        self._live = self._just_live = True
        self._frames_since_status = 0
        self._watch.take(1)

    def _unheard(self) -> str:
        params, since_ns = self._params, self._world.time_ns - FRESH_NS
        nodes = self._tick_participants + params.set_participants
        silent = [node for node in nodes if self._inbox.acks.get(node, (-FRESH_NS, 0))[0] <= since_ns]
        if params.wait_for_metadata and self._inbox.metadata_ns <= max(since_ns, -1):
            silent.append("planning_metadata")
        return f"nothing heard from {', '.join(silent)}" if silent else ""

    def _run_script(self) -> None:
        if self._params.sync and round(self._world.time_s / TICK_S) % SYNC_EVENT_TICKS:
            return
        holding = frozenset(name for name, hand in self._world.hands.items() if hand.grasping)
        now = Situation(
            self._world.time_s, self._inbox.commander_state, dict(self._inbox.raster), self._world.seed_xy(), holding
        )
        for event in self._script.fired(now):
            self._fire(event)

    def _fire(self, event: Event) -> None:
        rospy.loginfo("event at %.3f s: %s", self._world.time_s, event.name)
        try:
            if event.spawn is not None:
                self._world.spawn(event.spawn)
            elif event.delete:
                self._world.delete(event.delete)
            elif event.push and not self._world.push(event.push, event.dx_m, event.dy_m):
                rospy.logwarn("event %s: %s is not in the cell, nothing pushed", event.name, event.push)
            elif event.move and not self._world.walk(event.move, event.dx_m, event.dy_m, event.speed_mps):
                rospy.logwarn(
                    "event %s: %s is neither a bin nor an obstacle nobody registered, nothing moved",
                    event.name,
                    event.move,
                )
            elif event.vacuum and not self._world.fail_vacuum(event.vacuum, not event.enabled):
                rospy.logwarn("event %s: %s has no hand, nothing switched", event.name, event.vacuum)
            elif event.camera:
                others = tuple(camera for camera in self._off if camera != event.camera)
                self._off = others if event.enabled else (*others, event.camera)
        except SpawnError as error:
            rospy.logwarn("event %s: %s; tried again in a second", event.name, error)
            self._script.again(event, self._world.time_s + 1.0)

    def _serve_spawn(self, request: Any) -> str:
        spec = spawn_spec(request, scene_path(self._params.scene).resolve().parent)
        self._world.spawn(spec)
        return f"{spec.kind} {spec.name} is at ({spec.x:.3f}, {spec.y:.3f}, {spec.z:.3f})"

    def _serve_delete(self, request: Any) -> str:
        name = self._world.named(request.name, (request.x, request.y))
        self._world.delete(name)
        return f"{name} has left the cell"


def main() -> None:
    """Run the node."""
    run_node("simulation", lambda stop: SimulationNode(load_params(SimulationParams), stop).run(), SpawnError)
