"""A suction cup in PyBullet: a fixed constraint with a limited force.

It is made when the cup presses on a body and covers it, and broken when the body is torn from where it was taken: a
piece can be missed, and can be lost.
"""

from __future__ import annotations

from typing import Dict, Optional

import numpy as np
import pybullet

from yarm.geometry import FloatArray, transform_matrix, transform_points

PRESS_N = 2.0
"""Force on the cup above which a seal can form."""
HOLDING_N = 20.0
"""Force with which the cup holds; what pulls harder tears the piece off."""
TORN_M = 0.010
"""A piece that has moved so far in the cup is lost."""
RAY_OFFSET_M = 0.012
RAYS_ON_BODY = 3
"""Of four rays beside the cup's middle so many must meet the body."""
RAY_FROM_M, RAY_TO_M = 0.031, -0.010
"""Rays begin over the cup, pass through it, and end under its face; metres over the face."""
HITS = 3
"""Hits of a ray that are looked at: the cup itself is one, and they come in no order."""


class SuctionCup:
    """The cup at one link of a robot. ``update_cup`` once a tick."""

    def __init__(self, client: int, uid: int, link: int, T_link_cup: FloatArray, holding_n: float = HOLDING_N) -> None:
        """Off, with nothing in it.

        Args:
            client: PyBullet's number of the world.
            uid: of the robot.
            link: PyBullet's number of the link that is the cup.
            T_link_cup: (4, 4) middle of the cup's face in the link's frame, z into the cup.
            holding_n: force with which the cup holds.
        """
        self._client, self._uid, self._link, self._holding_n = client, uid, link, holding_n
        self._T_link_cup = T_link_cup
        self._on, self._works = False, True
        self._constraint: Optional[int] = None
        self._held: Optional[int] = None
        self._taken: FloatArray = np.eye(4)
        self.lost = 0

    @property
    def grasping(self) -> bool:
        """Whether a body hangs on the cup."""
        return self._held is not None

    @property
    def held_uid(self) -> Optional[int]:
        """PyBullet's number of the body that hangs on the cup."""
        return self._held

    @property
    def cup(self) -> FloatArray:
        """T_world_cup (4, 4): middle of the cup's face, z into the cup, away from what it takes."""
        state = pybullet.getLinkState(self._uid, self._link, True, physicsClientId=self._client)
        return np.asarray(transform_matrix(state[4], state[5]) @ self._T_link_cup)

    def on(self) -> None:
        """Turn suction on: the cup takes what it presses on."""
        self._on = True

    def off(self) -> None:
        """Turn suction off: the cup lets go."""
        self._on = False
        self._release()

    def fail(self, failed: bool = True) -> None:
        """Let the vacuum fail, or work again: without it the cup takes nothing and loses what it holds."""
        self._works = not failed

    def press_n(self) -> Dict[int, float]:
        """Force of the cup on each body that it touches, N."""
        forces: Dict[int, float] = {}
        for point in pybullet.getContactPoints(self._uid, linkIndexA=self._link, physicsClientId=self._client):
            forces[point[2]] = forces.get(point[2], 0.0) + float(point[9])
        return forces

    def update_cup(self) -> None:
        """Take, hold or lose."""
        if self._held is not None:
            torn_m = float(np.linalg.norm(self._in_cup(self._held)[:3, 3] - self._taken[:3, 3]))
            if torn_m > TORN_M or not self._works:
                self.lost += 1
                self._release()
        elif self._on and self._works:
            pressed = {body: force for body, force in self.press_n().items() if force > PRESS_N}
            body = max(pressed, key=lambda uid: pressed[uid], default=None)
            if body is not None and self._covers(body):
                self._take(body)

    def _covers(self, body: int) -> bool:
        offsets = [(x, y) for x in (-RAY_OFFSET_M, RAY_OFFSET_M) for y in (-RAY_OFFSET_M, RAY_OFFSET_M)]
        ends = [
            transform_points(self.cup, [(x, y, height) for x, y in offsets]).tolist()
            for height in (RAY_FROM_M, RAY_TO_M)
        ]
        met = np.zeros(len(offsets), dtype=bool)
        for number in range(HITS):
            hits = pybullet.rayTestBatch(ends[0], ends[1], reportHitNumber=number, physicsClientId=self._client)
            met |= [hit[0] == body for hit in hits]
        return int(met.sum()) >= RAYS_ON_BODY

    def _take(self, body: int) -> None:
        self._taken = self._in_cup(body)
        state = pybullet.getLinkState(self._uid, self._link, True, physicsClientId=self._client)
        hand, piece = transform_matrix(state[0], state[1]), self._pose(body)
        between = np.linalg.inv(hand) @ piece
        turn = pybullet.multiplyTransforms(
            *pybullet.invertTransform(state[0], state[1]),
            (0.0, 0.0, 0.0),
            pybullet.getBasePositionAndOrientation(body, physicsClientId=self._client)[1],
        )[1]
        self._constraint = pybullet.createConstraint(
            self._uid,
            self._link,
            body,
            -1,
            pybullet.JOINT_FIXED,
            (0.0, 0.0, 0.0),
            between[:3, 3].tolist(),
            (0.0, 0.0, 0.0),
            turn,
            physicsClientId=self._client,
        )
        pybullet.changeConstraint(self._constraint, maxForce=self._holding_n, physicsClientId=self._client)
        self._held = body

    def _release(self) -> None:
        if self._constraint is not None:
            pybullet.removeConstraint(self._constraint, physicsClientId=self._client)
        self._constraint = self._held = None

    def _in_cup(self, body: int) -> FloatArray:
        return np.asarray(np.linalg.inv(self.cup) @ self._pose(body))

    def _pose(self, body: int) -> FloatArray:
        return transform_matrix(*pybullet.getBasePositionAndOrientation(body, physicsClientId=self._client))
