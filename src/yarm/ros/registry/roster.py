"""Who of a scene is in the cell, judged by the frames that are heard; no ROS here.

What the scene fixes in place (tables, obstacles, targets, what a person names) is there, and its frames are the
roster's own to tell unless somebody else tells them. What drivers move (robots, arms) is there while all its frames
are told in the world and none of them is older than a limit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Dict, Iterable, List, Mapping, Optional, Tuple

import numpy as np

from yarm.geometry import FloatArray
from yarm.geometry.kinds import ObjectKind
from yarm.sim.scenes.bodies import Body, SpawnError

MOVED_M = 0.01
"""A piece is followed when it is seen this far from its frame, metres."""
OFF_M = 0.02
OFF_RAD = math.radians(1.0)
"""A frame that is told elsewhere than where the scene has it, by more than this, is worth a word."""


@dataclass(frozen=True, eq=False)
class HeardFrame:
    """A frame as it was heard: its parent, when, s (inf for one that always holds), and T_parent_frame (4, 4)."""

    parent: str
    stamp_s: float
    pose: FloatArray


@dataclass(frozen=True)
class Absence:
    """Why an object of the scene is not in the registry."""

    name: str
    reason: str


class Roster:
    """The bodies of a scene, the frames heard of them, and what a person has put in since. Not thread-safe."""

    def __init__(
        self,
        world: str,
        bodies: Iterable[Body],
        silent_s: float,
        cameras: Optional[Mapping[str, FloatArray]] = None,
    ) -> None:
        """Nothing heard yet.

        Args:
            world: name of the world's frame.
            bodies: everything of the scene that is to be told of; debris lies in its own frame, see ``add``.
            silent_s: age of a frame, s, from which on its body is not there.
            cameras: T_world_frame (4, 4) of frames to tell unless somebody else does.
        """
        self._cameras = dict(cameras or {})
        self._world, self._silent_s = world, silent_s
        self._bodies = {body.name: body for body in bodies if body.registered}
        self._fixed: Dict[str, HeardFrame] = {}
        self._moving: Dict[str, HeardFrame] = {}

    @property
    def named(self) -> Tuple[str, ...]:
        """Names of the debris, ordered."""
        return tuple(sorted(name for name, body in self._bodies.items() if body.kind == ObjectKind.DEBRIS))

    def hear(self, frame: str, heard: HeardFrame) -> None:
        """Take a transform that drivers tell; one with an infinite stamp always holds."""
        kept = self._fixed if math.isinf(heard.stamp_s) else self._moving
        before = kept.get(frame)
        if before is None or heard.stamp_s >= before.stamp_s:
            kept[frame] = heard

    def forget(self) -> None:
        """Time has started again: what moved is not known any more."""
        self._moving.clear()

    def add(self, body: Body) -> None:
        """Put in what a person names; its frames are the roster's own.

        Raises:
            SpawnError: the name is taken.
        """
        if body.name in self._bodies:
            raise SpawnError(f"name {body.name!r} is taken; in the cell: {', '.join(sorted(self._bodies))}")
        self._bodies[body.name] = body

    def remove(self, name: str) -> None:
        """Take out debris, a target or an obstacle; what has drivers comes and goes with its frames.

        Raises:
            SpawnError: no such object, or one that drivers tell of.
        """
        body = self._bodies.get(name)
        removable = sorted(b.name for b in self._bodies.values() if self._is_ours(b))
        if body is None or not self._is_ours(body):
            why = "nobody of that name is in the cell" if body is None else f"a {body.kind} with drivers stays"
            raise SpawnError(f"cannot remove {name!r}: {why}; removable: {', '.join(removable) or 'nothing'}")
        del self._bodies[name]

    def follow(self, name: str, place: Tuple[float, float, float]) -> bool:
        """Move a piece's frame to where its middle is seen, metres, world; true when it was elsewhere."""
        body = self._bodies.get(name)
        if body is None or body.kind != ObjectKind.DEBRIS:
            return False
        pose = body.static_frames[body.seed_frame].copy()
        if float(np.linalg.norm(pose[:3, 3] - place)) <= MOVED_M:
            return False
        pose[:3, 3] = place
        self._bodies[name] = replace(body, static_frames={body.seed_frame: pose})
        return True

    def own_frames(self) -> Dict[str, FloatArray]:
        """T_world_frame (4, 4) of each frame that the roster has to tell because nobody else does."""
        told = {*self._fixed, *self._moving}
        frames = dict(self._cameras)
        frames.update({f: pose for body in self._bodies.values() for f, pose in body.static_frames.items()})
        return {frame: pose for frame, pose in frames.items() if frame not in told}

    def present(self, now_s: float) -> Tuple[Body, ...]:
        """The bodies that are in the cell, those of the scene in its order."""
        return tuple(body for body in self._bodies.values() if not self._absence(body, now_s))

    def absent(self, now_s: float) -> List[Absence]:
        """The bodies that are not, and why."""
        found = [(body.name, self._absence(body, now_s)) for body in self._bodies.values()]
        return [Absence(name, reason) for name, reason in found if reason]

    def told_elsewhere(self) -> List[str]:
        """What is wrong with frames that somebody fixes elsewhere than the scene has them, a sentence each."""
        expected = [(frame, "the file of the cameras' poses", pose) for frame, pose in self._cameras.items()]
        for body in self._bodies.values():
            expected += [(frame, "the scene", pose) for frame, pose in body.static_frames.items()]
        found = []
        for frame, source, pose in expected:
            heard = self._fixed.get(frame)
            if heard is not None and heard.parent == self._world:
                found += _difference(frame, source, heard.pose, pose)
        return found

    def _is_ours(self, body: Body) -> bool:
        return set(body.frames) <= set(body.static_frames)

    def _absence(self, body: Body, now_s: float) -> str:
        own = {f for f in body.static_frames if f not in self._fixed and f not in self._moving}
        for frame in body.frames:
            if frame in own:
                continue
            heard = self._fixed.get(frame) or self._moving.get(frame)
            if heard is None:
                return f"no transform from {self._world} to {frame}"
            if heard.parent != self._world:
                return f"{frame} is told in {heard.parent}; the frames of robots and arms must be told in {self._world}"
            age_s = now_s - heard.stamp_s
            if age_s > self._silent_s:
                return f"{frame} was last told {age_s:.1f} s ago, at most {self._silent_s:g} s"
        return ""


def _difference(frame: str, source: str, told: FloatArray, drawn: FloatArray) -> List[str]:
    apart = np.linalg.inv(drawn) @ told
    off_m = float(np.linalg.norm(apart[:3, 3]))
    off_rad = math.acos(min(1.0, max(-1.0, 0.5 * (float(np.trace(apart[:3, :3])) - 1.0))))
    if off_m <= OFF_M and off_rad <= OFF_RAD:
        return []
    off = f"{off_m:.3f} m and {math.degrees(off_rad):.1f} deg"
    return [f"{frame}: /tf_static has it {off} from where {source} has it, and counts; one of them is wrong"]
