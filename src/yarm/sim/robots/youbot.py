"""The youBot in PyBullet: a mecanum base driven as a holonomic one, five motors, a suction cup.

The rollers are not modelled. The wheels carry the base without friction; what they push with is a force towards the
commanded velocity, no greater than their grip, and a share of the velocity is lost to slip: more of it sideways, where
the rollers work against each other.
"""

from __future__ import annotations

import math
from typing import Dict, List, Tuple

import numpy as np
import pybullet

from yarm.geometry import FloatArray, Pose2, transform_matrix
from yarm.robots.youbot import JOINT_NAMES, mechanical_angles, urdf_angles, urdf_rates
from yarm.sim.engine.bodies import link_names, load_urdf, set_root_pose
from yarm.sim.robots.errors import CommandError
from yarm.sim.robots.suction import SuctionCup
from yarm.sim.scenes.bodies import description

FASTEST_MPS, FASTEST_RADPS = 0.5, 1.0
SLIP = (0.02, 0.10, 0.05)
"""Shares of the commanded speed ahead, sideways and of the turn that are lost on an average floor."""
SLIP_NOISE = 0.02
"""Standard deviation of these shares from one moment to the next."""
GRIP = 0.5
"""Greatest push, as a share of the weight."""
PUSH_PER_S, TURN_PER_S = 20.0, 20.0
"""How quickly the base's speed goes to the commanded one, 1/s."""
MOTOR_GAIN = 0.3
T_LINK5_FACE = transform_matrix((0.0, 0.0, 0.055), (1.0, 0.0, 0.0, 0.0))
"""Middle of the cup's face in arm_link_5, z into the cup."""


class Youbot:
    """Base, arm and cup. ``update`` once a physics step."""

    def __init__(self, client: int, start: Pose2, joints: FloatArray, rng: np.random.Generator) -> None:
        """Put it on the floor.

        Args:
            client: PyBullet's number of the world.
            start: of the base's middle, world.
            joints: mechanical angles (5,), rad.
            rng: of the slip.
        """
        text, self._model = description("youbot.urdf.xacro", system="manipulation")
        self._client, self._rng = client, rng
        self.uid = load_urdf(client, text, (start.x, start.y, 0.0), start.yaw_rad, fixed=False, round_sides=True)
        set_root_pose(client, self.uid, (start.x, start.y, 0.0), start.yaw_rad)
        self.links = link_names(client, self.uid)
        self._base = self.links.index("base_link")
        self._joints = [self.links.index(self._model.joints[name].child) for name in JOINT_NAMES]
        self._efforts = [self._model.joints[name].effort for name in JOINT_NAMES]
        self.mass_kg = sum(
            pybullet.getDynamicsInfo(self.uid, link, physicsClientId=client)[0]
            for link in range(-1, len(self.links) - 1)
        )
        self._free_wheels()
        self.cup = SuctionCup(client, self.uid, self.links.index("suction_cup"), T_LINK5_FACE)
        self._command = np.zeros(3)
        self._set(joints)

    def drive(self, velocity: FloatArray) -> None:
        """Command the base: (3,) m/s ahead and to the left, rad/s; each is cut to what the base can.

        Raises:
            CommandError: not three finite numbers.
        """
        wanted = np.asarray(velocity, dtype=float)
        if wanted.shape != (3,) or not np.all(np.isfinite(wanted)):
            raise CommandError(f"velocity {wanted.tolist()} must be 3 finite numbers")
        speed = math.hypot(wanted[0], wanted[1])
        share = min(1.0, FASTEST_MPS / speed) if speed > 0.0 else 1.0
        turn = min(max(wanted[2], -FASTEST_RADPS), FASTEST_RADPS)
        self._command = np.array([share * wanted[0], share * wanted[1], turn])

    def follow(self, joints: FloatArray, speeds: FloatArray) -> None:
        """Set-points of the arm's motors: mechanical angles (5,), rad, and their speeds (5,), rad/s."""
        pybullet.setJointMotorControlArray(
            self.uid,
            self._joints,
            pybullet.POSITION_CONTROL,
            targetPositions=urdf_angles(joints).tolist(),
            targetVelocities=urdf_rates(speeds).tolist(),
            forces=self._efforts,
            positionGains=[MOTOR_GAIN] * len(self._joints),
            physicsClientId=self._client,
        )

    def update(self) -> None:
        """Push the base, and let the cup take, hold or lose."""
        pose, moving = self.pose(), self._velocity()
        slip = np.clip(np.array(SLIP) + self._rng.normal(0.0, SLIP_NOISE, 3), 0.0, 1.0)
        c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
        ahead, left, turn = (1.0 - slip) * self._command
        wanted = np.array([c * ahead - s * left, s * ahead + c * left])
        push = self.mass_kg * PUSH_PER_S * (wanted - moving[:2])
        most = GRIP * self.mass_kg * 9.81
        push *= min(1.0, most / max(float(np.linalg.norm(push)), 1e-9))
        # The whole robot turns about its middle: a push at the centre of mass would turn it with an arm put out.
        inertia = self.mass_kg * 0.05
        twist = min(max(inertia * TURN_PER_S * (turn - moving[2]), -0.2 * most), 0.2 * most)
        self._apply(push, twist)
        self.cup.update_cup()

    def pose(self) -> Pose2:
        """Where the base's middle is, world."""
        state = pybullet.getLinkState(self.uid, self._base, True, physicsClientId=self._client)
        turn = transform_matrix(state[4], state[5])
        return Pose2(float(turn[0, 3]), float(turn[1, 3]), math.atan2(turn[1, 0], turn[0, 0]))

    def link_frames(self) -> Dict[str, Tuple[float, ...]]:
        """The frame of each link but the root: x, y, z, metres, world, and its quaternion x, y, z, w."""
        states = pybullet.getLinkStates(
            self.uid, list(range(len(self.links) - 1)), computeForwardKinematics=True, physicsClientId=self._client
        )
        return {name: (*state[4], *state[5]) for name, state in zip(self.links, states)}

    def joints(self) -> FloatArray:
        """Mechanical angles (5,), rad, where the motors have them."""
        states = pybullet.getJointStates(self.uid, self._joints, physicsClientId=self._client)
        return mechanical_angles([state[0] for state in states])

    def joint_rates(self) -> FloatArray:
        """Speeds of the mechanical angles (5,), rad/s."""
        states = pybullet.getJointStates(self.uid, self._joints, physicsClientId=self._client)
        return urdf_rates([state[1] for state in states])

    def touching(self) -> List[Tuple[str, int, float]]:
        """What touches it: its link, the other body's PyBullet number, and the force, N."""
        found: Dict[Tuple[str, int], float] = {}
        for point in pybullet.getContactPoints(self.uid, physicsClientId=self._client):
            if point[8] <= 0.0:
                key = (self.links[point[3]], int(point[2]))
                found[key] = found.get(key, 0.0) + float(point[9])
        return [(link, body, force) for (link, body), force in found.items()]

    def _velocity(self) -> FloatArray:
        state = pybullet.getLinkState(self.uid, self._base, 1, physicsClientId=self._client)
        return np.array([state[6][0], state[6][1], state[7][2]])

    def _apply(self, push: FloatArray, twist: float) -> None:
        at = pybullet.getLinkState(self.uid, self._base, physicsClientId=self._client)[0]
        frame = pybullet.WORLD_FRAME
        pybullet.applyExternalForce(
            self.uid, self._base, (*push.tolist(), 0.0), at, frame, physicsClientId=self._client
        )
        pybullet.applyExternalTorque(self.uid, self._base, (0.0, 0.0, twist), frame, physicsClientId=self._client)

    def _free_wheels(self) -> None:
        for link, name in enumerate(self.links[:-1]):
            if name.startswith("wheel_"):
                pybullet.changeDynamics(
                    self.uid, link, lateralFriction=0.0, frictionAnchor=0, physicsClientId=self._client
                )
                pybullet.setJointMotorControl2(
                    self.uid, link, pybullet.VELOCITY_CONTROL, force=0.0, physicsClientId=self._client
                )

    def _set(self, joints: FloatArray) -> None:
        for link, angle in zip(self._joints, urdf_angles(joints).tolist()):
            pybullet.resetJointState(self.uid, link, angle, physicsClientId=self._client)
        self.follow(joints, np.zeros(5))
