"""The picture of where people may be."""

from __future__ import annotations

from typing import List, Sequence

from visualization_msgs.msg import Marker

from yarm.ros.common import names
from yarm.ros.common.pictures import Picture, marker
from yarm.safety.clearance import Body

COLOR = (1.0, 0.4, 0.1, 0.35)


class PeoplePicture:
    """Discs in which people may be by the time a robot stands."""

    def __init__(self) -> None:
        """Advertise."""
        self._picture = Picture(names.SAFETY_PEOPLE)

    def show(self, bodies: Sequence[Body], stand_s: float, now_s: float) -> None:
        """Send it, when anybody looks.

        Args:
            bodies: those with a disc are shown.
            stand_s: until a robot stands, s.
            now_s: time, s.
        """
        if self._picture.publisher.get_num_connections() == 0:
            return
        discs: List[Marker] = []
        for body in bodies:
            if body.disc is None:
                continue
            radius_m = body.disc.radius_m + body.disc.speed_mps * (body.age_s + stand_s)
            made = marker("people", Marker.CYLINDER, COLOR, (2.0 * radius_m, 2.0 * radius_m, 0.02))
            made.pose.position.x, made.pose.position.y, made.pose.position.z = body.disc.x, body.disc.y, 0.01
            discs.append(made)
        self._picture.send(discs, now_s)
