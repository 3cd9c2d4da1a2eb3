"""A mobile robot of the controls server: pose goals, CALIBRATION, and PICK and DROP with a hand."""

from __future__ import annotations

import math
from typing import Callable, List, Optional, Tuple

import numpy as np
import rospy
from geometry_msgs.msg import Pose, Twist
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from yarm.control.actions import MobileAction, SearchSpace
from yarm.control.base.controller import BaseCommand, BaseController, BaseGoal, Outcome
from yarm.control.base.footprint import Box, box_around, extent_in_cells
from yarm.control.base.kinematics import Casters, full_turn
from yarm.geometry import STRAY, transform_matrix
from yarm.geometry.grid import GridSpec
from yarm.geometry.kinds import ObjectKind
from yarm.geometry.poses import Pose2, yaw_of_quaternion
from yarm.msg import MoveRobotFeedback, MoveRobotGoal, RegisteredObject
from yarm.robots import bin as bins
from yarm.robots.ankurbot import (
    ANKURBOT_BEAMS,
    ANKURBOT_DISCS,
    ARM_REACH_M,
    HAND_EE_HEIGHT_M,
    LIFT_JOINT,
    drawn_up,
)
from yarm.ros.common import names
from yarm.ros.common.checks import FARTHEST_M, Doorkeeper, joints_fault, present_s
from yarm.ros.common.clock import SAME_TICK_S
from yarm.ros.common.solids import solids_of
from yarm.ros.controls.hand import Hand
from yarm.ros.controls.params import ControlsServerParams
from yarm.ros.controls.robots import End, Outbox, RobotUnit, SeedPose

REGISTRY_WAIT_S = 3.0
RESEND_S = 0.5
CASTER_CHANGE_RAD = 1e-4
VIA_YAW_DEG = 0.5
"""Poses a goal goes by may differ from its target's heading by this."""
MOST_VIA = 100
HAND_ACTIONS = (MobileAction.PICK, MobileAction.DROP)


class MobileUnit(RobotUnit):
    """Drives one omnidirectional robot."""

    kind = ObjectKind.MOBILE

    def __init__(
        self,
        name: str,
        params: ControlsServerParams,
        registered: Callable[[str], Optional[RegisteredObject]],
        wake: Callable[[], None],
    ) -> None:
        """Advertise and subscribe.

        Args:
            name: of the robot.
            params: the server's.
            registered: entry of the object registry by name.
            wake: called when something a tick may wait for has come.
        """
        self._name = name
        self._params = params
        self._registered = registered
        self._wake = wake
        self._controller = BaseController(params)
        self._calibration_s: Optional[float] = None
        self._calibrating = False
        self._hand: Optional[Hand] = None
        self._hand_action: Optional[MobileAction] = None
        self._casters: Optional[Casters] = None
        self._casters_s = -math.inf
        self._sent: Tuple[Optional[Casters], float] = (None, 0.0)
        self._velocity = (0.0, 0.0, 0.0)
        self._acceleration = (0.0, 0.0)
        self._velocity_s = 0.0
        self._outbox = Outbox()
        self._cmd_vel = self._outbox.publisher(names.cmd_vel(name), Twist)
        self._steer = [self._outbox.publisher(names.caster_command(name, caster), Float64) for caster in names.CASTERS]
        self._door = Doorkeeper(names.joint_states(name))
        self._joints = rospy.Subscriber(
            names.joint_states(name), JointState, self._on_joints, queue_size=5, tcp_nodelay=True
        )

    def refusal(self, goal: MoveRobotGoal) -> str:
        """Pose goals need finite poses, all at one heading."""
        if not self.drives(goal):
            return ""
        fault = pose_fault("target", goal.target) or via_fault(goal)
        if fault:
            return fault
        if MobileAction.of(goal.action) in HAND_ACTIONS and (self._hand is None or not self._hand.known):
            return f"{goal.action}: {self._name} has no hand, or nobody moves it ({names.lift_command(self._name)})"
        return hand_fault(goal.action, self._registered)

    def drives(self, goal: MoveRobotGoal) -> bool:
        """Every goal but a calibration moves the base."""
        return MobileAction.of(goal.action) is not MobileAction.CALIBRATE

    def continues(self, goal: MoveRobotGoal) -> bool:
        """A goal that goes by where the straight way being driven ends; a hand's work is done standing."""
        return self._hand_action is None and self.drives(goal) and self._controller.continues(self._base_goal(goal))

    def _base_goal(self, goal: MoveRobotGoal) -> BaseGoal:
        action = MobileAction.of(goal.action)
        near_m = self._params.hand_tolerance_m if action in HAND_ACTIONS else None
        via = tuple(target_pose(pose) for pose in goal.via)
        return BaseGoal(target_pose(goal.target), action is MobileAction.ABOUT_BODY, near_m, via)

    def start(self, goal: MoveRobotGoal) -> None:
        """Calibrate, or drive to the target; over it the hand may have work."""
        action = MobileAction.of(goal.action)
        self._calibrating = not self.drives(goal)
        self._calibration_s = None
        self._hand_action = action if action in HAND_ACTIONS else None
        if not self._calibrating:
            self._controller.start(self._base_goal(goal))

    def cancel(self, reason: str) -> None:
        """Zero velocity at once; a hand is drawn up."""
        self._calibrating = False
        self._hand_action = None
        if self._hand is not None:
            self._hand.stop()
        self._send(self._controller.stop(reason), self._sent[1])

    def tick(self, pose: SeedPose, now_s: float) -> Optional[End]:
        """One step of the controller."""
        planar = Pose2(float(pose.position[0]), float(pose.position[1]), yaw_of_quaternion(pose.quaternion))
        if self._calibrating:
            return self._calibrate(now_s)
        if self._hand is not None and self._hand.active:
            return self._hand.tick(now_s)
        return self._drive(planar, pose.stamp_s, now_s)

    def hold(self) -> None:
        """Zero velocity; the goal goes on with the next pose."""
        if self._controller.active:
            self._send(self._controller.pause(), self._sent[1])

    def feedback(self, feedback: MoveRobotFeedback) -> None:
        """Velocity and acceleration of the end effector."""
        feedback.vx, feedback.vy = self._velocity[:2]
        feedback.ax, feedback.ay = self._acceleration
        if self._hand is not None:
            feedback.lift = self._hand.lift_m
            feedback.stage = self._hand.stage if self._hand.active else "aligning" if self._hand_action else ""

    def ready(self, stamp_s: float) -> bool:
        """The casters' angles of this tick are here, and in lock-step its hand's word."""
        return self._casters_s >= stamp_s - SAME_TICK_S and (self._hand is None or self._hand.ready(stamp_s))

    def reset(self) -> None:
        """Forget goal, stamps and counts."""
        self._calibrating = False
        self._hand_action = None
        if self._hand is not None:
            self._hand.reset()
        self._controller.reset()
        self._casters, self._casters_s = None, -math.inf
        self._sent, self._velocity_s = (None, 0.0), 0.0
        self._outbox.sent = 0

    def close(self) -> None:
        """Withdraw all topics."""
        self._joints.unregister()
        if self._hand is not None:
            self._hand.close()
        self._outbox.close()

    @property
    def simulator_commands(self) -> int:
        """Messages sent to the simulator so far."""
        return self._outbox.sent

    def _drive(self, planar: Pose2, stamp_s: float, now_s: float) -> Optional[End]:
        """One step of the base; where it has arrived, the hand begins."""
        was_active = self._controller.active
        if was_active and self._casters is None:
            return self._without_casters(now_s)
        if was_active and self._hand is not None:
            free, end = self._hand.before_driving(now_s)
            if not free:
                return self._stand(end)
        command = self._controller.step(planar, self._casters or (0.0, 0.0, 0.0, 0.0), stamp_s)
        self._note_velocity(stamp_s)
        if not was_active:
            return None
        self._send(command, now_s)
        if command.outcome is Outcome.ACTIVE:
            return None
        action, self._hand_action = self._hand_action, None
        if command.outcome is Outcome.SUCCEEDED and action is not None and self._hand is not None:
            return self._hand.start(action, now_s)
        return command.outcome, command.reason

    def _stand(self, end: Optional[End]) -> Optional[End]:
        """Zero velocity while the hand is down; the end of the goal when it does not come up."""
        if end is None:
            self.hold()
            return None
        outcome, reason = end
        self._hand_action = None
        self._send(self._controller.stop(reason, outcome), self._sent[1])
        return end

    def _calibrate(self, now_s: float) -> Optional[End]:
        if self._calibration_s is None:
            self._calibration_s = now_s
        entry = self._registered(self._name)
        boxes = [] if entry is None else boxes_in_base(entry, self._name) if entry.shapes else type_boxes()
        if boxes:
            self._calibrating = False
            area = ",".join(str(n) for n in extent_in_cells(boxes, GridSpec()))
            return Outcome.SUCCEEDED, SearchSpace.XY.answer(area)
        if now_s - self._calibration_s > REGISTRY_WAIT_S:
            self._calibrating = False
            return Outcome.ABORTED, f"{names.OBJECT_REGISTRY} has had no solids of {self._name} for {REGISTRY_WAIT_S} s"
        return None

    def _without_casters(self, now_s: float) -> Optional[End]:
        if self._calibration_s is None:
            self._calibration_s = now_s
        if now_s - self._calibration_s <= REGISTRY_WAIT_S:
            return None
        reason = f"nothing on {names.joint_states(self._name)} for {REGISTRY_WAIT_S} s: caster angles are unknown"
        self._controller.stop(reason, Outcome.ABORTED)
        return Outcome.ABORTED, reason

    def _on_joints(self, message: JointState) -> None:
        if self._door.refuses(message, joints_fault(message, present_s(self._params.sync))):
            return
        angles = dict(zip(message.name, message.position))
        try:
            fl, fr, rl, rr = (angles[f"{caster}_caster_joint"] for caster in names.CASTERS)
        except KeyError as missing:
            rospy.logerr_throttle(10.0, f"{names.joint_states(self._name)} lacks {missing}: {list(message.name)}")
            return
        if LIFT_JOINT in angles:
            self._note_hand(angles[LIFT_JOINT], dict(zip(message.name, message.velocity)).get(LIFT_JOINT, 0.0))
        self._casters, self._casters_s = (fl, fr, rl, rr), message.header.stamp.to_sec()
        self._wake()

    def _note_hand(self, lift_m: float, speed_mps: float) -> None:
        """Take in the lift of a hand; the first word of it is how the robot is known to have one."""
        if self._hand is None:
            self._hand = Hand(self._name, self._params, self._outbox, self._wake, self._params.sync)
        self._hand.note_joint(lift_m, speed_mps)

    def _send(self, command: BaseCommand, now_s: float) -> None:
        last, last_s = self._sent
        if command.casters is not None and (
            last is None
            or now_s - last_s > RESEND_S
            or any(abs(a - b) > CASTER_CHANGE_RAD for a, b in zip(command.casters, last))
        ):
            for publisher, angle in zip(self._steer, command.casters):
                self._outbox.send(publisher, Float64(angle))
            self._sent = (command.casters, now_s)
        twist = Twist()
        twist.linear.x, twist.angular.z = command.drive_mps, command.yaw_rate_radps
        self._outbox.send(self._cmd_vel, twist)

    def _note_velocity(self, stamp_s: float) -> None:
        velocity, dt_s = self._controller.velocity(), stamp_s - self._velocity_s
        if dt_s > 1e-6:
            ax, ay = ((new - old) / dt_s for new, old in zip(velocity[:2], self._velocity[:2]))
            self._acceleration = (ax, ay)
        self._velocity, self._velocity_s = velocity, stamp_s


def hand_fault(action: str, registered: Callable[[str], Optional[RegisteredObject]]) -> str:
    """What is wrong with the name in a PICK or a DROP; empty for any other action, and when nothing is.

    Args:
        action: of the goal.
        registered: entry of the object registry by name.
    """
    kind, name = MobileAction.of(action), action.partition(" ")[2].strip()
    if kind not in HAND_ACTIONS:
        return ""
    wanted, example = ("a piece of debris", "debris_1") if kind is MobileAction.PICK else ("a bin", "bin_1")
    entry = registered(name)
    if not name:
        return f"{action!r} needs the name of {wanted}, as in '{kind.value} {example}'"
    if entry is None and not (kind is MobileAction.PICK and name.startswith(STRAY)):
        return f"{action}: nobody in {names.OBJECT_REGISTRY} is called {name}"
    fits = entry is None or (entry.object == ObjectKind.DEBRIS if kind is MobileAction.PICK else bins.is_bin(name))
    return "" if fits else f"{action}: {name} is no {wanted[2:]}"


def pose_fault(what: str, pose: Pose) -> str:
    """What is wrong with a pose of a goal; empty when nothing is."""
    position, q = pose.position, pose.orientation
    values = (position.x, position.y, position.z, q.x, q.y, q.z, q.w)
    norm = math.hypot(q.x, q.y, q.z, q.w)
    if not all(abs(v) <= FARTHEST_M for v in values) or abs(norm - 1.0) > 0.01:
        limits = f"finite, within {FARTHEST_M:g} m, with a quaternion of length 1 (it is {norm:.3g})"
        return f"{what} {values} must be {limits}"
    return ""


def via_fault(goal: MoveRobotGoal) -> str:
    """What is wrong with the poses a goal goes by; empty when nothing is. The base does not turn at them."""
    if len(goal.via) > MOST_VIA:
        return f"via has {len(goal.via)} poses; at most {MOST_VIA} are taken, send the rest with later goals"
    for k, pose in enumerate(goal.via):
        fault = pose_fault(f"via[{k}]", pose)
        if fault:
            return fault
        off_deg = math.degrees(abs(full_turn(target_pose(pose).yaw_rad - target_pose(goal.target).yaw_rad)))
        if off_deg > VIA_YAW_DEG:
            return f"via[{k}] is turned by {off_deg:.1f} deg from the target, allowed {VIA_YAW_DEG:g}: end a goal there"
    return ""


def target_pose(pose: Pose) -> Pose2:
    """Pose in the plane of a geometry_msgs/Pose."""
    q = pose.orientation
    return Pose2(pose.position.x, pose.position.y, yaw_of_quaternion((q.x, q.y, q.z, q.w)))


def type_boxes() -> List[Box]:
    """Boxes around the solids of the type of robot this unit drives, for one whose own nobody drew."""
    discs = [
        ((d.x - d.radius, d.y - d.radius, d.z[0]), (d.x + d.radius, d.y + d.radius, d.z[1])) for d in ANKURBOT_DISCS
    ]
    beams = [((b.x[0], b.y[0], b.z[0]), (b.x[1], b.y[1], b.z[1])) for b in ANKURBOT_BEAMS]
    return [(np.array(lower), np.array(upper)) for lower, upper in (*discs, *beams)]


def boxes_in_base(entry: RegisteredObject, name: str) -> List[Box]:
    """Boxes around a robot's registered solids, in its base frame, a hand drawn up."""
    T_base_ee = transform_matrix((ARM_REACH_M, 0.0, HAND_EE_HEIGHT_M), (0.0, 0.0, 0.0, 1.0))
    own = []
    for frame, solid in solids_of(entry):
        T_ee_frame = drawn_up(name, frame)
        if T_ee_frame is not None:
            own.append(solid.seen_from(T_base_ee @ T_ee_frame))
        elif frame == names.base_frame(name):
            own.append(solid)
    return [box_around(solid.half_extent, solid.pose) for solid in own]
