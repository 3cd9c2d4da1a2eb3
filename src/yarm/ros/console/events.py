"""The newest events: warnings of every node, and what who leads the mission says."""

from __future__ import annotations

from collections import deque
from typing import Any, Deque, Dict

from rosgraph_msgs.msg import Log

from yarm.console.cell import Part
from yarm.console.wire import encode
from yarm.ros.common import names
from yarm.ros.console.routes import Route

TELLERS = (names.COMMANDER_NODE, names.EXPLORER_NODE, names.INSPECTOR_NODE, names.YOUBOT_NODE)
"""Nodes that lead a mission: all that they say is of interest to a person at the cell."""
MOST = 200
LONGEST = 400
"""Characters of an event that are kept."""


class EventLog:
    """Takes in what nodes log. One that repeats itself is one event with a count. Not thread-safe."""

    def __init__(self) -> None:
        """Nothing yet."""
        self._events: Deque[Dict[str, Any]] = deque(maxlen=MOST)
        self._version = 0
        self._part = Part(0, encode({"kind": "events", "events": []}, {}))

    def routes(self) -> Dict[str, Route]:
        """What it listens to."""
        return {"/rosout": Route(Log, self.note, 100)}

    def part(self) -> Part:
        """The events, oldest first."""
        if self._part.version != self._version:
            self._part = Part(self._version, encode({"kind": "events", "events": list(self._events)}, {}))
        return self._part

    def note(self, message: Log) -> None:
        """Take in what a node has logged; what is of no interest to a person at the cell is left out."""
        node = message.name.lstrip("/")
        if message.level < Log.WARN and node not in TELLERS:
            return
        event = {
            "time_s": round(message.header.stamp.to_sec(), 2),
            "level": {Log.WARN: "warning", Log.ERROR: "error", Log.FATAL: "error"}.get(message.level, "info"),
            "node": node,
            "text": message.msg[:LONGEST],
            "times": 1,
        }
        self._version += 1
        for last in list(self._events)[-3:]:
            if (last["node"], last["text"]) == (event["node"], event["text"]):
                event["times"] = last["times"] + 1
                self._events.remove(last)
        self._events.append(event)
