"""The two kinds of robots in PyBullet: their motors, their frames."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Sequence, Tuple

import numpy as np
import pybullet
import yaml

from yarm.geometry import FloatArray, transform_matrix, wrap_angle
from yarm.geometry.urdf import UrdfModel
from yarm.resources import resource
from yarm.sim.bodies import Body, FramedSolid, com_offset, description, link_names, load_urdf
from yarm.sim.drive import CASTER_NAMES, WHEEL_RADIUS_M, wheel_speeds
from yarm.sim.joint_path import JointLimits, JointPath

CASTER_TORQUE_NM = 50.0
CASTER_SPEED_RPS = 12.0
WHEEL_TORQUE_NM = 20.0
TOOL_FRAMES = ("tool0", "sander_tip", "wrist_camera_optical_frame")


class CommandError(ValueError):
    """A command was refused; the message names the value and what is accepted."""


@dataclass(frozen=True)
class CasterReading:
    """One caster's controller: commanded and measured angle, rad, speed, rad/s, and motor torque, N m."""

    set_point: float
    angle: float
    speed: float
    torque: float


class Ankurbot:
    """Four steered, driven casters under a body with a fixed arm. Moves only through its wheels."""

    def __init__(self, client: int, name: str, x: float, y: float, heading_rad: float) -> None:
        """Put the robot on the floor at its body centre x, y, metres, with the arm along ``heading_rad``."""
        text, model = description("ankurbot.urdf.xacro")
        self._client = client
        self.uid = load_urdf(client, text, (x, y, 0.0), heading_rad, fixed=False)
        self._T_com_root = np.linalg.inv(com_offset(client, self.uid))
        names = link_names(client, self.uid)
        self._casters = [names.index(f"{caster}_caster") for caster in CASTER_NAMES]
        self._wheels = [names.index(f"{caster}_wheel") for caster in CASTER_NAMES]
        self._T_base_ee = model.rigid_group("ee")[1]
        self.reach_m = float(self._T_base_ee[0, 3])
        self.body = _mobile_body(name, self.uid, model)
        self._set_points = np.zeros(4)
        self._drive = (0.0, 0.0)
        self._wheel_mps = np.zeros(4)
        for caster in range(4):
            self._steer_motor(caster)
        self._drive_motors()

    def steer(self, caster: str, angle_rad: float) -> bool:
        """Command one caster's angle, clamped to [-pi, pi]; true when it had to be clamped.

        Raises:
            CommandError: not finite.
        """
        if not math.isfinite(angle_rad):
            raise CommandError(f"caster {caster}: angle {angle_rad} must be a finite number of rad")
        index = CASTER_NAMES.index(caster)
        clamped = min(max(angle_rad, -math.pi), math.pi)
        if clamped != self._set_points[index]:
            self._set_points[index] = clamped
            self._steer_motor(index)
        return abs(clamped - angle_rad) > 1e-6

    def drive(self, speed_mps: float, yaw_rate_rps: float, limit_mps: float) -> bool:
        """Command drive speed and yaw rate; wheel speeds are limited, m/s; true when the drive speed was clamped.

        Raises:
            CommandError: not finite.
        """
        if not (math.isfinite(speed_mps) and math.isfinite(yaw_rate_rps)):
            raise CommandError(f"drive speed {speed_mps} m/s and yaw rate {yaw_rate_rps} rad/s must be finite numbers")
        clamped = min(max(speed_mps, -limit_mps), limit_mps)
        self._drive = (clamped, yaw_rate_rps)
        return clamped != speed_mps

    def update(self, dt_s: float, acceleration: float, limit_mps: float) -> bool:
        """Once a tick: wheel speeds from the command and the measured casters, ramped by ``acceleration`` m/s^2.

        Returns:
            false when a yaw rate is commanded while the wheels are parallel, so that it means nothing.
        """
        if self._drive == (0.0, 0.0) and not np.any(self._wheel_mps):
            return True
        result = wheel_speeds(self.caster_angles(), *self._drive)
        wanted = result.speeds_mps
        fastest = float(np.max(np.abs(wanted)))
        if fastest > limit_mps:
            wanted = wanted * (limit_mps / fastest)
        step = acceleration * dt_s
        change = wanted - self._wheel_mps
        largest = float(np.max(np.abs(change)))
        self._wheel_mps = wanted.copy() if largest <= step else self._wheel_mps + change * (step / largest)
        self._drive_motors()
        return result.has_centre

    def caster_angles(self) -> FloatArray:
        """Measured caster angles (4,), rad."""
        states = pybullet.getJointStates(self.uid, self._casters, physicsClientId=self._client)
        return np.array([state[0] for state in states])

    def caster_readings(self) -> List[CasterReading]:
        """State of each caster's controller, in the order of CASTER_NAMES."""
        states = pybullet.getJointStates(self.uid, self._casters, physicsClientId=self._client)
        return [CasterReading(float(goal), s[0], s[1], s[3]) for goal, s in zip(self._set_points, states)]

    def joint_readings(self) -> Tuple[List[str], List[float], List[float]]:
        """Names, positions (rad, wheels wrapped) and speeds (rad/s) of casters and wheels."""
        states = pybullet.getJointStates(self.uid, self._casters + self._wheels, physicsClientId=self._client)
        names = [f"{c}_caster_joint" for c in CASTER_NAMES] + [f"{c}_wheel_joint" for c in CASTER_NAMES]
        return names, [wrap_angle(state[0]) for state in states], [state[1] for state in states]

    def transforms(self) -> Dict[str, FloatArray]:
        """T_world_frame (4, 4) of its frames."""
        position, quaternion = pybullet.getBasePositionAndOrientation(self.uid, physicsClientId=self._client)
        T_world_base = transform_matrix(position, quaternion) @ self._T_com_root
        name = self.body.name
        return {f"{name}/base_link": T_world_base, f"{name}/ee": T_world_base @ self._T_base_ee}

    def _steer_motor(self, index: int) -> None:
        pybullet.setJointMotorControl2(
            self.uid,
            self._casters[index],
            pybullet.POSITION_CONTROL,
            targetPosition=float(self._set_points[index]),
            force=CASTER_TORQUE_NM,
            maxVelocity=CASTER_SPEED_RPS,
            physicsClientId=self._client,
        )

    def _drive_motors(self) -> None:
        if not np.any(self._wheel_mps):
            self._brake()
            return
        pybullet.setJointMotorControlArray(
            self.uid,
            self._wheels,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=(self._wheel_mps / WHEEL_RADIUS_M).tolist(),
            forces=[WHEEL_TORQUE_NM] * 4,
            physicsClientId=self._client,
        )

    def _brake(self) -> None:
        """Hold the wheels at their angles: a motor that only holds speed 0 creeps by some mm a minute."""
        states = pybullet.getJointStates(self.uid, self._wheels, physicsClientId=self._client)
        pybullet.setJointMotorControlArray(
            self.uid,
            self._wheels,
            pybullet.POSITION_CONTROL,
            targetPositions=[state[0] for state in states],
            forces=[WHEEL_TORQUE_NM] * 4,
            physicsClientId=self._client,
        )


def _mobile_body(name: str, uid: int, model: UrdfModel) -> Body:
    """Body whose solids, wheels too (balls: their turning changes nothing), are all in base_link."""
    base = f"{name}/base_link"
    solids = []
    for solid in model.solids:
        pose = solid.T_link_solid
        link = solid.link
        while link != "base_link":
            joint = next(j for j in model.joints.values() if j.child == link)
            pose, link = joint.T_parent_child @ pose, joint.parent
        solids.append(FramedSolid(base, solid, pose))
    return Body(name, "Mobile", True, f"{name}/ee", (base, f"{name}/ee"), tuple(solids), (uid,))


@dataclass(frozen=True)
class ArmMount:
    """Where an arm is bolted (x, y, z, metres, world) and its storage pose (rad), from config/hc10.yaml."""

    base_xyz: Tuple[float, float, float]
    storage: Tuple[float, ...]


def arm_mount() -> ArmMount:
    """Read config/hc10.yaml."""
    raw = yaml.safe_load(resource("config", "hc10.yaml").read_text(encoding="utf-8"))
    x, y, z = raw["base_xyz"]
    return ArmMount((float(x), float(y), float(z)), tuple(float(angle) for angle in raw["storage"]))


class Arm:
    """The HC10: six position-controlled joints that follow streamed trajectories."""

    def __init__(self, client: int, name: str, tucked: bool = False) -> None:
        """Bolt the arm to its stand in its storage pose.

        Args:
            client: PyBullet's number of the world.
            name: unique name.
            tucked: it stays so (see ArmSpec).
        """
        text, self._model = description("hc10.urdf.xacro")
        mount = arm_mount()
        self._client = client
        self.uid = load_urdf(client, text, mount.base_xyz, 0.0, fixed=True)
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
        self._T_world_base = transform_matrix(mount.base_xyz, (0.0, 0.0, 0.0, 1.0))
        self._tools = [(tool, *self._model.rigid_group(tool)) for tool in TOOL_FRAMES]
        self.body = _arm_body(name, self.uid, self._model, self._T_world_base, tucked)
        self.place(mount.storage)

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


def _arm_body(name: str, uid: int, model: UrdfModel, T_world_base: FloatArray, tucked: bool) -> Body:
    """Body whose solids are in the frame of the moving link that carries them."""
    solids = []
    for solid in model.solids:
        link, T_group_link = model.rigid_group(solid.link)
        solids.append(FramedSolid(f"{name}/{link}", solid, T_group_link @ solid.T_link_solid))
    frames = ("base_link", *(joint.child for joint in model.moving_joints), "tool0")
    base = f"{name}/base_link"
    return Body(
        name,
        "Obstacle" if tucked else "Manipulator",
        not tucked,
        f"{name}/tool0",
        tuple(f"{name}/{frame}" for frame in frames),
        tuple(solids),
        (uid,),
        {base: T_world_base},
    )
