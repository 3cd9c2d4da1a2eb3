"""A recorded run as a film: the messages of a bag, taken in one after the other as a page would have heard them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, List, Sequence, Set

import rosbag
import rospy
from genpy import DeserializationError

from yarm.console.film import Film, FilmError
from yarm.console.picture import Area
from yarm.robots.hc10 import AT_ORIGIN
from yarm.ros.common import names
from yarm.ros.console.cell_words import private_area
from yarm.ros.console.routes import Route
from yarm.ros.console.system_book import SystemBook

LARGE = ("sensor_msgs/PointCloud2", "sensor_msgs/Image")
PICTURES = (names.OCCUPANCY, names.MAPS_AND_MASKS, names.PARTICLES_AND_WAYPOINTS)
"""Types and topics that no page shows and that most of a bag is: they are not even read."""


def film_of_bag(path: Path, period_s: float) -> Film:
    """The film of a bag that ``rosbag record`` has written.

    Args:
        path: the bag.
        period_s: between two pictures, s of recorded time.

    Raises:
        FilmError: it cannot be read, or has nothing that a page shows.
    """
    film = Film(str(path))
    book = SystemBook(_areas, film.note)
    try:
        with rosbag.Bag(str(path)) as bag:
            _play(bag, book, film, period_s)
    except (rosbag.ROSBagException, FilmError, DeserializationError, OSError) as error:
        raise FilmError(f"{path} cannot be read: {error}; is it a whole recording of a run?") from error
    return film


def _play(bag: rosbag.Bag, book: SystemBook, film: Film, period_s: float) -> None:
    foreign: Set[str] = set()
    next_s, last_s = math.inf, math.inf
    for topic, (kind, data, md5, *_), stamp in bag.read_messages(raw=True, connection_filter=_is_small):
        now_s = stamp.to_sec()
        if now_s < last_s:
            next_s = now_s + period_s
        while now_s >= next_s:
            film.add(next_s, book.parts(), book.state(next_s, next_s))
            next_s += period_s
        last_s = now_s
        name = f"/{topic.lstrip('/')}"
        route = book.routes().get(name) or book.routes().get(name.lstrip("/"))
        if route is None:
            continue
        if md5 != route.kind._md5sum:
            foreign.add(kind)
            continue
        route.take(_message(route, data))
        book.heard(topic.lstrip("/"), now_s, now_s)
    if last_s == math.inf:
        raise FilmError("it has no messages")
    film.add(last_s, book.parts(), book.state(last_s, last_s))
    if foreign:
        film.note(f"recorded with another version of yarm, left out: {', '.join(sorted(foreign))}")


def _is_small(topic: str, datatype: str, *_: Any) -> bool:
    return datatype not in LARGE and topic.lstrip("/") not in PICTURES


def _message(route: Route, data: bytes) -> Any:
    message = (rospy.AnyMsg if route.raw else route.kind)()
    message.deserialize(data)
    return message


def _areas(arms: Sequence[str]) -> List[Area]:
    """A bag has no parameters: where one arm stands is known, of several it is not."""
    return [private_area(arms[0], AT_ORIGIN)] if len(arms) == 1 else []
