"""A shipped scene with its simulated cameras, and the C++ perception behind them; no ROS between."""

from __future__ import annotations

from dataclasses import replace
from typing import List, Optional, Sequence, Tuple

import numpy as np

from support.perception_chain import ChainMap, KnownBody, KnownSolid, PerceptionChain
from yarm.sim.engine.world import SimWorld
from yarm.sim.scenes.bodies import Body, FramedSolid
from yarm.sim.scenes.scene import load_scene
from yarm.sim.sensors.camera_model import CLOUD_DTYPE, Cloud
from yarm.sim.sensors.cameras import Eyes

CAMERAS = (1, 2, 3, 4)
TICKS_A_SET = 2


def known_body(body: Body) -> KnownBody:
    """A simulated body as the registry tells it."""
    solids = tuple(known_solid(item) for item in body.solids)
    return KnownBody(body.name, body.kind, not body.dynamic, body.seed_frame, tuple(body.link_frames), solids)


def known_solid(item: FramedSolid) -> KnownSolid:
    """A simulated solid, in the C++ core's convention of sizes."""
    size = tuple(item.solid.size)
    if item.solid.shape == "cylinder":
        size = (size[0], 0.0, size[1])
    elif item.solid.shape == "sphere":
        size = (size[0], 0.0, 0.0)
    return KnownSolid(item.solid.shape, size, item.frame, item.T_frame_solid)


class SimulatedCell:
    """A simulated scene, its cameras and the perception chain."""

    def __init__(
        self,
        scene: str,
        hands: bool = False,
        start: Optional[Tuple[float, float]] = None,
        visibility: bool = False,
        places: Sequence[Tuple[float, float, float]] = (),
    ) -> None:
        """Load it; noise is on.

        Args:
            scene: a shipped one.
            hands: its mobile robots carry a hand.
            visibility: judge what the cameras see of the cells.
            start: middle of its first robot, x, y, metres, in place of the scene's.
            places: middles of its robots, x, y, metres, and headings of their arms, rad, in place of the scene's.
        """
        loaded = load_scene(scene)
        if start is not None:
            first = replace(loaded.robots[0], x=start[0], y=start[1])
            loaded = replace(loaded, robots=(first, *loaded.robots[1:]))
        if places:
            robots = tuple(replace(r, x=x, y=y, heading_rad=yaw) for r, (x, y, yaw) in zip(loaded.robots, places))
            loaded = replace(loaded, robots=robots)
        self.silent: Tuple[int, ...] = ()
        self.world = SimWorld(loaded, hands=hands)
        self.eyes = Eyes(self.world.scene.seed, noise=True)
        self.chain = PerceptionChain(visibility=visibility)
        self.frame = 0
        self.tell()

    def tell(self) -> None:
        """The cameras learn who is there."""
        self.eyes.look_at(self.world.bodies, self.world.transforms())

    def spawn_all(self) -> None:
        """Everything that the scene's events bring comes at once."""
        for event in self.world.scene.events:
            if event.spawn is not None:
                self.world.spawn(event.spawn)
        self.tell()

    def next_clouds(self, ticks: int = TICKS_A_SET) -> List[Cloud]:
        """Simulate up to the next camera set: the cloud of each camera, empty of those in ``silent``."""
        for _ in range(ticks):
            self.world.tick()
        self.frame += 1
        poses = dict(self.world.transforms())
        none: Cloud = np.zeros((0, 0), dtype=CLOUD_DTYPE)
        return [
            none if camera in self.silent else self.eyes.overhead_cloud(camera, poses, self.frame).copy()
            for camera in CAMERAS
        ]

    def bodies(self) -> List[KnownBody]:
        """Who is there, as the registry tells it."""
        return [known_body(body) for body in self.world.bodies.values() if body.registered]

    def next_set(self, calibrating: bool, ticks: int = TICKS_A_SET) -> ChainMap:
        """Simulate up to the next camera set and perceive it."""
        clouds, poses = self.next_clouds(ticks), dict(self.world.transforms())
        grasping = [name for name, hand in self.world.hands.items() if hand.grasping]
        return self.chain.process(
            clouds, self.eyes.overhead_poses, self.bodies(), poses, calibrating, self.world.time_ns, grasping
        )

    def close(self) -> None:
        """Free the chain and the world."""
        self.chain.close()
        self.world.close()
