"""Writes maps in a thread of its own, so that a slow disk never holds up the loop."""

from __future__ import annotations

import queue
import threading
from pathlib import Path
from typing import Optional

import rospy

from yarm.exploration.map_keeper import SaveOrder
from yarm.navigation.map_file import MapFileError, write_map

CLOSE_LIMIT_S = 10.0
LAST_GOOD = "_last_good"
"""Ends the name of the last good map of a mapping that began anew."""


class Saver:
    """Takes orders, and writes one map after the other."""

    def __init__(self, name: Path) -> None:
        """Ready.

        Args:
            name: of the map's files, without suffix.
        """
        self._name = name
        self._orders: queue.Queue[Optional[SaveOrder]] = queue.Queue()
        self.saved = ""
        self._thread = threading.Thread(target=self._work, name="map saver", daemon=True)
        self._thread.start()

    def save(self, order: SaveOrder) -> None:
        """Have a map written soon."""
        self._orders.put(order)

    def close(self) -> None:
        """Write what is ordered, and end."""
        self._orders.put(None)
        self._thread.join(CLOSE_LIMIT_S)

    def _work(self) -> None:
        while True:
            order = self._orders.get()
            if order is None:
                return
            name = self._name.with_name(self._name.name + LAST_GOOD) if order.last_good else self._name
            try:
                files = write_map(order.map, name)
            except MapFileError as error:
                rospy.logerr("the map is not saved (%s): %s", order.why, error)
                continue
            self.saved = str(files.description)
            rospy.loginfo("map saved (%s): %s, %.2f m2 known", order.why, files.image, order.map.known_m2)
