"""The URDF's chain, multiplied out, is the closed form."""

from __future__ import annotations

import numpy as np

from yarm.geometry.urdf import expand_xacro, parse_urdf
from yarm.manipulation.kinematics.forward import forward_many
from yarm.resources import resource
from yarm.robots.youbot import JOINT_NAMES, random_joints, urdf_angles


def test_the_urdf_puts_the_hand_where_the_closed_form_does() -> None:
    model = parse_urdf(expand_xacro(resource("urdf", "manipulation", "youbot.urdf.xacro"), base="false"))
    q = random_joints(np.random.default_rng(5), 200)
    for joints, pose in zip(urdf_angles(q), forward_many(q)):
        reached = model.rigid_group("arm_link_0")[1]
        for name, angle in zip(JOINT_NAMES, joints):
            joint = model.joints[name]
            x, y, z = joint.axis
            cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
            turn = np.eye(4)
            turn[:3, :3] += np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
            reached = reached @ joint.T_parent_child @ turn
        reached = reached @ model.rigid_group("arm_link_ee")[1]
        assert np.max(np.abs(reached - pose)) < 1e-9
