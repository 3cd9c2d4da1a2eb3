"""Ground truth: who touches whom, and who may."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Dict, List, Mapping, Optional, Tuple

import pybullet

from yarm.geometry.kinds import ContactKind, ObjectKind

Key = Tuple[int, int, int, int]
Stations = Mapping[str, Mapping[str, str]]
"""For each manipulator the names of its station's fixtures by type ("table", "stand")."""
FLOOR = "Floor"
"""Kind of the floor, which no registry knows."""
DEBRIS_LINKS = ("table", "part", "bin")
"""Links of fixtures that debris may lie on, or in."""
TIP_LINKS = ("ee", "hand")
"""Links of a mobile robot that may touch the debris it was sent to."""
NOTHING_HELD: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True)
class Side:
    """One side of a contact: the body's name and kind (``FLOOR`` for the floor), and the link's name."""

    body: str
    kind: str
    link: str


@dataclass(frozen=True)
class Contact:
    """A contact.

    Attributes:
        a: the first body's side.
        b: the other.
        point: of the deepest contact, on the first body, metres, world.
        depth_m: of that one; positive when the bodies overlap.
        kind: what it counts as.
        force_n: greatest force of one link on the other in a physics step, along the contacts' normals.
    """

    a: Side
    b: Side
    point: Tuple[float, float, float]
    depth_m: float
    kind: ContactKind
    force_n: float


def contact_kind(
    a: Side, b: Side, goals: Mapping[str, str], stations: Stations, held: Mapping[str, str] = NOTHING_HELD
) -> ContactKind:
    """What a contact of these two sides counts as.

    Allowed: fixed things among themselves; wheels or casters and floor; an arm's base and its own stand; debris and a
    table, bin, floor or other debris; the sander and its own station's workpiece; an end effector and the debris it was
    sent to, or that hangs on it.
    ``goals`` says to which debris each robot was sent; while it is empty (nobody assigns tasks) an end effector may
    touch any debris. ``held`` says what hangs on each robot's hand. Sander and debris is counted apart.
    """
    kinds = (_kind_of_ordered(a, b, goals, stations, held), _kind_of_ordered(b, a, goals, stations, held))
    return next((kind for kind in kinds if kind is not None), ContactKind.FAILURE)


def _kind_of_ordered(
    one: Side, other: Side, goals: Mapping[str, str], stations: Stations, held: Mapping[str, str]
) -> Optional[ContactKind]:
    if one.kind == ObjectKind.MANIPULATOR and one.link == "sander" and other.kind == ObjectKind.DEBRIS:
        return ContactKind.SANDER_DEBRIS
    # A robot without a goal may touch no debris; but while no goals are known at all, any.
    goal = goals.get(one.body, "" if goals else other.body)
    own = stations.get(one.body, {}) if one.kind == ObjectKind.MANIPULATOR else {}
    allowed = (
        {one.kind, other.kind} <= {ObjectKind.OBSTACLE, FLOOR}
        or (one.link.endswith(("_wheel", "_caster")) and other.kind == FLOOR)
        or (one.link == "base_link" and other.body == own.get("stand"))
        or (one.link == "sander" and other.link == "part" and other.body == own.get("table"))
        or (one.kind == ObjectKind.DEBRIS and (other.kind in (ObjectKind.DEBRIS, FLOOR) or other.link in DEBRIS_LINKS))
        or (one.link in TIP_LINKS and other.kind == ObjectKind.DEBRIS and other.body in (goal, held.get(one.body)))
    )
    return ContactKind.ALLOWED if allowed else None


class ContactLog:
    """The deepest contact, and the greatest force, of each pair of links since the log was last emptied."""

    def __init__(self, client: int, stations: Stations) -> None:
        """Watch the bodies of a PyBullet client; ``stations`` says which stand and table are whose."""
        self._client = client
        self.stations = stations
        self._sides: Dict[Tuple[int, int], Side] = {}
        self._kinds: Dict[Key, ContactKind] = {}
        self._deepest: Dict[Key, Tuple[float, Tuple[float, float, float]]] = {}
        self._forces: Dict[Key, float] = {}
        self.goals: Dict[str, str] = {}
        self.held: Dict[str, str] = {}

    def register(self, uid: int, name: str, kind: str, links: List[str]) -> None:
        """Know a body; ``links`` by PyBullet's index, the root last."""
        for index in range(-1, len(links) - 1):
            self._sides[(uid, index)] = Side(name, kind, links[index])
        self._kinds.clear()

    def forget(self, uid: int) -> None:
        """Forget a body that left."""
        self._sides = {key: side for key, side in self._sides.items() if key[0] != uid}
        self._kinds.clear()
        self._deepest = {key: value for key, value in self._deepest.items() if uid not in (key[0], key[1])}
        self._forces = {key: value for key, value in self._forces.items() if uid not in (key[0], key[1])}

    def set_goals(self, goals: Mapping[str, str]) -> None:
        """Which debris each robot was sent to."""
        if dict(goals) != self.goals:
            self.goals = dict(goals)
            self._kinds.clear()

    def set_held(self, held: Mapping[str, str]) -> None:
        """Which debris hangs on each robot's hand."""
        if dict(held) != self.held:
            self.held = dict(held)
            self._kinds.clear()

    def collect(self) -> None:
        """Note the contacts of the physics step just done."""
        forces: Dict[Key, float] = {}
        for point in pybullet.getContactPoints(physicsClientId=self._client):
            depth = -point[8]
            if depth < 0.0:
                continue
            key = (point[1], point[2], point[3], point[4])
            forces[key] = forces.get(key, 0.0) + point[9]
            known = self._deepest.get(key)
            if known is None or depth > known[0]:
                self._deepest[key] = (depth, point[5])
        for key, force in forces.items():
            self._forces[key] = max(force, self._forces.get(key, 0.0))

    def take(self) -> List[Contact]:
        """The contacts since the last call, and start afresh."""
        contacts = []
        for key, (depth, position) in self._deepest.items():
            a, b = self._sides.get((key[0], key[2])), self._sides.get((key[1], key[3]))
            if a is None or b is None:
                continue
            kind = self._kinds.get(key)
            if kind is None:
                kind = self._kinds[key] = contact_kind(a, b, self.goals, self.stations, self.held)
            contacts.append(Contact(a, b, position, depth, kind, self._forces.get(key, 0.0)))
        self._deepest, self._forces = {}, {}
        return contacts
