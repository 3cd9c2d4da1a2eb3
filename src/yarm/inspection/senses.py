"""All that is known at a pass of the inspector's loop, and which of it cannot be trusted; pure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Optional, Tuple

from yarm.geometry import Pose2, wrap_angle
from yarm.geometry.scans import Odometry, Scan
from yarm.inspection.model import Outcome
from yarm.tags.motifs import GreyImage

AGE_S = 0.5
"""A scan or an odometry older than this is missing."""
PLACE_AGE_S = 1.0
"""So is a place: localisations answer when they have moved, and their transform may lag."""
PATIENCE_S = 5.0
"""What has never come is not missing before this, s after the first pass."""
JUMP_M, JUMP_RAD = 0.30, 0.30
"""The map's odometry frame moves by less than this between two passes, unless the place has jumped."""
STANDS = frozenset({"scan", "odometry", "place", "navigation"})
"""While one of these is sick nothing is driven."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture of the camera: (h, w) grey, and when it was taken, s."""

    stamp_s: float
    grey: GreyImage


@dataclass(frozen=True, eq=False)
class Senses:
    """What has been heard; times on the clock, s.

    Attributes:
        now_s: time of the pass.
        scan: the newest; None before the first.
        odometry: the newest.
        map_from_odom: where the odometry's frame is in the map; None while nobody says.
        place_s: stamp of that.
        localised: the localisation is sure of it.
        place_fault: why it is not, by its own words.
        picture: the newest, if it has come since the last pass and can be used.
        camera: what is wrong with the camera; empty when it is well.
        goal: how the last goal stands.
        navigation: what is wrong with its server; empty when it lives.
        map_fault: what is wrong with the map, or with the boxes in it; empty when nothing is.
    """

    now_s: float
    scan: Optional[Scan] = None
    odometry: Optional[Odometry] = None
    map_from_odom: Optional[Pose2] = None
    place_s: float = -math.inf
    localised: bool = False
    place_fault: str = ""
    picture: Optional[Picture] = None
    camera: str = ""
    goal: Tuple[Outcome, str] = (Outcome.BUSY, "")
    navigation: str = ""
    map_fault: str = ""

    @property
    def pose(self) -> Optional[Pose2]:
        """Of the base in the map."""
        if self.map_from_odom is None or self.odometry is None:
            return None
        return self.map_from_odom.compose(self.odometry.pose)


@dataclass(frozen=True)
class Complaint:
    """One input that cannot be trusted: which, since when on the clock (s), what is wrong, what to do."""

    sensor: str
    since_s: float
    what: str
    remedy: str

    @property
    def text(self) -> str:
        """One sentence for people."""
        return f"{self.sensor}: {self.what}, since {self.since_s:.1f} s; {self.remedy}"


class SensesWatch:
    """Every input, pass after pass."""

    def __init__(self) -> None:
        """Nothing seen yet."""
        self._first_s: Optional[float] = None
        self._since_s: Dict[str, float] = {}
        self._before: Optional[Pose2] = None
        self.jump = ""
        """What has jumped at this pass; empty when nothing has."""

    def step(self, seen: Senses) -> Tuple[Complaint, ...]:
        """What is wrong at this pass; ``jump`` is set anew."""
        if self._first_s is None:
            self._first_s = seen.now_s
        self.jump = self._jump(seen)
        found: List[Complaint] = []
        for sensor, what, remedy in self._faults(seen):
            since_s = self._since_s.setdefault(sensor, seen.now_s)
            found.append(Complaint(sensor, since_s, what, remedy))
        sick = {complaint.sensor for complaint in found}
        self._since_s = {sensor: since for sensor, since in self._since_s.items() if sensor in sick}
        return tuple(found)

    def _faults(self, seen: Senses) -> List[Tuple[str, str, str]]:
        """Sensor, what is wrong, what to do."""
        scan_s = None if seen.scan is None else seen.scan.stamp_s
        faults = [
            (
                "scan",
                self._age(seen, scan_s, AGE_S),
                "look at the range sensor and its driver",
            ),
            (
                "odometry",
                self._age(seen, None if seen.odometry is None else seen.odometry.stamp_s, AGE_S),
                "look at the base and its driver",
            ),
            ("navigation", self._unless_young(seen, seen.navigation), "start move_base"),
            ("camera", self._unless_young(seen, seen.camera), "look at the camera and its driver"),
            ("map", self._unless_young(seen, seen.map_fault), "look at map_server and the boxes' file"),
        ]
        if seen.localised:
            place_s = None if seen.map_from_odom is None else seen.place_s
            faults.append(("place", self._age(seen, place_s, PLACE_AGE_S), "look at the localisation"))
        return [fault for fault in faults if fault[1]]

    def _age(self, seen: Senses, stamp_s: Optional[float], most_s: float) -> str:
        if stamp_s is None:
            return self._unless_young(seen, "nothing has come yet")
        age_s = seen.now_s - stamp_s
        return f"none newer than {age_s:.1f} s" if age_s > most_s else ""

    def _unless_young(self, seen: Senses, what: str) -> str:
        """Somebody who has just begun waits without a complaint."""
        assert self._first_s is not None
        return what if seen.now_s - self._first_s >= PATIENCE_S else ""

    def _jump(self, seen: Senses) -> str:
        before, self._before = self._before, seen.map_from_odom if seen.localised else None
        if before is None or self._before is None:
            return ""
        way_m = before.distance(self._before)
        turn_rad = abs(wrap_angle(self._before.yaw_rad - before.yaw_rad))
        if way_m < JUMP_M and turn_rad < JUMP_RAD:
            return ""
        return f"the place has jumped by {way_m:.2f} m and {turn_rad:.2f} rad"
