"""Camera sets of a simulated cell in which robots and the arm move, as messages; needs no ROS master."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Iterator, List, Tuple

import numpy as np
import rospy
from yarm.msg import ObjectRegistry

from support.golden import to_bytes
from yarm.ros.common import names
from yarm.ros.common.bodies import registry_entry, transform_message
from yarm.ros.simulation.clouds import RawCloud
from yarm.ros.simulation.outbox import frame_poses
from yarm.sim.engine.world import SimWorld
from yarm.sim.scenes.scene import load_scene
from yarm.sim.scenes.specs import ThingSpec
from yarm.sim.sensors.camera_model import KINECT
from yarm.sim.sensors.cameras import Eyes

CAMERAS = (1, 2, 3, 4)
TICKS_A_SET = 2
STILL_SETS = 6
SPEED_MPS = 0.3
DEBRIS = ThingSpec("debris_9", "Debris", -0.2, 0.1, 0.76, 0.5, ())


@dataclass(frozen=True)
class WholeSet:
    """One capture time.

    Attributes:
        stamp_ns: capture time, ns.
        still: nothing has moved yet.
        frames: serialised TFMessage of every frame that moves.
        fixed_frames: serialised TFMessage of the others.
        registry: serialised ObjectRegistry.
        clouds: points of each camera, (height, width) of ``CLOUD_DTYPE``, optical frame.
        cameras: T_world_optical (4, 4) of each camera.
    """

    stamp_ns: int
    still: bool
    frames: bytes
    fixed_frames: bytes
    registry: bytes
    clouds: Tuple[np.ndarray, ...]
    cameras: Tuple[np.ndarray, ...]

    def messages(self) -> List[bytes]:
        """The clouds as serialised PointCloud2."""
        stamp = rospy.Time(*divmod(self.stamp_ns, 10**9))
        raw = [RawCloud(names.camera_optical_frame(c), KINECT.height, KINECT.width, 16) for c in CAMERAS]
        return [to_bytes(r.fill(stamp, np.ascontiguousarray(cloud))) for r, cloud in zip(raw, self.clouds)]


def camera_sets(scene: str) -> Iterator[WholeSet]:
    """Sets without end, at the cameras' rate: ``STILL_SETS`` at rest, then debris appears and everybody moves."""
    with SimWorld(load_scene(scene)) as world:
        eyes = Eyes(1, True)
        version, count = -1, 0
        while True:
            if count == STILL_SETS:
                world.spawn(DEBRIS)
                _set_off(world)
            for _ in range(TICKS_A_SET):
                world.tick()
            if version != world.version:
                version = world.version
                eyes.look_at(world.bodies, world.transforms())
            yield _whole(world, eyes, count)
            count += 1


def _set_off(world: SimWorld) -> None:
    for robot in world.robots.values():
        robot.drive(SPEED_MPS, 0.0, 5.0)
    for arm in world.arms.values():
        joints, at, _ = arm.joint_readings()
        ahead = [[at[0] + turn, *at[1:]] for turn in (0.2, 0.4, 0.6)]
        arm.follow(joints, ahead, [1.0, 2.0, 3.0])


def _whole(world: SimWorld, eyes: Eyes, count: int) -> WholeSet:
    poses = world.transforms()
    stamp = rospy.Time(*divmod(world.time_ns, 10**9))
    fixed: Dict[str, np.ndarray] = frame_poses(list(eyes.overhead_poses))
    for body in world.bodies.values():
        fixed.update(body.static_frames)
    moving = {frame: pose for frame, pose in poses.items() if frame not in fixed}
    registry = ObjectRegistry(entries=[registry_entry(body) for body in world.bodies.values()])
    return WholeSet(
        stamp.to_nsec(),
        count < STILL_SETS,
        to_bytes(transform_message(stamp, moving)),
        to_bytes(transform_message(stamp, fixed)),
        to_bytes(registry),
        tuple(eyes.overhead_cloud(camera, poses, count).copy() for camera in CAMERAS),
        tuple(np.asarray(pose) for pose in eyes.overhead_poses),
    )
