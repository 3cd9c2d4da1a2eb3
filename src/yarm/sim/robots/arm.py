"""The manipulator in PyBullet: its motors, its frames."""

from __future__ import annotations

from dataclasses import replace
from typing import Dict, List, Sequence, Tuple

import numpy as np
import pybullet

from yarm.geometry import FloatArray, transform_matrix
from yarm.sim.engine.bodies import link_names, load_urdf
from yarm.sim.robots.errors import CommandError
from yarm.sim.robots.joint_path import JointLimits, JointPath
from yarm.sim.scenes.bodies import TOOL_FRAMES, arm_body, description
from yarm.sim.scenes.specs import ArmSpec

BRAKE_S = 0.2
"""An arm that nobody watches over is brought to rest in this time, s."""


class Arm:
    """The HC10: six position-controlled joints that follow streamed trajectories."""

    def __init__(self, client: int, spec: ArmSpec) -> None:
        """Bolt the arm to its stand in its storage pose; ``client`` is PyBullet's number of the world."""
        station = spec.station
        text, self._model = description("hc10.urdf.xacro")
        self._client = client
        self.station = station
        self.uid = load_urdf(client, text, station.base_xyz, station.yaw_rad, fixed=True)
        names = link_names(client, self.uid)
        joints = self._model.moving_joints
        self.joint_names = tuple(joint.name for joint in joints)
        self._names = names
        self._links = [names.index(joint.child) for joint in joints]
        self.tip_link = names.index("sander_tip")
        self._link_names = [joint.child for joint in joints]
        self._efforts = [joint.effort for joint in joints]
        self.limits = JointLimits(
            *(np.array([getattr(joint, key) for joint in joints]) for key in ("lower", "upper", "velocity"))
        )
        self._tools = [(tool, *self._model.rigid_group(tool)) for tool in TOOL_FRAMES]
        self.body = replace(arm_body(spec), uids=(self.uid,))
        self.place(station.folded)

    def place(self, joints: Sequence[float]) -> None:
        """Put the joints, rad, there at once and hold them: for the start and for checks, not for motion."""
        for index, angle in zip(self._links, joints):
            pybullet.resetJointState(self.uid, index, angle, physicsClientId=self._client)
        self.path = JointPath(joints, self.limits)
        self._motors()

    def link_name(self, index: int) -> str:
        """Name of a PyBullet link."""
        return self._names[index]

    def chain(self) -> List[Tuple[int, int]]:
        """PyBullet's index of each link with a body, and how many moving joints it is from the base."""
        order = ["base_link", *self._link_names]
        bodies = dict.fromkeys(solid.link for solid in self._model.solids)
        index = {name: i if i < len(self._names) - 1 else -1 for i, name in enumerate(self._names)}
        return [(index[link], order.index(self._model.rigid_group(link)[0])) for link in bodies]

    def follow(self, names: Sequence[str], positions: Sequence[Sequence[float]], times_s: Sequence[float]) -> List[str]:
        """Take a trajectory; joints may come in any order (see JointPath.follow).

        Raises:
            CommandError: joints missing or unknown.
            JointPathError: bad points.
        """
        if sorted(names) != sorted(self.joint_names):
            raise CommandError(f"joints {list(names)} must be {list(self.joint_names)}")
        order = [list(names).index(name) for name in self.joint_names]
        if any(len(point) != len(order) for point in positions):
            raise CommandError(f"every point must have {len(order)} positions")
        return self.path.follow([[point[i] for i in order] for point in positions], times_s)

    def brake(self) -> None:
        """Come to rest on the trajectory that is followed."""
        self.path.brake(BRAKE_S)

    def update(self, dt_s: float) -> None:
        """Once a physics step: move the set-points on."""
        if self.path.moving or np.any(self.path.velocity):
            self.path.advance(dt_s)
            self._motors()

    def joint_readings(self) -> Tuple[List[str], List[float], List[float]]:
        """Names, positions, rad, and speeds, rad/s."""
        states = pybullet.getJointStates(self.uid, self._links, physicsClientId=self._client)
        return list(self.joint_names), [state[0] for state in states], [state[1] for state in states]

    def transforms(self) -> Dict[str, FloatArray]:
        """T_world_frame (4, 4) of its moving frames."""
        states = pybullet.getLinkStates(
            self.uid, self._links, computeForwardKinematics=True, physicsClientId=self._client
        )
        poses = {name: transform_matrix(state[4], state[5]) for name, state in zip(self._link_names, states)}
        for tool, link, T_link_tool in self._tools:
            poses[tool] = poses[link] @ T_link_tool
        return {f"{self.body.name}/{link}": pose for link, pose in poses.items()}

    def _motors(self) -> None:
        pybullet.setJointMotorControlArray(
            self.uid,
            self._links,
            pybullet.POSITION_CONTROL,
            targetPositions=self.path.position.tolist(),
            targetVelocities=self.path.velocity.tolist(),
            forces=self._efforts,
            positionGains=[0.2] * len(self._links),
            physicsClientId=self._client,
        )
