"""Every reader of messages and every service of a node, with no ROS master: the node is made, its callbacks are kept.

``rospy`` is replaced for a while by what remembers who listens to what; what a node publishes is written as it would
go over the wire. So whatever the real node subscribes to is found here by itself, and a new reader too.
"""

from __future__ import annotations

import ast
import inspect
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any, Callable, Dict, List, Set, Tuple, Type

import roslib.message
import rospy
from actionlib_msgs.msg import GoalStatusArray
from rospy.msg import args_kwds_to_message

from yarm.ros import common
from yarm.ros.common import api

ROS = Path(common.__file__).resolve().parents[1]
"""The folder of all that speaks ROS."""
NOW_S = 12.0
AT_ONCE_S = 0.01
"""Wall time after which a service is taken to wait for its node's work, s."""
SENDER = {"callerid": "/stranger"}
Site = Tuple[str, int]
"""A call that listens: file below ``ROS``, line."""


@dataclass(frozen=True)
class Ear:
    """One callback of a node: of a topic, or of a service."""

    site: Site
    topic: str
    kind: Type[Any]
    call: Callable[[Any], Any]

    @property
    def is_service(self) -> bool:
        """It answers."""
        return hasattr(self.kind, "_request_class")

    @property
    def sent_kind(self) -> Type[Any]:
        """What is sent to it: for a reader of bytes, what the topic has."""
        if self.is_service:
            return self.kind._request_class
        if self.kind is not rospy.AnyMsg:
            return self.kind
        types = {topic.name: topic.type for topic in api.TOPICS}
        action, _, part = self.topic.rpartition("/")
        if part == "status" and action.rpartition("/")[2] in {each.name.rpartition("/")[2] for each in api.ACTIONS}:
            return GoalStatusArray
        return roslib.message.get_message_class(types[self.topic])

    def tell(self, message: Any, work: Callable[[], Any]) -> None:
        """Call it as rospy does, and have what it was told worked off; a service may wait for that."""
        if not self.is_service:
            self._call(message)
            work()
            return
        with ThreadPoolExecutor(1) as pool:
            answer = pool.submit(self._call, message)
            while not wait([answer], AT_ONCE_S).done:
                work()
            answer.result()
        work()

    def _call(self, message: Any) -> None:
        message._connection_header = {**SENDER, "type": type(message)._type}
        if self.is_service:
            written(self.call(message))
            return
        if self.kind is rospy.AnyMsg:
            header, data = message._connection_header, written(message)
            message = rospy.AnyMsg()
            message._buff, message._connection_header = data, header
        self.call(message)


@dataclass
class Ears:
    """What everybody listens to who was made meanwhile, and what they said."""

    heard: List[Ear] = field(default_factory=list)
    sites: Set[Site] = field(default_factory=set)
    said: Dict[str, int] = field(default_factory=dict)

    def by_topic(self, topic: str) -> List[Ear]:
        """Who listens to a topic."""
        return [ear for ear in self.heard if ear.topic == topic]

    def put_on(self, patch: Any) -> None:
        """Replace what nodes use of ``rospy``; ``patch`` is pytest's monkeypatch, or one like it."""
        given: Dict[str, Any] = {}
        replaced = {
            "Subscriber": partial(Listener, self),
            "Service": partial(Listener, self),
            "Publisher": partial(Speaker, self),
            "Timer": Silent,
            "ServiceProxy": Silent,
            "get_time": lambda: NOW_S,
            "get_param": lambda name, default=None: given.get(name, default),
            "set_param": given.__setitem__,
            "has_param": given.__contains__,
            "delete_param": lambda name: given.pop(name, None),
            "get_name": lambda: "/listener",
            "search_param": lambda _: None,
            "is_shutdown": lambda: False,
            **dict.fromkeys(("logdebug", "loginfo", "logwarn", "logerr", "logfatal"), lambda *_: None),
            **dict.fromkeys(("loginfo_throttle", "logwarn_throttle", "logerr_throttle"), lambda *_: None),
        }
        for name, value in replaced.items():
            patch.setattr(rospy, name, value)
        patch.setattr(rospy.rostime, "_rostime_initialized", True)
        patch.setattr(rospy.rostime, "_rostime_current", rospy.Time.from_sec(NOW_S))


class Listener:
    """Stands in for rospy.Subscriber and rospy.Service."""

    def __init__(self, ears: Ears, name: str, kind: Any, callback: Any, callback_args: Any = None, **_: Any) -> None:
        """Listen from now on."""
        told = callback if callback_args is None else lambda message: callback(message, callback_args)
        self._ears, self._ear = ears, Ear(_site(), name, kind, told)
        self.resolved_name = "/" + name.strip("/")
        ears.sites.add(self._ear.site)
        ears.heard.append(self._ear)

    def unregister(self, *_: Any) -> None:
        """Hear nothing more."""
        if self._ear in self._ears.heard:
            self._ears.heard.remove(self._ear)

    shutdown = unregister

    def get_num_connections(self) -> int:
        """Everybody is there."""
        return 1


class Speaker:
    """Stands in for rospy.Publisher."""

    def __init__(self, ears: Ears, name: str, kind: Any, *_: Any, **__: Any) -> None:
        """Nothing said yet."""
        self.name, self.resolved_name = name, "/" + name.strip("/")
        self._ears, self._kind = ears, kind

    def publish(self, *args: Any, **kwds: Any) -> None:
        """Write it down."""
        written(args_kwds_to_message(self._kind, args, kwds))
        self._ears.said[self.name] = self._ears.said.get(self.name, 0) + 1

    def unregister(self) -> None:
        """Nothing more is said."""

    def get_num_connections(self) -> int:
        """Somebody listens, so that everything is said."""
        return 1


class Silent:
    """Stands in for timers and for services of others, which never answer."""

    def __init__(self, *_: Any, **__: Any) -> None:
        """Nothing happens."""

    def __call__(self, *_: Any, **__: Any) -> Any:
        """Nobody answers.

        Raises:
            rospy.ServiceException: always.
        """
        raise rospy.ServiceException("nobody serves it")

    wait_for_service = __call__

    def shutdown(self) -> None:
        """Nothing to end."""


def written(message: Any) -> bytes:
    """A message as it goes over the wire."""
    buffer = BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def arrived(message: Any) -> Any:
    """A message as its reader gets it: written and read again."""
    return type(message)().deserialize(written(message))


def _site() -> Site:
    """Where in our sources the call is that listens; ("", 0) when it is in nobody's of ours."""
    for frame in inspect.stack()[2:]:
        path = Path(frame.filename).resolve()
        if ROS in path.parents:
            return str(path.relative_to(ROS)), frame.lineno
    return "", 0


def sites() -> List[Site]:
    """Every call of our sources that listens to a topic or serves."""
    found = []
    for path in sorted(ROS.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and ast.unparse(node.func) in ("rospy.Subscriber", "rospy.Service"):
                found.append((str(path.relative_to(ROS)), node.lineno))
    return found
