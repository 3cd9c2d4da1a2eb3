"""``rosrun yarm youbot_simulation``: the youBot on its floor, in physics, behind its driver's topics.

    roslaunch yarm youbot.launch console:=true     # waits for commands; a page in the browser shows it
    rosbag play results/coursework/3/tour.bag      # left by make demo CASE=coursework
    roslaunch yarm youbot.launch clear:=true       # it clears the floor by itself

It takes ``EffortJointInterface_trajectory_controller/command`` (trajectory_msgs/JointTrajectory, the driver's angles),
``cmd_vel`` for the base and ``youbot/gripper/on`` and ``off`` for the cup, and tells ``joint_states``, ``/tf``,
``object_registry`` and ``/clock``. What cannot be done is refused, with the reason in the log and in ``youbot/status``,
and the robot goes on with what it does; a newer motion replaces one from where the arm is. ``safety/stop`` stops
everything, until it is released.
"""

from __future__ import annotations

import argparse
import sys
import threading
import time
from pathlib import Path
from typing import List, Optional, Sequence

import numpy as np
import rospy

from yarm.console.reel import hand_way
from yarm.geometry import quaternion_from_rpy, transform_matrix, transform_points
from yarm.manipulation.clearing.brake import Brake
from yarm.manipulation.clearing.mission import Command, FloorMission, MissionError, Work
from yarm.manipulation.clearing.play import STEPS_PER_TICK, FloorRobot
from yarm.manipulation.clearing.reachability import T_BASE_ARM
from yarm.manipulation.motion.trajectory import Trajectory
from yarm.msg import YoubotStatus
from yarm.resources import resource
from yarm.robots.youbot import N_JOINTS
from yarm.ros.common import names
from yarm.ros.manipulation.floor_inbox import FloorInbox
from yarm.ros.manipulation.floor_outbox import FloorOutbox
from yarm.ros.safety.stop import StopService
from yarm.ros.simulation.loop import run_node
from yarm.sim.engine.youbot_floor import STEPS_PER_SECOND, YoubotFloor
from yarm.sim.scenes.youbot_floor import load_floor_scene

TICK_S = STEPS_PER_TICK / STEPS_PER_SECOND
FRAMES_EVERY, STATUS_EVERY, STOP_EVERY = 3, 6, 30
"""Ticks between two messages of frames, of the status, and of a person's stop."""
FACTOR_OVER_S = 1.0
BACKLOG_S = 0.1
"""A simulation that is late makes up for no more wall time than this, s."""


class FloorNode:
    """A floor's world, and the topics of its robot."""

    def __init__(self, scene: Path, seed: int, factor: float, clear: bool = False) -> None:
        """Put everything there and advertise.

        Args:
            scene: file of the floor.
            seed: of slip, debris, what is seen and the planner; 0 leaves the debris where the file has it.
            factor: greatest simulated seconds per second; 0 for no limit.
            clear: the robot clears the floor by itself; what its topics say is refused until it is done.

        Raises:
            SceneError: it is faulty.
            MissionError: the robot cannot clear it.
        """
        floor = load_floor_scene(scene).varied(seed)
        self._mission = FloorMission(floor, seed=seed, say=self._say) if clear else None
        self._work: Optional[Work] = None
        self._world = YoubotFloor(floor, np.zeros(N_JOINTS) if self._mission is None else self._mission.carry, seed)
        self._robot, self._brake = FloorRobot(self._world, seed), Brake()
        self._factor, self._due_s = factor, time.monotonic()
        self._told = YoubotStatus(doing="clears the floor" if clear else "")
        self._mark = (time.monotonic(), 0.0)
        self._ticks, self._grasping = 0, False
        self._out = FloorOutbox(self._world)
        self._inbox = FloorInbox(self._say)
        self._told_stop = ""
        self._stop = StopService(lambda: None)
        self._out.stop(self._stop.reason)

    def run(self, stop: threading.Event) -> None:
        """Simulate until told to stop."""
        with self._world:
            while not (stop.is_set() or rospy.is_shutdown()):
                self.tick()
                if self._factor > 0.0:
                    now_s = time.monotonic()
                    self._due_s = max(self._due_s + TICK_S / self._factor, now_s - BACKLOG_S)
                    stop.wait(max(self._due_s - now_s, 0.0))

    def tick(self) -> None:
        """One tick, and what is told after it.

        Raises:
            MissionError: the robot stands where its mission cannot begin.
        """
        reason = self._stop.reason
        rate = self._brake.step(bool(reason), TICK_S)
        command = self._next(reason, rate)
        if command.motion is not None:
            self._tell_way(command.motion)
        self._robot.tell(command, rate)
        self._ticks += 1
        self._out.tick()
        if self._ticks % FRAMES_EVERY == 0:
            self._out.frames()
        held = self._world.robot.cup.grasping
        if held is not self._grasping:
            self._grasping = held
            self._out.grasping(held)
        if reason != self._told_stop or self._ticks % STOP_EVERY == 0:
            self._told_stop = reason
            self._out.stop(reason)
        if self._ticks % STATUS_EVERY == 0:
            self._tell_status()

    def _next(self, stopped: str, rate: float) -> Command:
        """What the robot is told: by its mission, or by others."""
        busy = "it clears the floor by itself" if self._mission is not None else ""
        told = self._inbox.command(self._world.time_s, self._robot.set_points, stopped or busy)
        if self._mission is None:
            return told
        if rate == 0.0:
            return Command()
        try:
            if self._work is None:
                self._work = self._mission.work(self._robot.read())
                return next(self._work)
            return self._work.send(self._robot.read())
        except StopIteration:
            pieces = self._mission.pieces
            self._mission = self._work = None
            left = [f"{name}: {report.reason}" for name, report in pieces.items() if not report.cleared]
            self._say("; ".join(left) or f"the floor is clear, {len(pieces)} pieces are in the bin")
            return Command()

    def _tell_way(self, motion: Trajectory) -> None:
        base = self._world.robot.pose()
        T_world_base = transform_matrix((base.x, base.y, 0.0), quaternion_from_rpy(0.0, 0.0, base.yaw_rad))
        self._out.hand_path(transform_points(T_world_base @ T_BASE_ARM, hand_way(motion)))

    def _tell_status(self) -> None:
        wall_s, begun_s = time.monotonic() - self._mark[0], self._mark[1]
        if wall_s >= FACTOR_OVER_S:
            self._told.real_time_factor = (self._world.time_s - begun_s) / wall_s
            self._mark = (time.monotonic(), self._world.time_s)
        self._told.clearing, self._told.refused = self._mission is not None, self._inbox.refused
        self._told.left = self._robot.left_s
        self._out.status(self._told)

    def _say(self, text: str) -> None:
        self._told.doing = text.strip()
        rospy.loginfo("%s", self._told.doing)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the node until it is shut down; 1 when the scene is faulty, or cannot be cleared."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    given: List[str] = rospy.myargv(sys.argv)[1:] if arguments is None else list(arguments)
    parser.add_argument("--scene", type=Path, default=resource("scenes", "manipulation", "youbot_floor.yaml"))
    parser.add_argument("--seed", type=int, default=0, help="of slip, debris (0: as in the file), eyes and planner")
    parser.add_argument("--factor", type=float, default=1.0, help="greatest simulated seconds per second; 0: no limit")
    parser.add_argument("--clear", action="store_true", help="clear the floor by itself")
    options = parser.parse_args(given)
    run_node(
        names.YOUBOT_NODE,
        lambda stop: FloorNode(options.scene, options.seed, options.factor, options.clear).run(stop),
        MissionError,
    )
    return 0
