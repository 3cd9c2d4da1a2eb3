"""``rosrun yarm youbot_simulation``: the youBot's arm on its floor, in physics, behind its driver's topics.

    rosrun yarm youbot_simulation &
    rosbag play results/coursework/3/tour.bag   # left by make demo CASE=coursework

It takes ``EffortJointInterface_trajectory_controller/command`` (trajectory_msgs/JointTrajectory, the driver's angles)
and tells ``joint_states`` and ``/clock``. A motion that cannot be followed is refused, with the reason in the log, and
the arm goes on with what it does; a newer one replaces it from where the arm is. The base stands.
"""

from __future__ import annotations

import argparse
import sys
import threading
from collections import deque
from pathlib import Path
from typing import Deque, List, Optional, Sequence, Tuple

import numpy as np
import rospy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

from yarm.manipulation.motion.commanded import commanded
from yarm.manipulation.motion.trajectory import Trajectory, TrajectoryError
from yarm.resources import resource
from yarm.robots.youbot import JOINT_NAMES, N_JOINTS, urdf_angles, urdf_rates
from yarm.ros.common import names
from yarm.ros.simulation.loop import run_node
from yarm.sim.engine.youbot_floor import STEPS_PER_SECOND, YoubotFloor
from yarm.sim.scenes.youbot_floor import load_floor_scene

STEPS_PER_TICK = 4
TICK_S = STEPS_PER_TICK / STEPS_PER_SECOND


class FloorNode:
    """A floor's world, and the topics of its arm."""

    def __init__(self, scene: Path, seed: int, factor: float) -> None:
        """Put everything there and advertise.

        Args:
            scene: file of the floor.
            seed: of the base's slip.
            factor: greatest simulated seconds per second; 0 for no limit.

        Raises:
            SceneError: it is faulty.
        """
        self._joints = np.zeros(N_JOINTS)
        self._world = YoubotFloor(load_floor_scene(scene), self._joints, seed)
        self._factor = factor
        self._motion: Optional[Tuple[float, Trajectory]] = None
        self._commands: Deque[JointTrajectory] = deque()
        self._clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self._states = rospy.Publisher(names.ARM_JOINT_STATES, JointState, queue_size=10)
        self._heard = rospy.Subscriber(names.ARM_COMMAND, JointTrajectory, self._commands.append, queue_size=10)

    def run(self, stop: threading.Event) -> None:
        """Simulate until told to stop."""
        with self._world:
            while not (stop.is_set() or rospy.is_shutdown()):
                while self._commands:
                    self._take(self._commands.popleft())
                self._tick()
                if self._factor > 0.0:
                    stop.wait(TICK_S / self._factor)

    def _take(self, command: JointTrajectory) -> None:
        points = command.points
        rates = [p.velocities for p in points] if points and all(p.velocities for p in points) else None
        try:
            motion = commanded(
                command.joint_names,
                [p.time_from_start.to_sec() for p in points],
                [p.positions for p in points],
                rates,
                self._joints,
            )
        except (TrajectoryError, ValueError) as error:
            rospy.logwarn("%s refused: %s", names.ARM_COMMAND, error)
            return
        self._motion = max(self._world.time_s, command.header.stamp.to_sec()), motion
        rospy.loginfo("%s: %d points, %.2f s", names.ARM_COMMAND, len(points), motion.duration_s)

    def _tick(self) -> None:
        for _ in range(STEPS_PER_TICK):
            speeds = np.zeros(N_JOINTS)
            if self._motion is not None:
                began_s, motion = self._motion
                at = np.array([min(max(self._world.time_s - began_s, 0.0), motion.duration_s)])
                position, velocity, _ = motion.evaluate(at)
                self._joints = position[0]
                speeds = velocity[0] if 0.0 < at[0] < motion.duration_s else speeds
            self._world.robot.follow(self._joints, speeds)
            self._world.step()
        stamp = rospy.Time.from_sec(self._world.time_s)
        self._clock.publish(Clock(stamp))
        state = JointState(name=list(JOINT_NAMES), position=urdf_angles(self._world.robot.joints()).tolist())
        state.header.stamp = stamp
        state.velocity = urdf_rates(self._world.robot.joint_rates()).tolist()
        self._states.publish(state)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the node until it is shut down; 1 when the scene is faulty."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    given: List[str] = rospy.myargv(sys.argv)[1:] if arguments is None else list(arguments)
    parser.add_argument("--scene", type=Path, default=resource("scenes", "manipulation", "youbot_floor.yaml"))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--factor", type=float, default=1.0, help="greatest simulated seconds per second; 0: no limit")
    options = parser.parse_args(given)
    run_node("youbot_simulation", lambda stop: FloorNode(options.scene, options.seed, options.factor).run(stop))
    return 0
