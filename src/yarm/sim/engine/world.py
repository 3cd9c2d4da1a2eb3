"""The simulated cell: physics on a fixed step, commands in, poses, contacts and clearances out."""

from __future__ import annotations

import itertools
import logging
import math
from dataclasses import dataclass, replace
from typing import Dict, Iterable, List, Mapping, Optional, Tuple

import numpy as np
import pybullet

from yarm.geometry import STRAY, FloatArray, transform_matrix
from yarm.geometry.kinds import GOAL_KINDS, ContactKind, ObjectKind
from yarm.params import param
from yarm.robots import bin as bins
from yarm.sim.engine.bodies import com_offset, link_names, load_floor, open_engine
from yarm.sim.engine.contacts import FLOOR, Contact, ContactLog
from yarm.sim.engine.things import fixture_body, thing_body
from yarm.sim.robots.ankurbot import Ankurbot
from yarm.sim.robots.arm import Arm
from yarm.sim.robots.hand import SuctionHand
from yarm.sim.scenes.bodies import Body, SpawnError
from yarm.sim.scenes.events import PUSH_SPEED_MPS
from yarm.sim.scenes.scene import Scene
from yarm.sim.scenes.specs import ThingSpec

LOG = logging.getLogger(__name__)

STEPS_PER_SECOND = 240
STEPS_PER_TICK = 4
TICK_S = STEPS_PER_TICK / STEPS_PER_SECOND
AT_REST_MPS = 0.01
"""Debris slower than this is at rest."""
STRAY_REACH_M = 0.3
"""A piece that nobody registered is the one that perception means when it is so near, metres."""
OVERLAP_M = 0.002
"""A body put into the cell may overlap another by this much (things at rest do), metres."""

__all__ = ["SimWorld", "SpawnError", "WorldParams"]


@dataclass(frozen=True)
class WorldParams:
    """Limits of the mobile robots' drives."""

    wheel_speed_limit: float = param(5.0, "m/s", "greatest speed of a wheel over the floor", low=0.1, high=10.0)
    wheel_acceleration: float = param(4.0, "m/s^2", "greatest change of a wheel's speed", low=0.5, high=8.0)
    clearance_range: float = param(0.5, "m", "clearances beyond this count as infinite", low=0.05, high=5.0)


@dataclass
class _Push:
    name: str
    dx: float
    dy: float
    left_s: float


@dataclass
class _Walk:
    name: str
    velocity: FloatArray
    left_s: float


@dataclass(frozen=True)
class ClearanceReading:
    """Least distance, metres, of a robot to the nearest body it must not touch; inf and "" when none is near."""

    robot: str
    nearest: str
    distance_m: float


class SimWorld:
    """A PyBullet world without a window. Not thread-safe. Close it when done, or use it as a context manager."""

    def __init__(
        self, scene: Scene, params: Optional[WorldParams] = None, gui: bool = False, hands: bool = False
    ) -> None:
        """Build the scene.

        Args:
            scene: what is in it.
            params: limits of the drives.
            gui: show PyBullet's window.
            hands: all mobile robots carry a hand, drawn up; without, those whose type has one.

        Raises:
            SpawnError: bodies of the scene overlap; the message names them all.
        """
        self.scene = scene
        self._hands = hands
        self.params = params or WorldParams()
        self._client = open_engine(STEPS_PER_SECOND, gui)
        self.steps = 0
        self.robots: Dict[str, Ankurbot] = {}
        self.arms: Dict[str, Arm] = {}
        self._tucked: Dict[str, Arm] = {}
        self.bodies: Dict[str, Body] = {}
        self.version = 0
        self._pushes: List[_Push] = []
        self._walks: List[_Walk] = []
        self._walked: Dict[str, FloatArray] = {}
        self._poses: Dict[str, FloatArray] = {}
        self._poses_step = -1
        stations = {arm.name: {f.type: f.name for f in scene.fixtures_of(arm.name)} for arm in scene.arms}
        self._bolted = frozenset(fixture.name for fixture in scene.placed_fixtures)
        self.contacts = ContactLog(self._client, stations)
        self._floor = load_floor(self._client)
        self.contacts.register(self._floor, "floor", FLOOR, ["floor"])
        self._populate()

    def __enter__(self) -> SimWorld:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the engine."""
        if self._client >= 0:
            pybullet.disconnect(physicsClientId=self._client)
            self._client = -1

    @property
    def client(self) -> int:
        """PyBullet's number of this world, for tests that ask the engine itself."""
        return self._client

    @property
    def hands(self) -> Dict[str, SuctionHand]:
        """The hand of each mobile robot that has one."""
        return {name: robot.hand for name, robot in self.robots.items() if robot.hand is not None}

    @property
    def time_ns(self) -> int:
        """Simulated time, nanoseconds."""
        return self.steps * 1_000_000_000 // STEPS_PER_SECOND

    @property
    def time_s(self) -> float:
        """Simulated time, s."""
        return self.steps / STEPS_PER_SECOND

    def tick(self) -> List[str]:
        """One tick: drive commands to the wheels, then STEPS_PER_TICK physics steps.

        Returns:
            names of robots whose yaw rate means nothing because their wheels are parallel.
        """
        limits = self.params
        lost = [
            name
            for name, robot in self.robots.items()
            if not robot.update(TICK_S, limits.wheel_acceleration, limits.wheel_speed_limit)
        ]
        for _ in range(STEPS_PER_TICK):
            for arm in self.arms.values():
                arm.update(1.0 / STEPS_PER_SECOND)
            if self._pushes:
                self._apply_pushes()
            if self._walks:
                self._apply_walks()
            pybullet.stepSimulation(physicsClientId=self._client)
            self.contacts.collect()
            self.steps += 1
        self.contacts.set_held({name: piece for name in self.robots if (piece := self._on_hand(name))})
        return lost

    def run(self, seconds: float) -> None:
        """Tick for a simulated time, s."""
        for _ in range(round(seconds / TICK_S)):
            self.tick()

    def transforms(self) -> Mapping[str, FloatArray]:
        """T_world_frame (4, 4) of every tf frame of every object."""
        if self._poses_step != self.steps:
            poses: Dict[str, FloatArray] = {}
            for body in self.bodies.values():
                poses.update(body.static_frames)
                if body.kind == ObjectKind.DEBRIS:
                    poses[body.name] = self._root_pose(body.uids[0])
            poses.update(self._walked)
            for robot in self.robots.values():
                poses.update(robot.transforms())
            for arm in (*self.arms.values(), *self._tucked.values()):
                poses.update(arm.transforms())
            self._poses, self._poses_step = poses, self.steps
        return self._poses

    def seed_xy(self) -> Dict[str, Tuple[float, float]]:
        """Seed position x, y of each object, metres, world."""
        poses = self.transforms()
        return {
            body.name: (float(poses[body.seed_frame][0, 3]), float(poses[body.seed_frame][1, 3]))
            for body in self.bodies.values()
        }

    @property
    def debris(self) -> List[str]:
        """Names of the pieces of debris in the cell, ordered."""
        return sorted(body.name for body in self.bodies.values() if body.kind == ObjectKind.DEBRIS)

    def bin_of(self, name: str) -> str:
        """Name of the bin that a piece of debris is in: its middle inside, at rest, in nobody's hand; empty for none.

        Raises:
            KeyError: no such piece.
        """
        uid = self.bodies[name].uids[0]
        velocity, _ = pybullet.getBaseVelocity(uid, physicsClientId=self._client)
        held = any(hand.held_uid == uid for hand in self.hands.values())
        if held or float(np.linalg.norm(velocity)) >= AT_REST_MPS:
            return ""
        middle = self._root_pose(uid)[:, 3]
        within = (spec.name for spec in self.scene.bins if bins.inside(self._in_bin(spec.name, middle)))
        return next(within, "")

    def meant(self, goal: str, robot: str) -> str:
        """Name of the body that a robot's goal is.

        Debris that perception named is what the robot holds, else the piece that nobody registered nearest to its tip.
        """
        on_hand = self._on_hand(robot) if goal.startswith(STRAY) else ""
        return on_hand or (goal if robot not in self.robots else self.named(goal, self.seed_xy()[robot]))

    def named(self, name: str, xy: Tuple[float, float]) -> str:
        """Name of a body here: what perception calls debris_auto_<n> is the unregistered piece nearest to a place.

        Args:
            name: as perception has it.
            xy: where it is, metres, world.
        """
        places = self.seed_xy() if name.startswith(STRAY) and name not in self.bodies else {}
        strays = {
            body.name: math.dist(xy, places[body.name])
            for body in (self.bodies.values() if places else ())
            if body.kind == ObjectKind.DEBRIS and not body.registered
        }
        nearest = min(strays, key=lambda stray: strays[stray], default=name)
        return nearest if strays.get(nearest, math.inf) <= STRAY_REACH_M else name

    def clearances(self) -> List[ClearanceReading]:
        """Least distance between each robot (and arm) and everything it must not touch."""
        return [self._clearance(name) for name in (*self.robots, *self.arms)]

    def spawn(self, spec: ThingSpec) -> None:
        """Put debris, a target or an obstacle into the cell.

        Raises:
            SpawnError: the name is taken, or it would be inside another body; nothing changes then.
        """
        if spec.name in self.bodies or spec.name == "floor":
            raise SpawnError(f"name {spec.name!r} is taken; in the cell: {', '.join(sorted(self.bodies))}")
        body = thing_body(self._client, spec)
        overlapping = [name for uid in body.uids for name in self._overlapping(uid)]
        if overlapping:
            for uid in body.uids:
                pybullet.removeBody(uid, physicsClientId=self._client)
            raise SpawnError(f"{spec.name} at ({spec.x:.3f}, {spec.y:.3f}, {spec.z:.3f}) is inside {overlapping[0]}")
        self._add(body)

    def delete(self, name: str) -> None:
        """Take debris, a target or an obstacle out of the cell.

        Raises:
            SpawnError: no such object, or one that is bolted down or a robot.
        """
        body = self.bodies.get(name)
        deletable = sorted(b.name for b in self.bodies.values() if self._deletable(b))
        if body is None or not self._deletable(body):
            why = "nobody of that name is in the cell" if body is None else f"a {body.kind} of the cell stays"
            raise SpawnError(f"cannot delete {name!r}: {why}; deletable: {', '.join(deletable) or 'nothing'}")
        for hand in self.hands.values():
            if hand.held_uid in body.uids:
                hand.off()
        for uid in body.uids:
            self.contacts.forget(uid)
            pybullet.removeBody(uid, physicsClientId=self._client)
        del self.bodies[name]
        self._pushes = [push for push in self._pushes if push.name != name]
        self._walks = [walk for walk in self._walks if walk.name != name]
        self._walked.pop(name, None)
        self._poses_step = -1
        self.version += 1

    def push(self, name: str, dx_m: float, dy_m: float) -> bool:
        """Push a debris along (dx, dy), metres; false when it is not in the cell."""
        body = self.bodies.get(name)
        distance = float(np.hypot(dx_m, dy_m))
        if body is None or body.kind != ObjectKind.DEBRIS or distance == 0.0:
            return False
        self._pushes.append(_Push(name, dx_m / distance, dy_m / distance, distance / PUSH_SPEED_MPS))
        return True

    def walk(self, name: str, dx_m: float, dy_m: float, speed_mps: float) -> bool:
        """Let an obstacle nobody registered, or a bin, go along (dx, dy), metres; it stops for nothing.

        Returns:
            false without one.
        """
        body = self.bodies.get(name)
        distance = float(np.hypot(dx_m, dy_m))
        walks = body is not None and (name in {spec.name for spec in self.scene.bins} or not body.registered)
        if body is None or body.kind != ObjectKind.OBSTACLE or not walks or distance == 0.0:
            return False
        if name not in self._walked:
            self._walked[name] = body.static_frames[name].copy()
            self.bodies[name] = replace(body, static_frames={})
            self.version += 1
        velocity = np.array([dx_m, dy_m, 0.0]) * speed_mps / distance
        self._walks.append(_Walk(name, velocity, distance / speed_mps))
        return True

    def fail_vacuum(self, robot: str, failed: bool) -> bool:
        """Let the vacuum of a robot's hand fail, or work again; false for a robot without a hand."""
        hand = self.hands.get(robot)
        if hand is not None:
            hand.fail(failed)
        return hand is not None

    def failures(self) -> List[Contact]:
        """Contacts that nobody may make, since contacts were last taken."""
        return [contact for contact in self.contacts.take() if contact.kind is ContactKind.FAILURE]

    def _deletable(self, body: Body) -> bool:
        return body.kind in GOAL_KINDS or (body.kind == ObjectKind.OBSTACLE and body.name not in self._bolted)

    def _populate(self) -> None:
        for fixture in self.scene.placed_fixtures:
            self._add(fixture_body(self._client, fixture))
        for robot in self.scene.robots:
            self.robots[robot.name] = Ankurbot(self._client, robot, self._hands)
            self._add(self.robots[robot.name].body)
        for arm in self.scene.arms:
            built = Arm(self._client, arm)
            (self._tucked if arm.tucked else self.arms)[arm.name] = built
            self._add(built.body)
        for thing in self.scene.things:
            self._add(thing_body(self._client, thing))
        overlaps = self._all_overlaps()
        if overlaps:
            self.close()
            raise SpawnError(f"scene {self.scene.name}: " + "; ".join(f"{a} overlaps {b}" for a, b in overlaps))

    def _add(self, body: Body) -> None:
        for uid in body.uids:
            self.contacts.register(uid, body.name, body.kind, link_names(self._client, uid))
        self.bodies[body.name] = body
        self._poses_step = -1
        self.version += 1

    def _root_pose(self, uid: int) -> FloatArray:
        position, quaternion = pybullet.getBasePositionAndOrientation(uid, physicsClientId=self._client)
        pose: FloatArray = transform_matrix(position, quaternion) @ np.linalg.inv(com_offset(self._client, uid))
        return pose

    def _in_bin(self, name: str, point: FloatArray) -> FloatArray:
        """A point (4,) of the world in a bin's frame: the middle of its floor area, wherever the bin was moved to."""
        pose = self.transforms()[name].copy()
        pose[2, 3] -= bins.RIM_M
        return np.asarray(np.linalg.inv(pose) @ point)

    def _apply_pushes(self) -> None:
        for push in self._pushes:
            uid = self.bodies[push.name].uids[0]
            (_, _, vz), spin = pybullet.getBaseVelocity(uid, physicsClientId=self._client)
            velocity = [push.dx * PUSH_SPEED_MPS, push.dy * PUSH_SPEED_MPS, vz]
            pybullet.resetBaseVelocity(uid, velocity, spin, physicsClientId=self._client)
            push.left_s -= 1.0 / STEPS_PER_SECOND
        self._pushes = [push for push in self._pushes if push.left_s > 0.0]

    def _apply_walks(self) -> None:
        for walk in self._walks:
            uid = self.bodies[walk.name].uids[0]
            step = walk.velocity * min(walk.left_s, 1.0 / STEPS_PER_SECOND)
            position, quaternion = pybullet.getBasePositionAndOrientation(uid, physicsClientId=self._client)
            moved = np.asarray(position) + step
            pybullet.resetBasePositionAndOrientation(uid, moved.tolist(), quaternion, physicsClientId=self._client)
            self._walked[walk.name][:3, 3] += step
            walk.left_s -= 1.0 / STEPS_PER_SECOND
        self._walks = [walk for walk in self._walks if walk.left_s > 0.0]

    def _pair_distance(self, one: Iterable[int], other: Iterable[int], range_m: float) -> float:
        least = np.inf
        for a, b in itertools.product(one, other):
            for point in pybullet.getClosestPoints(a, b, range_m, physicsClientId=self._client):
                least = min(least, point[8])
        return float(least)

    def _clearance(self, name: str) -> ClearanceReading:
        body = self.bodies[name]
        nearest, least = "", np.inf
        for other in self.bodies.values():
            if other is body or not other.uids or self._may_touch(body, other):
                continue
            distance = self._pair_distance(body.uids, other.uids, self.params.clearance_range)
            if distance < least:
                nearest, least = other.name, distance
        return ClearanceReading(name, nearest, float(least))

    def _on_hand(self, robot: str) -> str:
        """Name of the piece that hangs on a robot's hand; empty for none, and for what has no hand."""
        hand = self.robots[robot].hand if robot in self.robots else None
        held = None if hand is None else hand.held_uid
        return "" if held is None else next((body.name for body in self.bodies.values() if held in body.uids), "")

    def _may_touch(self, body: Body, other: Body) -> bool:
        """Whether a robot's distance to the other body says nothing about safety (its goal, an arm's part)."""
        if body.kind == ObjectKind.MANIPULATOR:
            return other.name in self.contacts.stations[body.name].values() or other.kind == ObjectKind.DEBRIS
        goals, held = self.contacts.goals, self.contacts.held
        own = (goals.get(body.name, "" if goals else other.name), held.get(body.name))
        return other.kind == ObjectKind.DEBRIS and other.name in own

    def _overlapping(self, uid: int) -> List[str]:
        """Bodies, and the floor, that a body overlaps."""
        others = [("floor", self._floor)] + [(b.name, u) for b in self.bodies.values() for u in b.uids]
        return [
            name for name, other in others if other != uid and self._pair_distance([uid], [other], 0.0) < -OVERLAP_M
        ]

    def _stand_of(self, arm: str) -> str:
        return self.contacts.stations.get(arm, {}).get("stand", "")

    def _all_overlaps(self) -> List[Tuple[str, str]]:
        """Pairs of bodies that overlap, arm on stand apart."""
        found = []
        for a, b in itertools.combinations(self.bodies.values(), 2):
            bolted = self._stand_of(a.name) == b.name or self._stand_of(b.name) == a.name
            if not bolted and self._pair_distance(a.uids, b.uids, 0.0) < -OVERLAP_M:
                found.append((a.name, b.name))
        return found
