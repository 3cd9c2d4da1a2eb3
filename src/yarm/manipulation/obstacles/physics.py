"""The arm and its obstacles in PyBullet: motions are played with motors and gravity, and whatever touches is counted.

The check is independent of the planning: another engine, other distances, joints where the motors really bring them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Dict, FrozenSet, List, Optional, Sequence, Set, Tuple

import numpy as np
import pybullet

from yarm.geometry import FloatArray
from yarm.geometry.solids import Shape, Solid
from yarm.manipulation.motion.checkpoints import ArmScene
from yarm.manipulation.motion.trajectory import Trajectory
from yarm.manipulation.obstacles.collision import arm_description, separate_links
from yarm.manipulation.obstacles.ways import FIELDS, Ways
from yarm.robots.youbot import JOINT_NAMES, mechanical_angles, urdf_angles, urdf_rates
from yarm.sim.engine.bodies import link_names, load_urdf

STEPS_PER_SECOND = 240
SETTLE_S = 0.25
"""The motors get this long to arrive after each motion's end."""
REACHED_M = 0.005
REACHED_RAD = 0.02
FIELD_REACHED_M = 0.025
GAIN = 0.3


@dataclass(frozen=True, eq=False)
class LegPlayed:
    """What came of the way to one checkpoint.

    Attributes:
        goal: name of the checkpoint.
        reached: the hand ended at its position, and, but for the fields, with its tool's axis.
        off_m: distance left.
        touches: "link and obstacle", or two links: how often each pair began to touch.
        hand: (m, 3) the hand's way, metres, arm's frame.
        reason: why it was not reached.
    """

    goal: str
    reached: bool
    off_m: float
    touches: Dict[str, int]
    hand: FloatArray
    reason: str


@dataclass(frozen=True, eq=False)
class TaskPlayed:
    """What came of a whole task.

    Attributes:
        legs: one for each checkpoint that was set out for.
        duration_s: simulated.
        tracking_rad: greatest distance of a joint from its set-point.
    """

    legs: Tuple[LegPlayed, ...]
    duration_s: float
    tracking_rad: float

    @property
    def touches(self) -> int:
        """Touches of all legs."""
        return sum(sum(leg.touches.values()) for leg in self.legs)

    @property
    def reached(self) -> int:
        """Checkpoints that were reached."""
        return sum(leg.reached for leg in self.legs)


ArmWatch = Callable[["ArmWorld"], None]
"""What looks on: it is given the world after each tick."""


def unwatched(world: ArmWorld) -> None:
    """Nobody looks."""


class ArmWorld:
    """A PyBullet world with the arm bolted down and obstacles that stay. Close it, or use it as a context manager."""

    def __init__(self, scene: ArmScene, solid: bool = True) -> None:
        """Put everything there, the arm at the scene's start.

        Args:
            scene: the task.
            solid: obstacles stop the arm; else it goes through them, and is only seen to touch.
        """
        self._client = pybullet.connect(pybullet.DIRECT)
        pybullet.setGravity(0.0, 0.0, -9.81, physicsClientId=self._client)
        pybullet.setTimeStep(1.0 / STEPS_PER_SECOND, physicsClientId=self._client)
        text, model = arm_description()
        self._arm = load_urdf(self._client, text, (0.0, 0.0, 0.0), 0.0, fixed=True)
        self._links = link_names(self._client, self._arm)
        self._joints = [self._links.index(model.joints[name].child) for name in JOINT_NAMES]
        self._efforts = [model.joints[name].effort for name in JOINT_NAMES]
        self._hand = self._links.index("arm_link_ee")
        self._own_pairs = [
            (self._links.index(a), self._links.index(b)) for a, b in separate_links(model) if "arm_frame" not in (a, b)
        ]
        self._obstacles = {self._add(obstacle.solid): obstacle.name for obstacle in scene.obstacles}
        if not solid:
            for obstacle in self._obstacles:
                pybullet.setCollisionFilterGroupMask(obstacle, -1, 0, 0, physicsClientId=self._client)
        self._touching: Set[str] = set()
        self.tracking_rad = 0.0
        self.time_s = 0.0
        self.motion: Optional[Trajectory] = None
        for index, angle in zip(self._joints, urdf_angles(scene.start).tolist()):
            pybullet.resetJointState(self._arm, index, angle, physicsClientId=self._client)

    def __enter__(self) -> ArmWorld:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the physics client."""
        pybullet.disconnect(self._client)

    @property
    def touching(self) -> FrozenSet[str]:
        """Pairs that touch now, as ``LegPlayed`` names them."""
        return frozenset(self._touching)

    def play(self, motions: Sequence[Trajectory], watch: ArmWatch = unwatched) -> Tuple[Dict[str, int], FloatArray]:
        """Follow motions one after the other; ``motion`` is the one that is under way.

        Args:
            motions: of the joints.
            watch: looks on.

        Returns:
            how often each pair began to touch, and the hand's way (m, 3), metres.
        """
        touches: Dict[str, int] = {}
        hand: List[FloatArray] = []
        for motion in motions:
            self.motion = motion
            steps = int(np.ceil((motion.duration_s + SETTLE_S) * STEPS_PER_SECOND))
            times = np.minimum(np.arange(1, steps + 1) / STEPS_PER_SECOND, motion.duration_s)
            wanted, speed, _ = motion.evaluate(times)
            moving = times < motion.duration_s
            for target, velocity in zip(urdf_angles(wanted), np.where(moving[:, None], speed, 0.0)):
                self._step(target, velocity, touches)
                hand.append(self.hand_pose()[:3, 3])
                watch(self)
        return touches, np.array(hand).reshape(-1, 3)

    def hand_pose(self) -> FloatArray:
        """Pose (4, 4) of the end effector, arm's frame, where physics has it."""
        state = pybullet.getLinkState(self._arm, self._hand, True, physicsClientId=self._client)
        pose = np.eye(4)
        pose[:3, 3] = state[4]
        pose[:3, :3] = np.reshape(pybullet.getMatrixFromQuaternion(state[5]), (3, 3))
        return pose

    def link_frames(self) -> Dict[str, Tuple[float, ...]]:
        """The frame of each link: x, y, z, metres, arm's frame, and its quaternion x, y, z, w."""
        states = pybullet.getLinkStates(
            self._arm, list(range(len(self._links) - 1)), computeForwardKinematics=True, physicsClientId=self._client
        )
        root = pybullet.getBasePositionAndOrientation(self._arm, physicsClientId=self._client)
        found = {name: (*state[4], *state[5]) for name, state in zip(self._links, states)}
        return {**found, self._links[-1]: (*root[0], *root[1])}

    def joints(self) -> FloatArray:
        """Joints (5,), mechanical, rad."""
        states = pybullet.getJointStates(self._arm, self._joints, physicsClientId=self._client)
        return mechanical_angles([state[0] for state in states])

    def _step(self, target: FloatArray, velocity: FloatArray, touches: Dict[str, int]) -> None:
        pybullet.setJointMotorControlArray(
            self._arm,
            self._joints,
            pybullet.POSITION_CONTROL,
            targetPositions=target.tolist(),
            targetVelocities=urdf_rates(velocity).tolist(),
            forces=self._efforts,
            positionGains=[GAIN] * len(self._joints),
            physicsClientId=self._client,
        )
        pybullet.stepSimulation(physicsClientId=self._client)
        self.time_s += 1.0 / STEPS_PER_SECOND
        off = float(np.max(np.abs(urdf_angles(self.joints()) - target)))
        self.tracking_rad = max(self.tracking_rad, off)
        now = self._touching_now()
        for pair in now - self._touching:
            touches[pair] = touches.get(pair, 0) + 1
        self._touching = now

    def _touching_now(self) -> Set[str]:
        """Pairs that overlap: links and obstacles, and links that are neither one rigid body nor neighbours."""
        found = set()
        for obstacle, name in self._obstacles.items():
            for point in pybullet.getClosestPoints(self._arm, obstacle, 0.0, physicsClientId=self._client):
                if self._links[point[3]] != "arm_link_0":
                    found.add(f"{self._links[point[3]]} and {name}")
        for a, b in self._own_pairs:
            if pybullet.getClosestPoints(self._arm, self._arm, 0.0, a, b, physicsClientId=self._client):
                found.add(f"{self._links[a]} and {self._links[b]}")
        return found

    def _add(self, solid: Solid) -> int:
        kinds = {
            Shape.BOX: pybullet.GEOM_BOX,
            Shape.CYLINDER: pybullet.GEOM_CYLINDER,
            Shape.SPHERE: pybullet.GEOM_SPHERE,
        }
        size: Dict[str, object] = {"halfExtents": [0.5 * value for value in solid.size]}
        if solid.shape == Shape.CYLINDER:
            size = {"radius": solid.size[0], "height": solid.size[1]}
        elif solid.shape == Shape.SPHERE:
            size = {"radius": solid.size[0]}
        shape = pybullet.createCollisionShape(kinds[solid.shape], physicsClientId=self._client, **size)
        yaw = float(np.arctan2(solid.pose[1, 0], solid.pose[0, 0]))
        return int(
            pybullet.createMultiBody(
                0.0,
                shape,
                basePosition=solid.pose[:3, 3].tolist(),
                baseOrientation=pybullet.getQuaternionFromEuler((0.0, 0.0, yaw)),
                physicsClientId=self._client,
            )
        )


def play_task(scene: ArmScene, ways: Ways, solid: bool = True, watch: ArmWatch = unwatched) -> TaskPlayed:
    """Play all ways of a task.

    Args:
        scene: the task.
        ways: how its checkpoints are to be reached.
        solid: see ``ArmWorld``.
        watch: looks on.
    """
    poses = {point.name: point.pose for point in scene.checkpoints}
    legs = []
    field = ways.variant in FIELDS
    with ArmWorld(scene, solid) as world:
        for leg in ways.legs:
            touches, hand = world.play(leg.motions, watch)
            reached = world.hand_pose()
            off = float(np.linalg.norm(reached[:3, 3] - poses[leg.goal][:3, 3]))
            tilt = float(np.linalg.norm(np.cross(reached[:3, 2], poses[leg.goal][:3, 2])))
            there = off < FIELD_REACHED_M if field else off < REACHED_M and tilt < REACHED_RAD
            reason = leg.reason or ("" if there else f"the hand ended {off:.3f} m from the checkpoint")
            legs.append(LegPlayed(leg.goal, there and leg.found, off, touches, hand, reason))
        return TaskPlayed(tuple(legs), world.time_s, world.tracking_rad)
