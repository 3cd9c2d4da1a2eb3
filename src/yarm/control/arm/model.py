"""The HC10's kinematics from its URDF: frames, Jacobian and inverse kinematics of the sander's tip (PyKDL).

Joint vectors are (6,), rad, in the order of the URDF. All poses are in the frame of the arm's station
(``yarm.robots.hc10.Station``), metres: the world's, unless the station is moved.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, Optional, Sequence, Tuple

import numpy as np
import PyKDL

from yarm.control.arm.errors import ArmError
from yarm.geometry.grid import FloatArray
from yarm.geometry.urdf import Joint, JointKind, UrdfModel, expand_xacro, parse_urdf
from yarm.resources import resource
from yarm.robots.hc10 import arm_mount

TIP_LINK = "sander_tip"
CAMERA_LINK = "wrist_camera_optical_frame"
IK_TOLERANCE_M = 1e-5
IK_ITERATIONS = 200
STALLED_TOLERANCE = 2e-4
"""Near a singular wrist KDL stops with an error although it is there within this, m and rad."""


@dataclass(frozen=True, eq=False)
class JointLimits:
    """Lower and upper angle, rad, and greatest speed, rad/s, of each joint; (6,) each."""

    lower: FloatArray
    upper: FloatArray
    speed: FloatArray

    def __post_init__(self) -> None:
        """Refuse limits that no angle keeps.

        Raises:
            ArmError: not finite, a lower limit that is not under its upper one, or a speed that is not above 0.
        """
        for joint, (low, high, speed) in enumerate(zip(self.lower, self.upper, self.speed), start=1):
            if not (np.all(np.isfinite((low, high, speed))) and low < high and speed > 0.0):
                raise ArmError(
                    f"joint {joint}: limits {low:g} to {high:g} rad at {speed:g} rad/s; "
                    "the lower one must be under the upper one, the speed above 0"
                )

    def contain(self, q: FloatArray) -> bool:
        """Whether every joint (..., 6) is within its limits."""
        return bool(np.all(q >= self.lower) and np.all(q <= self.upper))


@dataclass(frozen=True, eq=False)
class ArmDescription:
    """What is known of the arm before it moves.

    Attributes:
        urdf: its URDF text.
        model: the same, parsed.
        base_xyz: where it is bolted, not turned, metres, frame of its station.
        storage: storage pose, (6,) rad.
        limits: of the joints.
    """

    urdf: str
    model: UrdfModel
    base_xyz: FloatArray
    storage: FloatArray
    limits: JointLimits


def load_arm(storage: Sequence[float] = ()) -> ArmDescription:
    """The shipped HC10 (urdf/cell/hc10.urdf.xacro, config/cell/hc10.yaml).

    Args:
        storage: its storage pose, (6,) rad; empty for the shipped one.
    """
    urdf = expand_xacro(resource("urdf", "cell", "hc10.urdf.xacro"))
    mount = arm_mount()
    model = parse_urdf(urdf)
    joints = model.moving_joints
    limits = JointLimits(
        np.array([j.lower for j in joints]), np.array([j.upper for j in joints]), np.array([j.velocity for j in joints])
    )
    return ArmDescription(urdf, model, np.array(mount.base_xyz), np.array(storage or mount.storage), limits)


class ArmKinematics:
    """Forward and inverse kinematics. Not thread-safe (KDL's solvers keep state): one instance a thread."""

    def __init__(self, arm: ArmDescription) -> None:
        """Build the chains.

        Args:
            arm: the description.
        """
        self.limits = arm.limits
        self._T_world_base = np.eye(4)
        self._T_world_base[:3, 3] = arm.base_xyz
        self._chains = {link: _chain(arm.model, link) for link in (TIP_LINK, CAMERA_LINK)}
        self._forward = {link: PyKDL.ChainFkSolverPos_recursive(chain) for link, chain in self._chains.items()}
        weights = np.array([[1.0], [1.0], [1.0], [0.3], [0.3], [0.3]])
        self._inverse = PyKDL.ChainIkSolverPos_LMA(self._chains[TIP_LINK], weights, IK_TOLERANCE_M, IK_ITERATIONS)
        self._jacobian = PyKDL.ChainJntToJacSolver(self._chains[TIP_LINK])

    def tip(self, q: FloatArray) -> FloatArray:
        """Pose (4, 4) of the sander's tip."""
        return self._pose(TIP_LINK, q)

    def camera(self, q: FloatArray) -> FloatArray:
        """Pose (4, 4) of the wrist camera's optical frame."""
        return self._pose(CAMERA_LINK, q)

    def jacobian(self, q: FloatArray) -> FloatArray:
        """(6, 6): joint speeds to the tip's velocity (3, m/s) and angular velocity (3, rad/s), world axes."""
        jacobian = PyKDL.Jacobian(6)
        self._jacobian.JntToJac(_joints(q), jacobian)
        return np.array([[jacobian[row, column] for column in range(6)] for row in range(6)])

    def solve(self, pose: FloatArray, guess: FloatArray) -> Optional[FloatArray]:
        """Joints (6,) within their limits at which the tip has a pose (4, 4), found from a guess; None without."""
        target = np.linalg.inv(self._T_world_base) @ pose
        frame = PyKDL.Frame(
            PyKDL.Rotation(*(float(v) for v in target[:3, :3].ravel())),
            PyKDL.Vector(*(float(v) for v in target[:3, 3])),
        )
        answer = PyKDL.JntArray(6)
        stalled = self._inverse.CartToJnt(_joints(guess), frame, answer) < 0
        found = np.array([answer[i] for i in range(6)])
        if stalled and np.max(np.abs(self.tip(found) - pose)) > STALLED_TOLERANCE:
            return None
        q = self._unwound(found, guess)
        return q if self.limits.contain(q) else None

    def _unwound(self, q: FloatArray, guess: FloatArray) -> FloatArray:
        """The same angles, whole turns nearest to the guess or, where that is out of limits, within them."""
        near = guess + np.remainder(q - guess + math.pi, 2.0 * math.pi) - math.pi
        near = np.where(near > self.limits.upper, near - 2.0 * math.pi, near)
        unwound: FloatArray = np.where(near < self.limits.lower, near + 2.0 * math.pi, near)
        return unwound

    def _pose(self, link: str, q: FloatArray) -> FloatArray:
        frame = PyKDL.Frame()
        self._forward[link].JntToCart(_joints(q), frame)
        pose = np.eye(4)
        pose[:3, :3] = [[frame.M[row, column] for column in range(3)] for row in range(3)]
        pose[:3, 3] = [frame.p[i] for i in range(3)]
        result: FloatArray = self._T_world_base @ pose
        return result


def tool_pose(point: FloatArray, normal: FloatArray, yaw_rad: float) -> FloatArray:
    """Pose (4, 4) of the tip standing on a point of a surface: its z against the normal, its x turned by the yaw.

    Args:
        point: (3,), metres, world.
        normal: (3,), out of the surface, of length 1.
        yaw_rad: direction of the tool's x axis about world z.
    """
    zx, zy, zz = (-float(v) for v in normal)
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    yx, yy, yz = -zz * s, zz * c, zx * s - zy * c
    length = math.sqrt(yx * yx + yy * yy + yz * yz)
    yx, yy, yz = yx / length, yy / length, yz / length
    xx, xy, xz = yy * zz - yz * zy, yz * zx - yx * zz, yx * zy - yy * zx
    px, py, pz = (float(v) for v in point)
    return np.array([[xx, yx, zx, px], [xy, yy, zy, py], [xz, yz, zz, pz], [0.0, 0.0, 0.0, 1.0]])


def _joints(q: FloatArray) -> PyKDL.JntArray:
    array = PyKDL.JntArray(6)
    for index, value in enumerate(q):
        array[index] = float(value)
    return array


def _chain(model: UrdfModel, tip: str) -> PyKDL.Chain:
    """Chain from the URDF's root to a link."""
    parents: Dict[str, Joint] = {joint.child: joint for joint in model.joints.values()}
    path = []
    link = tip
    while link in parents:
        path.append(parents[link])
        link = parents[link].parent
    chain = PyKDL.Chain()
    for joint in reversed(path):
        offset = _frame(joint.T_parent_child)
        if joint.kind is JointKind.FIXED:
            chain.addSegment(PyKDL.Segment(joint.child, PyKDL.Joint(joint.name), offset))
        else:
            axis = offset.M * PyKDL.Vector(*joint.axis)
            moving = PyKDL.Joint(joint.name, offset.p, axis, PyKDL.Joint.RotAxis)
            chain.addSegment(PyKDL.Segment(joint.child, moving, offset))
    return chain


def _frame(matrix: FloatArray) -> PyKDL.Frame:
    values: Tuple[float, ...] = tuple(float(v) for v in matrix[:3, :3].ravel())
    return PyKDL.Frame(PyKDL.Rotation(*values), PyKDL.Vector(*(float(v) for v in matrix[:3, 3])))
